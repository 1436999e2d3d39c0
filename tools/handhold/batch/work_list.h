// The clouds of a batch and where their results go.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "cloud_list.h"

namespace handhold::batch {

struct Work {
  std::filesystem::path cloud, result;
  std::string name;  ///< of the result, without .json: the cloud's, with the folders below the source
};

/// @throws UsageError: two clouds whose results have one name
std::vector<Work> list_work(const CloudList& list, const std::filesystem::path& out);

/// Removes the halves of these results that a process left when it was killed.
void remove_leftovers(const std::vector<Work>& work);

}  // namespace handhold::batch
