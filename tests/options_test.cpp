// Options: what is refused and how the message says it, presets, and names of enum values.
#include "handhold/options.h"

#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace handhold {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// What validate() says about these options; empty: nothing.
std::string complaint(const Options& options) {
  try {
    options.validate();
  } catch (const OptionError& error) {
    return error.what();
  }
  return {};
}

struct BadValue {
  std::function<void(Options&)> set;
  std::string name, value, valid;  ///< all three must be in the message
};

std::vector<BadValue> bad_values() {
  using O = Options;
  std::vector<BadValue> bad = {
      {[](O& o) { o.samples = 0; }, "samples", "0", "between 1 and 10000000"},
      {[](O& o) { o.samples = -5; }, "samples", "-5", "between 1 and 10000000"},
      {[](O& o) { o.samples = 10'000'001; }, "samples", "10000001", "between 1 and 10000000"},
      {[](O& o) {
         o.workspace = {{1, 0, 0, 1, 0, 1}};
       },
       "workspace", "1 0", "low < high along x"},
      {[](O& o) {
         o.workspace = {{0, 1, 2, 2, 0, 1}};
       },
       "workspace", "2 2", "low < high along y"},
      {[](O& o) {
         o.workspace = {{0, 1, 0, 1, kNan, 1}};
       },
       "workspace", "nan 1", "low < high along z"},
      {[](O& o) { o.radius.assign(9, 0.02); }, "radius", "9 values", "at most 8"},
      {[](O& o) {
         o.method = Method::kPaper, o.radius = {0.02, 0.03};
       },
       "radius", "2 values", "one radius"},
      {[](O& o) {
         o.radius = {0.02, 0};
       },
       "radius", "0", "greater than 0 and at most 1 m"},
      {[](O& o) { o.min_neighbours = 9; }, "min_neighbours", "9", "between 10 and 1000000"},
      {[](O& o) { o.min_neighbours = 1'000'001; }, "min_neighbours", "1000001", "between 10 and 1000000"},
      {[](O& o) { o.hand_minimum = -0.01; }, "hand_minimum", "-0.01", "at least 0 and below hand_aperture (0.08 m)"},
      {[](O& o) { o.hand_minimum = 0.08; }, "hand_minimum", "0.08", "at least 0 and below hand_aperture (0.08 m)"},
      {[](O& o) { o.hand_minimum = kNan; }, "hand_minimum", "nan", "at least 0 and below hand_aperture (0.08 m)"},
      {[](O& o) { o.handle_min_affordances = 0; }, "handle_min_affordances", "0", "between 1 and 1000000"},
      {[](O& o) { o.handle_min_affordances = 1'000'001; }, "handle_min_affordances", "1000001", "between 1 and"},
      {[](O& o) { o.deadline_ms = 0; }, "deadline_ms", "0", "greater than 0 and at most 60000 ms"},
      {[](O& o) { o.deadline_ms = -1; }, "deadline_ms", "-1", "greater than 0"},
      {[](O& o) { o.deadline_ms = kNan; }, "deadline_ms", "nan", "ms"},
      {[](O& o) { o.threads = -1; }, "threads", "-1", "between 0 and 4096"},
      {[](O& o) { o.threads = 4097; }, "threads", "4097", "between 0 and 4096"},
      {[](O& o) { o.method = static_cast<Method>(7); }, "method", "7", "one of"},
      {[](O& o) { o.strategy = static_cast<Strategy>(7); }, "strategy", "7", "one of"},
      {[](O& o) { o.axis = static_cast<AxisEstimator>(7); }, "axis", "7", "one of"},
      {[](O& o) { o.index = static_cast<IndexKind>(7); }, "index", "7", "one of"},
      {[](O& o) { o.backend = static_cast<Backend>(7); }, "backend", "7", "one of"},
  };
  const auto number = [&](const char* name, std::function<void(Options&, double)> set, double value, const char* text,
                          const std::string& valid) {
    bad.push_back({[=](Options& o) { set(o, value); }, name, text, valid});
  };
  const auto positive = [&](const char* name, const std::function<void(Options&, double)>& set, const char* high) {
    const std::string valid = std::string("greater than 0 and at most ") + high + " m";
    number(name, set, 0, "0", valid);
    number(name, set, -0.25, "-0.25", valid);
    number(name, set, 1000.5, "1000.5", valid);
    number(name, set, kNan, "nan", valid);
    number(name, set, kInfinity, "inf", valid);
  };
  positive(
      "proposal_sigma", [](O& o, double v) { o.proposal_sigma = v; }, "1");
  positive(
      "radius", [](O& o, double v) { o.radius = {v}; }, "1");
  positive(
      "hand_aperture", [](O& o, double v) { o.hand_aperture = v; }, "1");
  positive(
      "finger_thickness", [](O& o, double v) { o.finger_thickness = v; }, "0.5");
  positive(
      "finger_width", [](O& o, double v) { o.finger_width = v; }, "0.5");
  positive(
      "finger_depth", [](O& o, double v) { o.finger_depth = v; }, "0.5");
  positive(
      "reach", [](O& o, double v) { o.reach = v; }, "100");
  positive(
      "handle_gap", [](O& o, double v) { o.handle_gap = v; }, "1");

  const auto from_zero = [&](const char* name, const std::function<void(Options&, double)>& set, const char* high) {
    const std::string valid = std::string("between 0 and ") + high;
    number(name, set, -0.25, "-0.25", valid);
    number(name, set, 2e6, "2e+06", valid);
    number(name, set, kNan, "nan", valid);
    number(name, set, kInfinity, "inf", valid);
  };
  from_zero(
      "shell_gap_area_mm2", [](O& o, double v) { o.shell_gap_area_mm2 = v; }, "1e+06 mm^2");
  from_zero(
      "shell_inner_area_mm2", [](O& o, double v) { o.shell_inner_area_mm2 = v; }, "1e+06 mm^2");
  from_zero(
      "align_angle", [](O& o, double v) { o.align_angle = v; }, "1.5707963267948966 rad");
  from_zero(
      "align_offset", [](O& o, double v) { o.align_offset = v; }, "1 m");
  from_zero(
      "align_radius", [](O& o, double v) { o.align_radius = v; }, "1 m");
  from_zero(
      "handle_min_length", [](O& o, double v) { o.handle_min_length = v; }, "10 m");
  from_zero(
      "min_free", [](O& o, double v) { o.min_free = v; }, "1");
  from_zero(
      "min_confidence", [](O& o, double v) { o.min_confidence = v; }, "1");
  return bad;
}

