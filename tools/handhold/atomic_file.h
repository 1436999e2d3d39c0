// Output files that are there as a whole or not at all.
#pragma once

#include <cstdio>
#include <string>

namespace handhold {

/// A file under construction: written beside its target and renamed onto it by commit(), so that a reader never sees
/// half a file and a failure leaves the old one.
///
/// A target that is a device, a pipe or a socket (/dev/null, /dev/stdout) is written directly: renaming would replace
/// it. A symbolic link stays; what it points to is replaced. The modes of a file that exists are kept.
///
/// Every member throws std::runtime_error with one line: what, where, what would be right.
class AtomicFile {
 public:
  explicit AtomicFile(std::string path);
  /// Removes the temporary file unless commit() has returned.
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  /// Open for binary writing; owned by this object, null after commit().
  std::FILE* handle() { return file_; }
  /// For writers that open by name themselves (and leave handle() alone). Equals the target for a device.
  const std::string& temporary_path() const { return temporary_path_; }

  void write(const std::string& bytes);
  /// Flushes, checks that all bytes arrived, and renames.
  void commit();

  /// Throws what the constructor would throw, without leaving anything behind: to refuse a path before the work is
  /// done.
  static void check_writable(const std::string& path);

  /// The target of a temporary file beside it, by its name; empty: `path` is no such name.
  static std::string target_of(const std::string& path);
  /// Removes the temporary file `path` unless a process, on this machine or another one, is writing it. What was killed
  /// leaves such files.
  static void remove_if_abandoned(const std::string& path);

 private:
  void discard() noexcept;

  std::string path_;    ///< as the user named it: for messages
  std::string target_;  ///< with symbolic links resolved
  std::string temporary_path_;
  std::FILE* file_ = nullptr;
  bool rename_ = true;
};

/// A whole file. @throws std::runtime_error as AtomicFile
void write_file(const std::string& path, const std::string& bytes);

/// Writes all of `bytes` to a stream that is open already (standard output) and flushes it; `name` is for the message.
/// @throws std::runtime_error when they do not all arrive
void write_and_flush(std::FILE* file, const std::string& bytes, const std::string& name);

}  // namespace handhold
