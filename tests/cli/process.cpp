#include "process.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <stdexcept>

namespace handhold::test {
namespace {

/// In the child, between fork and exec. The test has one thread, so that allocation (setenv) is safe here, too.
[[noreturn]] void become_program(char* const* arguments, const char* where, const Surroundings& around, int out,
                                 int err) {
  ::prctl(PR_SET_PDEATHSIG, SIGTERM);
  ::dup2(out, STDOUT_FILENO);
  ::dup2(err, STDERR_FILENO);
  if (!around.standard_output.empty()) {
    const int file = ::open(around.standard_output.c_str(), O_WRONLY | O_CREAT, 0666);
    if (file < 0) ::_exit(126);
    ::dup2(file, STDOUT_FILENO);
  }
  if (around.max_file_bytes > 0) {
    // Without the signal the write fails with EFBIG, as one on a full disk fails with ENOSPC.
    std::signal(SIGXFSZ, SIG_IGN);
    rlimit limit{};
    limit.rlim_cur = limit.rlim_max = static_cast<rlim_t>(around.max_file_bytes);
    ::setrlimit(RLIMIT_FSIZE, &limit);
  }
  for (const auto& [name, value] : around.environment) ::setenv(name.c_str(), value.c_str(), 1);
  if (::chdir(where) != 0) ::_exit(126);
  ::execv(arguments[0], arguments);
  ::_exit(127);
}

}  // namespace

Outcome run_program(const std::vector<std::string>& arguments, const std::filesystem::path& where,
                    const Surroundings& around) {
  std::vector<std::string> words = around.launcher;
  words.emplace_back(HANDHOLD_PROGRAM);
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> pointers;
  for (std::string& word : words) pointers.push_back(word.data());
  pointers.push_back(nullptr);

  std::array<int, 2> out{}, err{};
  if (::pipe(out.data()) != 0 || ::pipe(err.data()) != 0) throw std::runtime_error("pipe failed");
  const pid_t child = ::fork();
  if (child < 0) throw std::runtime_error("fork failed");
  if (child == 0) become_program(pointers.data(), where.c_str(), around, out[1], err[1]);
  ::close(out[1]);
  ::close(err[1]);

  Outcome result;
  std::array<pollfd, 2> ends = {pollfd{out[0], POLLIN, 0}, pollfd{err[0], POLLIN, 0}};
  std::array<std::string*, 2> texts = {&result.out, &result.err};
  bool is_watched = static_cast<bool>(around.watch);
  while (ends[0].fd >= 0 || ends[1].fd >= 0) {
    if (is_watched && around.watch(child)) is_watched = false;
    if (::poll(ends.data(), ends.size(), is_watched ? 2 : -1) <= 0) continue;
    for (std::size_t i = 0; i < ends.size(); ++i) {
      if (ends[i].fd < 0 || ends[i].revents == 0) continue;
      char bytes[4096];
      const ssize_t n = ::read(ends[i].fd, bytes, sizeof bytes);
      if (n > 0) {
        texts[i]->append(bytes, static_cast<std::size_t>(n));
      } else {
        ::close(ends[i].fd);
        ends[i].fd = -1;
      }
    }
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  if (WIFEXITED(status)) result.exit_code = WEXITSTATUS(status);
  return result;
}

Folder::Folder() {
  std::string pattern = (std::filesystem::temp_directory_path() / "handhold-test-XXXXXX").string();
  if (!::mkdtemp(pattern.data())) throw std::runtime_error("cannot create " + pattern);
  path_ = pattern;
}

Folder::~Folder() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

std::vector<std::string> Folder::entries() const {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(path_)) {
    names.push_back(entry.path().lexically_relative(path_).string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

void Folder::write(const std::string& name, const std::string& bytes) const {
  std::ofstream file(path_ / name, std::ios::binary);
  file << bytes;
  if (!file.flush()) throw std::runtime_error("cannot write " + name);
}

std::string Folder::read(const std::string& name) const {
  std::ifstream file(path_ / name, std::ios::binary);
  if (!file) throw std::runtime_error("cannot read " + name);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

}  // namespace handhold::test