TEST(Options, EveryBadValueIsNamedWithItsRange) {
  for (const BadValue& bad : bad_values()) {
    SCOPED_TRACE(bad.name + " = " + bad.value);
    Options options;
    bad.set(options);
    const std::string message = complaint(options);
    EXPECT_EQ(message.rfind(bad.name + " = ", 0), 0u) << message;
    EXPECT_NE(message.find("= " + bad.value), std::string::npos) << message;
    EXPECT_NE(message.find("must be"), std::string::npos) << message;
    EXPECT_NE(message.find(bad.valid), std::string::npos) << message;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
  }
}

TEST(Options, EveryFieldButTheSeedHasABadValue) {
  std::set<std::string> tested;
  for (const BadValue& bad : bad_values()) tested.insert(bad.name);
  Options options;
  visit_options(options, [&](const auto&, const OptionInfo& info) {
    EXPECT_EQ(tested.count(info.name), std::string(info.name) == "seed" ? 0u : 1u) << info.name;
  });
}

TEST(Options, EndsOfTheRangesAreValid) {
  Options low;
  low.samples = 1, low.min_neighbours = 10, low.hand_minimum = 0, low.handle_min_affordances = 1, low.threads = 0;
  low.shell_gap_area_mm2 = low.shell_inner_area_mm2 = low.align_angle = low.align_offset = low.align_radius = 0;
  low.handle_min_length = 0, low.min_confidence = 0;
  EXPECT_EQ(complaint(low), "");
  Options high;
  high.samples = 10'000'000, high.min_neighbours = high.handle_min_affordances = 1'000'000, high.threads = 4096;
  high.proposal_sigma = 1, high.radius.assign(8, 1), high.hand_aperture = 1, high.finger_thickness = 0.5;
  high.finger_width = high.finger_depth = 0.5, high.reach = 100,
  high.shell_gap_area_mm2 = high.shell_inner_area_mm2 = 1e6;
  high.align_angle = 1.5707963267948966, high.align_offset = high.align_radius = high.handle_gap = 1;
  high.handle_min_length = 10, high.min_confidence = 1;
  high.seed = std::numeric_limits<std::uint64_t>::max();
  high.backend = Backend::kCuda;  // whether there is a GPU is another question
  EXPECT_EQ(complaint(high), "");
}

