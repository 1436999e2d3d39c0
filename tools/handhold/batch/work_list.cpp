#include "work_list.h"

#include <algorithm>
#include <fstream>
#include <map>
#include <stdexcept>
#include <system_error>

#include "usage_error.h"

namespace handhold::batch {
namespace {

namespace fs = std::filesystem;

bool is_cloud(const fs::path& path) {
  std::string extension = path.extension().string();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return extension == ".pcd" || extension == ".ply";
}

template <class Iterator>
void add_clouds(const fs::path& folder, std::vector<fs::path>& clouds) {
  std::error_code error;
  for (Iterator i(folder, fs::directory_options::skip_permission_denied, error), end; !error && i != end;
       i.increment(error)) {
    if (is_cloud(i->path()) && i->is_regular_file(error)) clouds.push_back(i->path());
  }
  if (error) throw std::runtime_error("cannot list '" + folder.string() + "': " + error.message());
}

std::vector<fs::path> clouds_of_list(const fs::path& list) {
  std::ifstream file(list);
  std::vector<fs::path> clouds;
  for (std::string line; std::getline(file, line);) {
    while (!line.empty() && (line.back() == '\r' || line.back() == ' ' || line.back() == '\t')) line.pop_back();
    if (!line.empty() && line.front() != '#') clouds.push_back(list.parent_path() / line);
  }
  if (file.bad() || !file.eof()) throw std::runtime_error("cannot read the list '" + list.string() + "'");
  return clouds;
}

/// Relative to the folder, or the bare name when it is elsewhere; without the extension.
std::string name_of(const fs::path& cloud, const fs::path& folder) {
  fs::path name = cloud.lexically_normal().lexically_relative(folder.lexically_normal());
  if (name.empty() || *name.begin() == "..") name = cloud.filename();
  return name.replace_extension().generic_string();
}

}  // namespace

std::vector<Work> list_work(const fs::path& source, const fs::path& out, bool recursive) {
  std::error_code error;
  const bool folder = fs::is_directory(source, error);
  if (!folder && !fs::is_regular_file(source, error)) {
    throw std::runtime_error("'" + source.string() + "' is neither a folder nor a list of clouds; give one of them");
  }
  if (!folder && is_cloud(source)) {
    throw UsageError("'" + source.string() + "' is a cloud; give a folder or a list, or use 'handhold localize'");
  }
  if (!folder && recursive) throw UsageError("--recursive needs a folder, and '" + source.string() + "' is a file");
  std::vector<fs::path> clouds;
  if (!folder) {
    clouds = clouds_of_list(source);
  } else if (recursive) {
    add_clouds<fs::recursive_directory_iterator>(source, clouds);
  } else {
    add_clouds<fs::directory_iterator>(source, clouds);
  }
  if (clouds.empty()) {
    throw std::runtime_error("'" + source.string() + "' " +
                             (folder ? "holds no .pcd or .ply file" +
                                           std::string(recursive ? "" : "; --recursive looks into its folders, too")
                                     : "names no cloud; give one path a line"));
  }
  if (folder) std::sort(clouds.begin(), clouds.end());
  std::vector<Work> work;
  std::map<std::string, fs::path> known;
  for (const fs::path& cloud : clouds) {
    Work w;
    w.cloud = cloud;
    w.name = name_of(cloud, folder ? source : source.parent_path());
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
