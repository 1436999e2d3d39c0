#include "cloud_input.h"

#include <filesystem>
#include <utility>
#include <vector>

#include "atomic_file.h"
#include "command_line.h"
#include "handhold/io.h"
#include "handhold/option_text.h"
#include "html/page.h"
#include "usage_error.h"

namespace handhold {

namespace {

/// The same place on disk, whether or not something is there yet. Devices may be named twice.
bool same_file(const std::string& a, const std::string& b) {
  namespace fs = std::filesystem;
  std::error_code error;
  if (fs::is_character_file(a, error)) return false;
  if (fs::equivalent(a, b, error)) return true;
  const fs::path full_a = fs::weakly_canonical(fs::absolute(a), error);
  return !error && !full_a.empty() && full_a == fs::weakly_canonical(fs::absolute(b), error);
}

}  // namespace

void add_cloud_flags(CLI::App& app, CloudArguments& a, const std::string& group) {
  app.add_option("CLOUD", a.cloud, "Point cloud, .pcd or .ply (m)")->option_text(" ");
  add_text_flag(app, "--depth", a.depth, "F.png", "Depth image (16-bit gray PNG) instead of CLOUD; needs the next five",
                group);
  add_camera_flags(app, a.camera, group);
  add_text_flag(app, "--viewpoint", a.viewpoint, "X Y Z|none",
                "Where the sensor stood (m), instead of what the cloud says; none: merged views", group);
}

CloudInput::CloudInput(const CloudArguments& a, const std::string& subcommand)
    : path_(a.depth.empty() ? a.cloud : a.depth), is_depth_(!a.depth.empty()) {
  if (a.cloud.empty() && a.depth.empty()) {
    throw UsageError("no cloud given; for example 'handhold " + subcommand +
                     " cloud.pcd', or '--depth image.png' with intrinsics");
  }
  if (!a.cloud.empty() && is_depth_) throw UsageError("both '" + a.cloud + "' and --depth given; give one of them");
  if (is_depth_) {
    camera_ = depth_camera(a.camera, "--depth");
  } else {
    refuse_camera(a.camera, "--depth");
  }
  if (a.viewpoint == "none") {
    viewpoint_ = std::optional<Vector3>();
  } else if (!a.viewpoint.empty()) {
    const std::vector<double> v = a.viewpoint.find_first_not_of("+-.0123456789eE, ") == std::string::npos
                                      ? parse_numbers("--viewpoint", a.viewpoint)
                                      : std::vector<double>();
    if (v.size() != 3) throw UsageError("--viewpoint = '" + a.viewpoint + "': must be three numbers (m) or 'none'");
    viewpoint_ = Vector3{v[0], v[1], v[2]};
  }
}

Cloud CloudInput::read() const {
  Cloud cloud = is_depth_ ? read_depth_png(path_, camera_.intrinsics, camera_.depth_unit_m) : read_cloud(path_);
  if (viewpoint_) cloud.viewpoint = *viewpoint_;
  return cloud;
}

std::string CloudInput::name() const {
  return std::filesystem::path(path_).filename().string();
}

void check_result_paths(const ResultPaths& paths, const std::string& input) {
  const std::pair<std::string, std::string> outputs[] = {
      {"--json", paths.json}, {"--picture", paths.picture}, {"--html", paths.html}};
  if (!paths.html.empty()) check_page_support();
  for (const auto& [flag, path] : outputs) {
    if (path == "-" && flag != "--json") throw UsageError(flag + ": standard output is for JSON; give a file name");
    if (path.empty() || path == "-") continue;
    if (same_file(path, input)) {
      throw UsageError(flag + " would overwrite the input '" + input + "'; give another name");
    }
    AtomicFile::check_writable(path);
    for (const auto& [other, other_path] : outputs) {
      if (other == flag) break;
      if (!other_path.empty() && same_file(other_path, path)) {
        throw UsageError(other + " and " + flag + " both name '" + path + "'; give two names");
      }
    }
  }
}

}  // namespace handhold