TEST(Options, PresetsAreValid) {
  EXPECT_EQ(complaint(Options()), "");
  EXPECT_EQ(complaint(Options::baxter()), "");
  Options paper = Options::baxter();
  paper.method = Method::kPaper;
  EXPECT_EQ(complaint(paper), "");
}

TEST(Options, DefaultsThatFollowOthers) {
  Options options;
  options.radius = {0.03, 0.02};
  options.hand_aperture = 0.1;
  EXPECT_DOUBLE_EQ(options.effective_proposal_sigma(), 0.015);
  EXPECT_DOUBLE_EQ(options.effective_reach(), 0.0625);
  options.proposal_sigma = 0.007, options.reach = 0.2;
  EXPECT_EQ(options.effective_proposal_sigma(), 0.007);
  EXPECT_EQ(options.effective_reach(), 0.2);
  EXPECT_EQ(options.effective_min_confidence(), 0.8);
  options.method = Method::kPaper;
  EXPECT_EQ(options.effective_min_confidence(), 0) << "that method's numbers are not probabilities";
  options.min_confidence = 0.3;
  EXPECT_EQ(options.effective_min_confidence(), 0.3);
}

template <class E>
void expect_round_trip(const std::vector<std::pair<E, std::string>>& names) {
  for (const auto& [value, name] : names) {
    EXPECT_EQ(to_string(value), name);
    E parsed = static_cast<E>(99);
    from_string(name, parsed);
    EXPECT_EQ(parsed, value);
  }
  for (const char* wrong : {"", "nonsense", "Default", "uniform ", "tau"}) {
    E value = names.back().first;
    try {
      from_string(wrong, value);
      ADD_FAILURE() << "'" << wrong << "' was taken";
    } catch (const OptionError& error) {
      const std::string message = error.what();
      EXPECT_NE(message.find("'" + std::string(wrong) + "'"), std::string::npos) << message;
      for (const auto& name : names) EXPECT_NE(message.find("'" + name.second + "'"), std::string::npos) << message;
    }
    EXPECT_EQ(value, names.back().first) << "a name that fails must change nothing";
  }
}

TEST(Options, NamesOfEnumValuesComeBack) {
  expect_round_trip<Method>({{Method::kDefault, "default"}, {Method::kPaper, "paper"}});
  expect_round_trip<Strategy>({{Strategy::kUniform, "uniform"}, {Strategy::kSum, "sum"}, {Strategy::kMax, "max"}});
  expect_round_trip<AxisEstimator>(
      {{AxisEstimator::kTaubin, "taubin"}, {AxisEstimator::kNormals, "normals"}, {AxisEstimator::kPca, "pca"}});
  expect_round_trip<IndexKind>({{IndexKind::kEmbree, "embree"}, {IndexKind::kGrid, "grid"}});
  expect_round_trip<Backend>({{Backend::kCpu, "cpu"}, {Backend::kCuda, "cuda"}, {Backend::kAuto, "auto"}});
}

}  // namespace
}  // namespace handhold
