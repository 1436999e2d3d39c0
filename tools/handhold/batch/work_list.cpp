#include "work_list.h"

#include <map>
#include <set>
#include <string>
#include <system_error>

#include "atomic_file.h"
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

void remove_leftovers(const std::vector<Work>& work) {
  std::set<fs::path> folders;
  std::set<std::string> results;
  for (const Work& w : work) {
    folders.insert(w.result.parent_path());
    results.insert(w.result.lexically_normal().string());
  }
  for (const fs::path& folder : folders) {
    std::error_code error;  // no such folder: nothing in it
    std::vector<std::string> leftovers;
    for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
      std::string path = entry->path().lexically_normal().string();
      if (results.count(AtomicFile::target_of(path)) > 0) leftovers.push_back(std::move(path));
    }
    for (const std::string& path : leftovers) AtomicFile::remove_if_abandoned(path);
  }
}

}  // namespace handhold::batch
