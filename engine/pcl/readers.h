// The two readers behind read_cloud(), and what they share.
#pragma once

#include <cstddef>
#include <string>

#include "handhold/cloud.h"

namespace handhold::io {

/// @throws IoError
Cloud read_pcd(const std::string& path, std::size_t file_size);
Cloud read_ply(const std::string& path, std::size_t file_size);

/// Keeps PCL from writing to the console while it lives, and other threads from reading meanwhile: PCL's verbosity is
/// one variable of the whole process. The application's choice is put back at the end.
class QuietPcl {
 public:
  QuietPcl();
  ~QuietPcl();
  QuietPcl(const QuietPcl&) = delete;
  QuietPcl& operator=(const QuietPcl&) = delete;

 private:
  int previous_;
};

}  // namespace handhold::io
