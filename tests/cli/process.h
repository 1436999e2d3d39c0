// Runs the built program and a folder for its files.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <utility>
#include <vector>

namespace handhold::test {

struct Outcome {
  int exit_code = -1;  ///< -1: ended by a signal
  std::string out;
  std::string err;
};

struct Surroundings {
  std::vector<std::pair<std::string, std::string>> environment;  ///< set on top of this process's
  std::string standard_output;                                   ///< file to write to instead of Outcome::out
  long max_file_bytes = 0;            ///< a write beyond this fails as on a full disk; 0: no limit
  std::vector<std::string> launcher;  ///< words before the program's: mpirun and what it takes
  /// Called every 2 ms with the id of the process that was started, until it says yes.
  std::function<bool(int process)> watch;
};

/// Runs `handhold` with the arguments, in the folder `where`. It gets SIGTERM should the test be killed meanwhile.
Outcome run_program(const std::vector<std::string>& arguments, const std::filesystem::path& where,
                    const Surroundings& around = {});

/// An empty folder that disappears with the object.
class Folder {
 public:
  Folder();
  ~Folder();
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;

  const std::filesystem::path& path() const { return path_; }
  /// Names of all entries, sorted.
  std::vector<std::string> entries() const;
  void write(const std::string& name, const std::string& bytes) const;
  std::string read(const std::string& name) const;

 private:
  std::filesystem::path path_;
};

}  // namespace handhold::test
