// The switches of the default method's conditions: on, they are the localizer as it is; off, each changes what is
// found.
#include "conditions.h"

#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "demo_cloud.h"
#include "handhold/sensor.h"
#include "localizer_detail.h"

namespace handhold {
namespace {

/// All handles, to the last digit.
std::string found(Localizer localizer) {
  std::string text;
  for (const Handle& h : localizer.localize(test::demo_cloud().view()).handles) {
    for (const Vector3& v : {h.center, h.axis, h.approach})
      for (const double x : v) text += std::to_string(x) + ' ';
    for (const double x : {h.radius, h.length, h.confidence, h.observed_free}) text += std::to_string(x) + ' ';
    text += '\n';
  }
  return text;
}

Options every_candidate() {
  Options options;
  options.samples = 3000;
  options.min_confidence = 0;
  return options;
}

TEST(Conditions, AllOnAreTheLocalizer) {
  EXPECT_EQ(found(LocalizerInside::make(every_candidate(), {})), found(Localizer(every_candidate())));
}

// join_curved changes nothing in this scene: its bows are followed in one piece. chain_test has what it does.
TEST(Conditions, EachOneOffChangesWhatIsFound) {
  using C = Conditions;
  std::vector<std::pair<const char*, bool C::*>> switches = {{"fill_shadows", &C::fill_shadows},
                                                             {"fill_void", &C::fill_void},
                                                             {"seen_empty", &C::seen_empty},
                                                             {"other_angles", &C::other_angles},
                                                             {"refine", &C::refine},
                                                             {"least_arc", &C::least_arc},
                                                             {"convex", &C::convex},
                                                             {"ends", &C::ends},
                                                             {"straps", &C::straps},
                                                             {"outline", &C::outline},
                                                             {"refit", &C::refit},
                                                             {"filter_normals", &C::filter_normals},
                                                             {"cut_profile", &C::cut_profile},
                                                             {"pass_flat", &C::pass_flat},
                                                             {"bows", &C::bows},
                                                             {"continue_parts", &C::continue_parts}};
  const std::string standard = found(Localizer(every_candidate()));
  for (const auto& [name, condition] : switches) {
    Conditions conditions;
    conditions.*condition = false;
    EXPECT_NE(found(LocalizerInside::make(every_candidate(), conditions)), standard) << name;
  }
}

TEST(Conditions, FixedEvidenceIsWhatTheCandidatesHave) {
  Conditions conditions;
  conditions.normal_error = 0.15, conditions.corner_gain = 0.3;
  Localizer localizer = LocalizerInside::make(every_candidate(), conditions);
  localizer.localize(test::demo_cloud().view());
  std::size_t with_normals = 0;
  for (const PartCandidate& candidate : LocalizerInside::candidates(localizer)) {
    EXPECT_EQ(candidate.evidence.corner_gain, 0.3);
    with_normals += candidate.evidence.normal_error == 0.15;
    EXPECT_TRUE(candidate.evidence.normal_error == 0.15 || candidate.evidence.normal_error == 0);
  }
  EXPECT_GE(with_normals, 3u);
}

}  // namespace
}  // namespace handhold
