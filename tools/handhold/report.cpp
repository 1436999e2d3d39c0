#include "report.h"

#include <algorithm>
#include <charconv>
#include <cstdarg>
#include <cstdint>
#include <cstdio>
#include <vector>

namespace handhold {
namespace {

__attribute__((format(printf, 1, 2))) std::string format(const char* pattern, ...) {
  char line[512];
  va_list arguments;
  va_start(arguments, pattern);
  std::vsnprintf(line, sizeof line, pattern, arguments);
  va_end(arguments);
  return line;
}

/// "1 handle", "2 handles", "no handles"
std::string counted(std::int64_t n, const std::string& what) {
  if (n == 0) return "no " + what + "s";
  return std::to_string(n) + " " + what + (n == 1 ? "" : "s");
}

std::string number(double value) {
  char digits[32];
  return {digits, std::to_chars(digits, digits + sizeof digits, value).ptr};
}

/// An option with its value as the user would write it: "reach = 0.05 m".
std::string setting(const char* name, double value, const char* unit = "") {
  return std::string(name) + " = " + number(value) + (*unit ? " " : "") + unit;
}

std::string counts(const StepCount& step, std::int64_t whole) {
  if (step.count == 0) return {};
  const double percent = whole > 0 ? 100.0 * static_cast<double>(step.count) / static_cast<double>(whole) : 0;
  const std::string settings = step.settings.empty() ? "" : " (" + step.settings + ")";
  return format("%9lld  %5.1f %%  ", static_cast<long long>(step.count), percent) + step.what + settings + "\n";
}

/// Advice for the steps that cost most, at most `most` of them.
std::string advice(std::vector<StepCount> steps, std::int64_t whole, std::size_t most) {
  std::stable_sort(steps.begin(), steps.end(),
                   [](const StepCount& a, const StepCount& b) { return a.count > b.count; });
  std::string text;
  for (std::size_t i = 0; i < std::min(most, steps.size()); ++i) {
    // What cost less than a twentieth is not worth a word.
    if (steps[i].count * 20 < whole || steps[i].count == 0) break;
    text +=
        format("%9lld that ", static_cast<long long>(steps[i].count)) + steps[i].what + ": " + steps[i].advice + "\n";
  }
  return text;
}

}  // namespace

std::vector<StepCount> sample_steps(const Options& o, const Funnel& f) {
  const bool paper = o.method == Method::kPaper;
  std::string radii;
  for (const double r : o.effective_radius()) radii += (radii.empty() ? "" : " ") + number(r);
  return {
      {"too_few_points", f.too_few_points, "had too few points around them",
       setting("min_neighbours", o.min_neighbours) + ", radius = " + radii + " m",
       "raise --radius or lower --min-neighbours; the cloud is sparse there"},
      {"flat", f.flat, "lay on a plane, a line or a single place", "",
       "no option makes them curved; --workspace keeps samples off tables and walls"},
      {"curvature_low", f.curvature_low, "lay on a surface too flat for the hand",
       setting("reach", o.effective_reach(), "m"),
       "raise --reach or --hand-aperture if the hand is larger; --workspace keeps samples off tables and walls"},
      {"concave", f.concave, "lay in a hollow", "", "nothing can be held there from the sensor's side"},
      {"circle_wide", f.circle_wide, "lay on something wider than the hand opens",
       setting("hand_aperture", o.hand_aperture, "m"),
       "raise --hand-aperture if the hand opens wider; a smaller --radius fits smaller circles"},
      {"circle_narrow", f.circle_narrow, "lay on something narrower than the hand closes",
       setting("hand_minimum", o.hand_minimum, "m"), "lower --hand-minimum if the hand closes further"},
      {"poor_fit", f.poor_fit, "lay on a surface that no cylinder fits", "",
       "other --radius values fit parts of other sizes"},
      paper ? StepCount{"no_gap", f.no_gap, "had no free gap for the fingers around them",
                        setting("finger_thickness", o.finger_thickness, "m"),
                        "lower --finger-thickness or --finger-width, or raise --shell-gap-area-mm2 for a noisy sensor"}
            : StepCount{"no_gap", f.no_gap, "had no place for two fingers that was seen to be empty",
                        setting("finger_thickness", o.finger_thickness, "m") + ", " +
                            setting("finger_depth", o.finger_depth, "m") + ", " + setting("min_free", o.min_free),
                        "lower --finger-thickness or --min-free, or raise --finger-depth if the fingers are longer"},
      {"shell_empty", f.shell_empty, "had a gap, but too little surface within it",
       setting("shell_inner_area_mm2", o.shell_inner_area_mm2, "mm^2"),
       "lower --shell-inner-area-mm2 or raise --finger-width"},
      {"cut", f.cut, "were not looked at in time", o.deadline_ms ? setting("deadline_ms", *o.deadline_ms, "ms") : "",
       "raise --deadline-ms, or lower --samples"},
  };
}

std::vector<StepCount> affordance_steps(const Options& o, const Funnel& f) {
  return {
      {"not_aligned", f.not_aligned, "had too few aligned neighbours",
       setting("handle_min_affordances", o.handle_min_affordances) + ", " +
           setting("align_angle", o.align_angle, "rad") + ", " + setting("align_offset", o.align_offset, "m") + ", " +
           setting("align_radius", o.align_radius, "m"),
       "raise --samples, --align-angle, --align-offset or --align-radius, or lower --handle-min-affordances"},
      {"unconfirmed", f.unconfirmed, "belonged to groups that the points of the cloud do not bear out",
       setting("min_free", o.min_free),
       "raise --samples; the part is short, of several pieces, or beside space that was not seen"},
      {"too_short", f.too_short, "stood in a row too short for a handle",
       setting("handle_min_length", o.handle_min_length, "m"),
       "lower --handle-min-length, or raise --handle-gap or --samples"},
      {"low_confidence", f.low_confidence, "belonged to handles of low confidence",
       setting("min_confidence", o.effective_min_confidence()), "lower --min-confidence"},
  };
}

std::string summary_table(const std::string& source, const Result& result, const RunTimes* times) {
  std::string text = counted(static_cast<std::int64_t>(result.handles.size()), "handle") + " in " + source;
  text += format(": %zu points, %zu finite; %s, ", result.points, result.finite_points,
                 counted(result.funnel.samples, "sample").c_str());
  text += counted(static_cast<std::int64_t>(result.affordances.size()), "affordance");
  if (times) text += format("; %.1f ms", times->median_ms.total);
  if (result.status == Status::kDeadline) text += "; cut by the deadline";
  text += "\n";
  if (result.handles.empty()) return text;
  text += "  no     centre x        y        z mm     axis x      y      z   radius mm  length mm  confidence\n";
  int number = 0;
  for (const Handle& h : result.handles) {
    text += format("%4d     %8.1f %8.1f %8.1f       %7.3f%7.3f%7.3f   %9.1f  %9.1f  %10.2f\n", ++number,
                   1e3 * h.center[0], 1e3 * h.center[1], 1e3 * h.center[2], h.axis[0], h.axis[1], h.axis[2],
                   1e3 * h.radius, 1e3 * h.length, h.confidence);
  }
  return text;
}

std::string times_table(const RunTimes& times) {
  std::string text = format("times of %d runs     median ms     99th percentile ms\n", times.runs);
  for (const auto& [name, stage] : kStages) {
    text += format("  %-16s  %11.3f  %21.3f\n", name, times.median_ms.*stage, times.p99_ms.*stage);
  }
  return text;
}

std::string explanation(const Options& options, const Result& result) {
  const Funnel& funnel = result.funnel;
  if (funnel.samples == 0) {
    return options.workspace ? "no samples: no point of the cloud lies inside --workspace\n"
                             : "no samples were drawn\n";
  }
  const std::vector<StepCount> samples = sample_steps(options, funnel);
  std::string text = "of " + counted(funnel.samples, "sample") + ":\n";
  for (const StepCount& step : samples) text += counts(step, funnel.samples);
  text += counts({"affordances", funnel.affordances, "gave an affordance", {}, {}}, funnel.samples);
  std::string what_helps = advice(samples, funnel.samples, 3);
  if (funnel.affordances > 0) {
    const std::vector<StepCount> affordances = affordance_steps(options, funnel);
    text += "of " + counted(funnel.affordances, "affordance") + ":\n";
    for (const StepCount& step : affordances) text += counts(step, funnel.affordances);
    text += counts({"in_handles",
                    funnel.in_handles,
                    "ended in " + counted(static_cast<std::int64_t>(result.handles.size()), "handle"),
                    {},
                    {}},
                   funnel.affordances);
    what_helps += advice(affordances, funnel.affordances, 2);
  }
  if (!what_helps.empty()) text += "what would change that:\n" + what_helps;
  return text;
}

}  // namespace handhold
