#include "camera_arguments.h"

#include <array>
#include <vector>

#include "command_line.h"
#include "handhold/option_text.h"
#include "usage_error.h"

namespace handhold {
namespace {

struct Flag {
  const char* name;
  std::string CameraArguments::*text;
  const char* value;
  const char* help;
};

constexpr std::array<Flag, 5> kFlags = {{
    {"--fx", &CameraArguments::fx, "X", "Focal length along rows (px)"},
    {"--fy", &CameraArguments::fy, "X", "Focal length along columns (px)"},
    {"--cx", &CameraArguments::cx, "X", "Column of the principal point (px)"},
    {"--cy", &CameraArguments::cy, "X", "Row of the principal point (px)"},
    {"--depth-unit-m", &CameraArguments::depth_unit, "U",
     "Metres of one step of the image's values (0.001: millimetres)"},
}};

double number(const char* flag, const std::string& text) {
  const std::vector<double> values = parse_numbers(flag, text);
  if (values.size() != 1) throw UsageError(std::string(flag) + " = '" + text + "': must be one number");
  return values[0];
}

}  // namespace

void add_camera_flags(CLI::App& app, CameraArguments& a, const std::string& group) {
  for (const Flag& flag : kFlags) add_text_flag(app, flag.name, a.*flag.text, flag.value, flag.help, group);
}

DepthCamera depth_camera(const CameraArguments& a, const std::string& who) {
  std::array<double, kFlags.size()> values{};
  for (std::size_t i = 0; i < kFlags.size(); ++i) {
    const char* flag = kFlags[i].name;
    const std::string& text = a.*kFlags[i].text;
    if (text.empty()) throw UsageError(who + " needs " + flag + ", too");
    values[i] = number(flag, text);
    const bool position = kFlags[i].text == &CameraArguments::cx || kFlags[i].text == &CameraArguments::cy;
    if (!position && values[i] <= 0) throw UsageError(std::string(flag) + " = '" + text + "': must be above 0");
  }
  return {{values[0], values[1], values[2], values[3]}, values[4]};
}

void refuse_camera(const CameraArguments& a, const std::string& what) {
  for (const Flag& flag : kFlags) {
    if (!(a.*flag.text).empty()) throw UsageError(std::string(flag.name) + " needs " + what);
  }
}

}  // namespace handhold
