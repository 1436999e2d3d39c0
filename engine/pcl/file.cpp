#include "file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <memory>

#include "handhold/io.h"

namespace handhold::io {
namespace {

struct Close {
  void operator()(std::FILE* file) const { std::fclose(file); }
};
using FilePtr = std::unique_ptr<std::FILE, Close>;

// Opens a name that nobody uses yet, beside `path`: a rename is atomic only within one file system.
FilePtr open_beside(const std::string& path, std::string& temporary) {
  for (int attempt = 0; attempt < 100; ++attempt) {
    temporary = path + ".part" + std::to_string(::getpid()) + "." + std::to_string(attempt);
    const int descriptor = ::open(temporary.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (descriptor >= 0) return FilePtr(::fdopen(descriptor, "wb"));
    if (errno != EEXIST) break;
  }
  throw IoError("cannot write " + path + ": " + std::strerror(errno) +
                "; the folder must exist and files in it must be writable");
}

}  // namespace

std::size_t checked_file_size(const std::string& path) {
  struct stat info {};
  if (::stat(path.c_str(), &info) != 0) {
    throw IoError("cannot read " + (path.empty() ? "a file without a name" : path) + ": " + std::strerror(errno) +
                  "; give the path of a file that exists");
  }
  if (S_ISDIR(info.st_mode)) throw IoError("cannot read " + path + ": it is a directory; give the path of a file");
  if (!S_ISREG(info.st_mode)) throw IoError("cannot read " + path + ": it is no regular file; save it to a file first");
  if (info.st_size == 0) throw IoError("cannot read " + path + ": the file is empty; write it again");
  return static_cast<std::size_t>(info.st_size);
}

std::string read_bytes(const std::string& path, std::size_t size) {
  FilePtr file(std::fopen(path.c_str(), "rb"));
  if (!file) {
    throw IoError("cannot read " + path + ": " + std::strerror(errno) + "; it must be readable by this user");
  }
  std::string bytes(size, '\0');
  if (std::fread(bytes.data(), 1, size, file.get()) != size) {
    throw IoError("cannot read " + path + ": it ended early or the disk failed; it must not change while it is read");
  }
  return bytes;
}

void write_whole_file(const std::string& path, const std::string& head, const std::string& body) {
  // A rename would put a file in the place of a device such as /dev/null.
  struct stat info {};
  if (::stat(path.c_str(), &info) == 0 && !S_ISREG(info.st_mode)) {
    throw IoError("cannot write " + path + ": it is no regular file; give the path of a file");
  }
  std::string temporary;
  FilePtr file = open_beside(path, temporary);
  const auto put = [&](const std::string& part) {
    return std::fwrite(part.data(), 1, part.size(), file.get()) == part.size();
  };
  const bool written = file && put(head) && put(body) && std::fflush(file.get()) == 0;
  // A full disk may show only now, so that closing counts as writing.
  const bool closed = file && std::fclose(file.release()) == 0;
  if (written && closed && std::rename(temporary.c_str(), path.c_str()) == 0) return;
  const std::string reason = std::strerror(errno);
  std::remove(temporary.c_str());
  throw IoError("cannot write " + path + ": " + reason + "; the disk must have room and the path must name a file");
}

}  // namespace handhold::io
