#include "work_list.h"

#include <map>

#include "usage_error.h"

namespace handhold::batch {
namespace {

namespace fs = std::filesystem;

/// Relative to the folder, or the bare name when it is elsewhere; without the extension.
std::string name_of(const fs::path& cloud, const fs::path& folder) {
  fs::path name = cloud.lexically_normal().lexically_relative(folder.lexically_normal());
  if (name.empty() || *name.begin() == "..") name = cloud.filename();
  return name.replace_extension().generic_string();
}

}  // namespace

std::vector<Work> list_work(const CloudList& list, const fs::path& out) {
  std::vector<Work> work;
  std::map<std::string, fs::path> known;
  for (const fs::path& cloud : list.clouds) {
    Work w;
    w.cloud = cloud;
    w.name = name_of(cloud, list.folder);
    w.result = out / (w.name + ".json");
    const auto [other, is_new] = known.emplace(w.name, cloud);
    if (!is_new) {
      throw UsageError("'" + other->second.string() + "' and '" + cloud.string() + "' would both be written to '" +
                       w.result.string() + "'; rename one of them");
    }
    work.push_back(std::move(w));
  }
  return work;
}

}  // namespace handhold::batch
