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

std::string extension_of(const fs::path& path) {
  std::string extension = path.extension().string();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return extension;
}

bool is_cloud(const fs::path& path) {
  const std::string extension = extension_of(path);
  return extension == ".pcd" || extension == ".ply";
}

bool is_png(const fs::path& path) {
  return extension_of(path) == ".png";
}

bool is_frame(const fs::path& path) {
  return is_cloud(path) || is_png(path);
}

/// Whether it is a folder; another file is a list. `what` it would list.
bool is_folder(const fs::path& source, const char* what) {
  std::error_code error;
  if (fs::is_directory(source, error)) return true;
  if (fs::is_regular_file(source, error)) return false;
  throw std::runtime_error("'" + source.string() + "' is neither a folder nor a list of " + what +
                           "; give one of them");
}

template <class Iterator>
void add_files(const fs::path& folder, bool (*wanted)(const fs::path&), std::vector<fs::path>& files) {
  std::error_code error;
  for (Iterator i(folder, fs::directory_options::skip_permission_denied, error), end; !error && i != end;
       i.increment(error)) {
    if (wanted(i->path()) && i->is_regular_file(error)) files.push_back(i->path());
  }
  if (error) throw std::runtime_error("cannot list '" + folder.string() + "': " + error.message());
}

std::vector<fs::path> files_of_list(const fs::path& list) {
  std::ifstream file(list);
  std::vector<fs::path> files;
  for (std::string line; std::getline(file, line);) {
    while (!line.empty() && (line.back() == '\r' || line.back() == ' ' || line.back() == '\t')) line.pop_back();
    if (!line.empty() && line.front() != '#') files.push_back(list.parent_path() / line);
  }
  if (file.bad() || !file.eof()) throw std::runtime_error("cannot read the list '" + list.string() + "'");
  return files;
}

}  // namespace

CloudList list_clouds(const fs::path& source, bool recursive) {
  const bool folder = is_folder(source, "clouds");
  if (!folder && is_cloud(source)) {
    throw UsageError("'" + source.string() + "' is a cloud; give a folder or a list, or use 'handhold localize'");
  }
  if (!folder && recursive) throw UsageError("--recursive needs a folder, and '" + source.string() + "' is a file");
  std::vector<fs::path> clouds;
  if (!folder) {
    clouds = files_of_list(source);
  } else if (recursive) {
    add_files<fs::recursive_directory_iterator>(source, is_cloud, clouds);
  } else {
    add_files<fs::directory_iterator>(source, is_cloud, clouds);
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

FrameList list_frames(const fs::path& source, bool images_meant) {
  const std::string name = "'" + source.string() + "'";
  const bool folder = is_folder(source, "clouds or depth images");
  if (!folder && is_cloud(source)) {
    throw UsageError(name + " is a cloud; give a folder or a list, or use 'handhold localize'");
  }
  if (!folder && is_png(source)) {
    throw UsageError(name + " is one image; give a folder or a list, or use 'handhold localize --depth'");
  }
  std::vector<fs::path> files;
  if (folder) {
    add_files<fs::directory_iterator>(source, is_frame, files);
    if (!images_meant && std::any_of(files.begin(), files.end(), is_cloud)) {
      files.erase(std::remove_if(files.begin(), files.end(), is_png), files.end());
    }
    std::sort(files.begin(), files.end());
  } else {
    files = files_of_list(source);
  }
  if (files.empty()) {
    throw std::runtime_error(name + (folder ? " holds no .pcd, .ply or .png file; give a folder of frames"
                                            : " names no cloud or depth image; give one path a line"));
  }
  const auto images = std::count_if(files.begin(), files.end(), is_png);
  if (images > 0 && images < static_cast<std::ptrdiff_t>(files.size())) {
    throw UsageError(name + (folder ? " holds" : " names") +
                     " clouds and PNGs; give a folder or a list of clouds alone, or of depth images alone");
  }
  return {std::move(files), images > 0};
}

}  // namespace handhold
