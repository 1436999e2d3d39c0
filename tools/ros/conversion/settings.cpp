#include "settings.h"

#include <algorithm>
#include <exception>
#include <type_traits>

#include "handhold/config.h"
#include "handhold/localizer.h"
#include "handhold/option_text.h"

namespace handhold::ros_bridge {
namespace {

/// Calls visit(name, field) for what only a node has.
template <class S, class Visitor>
void visit_settings(S& s, Visitor&& visit) {
  visit("config", s.config);
  visit("hand", s.hand);
  visit("workspace_frame", s.workspace_frame);
  visit("viewpoint_frame", s.viewpoint_frame);
  visit("fixed_frame", s.fixed_frame);
  visit("base_frame", s.base_frame);
  visit("track", s.track);
  visit("transform_timeout", s.transform_timeout);
  visit("input_timeout", s.input_timeout);
  visit("diagnostics_period", s.diagnostics_period);
}

struct FromText {
  const std::string& name;
  const std::string& text;

  [[noreturn]] void fail(const std::string& right) const {
    throw OptionError(name + " = '" + text + "': must be " + right);
  }
  void operator()(std::string& field) const {
    if (name == "hand" && !text.empty() && text != "baxter") fail("'baxter', or empty");
    field = text;
  }
  void operator()(bool& field) const {
    if (text != "true" && text != "false") fail("true or false");
    field = text == "true";
  }
  void operator()(double& field) const {
    const double low = name == "transform_timeout" ? 0 : 0.1, high = 3600;
    const std::vector<double> values = parse_numbers(name, text);
    if (values.size() != 1 || values[0] < low || values[0] > high) {
      fail(low == 0 ? "from 0 to 3600 s" : "from 0.1 to 3600 s");
    }
    field = values[0];
  }
};

template <class Work>
bool try_to(std::vector<std::string>& problems, const std::string& where, Work&& work) {
  try {
    work();
    return true;
  } catch (const std::exception& error) {
    problems.push_back(where + error.what());
    return false;
  }
}

/// The option that a message begins with.
std::string first_word(const std::string& message) {
  return message.substr(0, message.find_first_not_of("abcdefghijklmnopqrstuvwxyz_0123456789"));
}

/// Brings options that are out of range, or do not go together, back to what they were.
void make_valid(Options& options, const Options& good, const std::string& where, std::vector<std::string>& problems) {
  for (std::size_t i = option_names().size(); i > 0; --i) {
    try {
      options.validate();
      return;
    } catch (const OptionError& error) {
      const std::string name = first_word(error.what());
      problems.push_back(where + error.what());
      const std::vector<std::string> names = option_names();
      if (std::find(names.begin(), names.end(), name) == names.end()) break;
      set_option(options, name, get_option(good, name));
    }
  }
  try {
    options.validate();
  } catch (const OptionError&) {
    options = good;
  }
}

/// Whether the GPU is there turns out when a localizer is made, and no cloud should have to wait for that.
void make_runnable(Options& options, const Options& good, const std::string& where,
                   std::vector<std::string>& problems) {
  if (options.backend != Backend::kCuda) return;
  if (try_to(problems, where, [&] { Localizer localizer(options); })) return;
  // The last good one may be the same, with options that the GPU could do.
  options.backend = good.backend == Backend::kCuda ? Backend::kAuto : good.backend;
}

}  // namespace

const std::vector<std::string>& arm_parameters() {
  static const std::vector<std::string> names = {"arm",   "arm_file", "fingers", "slot",  "tip",
                                                 "start", "table",    "order",   "grasps"};
  return names;
}

Settings read_settings(const Texts& parameters, const Settings& good, const std::string& where,
                       const ArmOptions& arm_options, std::vector<std::string>& problems) {
  const std::string before = "parameter " + where + "/";
  Settings s;
  const std::vector<std::string> options = option_names();
  std::vector<std::string> known = options;
  visit_settings(s, [&](const char* name, auto& field) {
    known.emplace_back(name);
    const auto given = parameters.find(name);
    if (given == parameters.end()) return;
    if (try_to(problems, before, [&] { FromText{given->first, given->second}(field); })) return;
    visit_settings(good, [&](const std::string& other, const auto& last) {
      if constexpr (std::is_same_v<decltype(last), std::add_const_t<std::decay_t<decltype(field)>>&>) {
        if (other == name) field = last;
      }
    });
  });
  known.insert(known.end(), arm_parameters().begin(), arm_parameters().end());
  for (const auto& [name, text] : parameters) {
    if (std::find(known.begin(), known.end(), name) != known.end()) continue;
    const std::string nearest = nearest_name(name, known);
    problems.push_back("unknown parameter " + where + "/" + name + "; " +
                       (nearest.empty() ? "parameters are the names of options, as in hand_aperture"
                                        : "did you mean '" + nearest + "'?"));
  }

  if (s.hand == "baxter") s.options = Options::baxter();
  for (const std::string& name : arm_parameters()) {
    const auto given = parameters.find(name);
    if (given != parameters.end() && !given->second.empty()) s.arm[name] = given->second;
  }
  if (!s.arm.empty() && !arm_options) {
    problems.push_back(before + s.arm.begin()->first + ": this node was built without handhold::plan and cannot plan");
    s.arm.clear();
  } else if (!s.arm.empty()) {
    const auto take = [&] { s.options = arm_options(s.arm); };
    if (!try_to(problems, before, take)) {
      s.arm = good.arm;
      if (!s.arm.empty()) s.options = arm_options(s.arm);
    }
  }
  if (!s.config.empty()) {
    const auto take = [&] { apply_toml_file(s.options, s.config); };
    if (!try_to(problems, before + "config: ", take)) s.options = good.options;
  }
  for (const std::string& name : options) {
    const auto given = parameters.find(name);
    if (given == parameters.end()) continue;
    const auto take = [&] { set_option(s.options, name, given->second); };
    if (!try_to(problems, before, take)) set_option(s.options, name, get_option(good.options, name));
  }
  make_valid(s.options, good.options, before, problems);
  make_runnable(s.options, good.options, before, problems);
  return s;
}

}  // namespace handhold::ros_bridge
