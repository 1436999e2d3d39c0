#include "atomic_file.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <stdexcept>
#include <utility>

namespace handhold {
namespace {

/// Between the target's name and "PROCESS-ATTEMPT" in the name of a temporary file.
constexpr const char* kPart = ".part-";

std::string folder_of(const std::string& path) {
  const std::size_t slash = path.rfind('/');
  if (slash == std::string::npos) return ".";
  return slash == 0 ? "/" : path.substr(0, slash);
}

[[noreturn]] void fail(const std::string& path, int error) {
  std::string advice = "choose another path";
  switch (error) {
    case ENOENT:
    case ENOTDIR:
      if (struct stat info{}; ::stat(folder_of(path).c_str(), &info) == 0 && S_ISDIR(info.st_mode)) break;
      advice = "create the folder '" + folder_of(path) + "' first or choose another path";
      break;
    case EACCES:
    case EPERM:
    case EROFS:
      advice = "choose a path that you may write to";
      break;
    case ENOSPC:
    case EDQUOT:
    case EFBIG:
      advice = "free some space or choose a path on another disk";
      break;
    case EISDIR:
      advice = "give the name of a file";
      break;
    case ENAMETOOLONG:
      advice = "choose a shorter name";
      break;
  }
  throw std::runtime_error("cannot write '" + path + "': " + std::strerror(error) + "; " + advice);
}

/// The path that a rename should replace: links followed, also when they point to nothing yet.
std::string resolve_link(const std::string& path) {
  std::string current = path;
  for (int hops = 0; hops < 40; ++hops) {
    char text[4096];
    const ssize_t length = ::readlink(current.c_str(), text, sizeof text);
    if (length < 0) return current;
    const std::string next(text, static_cast<std::size_t>(length));
    current = next[0] == '/' ? next : folder_of(current) + "/" + next;
  }
  fail(path, ELOOP);
}

/// Decides how `path` is written: true to rename onto it, false to write it directly. Fails where neither can work.
bool is_replaceable(const std::string& path, const std::string& target) {
  struct stat info {};
  if (path.empty()) fail(path, ENOENT);
  if (path.back() == '/') fail(path, EISDIR);
  if (::stat(target.c_str(), &info) != 0) {
    if (errno != ENOENT) fail(path, errno);
    return true;
  }
  if (S_ISDIR(info.st_mode)) fail(path, EISDIR);
  // A rename asks only for the folder's permission; a file that its owner made read-only is refused all the same.
  if (::access(target.c_str(), W_OK) != 0) fail(path, errno);
  return S_ISREG(info.st_mode);
}

}  // namespace

AtomicFile::AtomicFile(std::string path) : path_(std::move(path)) {
  // The magic links of /proc (/dev/stdout is one) lead to names like "pipe:[123]" that cannot be opened: what they open
  // decides first, the link's text only for files that are replaced.
  rename_ = is_replaceable(path_, path_);
  if (!rename_) {
    temporary_path_ = target_ = path_;
    file_ = std::fopen(path_.c_str(), "wb");
    if (!file_) fail(path_, errno);
    return;
  }
  target_ = resolve_link(path_);
  mode_t mode = 0666;  // less the umask, as for every new file
  struct stat info {};
  const bool exists = ::stat(target_.c_str(), &info) == 0;
  int descriptor = -1;
  for (int attempt = 0; attempt < 100 && descriptor < 0; ++attempt) {
    temporary_path_ = target_ + kPart + std::to_string(::getpid()) + "-" + std::to_string(attempt);
    descriptor = ::open(temporary_path_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, mode);
    if (descriptor < 0 && errno != EEXIST) fail(path_, errno);
  }
  if (descriptor < 0) fail(path_, EEXIST);
  // Held until the file is closed, by whatever end: see remove_if_abandoned(). Not all file systems lock: best effort.
  ::flock(descriptor, LOCK_EX | LOCK_NB);
  // Best effort: a file system without modes is no reason to lose the output.
  if (exists && ::fchmod(descriptor, info.st_mode & 07777) != 0) errno = 0;
  file_ = ::fdopen(descriptor, "wb");
  if (!file_) {
    const int error = errno;
    ::close(descriptor);
    ::unlink(temporary_path_.c_str());
    fail(path_, error);
  }
}

AtomicFile::~AtomicFile() {
  discard();
}

void AtomicFile::discard() noexcept {
  if (!file_) return;
  std::fclose(file_);
  file_ = nullptr;
  if (rename_) ::unlink(temporary_path_.c_str());
}

void AtomicFile::write(const std::string& bytes) {
  errno = 0;
  if (std::fwrite(bytes.data(), 1, bytes.size(), file_) != bytes.size()) fail(path_, errno ? errno : EIO);
}

void AtomicFile::commit() {
  if (!file_) throw std::logic_error("AtomicFile::commit() was called twice for '" + path_ + "'");
  int error = 0;
  errno = 0;
  if (std::ferror(file_)) error = EIO;
  if (std::fflush(file_) != 0) error = errno ? errno : EIO;
  // Network and quota file systems report a full disk only here. Pipes and terminals have nothing to synchronise
  // (EINVAL).
  if (!error && rename_ && ::fsync(::fileno(file_)) != 0 && errno != EINVAL && errno != ENOTSUP) error = errno;
  if (error) {
    discard();
    fail(path_, error);
  }
  std::FILE* file = std::exchange(file_, nullptr);
  if (std::fclose(file) != 0) error = errno;
  if (!error && rename_ && std::rename(temporary_path_.c_str(), target_.c_str()) != 0) error = errno;
  if (error) {
    if (rename_) ::unlink(temporary_path_.c_str());
    fail(path_, error);
  }
}

void AtomicFile::check_writable(const std::string& path) {
  // A new file is really created and removed: permissions alone do not tell of read-only or special file systems. What
  // exists and is no regular file is not opened: a pipe would block.
  if (is_replaceable(path, path)) AtomicFile probe(path);
}

std::string AtomicFile::target_of(const std::string& path) {
  const std::size_t part = path.rfind(kPart);
  if (part == std::string::npos) return {};
  const std::string numbers = path.substr(part + std::strlen(kPart));
  const bool ours = numbers.find_first_not_of("0123456789-") == std::string::npos &&
                    std::count(numbers.begin(), numbers.end(), '-') == 1 && numbers.front() != '-' &&
                    numbers.back() != '-';
  return ours ? path.substr(0, part) : std::string();
}

void AtomicFile::remove_if_abandoned(const std::string& path) {
  const int descriptor = ::open(path.c_str(), O_WRONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
  if (descriptor < 0) return;
  if (::flock(descriptor, LOCK_EX | LOCK_NB) == 0) ::unlink(path.c_str());
  ::close(descriptor);
}

void write_file(const std::string& path, const std::string& bytes) {
  AtomicFile file(path);
  file.write(bytes);
  file.commit();
}

void write_and_flush(std::FILE* file, const std::string& bytes, const std::string& name) {
  errno = 0;
  const bool written = std::fwrite(bytes.data(), 1, bytes.size(), file) == bytes.size();
  if (!written || std::fflush(file) != 0) fail(name, errno ? errno : EIO);
}

}  // namespace handhold
