#include "cloud_list.h"

#include <algorithm>
#include <cctype>
#include <fstream>
#include <stdexcept>
#include <string>
#include <system_error>

#include "usage_error.h"

namespace handhold {
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

}  // namespace

CloudList list_clouds(const fs::path& source, bool recursive) {
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
  return {folder ? source : source.parent_path(), std::move(clouds)};
}

}  // namespace handhold
