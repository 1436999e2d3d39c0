// Which results in a folder are of this batch.
#pragma once

#include <filesystem>
#include <string>

#include "handhold/options.h"
#include "work_list.h"

namespace handhold::batch {

/// A file in the folder of results that says with which options they are made. A result is finished when it is newer
/// than this file and than its cloud.
class Manifest {
 public:
  /// Makes the folder and the file where they are missing. `backend`: what searches, also where the options leave it
  /// open. `force`: what is there is made again.
  /// @throws UsageError when the folder has results of other options, std::runtime_error when it cannot be written
  Manifest(const std::filesystem::path& out, const Options& options, Backend backend, bool force);

  bool finished(const Work& work) const;

 private:
  std::filesystem::file_time_type since_;
};

}  // namespace handhold::batch
