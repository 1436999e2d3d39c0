#include "handhold/options.h"

#include <charconv>
#include <cmath>
#include <utility>

namespace handhold {
namespace {

std::string text(double value) {
  if (std::isnan(value)) return "nan";
  char buffer[32];
  const auto end = std::to_chars(buffer, buffer + sizeof buffer, value).ptr;
  return {buffer, end};
}

[[noreturn]] void fail(const char* name, const std::string& value, const std::string& valid) {
  throw OptionError(std::string(name) + " = " + value + ": must be " + valid);
}

/// low <= value <= high; NaN fails.
void in_range(const char* name, double value, double low, double high, const char* unit) {
  if (!(value >= low && value <= high)) {
    fail(name, text(value), "between " + text(low) + " and " + text(high) + (*unit ? std::string(" ") + unit : ""));
  }
}
/// 0 < value <= high; NaN fails.
void positive(const char* name, double value, double high, const char* unit) {
  if (!(value > 0 && value <= high)) {
    fail(name, text(value), "greater than 0 and at most " + text(high) + " " + unit);
  }
}
void in_range(const char* name, long long value, long long low, long long high) {
  if (value < low || value > high) {
    fail(name, std::to_string(value), "between " + std::to_string(low) + " and " + std::to_string(high));
  }
}

template <class E>
struct Names;
template <>
struct Names<Method> {
  static constexpr const char* kWhat = "method";
  static constexpr std::pair<std::string_view, Method> kAll[] = {{"default", Method::kDefault},
                                                                 {"paper", Method::kPaper}};
};
template <>
struct Names<Strategy> {
  static constexpr const char* kWhat = "strategy";
  static constexpr std::pair<std::string_view, Strategy> kAll[] = {
      {"uniform", Strategy::kUniform}, {"sum", Strategy::kSum}, {"max", Strategy::kMax}};
};
template <>
struct Names<AxisEstimator> {
  static constexpr const char* kWhat = "axis";
  static constexpr std::pair<std::string_view, AxisEstimator> kAll[] = {
      {"taubin", AxisEstimator::kTaubin}, {"normals", AxisEstimator::kNormals}, {"pca", AxisEstimator::kPca}};
};
template <>
struct Names<IndexKind> {
  static constexpr const char* kWhat = "index";
  static constexpr std::pair<std::string_view, IndexKind> kAll[] = {{"embree", IndexKind::kEmbree},
                                                                    {"grid", IndexKind::kGrid}};
};
template <>
struct Names<Backend> {
  static constexpr const char* kWhat = "backend";
  static constexpr std::pair<std::string_view, Backend> kAll[] = {
      {"cpu", Backend::kCpu}, {"cuda", Backend::kCuda}, {"auto", Backend::kAuto}};
};

template <class E>
std::string_view name_of(E value) {
  for (const auto& [name, v] : Names<E>::kAll) {
    if (v == value) return name;
  }
  return {};
}
template <class E>
void parse(std::string_view name, E& value) {
  std::string valid;
  for (const auto& [n, v] : Names<E>::kAll) {
    if (n == name) {
      value = v;
      return;
    }
    valid += (valid.empty() ? "'" : ", '") + std::string(n) + "'";
  }
  fail(Names<E>::kWhat, "'" + std::string(name) + "'", "one of " + valid);
}
template <class E>
void known(E value) {
  if (name_of(value).empty()) fail(Names<E>::kWhat, std::to_string(static_cast<int>(value)), "one of the enumerators");
}

}  // namespace

std::string_view to_string(Method v) {
  return name_of(v);
}
std::string_view to_string(Strategy v) {
  return name_of(v);
}
std::string_view to_string(AxisEstimator v) {
  return name_of(v);
}
std::string_view to_string(IndexKind v) {
  return name_of(v);
}
std::string_view to_string(Backend v) {
  return name_of(v);
}
void from_string(std::string_view name, Method& v) {
  parse(name, v);
}
void from_string(std::string_view name, Strategy& v) {
  parse(name, v);
}
void from_string(std::string_view name, AxisEstimator& v) {
  parse(name, v);
}
void from_string(std::string_view name, IndexKind& v) {
  parse(name, v);
}
void from_string(std::string_view name, Backend& v) {
  parse(name, v);
}

void Options::validate() const {
  known(method), known(strategy), known(axis), known(index), known(backend);
  in_range("samples", samples, 1, 10'000'000);
  if (proposal_sigma) positive("proposal_sigma", *proposal_sigma, 1, "m");
  if (workspace) {
    for (int k = 0; k < 3; ++k) {
      const double low = (*workspace)[2 * k], high = (*workspace)[2 * k + 1];
      if (!(low < high)) {
        fail("workspace", text(low) + " " + text(high),
             std::string("low < high along ") + "xyz"[k] + " (XMIN XMAX YMIN YMAX ZMIN ZMAX in m)");
      }
    }
  }
  if (radius.size() > 8) fail("radius", std::to_string(radius.size()) + " values", "at most 8 radii");
  for (const double r : radius) positive("radius", r, 1, "m");
  if (method == Method::kPaper && radius.size() > 1) {
    fail("radius", std::to_string(radius.size()) + " values", "one radius with method 'paper'");
  }
  in_range("min_neighbours", min_neighbours, 10, 1'000'000);
  positive("hand_aperture", hand_aperture, 1, "m");
  if (!(hand_minimum >= 0 && hand_minimum < hand_aperture)) {
    fail("hand_minimum", text(hand_minimum), "at least 0 and below hand_aperture (" + text(hand_aperture) + " m)");
  }
  positive("finger_thickness", finger_thickness, 0.5, "m");
  positive("finger_width", finger_width, 0.5, "m");
  positive("finger_depth", finger_depth, 0.5, "m");
  in_range("min_free", min_free, 0, 1, "");
  if (reach) positive("reach", *reach, 100, "m");
  in_range("shell_gap_area_mm2", shell_gap_area_mm2, 0, 1e6, "mm^2");
  in_range("shell_inner_area_mm2", shell_inner_area_mm2, 0, 1e6, "mm^2");
  in_range("align_angle", align_angle, 0, 1.5707963267948966, "rad");
  in_range("align_offset", align_offset, 0, 1, "m");
  in_range("align_radius", align_radius, 0, 1, "m");
  positive("handle_gap", handle_gap, 1, "m");
  in_range("handle_min_affordances", handle_min_affordances, 1, 1'000'000);
  in_range("handle_min_length", handle_min_length, 0, 10, "m");
  if (min_confidence) in_range("min_confidence", *min_confidence, 0, 1, "");
  if (deadline_ms) positive("deadline_ms", *deadline_ms, 6e4, "ms");
  in_range("threads", threads, 0, 4096);
}

Options Options::baxter() {
  Options o;
  o.hand_aperture = 0.0767;
  o.hand_minimum = 0.035;
  // The tip's inner face stands 7.75 mm inside the finger's middle, the finger's outer face 6.75 mm outside it.
  o.finger_thickness = 0.0145;
  o.finger_width = 0.016;
  // From the housing of the base, 29 mm about its middle, to the fingertips, 95 mm from there.
  o.finger_depth = 0.066;
  return o;
}

}  // namespace handhold
