// handhold localize: reads a cloud, finds handles, writes them.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "atomic_file.h"
#include "camera_arguments.h"
#include "command_line.h"
#include "handhold/config.h"
#include "handhold/io.h"
#include "handhold/localizer.h"
#include "kernels.h"
#include "option_arguments.h"
#include "picture.h"
#include "progress.h"
#include "report.h"
#include "result_json.h"
#include "run_times.h"
#include "subcommand.h"
#include "threads.h"
#include "usage_error.h"
#include "why_failed.h"

namespace handhold {
namespace {

struct Arguments {
  OptionArguments options;
  CameraArguments camera;
  std::string cloud, depth;
  std::string viewpoint;
  std::string json, picture;
  std::string repeat;
  bool explain = false, print_options = false, no_times = false, show_samples = false;
};

void add_flags(CLI::App& app, Arguments& a) {
  app.add_option("CLOUD", a.cloud, "Point cloud, .pcd or .ply (m)")->option_text(" ");
  const auto text = [&app](const char* flag, std::string& target, const char* value, const char* help,
                           const char* group) { add_text_flag(app, flag, target, value, help, group); };
  const auto flag = [&app](const char* name, bool& target, const char* help, const char* group) {
    app.add_flag(name, target, help)->disable_flag_override()->group(group);
  };
  const char* input = "Input";
  text("--depth", a.depth, "F.png", "Depth image (16-bit gray PNG) instead of CLOUD; needs the next five", input);
  add_camera_flags(app, a.camera, input);
  text("--viewpoint", a.viewpoint, "X Y Z|none",
       "Where the sensor stood (m), instead of what the cloud says; none: merged views", input);
  add_preset_flags(app, a.options, input);

  const char* output = "Output";
  text("--json", a.json, "F", "Write the result as JSON; '-' is standard output", output);
  text("--picture", a.picture, "F.png", "Write a picture of the cloud and its handles", output);
  flag("--show-samples", a.show_samples, "Draw every sample into --picture, coloured by the step at which it ended",
       output);
  flag("--explain", a.explain, "Say which step ended how many samples, and what would change that", output);
  flag("--print-options", a.print_options, "Print the options in effect as TOML for --config, and exit", output);
  text("--repeat", a.repeat, "N", "Run N times after a warm-up: times are medians and 99th percentiles", output);
  flag("--no-times", a.no_times, "Leave out what differs from run to run: times, number of threads", output);
  add_option_flags(app, a.options.texts);
}

int parse_repeat(const std::string& text) {
  return text.empty() ? 0 : static_cast<int>(whole_number("--repeat", text, 1, 1'000'000));
}

/// Reads what the arguments name; wrong combinations are refused before.
class Input {
 public:
  explicit Input(const Arguments& a) : path_(a.depth.empty() ? a.cloud : a.depth), is_depth_(!a.depth.empty()) {
    if (a.cloud.empty() && a.depth.empty()) {
      throw UsageError(
          "no cloud given; for example 'handhold localize cloud.pcd', or '--depth image.png' with intrinsics");
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

  const std::string& path() const { return path_; }

  Cloud read() const {
    Cloud cloud = is_depth_ ? read_depth_png(path_, camera_.intrinsics, camera_.depth_unit_m) : read_cloud(path_);
    if (viewpoint_) cloud.viewpoint = *viewpoint_;
    return cloud;
  }

 private:
  std::string path_;
  bool is_depth_;
  DepthCamera camera_;
  std::optional<std::optional<Vector3>> viewpoint_;  ///< none: the cloud's own
};

/// The same place on disk, whether or not something is there yet. Devices may be named twice.
bool same_file(const std::string& a, const std::string& b) {
  std::error_code error;
  if (std::filesystem::is_character_file(a, error)) return false;
  if (std::filesystem::equivalent(a, b, error)) return true;
  const std::filesystem::path full_a = std::filesystem::weakly_canonical(std::filesystem::absolute(a), error);
  return !error && !full_a.empty() && full_a == std::filesystem::weakly_canonical(std::filesystem::absolute(b), error);
}

/// Refuses output paths that cannot work before anything is computed.
void check_outputs(const Arguments& a, const std::string& input) {
  if (a.picture == "-") throw UsageError("--picture: standard output is for JSON; give a file name");
  if (a.show_samples && a.picture.empty()) throw UsageError("--show-samples needs --picture, which shows them");
  const std::pair<const char*, const std::string*> outputs[] = {{"--json", &a.json}, {"--picture", &a.picture}};
  for (const auto& [flag, path] : outputs) {
    if (path->empty() || *path == "-") continue;
    if (same_file(*path, input))
      throw UsageError(std::string(flag) + " would overwrite the input '" + input + "'; give another name");
    AtomicFile::check_writable(*path);
  }
  if (!a.json.empty() && !a.picture.empty() && same_file(a.json, a.picture)) {
    throw UsageError("--json and --picture both name '" + a.json + "'; give two names");
  }
}

/// One run, or a warm-up and `repeat` runs.
std::vector<StageTimes> run_repeatedly(Localizer& localizer, const CloudView& cloud, int repeat, Result& result,
                                       Progress& progress) {
  progress.show("searching");
  localizer.localize(cloud, result);
  const bool searched = result.status == Status::kOk || result.status == Status::kDeadline;
  if (repeat == 0 || !searched) return {result.times_ms};
  std::vector<StageTimes> times;
  for (int i = 0; i < repeat; ++i) {
    progress.show("run " + std::to_string(i + 1) + " of " + std::to_string(repeat));
    localizer.localize(cloud, result);
    times.push_back(result.times_ms);
  }
  return times;
}

int run(const Arguments& a) {
  const Options options = effective_options(a.options);
  const int repeat = parse_repeat(a.repeat);
  if (a.print_options) {
    write_and_flush(stdout, to_toml(options), "standard output");
    return 0;
  }
  const Input input(a);
  if (const char* problem = kernels::isa_error()) throw UsageError(problem);
  check_outputs(a, input.path());

  Result result;
  RunTimes run_times;
  PictureOptions picture;
  Cloud cloud;
  {
    Progress progress;
    progress.show("reading " + input.path());
    cloud = input.read();
    const auto more_threads = allow_threads(options.threads);
    Localizer localizer(options);
    run_times = summarize(run_repeatedly(localizer, cloud.view(), repeat, result, progress));
    if (a.show_samples) picture.samples = localizer.samples();
  }
  const RunTimes* times = a.no_times ? nullptr : &run_times;
  const std::string failure = why_failed(input.path(), cloud.view(), options, result);

  // A program that reads the JSON of a frame that failed learns the status from it.
  if (!a.json.empty()) {
    const std::string json = to_json(cloud.view(), options, result, times);
    if (a.json == "-") {
      write_and_flush(stdout, json, "standard output");
    } else {
      write_file(a.json, json);
    }
  }
  if (!failure.empty()) throw std::runtime_error(failure);
  if (!a.picture.empty()) write_picture(a.picture, cloud.view(), cloud.rgb, result, picture);

  std::string text;
  if (a.json.empty()) {
    text += summary_table(input.path(), result, times);
    if (repeat && times) text += times_table(run_times);
    if (result.handles.empty() && !a.explain) text += "add --explain to see why\n";
  }
  if (a.explain) text += explanation(options, result);
  // JSON on standard output stays JSON.
  if (!text.empty()) write_and_flush(a.json == "-" ? stderr : stdout, text, "standard output");
  return 0;
}

}  // namespace

Subcommand add_localize(CLI::App& parent) {
  CLI::App* app = parent.add_subcommand("localize", "Find the handles in a point cloud or a depth image");
  app->allow_extras();
  auto arguments = std::make_shared<Arguments>();
  add_flags(*app, *arguments);
  return {app, [arguments] { return run(*arguments); }};
}

}  // namespace handhold
