// The clouds of a batch and where their results go.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace handhold::batch {

struct Work {
  std::filesystem::path cloud, result;
  std::string name;  ///< of the result, without .json: the cloud's, with the folders below the source
};

/// Of a folder all .pcd and .ply files in order of their names, with those of its folders when `recursive`; of a text
/// file those that its lines name, relative to its folder (empty lines and those that begin with # are passed over).
/// @throws UsageError, std::runtime_error: no such source, nothing in it, two clouds whose results have one name
std::vector<Work> list_work(const std::filesystem::path& source, const std::filesystem::path& out, bool recursive);

}  // namespace handhold::batch
