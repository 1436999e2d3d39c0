// Handles against the truth: matching, figures, causes, files.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string>

#include "causes.h"
#include "files.h"
#include "matching.h"
#include "objects.h"
#include "soundness.h"
#include "summary.h"
#include "tables.h"

namespace handhold::evaluation {
namespace {

constexpr double kPi = 3.14159265358979323846;

/// 100 mm along x about `center`.
LabelledPart rod(const std::string& what, const Vector3& center = {0, 0, 1}, double radius = 0.02) {
  LabelledPart part;
  part.what = what;
  part.center = center;
  part.axis = {1, 0, 0};
  part.radius = radius;
  part.length = 0.1;
  part.centre_line = {{center[0] - 0.05, center[1], center[2]}, {center[0] + 0.05, center[1], center[2]}};
  return part;
}

/// Half a circle of 40 mm radius in the plane z = 1, from (40, 0) over (0, 40) to (-40, 0) mm.
LabelledPart bow() {
  LabelledPart part;
  part.what = "bow";
  part.center = {0, 0.04, 1};
  part.axis = {1, 0, 0};
  part.radius = 0.01;
  part.length = 0.04 * kPi;
  for (int i = 0; i <= 90; ++i) {
    part.centre_line.push_back({0.04 * std::cos(kPi * i / 90), 0.04 * std::sin(kPi * i / 90), 1});
  }
  return part;
}

Handle handle(const Vector3& center, double angle = 0, double radius = 0.02, double confidence = 1) {
  Handle h;
  h.center = center;
  h.axis = {std::cos(angle), std::sin(angle), 0};
  h.radius = radius;
  h.length = 0.08;
  h.confidence = confidence;
  return h;
}

bool match(const Handle& h, const LabelledPart& part) {
  return matches(offset(h.center, h.axis, h.radius, part), part);
}

// ---- Matching -------------------------------------------------------------------------------------------------------

TEST(Matching, TheLimitsOfTheRule) {
  const LabelledPart part = rod("rod");
  EXPECT_TRUE(match(handle({0, 0, 1}), part));
  // Along: 50 mm to the end, and 20 mm.
  EXPECT_TRUE(match(handle({0.0699, 0, 1}), part));
  EXPECT_FALSE(match(handle({0.0701, 0, 1}), part));
  EXPECT_TRUE(match(handle({-0.0699, 0, 1}), part));
  EXPECT_FALSE(match(handle({-0.0701, 0, 1}), part));
  // Across: half the radius, and 10 mm.
  EXPECT_TRUE(match(handle({0, 0.0199, 1}), part));
  EXPECT_FALSE(match(handle({0, 0.0201, 1}), part));
  EXPECT_TRUE(match(handle({0.069, 0, 1.0199}), part)) << "both, beyond the end";
  EXPECT_FALSE(match(handle({0, 0.015, 1.015}), part));
  // Axis: |cos| >= 0.8, either way round.
  EXPECT_TRUE(match(handle({0, 0, 1}, std::acos(0.801)), part));
  EXPECT_FALSE(match(handle({0, 0, 1}, std::acos(0.799)), part));
  EXPECT_TRUE(match(handle({0, 0, 1}, kPi - 0.1), part));
  // Radius: 0.4 of 20 mm; of a thin part 5 mm.
  EXPECT_TRUE(match(handle({0, 0, 1}, 0, 0.0279), part));
  EXPECT_FALSE(match(handle({0, 0, 1}, 0, 0.0281), part));
  EXPECT_FALSE(match(handle({0, 0, 1}, 0, 0.0119), part));
  EXPECT_TRUE(match(handle({0, 0, 1}, 0, 0.0109), rod("thin", {0, 0, 1}, 0.006)));
  EXPECT_FALSE(match(handle({0, 0, 1}, 0, 0.0111), rod("thin", {0, 0, 1}, 0.006)));
}

TEST(Matching, ACurvedPartIsMetAnywhereOnItsCentreLineAlongTheTangentThere) {
  const LabelledPart part = bow();
  for (const double at : {0.1, 0.8, 1.5, 2.4, 3.0}) {
    const Vector3 on = {0.04 * std::cos(at), 0.04 * std::sin(at), 1};
    EXPECT_TRUE(match(handle(on, at + kPi / 2, 0.01), part)) << at;
    EXPECT_FALSE(match(handle(on, at, 0.01), part)) << "across, at " << at;
    const Offset o = offset({1.1 * on[0], 1.1 * on[1], 1.003}, {-std::sin(at), std::cos(at), 0}, 0.012, part);
    EXPECT_NEAR(o.distance, std::hypot(0.004, 0.003), 2e-5);
    EXPECT_NEAR(o.angle, 0, 0.03);
    EXPECT_NEAR(o.radius, 0.002, 1e-12);
    EXPECT_EQ(o.along, 0);
  }
  EXPECT_FALSE(match(handle({0, 0, 1}, 0, 0.01), part)) << "the middle of the circle is empty";
  // Beyond an end, along the tangent there.
  EXPECT_TRUE(match(handle({0.04, -0.019, 1}, kPi / 2, 0.01), part));
  EXPECT_FALSE(match(handle({0.04, -0.021, 1}, kPi / 2, 0.01), part));
}

TEST(Matching, WhichPartsAreNeeded) {
  LabelledPart part = rod("rod");
  EXPECT_TRUE(needed(part, {}));
  part.radius = 0.0401;
  EXPECT_FALSE(needed(part, {}));
  EXPECT_TRUE(needed(part, {0.1, 0.5, 0}));
  part = rod("rod");
  part.confidence = 0.5;
  EXPECT_TRUE(needed(part, {}));
  part.confidence = 0.49;
  EXPECT_FALSE(needed(part, {}));
  part = rod("rod");
  part.graspable = false;
  EXPECT_FALSE(needed(part, {}));
  part = rod("rod");
  part.measured = false;
  EXPECT_FALSE(needed(part, {}));
}

TEST(Matching, TheFirstHandleIsRightTheSecondADuplicateAndTheRestAreFalse) {
  const SceneScore score =
      score_scene("s", {rod("a"), rod("b", {0.5, 0, 1})},
                  {handle({0, 0, 1}), handle({0.02, 0, 1}), handle({0, 0.3, 1}), handle({0.5, 0, 1}, 0, 0.02, 0.3)},
                  {0.08, 0.5, 0.4});
  ASSERT_EQ(score.handles.size(), 4u);
  EXPECT_EQ(score.handles[0].verdict, Verdict::kRight);
  EXPECT_EQ(score.handles[1].verdict, Verdict::kDuplicate);
  EXPECT_EQ(score.handles[2].verdict, Verdict::kFalse);
  EXPECT_EQ(score.handles[2].part, -1);
  EXPECT_EQ(score.handles[3].verdict, Verdict::kLeftOut);
  EXPECT_EQ(score.parts[0].handle, 0);
  EXPECT_EQ(score.parts[1].handle, -1) << "a handle that was left out finds nothing";
  EXPECT_NEAR(score.handles[0].length_error, -0.02, 1e-12);
}

TEST(Matching, AHandleCountsForTheNearestOfSeveralParts) {
  const std::vector<LabelledPart> parts = {rod("a"), rod("b", {0.11, 0, 1})};
  EXPECT_EQ(score_scene("s", parts, {handle({0.052, 0, 1})}).handles[0].part, 0);
  EXPECT_EQ(score_scene("s", parts, {handle({0.058, 0, 1})}).handles[0].part, 1);
  // The middle of the short one is nearer, but the handle lies on the long one.
  LabelledPart shoulder = rod("shoulder", {0.065, 0, 1});
  shoulder.centre_line = {{0.05, 0, 1}, {0.08, 0, 1}};
  shoulder.length = 0.03;
  EXPECT_EQ(score_scene("s", {shoulder, parts[0]}, {handle({0.04, 0, 1})}).handles[0].part, 1);
}

// ---- Figures --------------------------------------------------------------------------------------------------------

class Figures : public ::testing::Test {
 protected:
  void add_scene(const std::vector<LabelledPart>& parts, const std::vector<Handle>& handles,
                 const MatchOptions& options = {}) {
    scores_.push_back(score_scene("s" + std::to_string(scores_.size()), parts, handles, options));
    parts_.push_back(parts);
    handles_.push_back(handles);
  }
  Summary summary() const { return summarize(scores_, parts_, handles_); }

  std::vector<SceneScore> scores_;
  std::vector<std::vector<LabelledPart>> parts_;
  std::vector<std::vector<Handle>> handles_;
};

TEST_F(Figures, RecallPrecisionDuplicatesAndQuiet) {
  LabelledPart unsure = rod("unsure", {0.5, 0, 1});
  unsure.confidence = 0.3;
  add_scene({rod("a"), rod("b", {0, 0.5, 1}), unsure},
            {handle({0, 0, 1}), handle({0.01, 0, 1}), handle({0.5, 0, 1}), handle({0, -0.4, 1})});
  add_scene({}, {});
  add_scene({}, {handle({0, 0, 1})});
  add_scene({unsure}, {handle({0.5, 0, 1})});
  const Summary s = summary();
  EXPECT_EQ(s.scenes, 4u);
  EXPECT_EQ(s.recall.count, 1u);
  EXPECT_EQ(s.recall.of, 2u) << "what is not needed is not asked for";
  EXPECT_EQ(s.precision.count, 3u) << "but it is right when found";
  EXPECT_EQ(s.precision.of, 6u);
  EXPECT_EQ(s.duplicates.count, 1u);
  EXPECT_EQ(s.duplicates.of, 6u);
  EXPECT_EQ(s.quiet.count, 1u);
  EXPECT_EQ(s.quiet.of, 2u);
  EXPECT_EQ(s.unneeding_quiet.count, 2u);
  EXPECT_EQ(s.unneeding_quiet.of, 3u);
}

TEST_F(Figures, MediansOfTheErrorsOfFoundParts) {
  add_scene({rod("a")}, {handle({0.03, 0.001, 1}, 0.01, 0.021)});
  add_scene({rod("a")}, {handle({0, 0.005, 1}, 0.05, 0.016)});
  add_scene({rod("a")}, {handle({0, 0, 1.002}, 0.03, 0.022)});
  add_scene({rod("missed")}, {});
  Summary s = summary();
  EXPECT_NEAR(*s.errors.center, 0.002, 1e-12);
  EXPECT_NEAR(*s.errors.axis, 0.03, 1e-9);
  EXPECT_NEAR(*s.errors.radius, 0.002, 1e-12);
  EXPECT_NEAR(*s.errors.length, 0.02, 1e-12);
  add_scene({rod("a")}, {handle({0, 0.004, 1}, 0.05, 0.02)});
  EXPECT_NEAR(*summary().errors.center, 0.003, 1e-12) << "of an even number: the mean of the middle ones";
  EXPECT_FALSE(summarize({}, {}, {}).errors.center);
}

TEST_F(Figures, ByPartRadiusAndSupport) {
  LabelledPart thin = rod("strap", {0, 0, 1}, 0.0099), thick = rod("body", {0, 0.3, 1}, 0.03);
  thin.family = "mug";
  thin.raised = true;
  thick.raised = false;
  add_scene({thin, thick}, {handle({0, 0, 1}, 0, 0.011)});
  add_scene({thick}, {handle({0, 0.3, 1}, 0, 0.03), handle({0, 0, 1}, 0, 0.05)});
  const Summary s = summary();
  ASSERT_EQ(s.by_what.size(), 2u);
  EXPECT_EQ(s.by_what[0].name, "body");
  EXPECT_EQ(s.by_what[0].recall.count, 1u);
  EXPECT_EQ(s.by_what[0].recall.of, 2u);
  EXPECT_EQ(s.by_what[1].name, "mug");
  ASSERT_EQ(s.by_radius.size(), 5u);
  EXPECT_EQ(s.by_radius[0].recall.of, 1u) << "below 10 mm";
  EXPECT_EQ(s.by_radius[0].precision.of, 0u);
  EXPECT_EQ(s.by_radius[1].precision.count, 1u) << "by the handle's own radius";
  EXPECT_EQ(s.by_radius[3].recall.of, 2u) << "30 mm and more";
  EXPECT_EQ(s.by_radius[4].precision.of, 1u);
  ASSERT_EQ(s.by_support.size(), 2u);
  EXPECT_EQ(s.by_support[0].name, "raised");
  EXPECT_EQ(s.by_support[0].recall.count, 1u);
  EXPECT_EQ(s.by_support[1].recall.of, 2u);
  EXPECT_TRUE(summarize({}, {}, {}).by_support.empty());
}

TEST_F(Figures, Reliability) {
  add_scene({rod("a"), rod("b", {0, 0.5, 1})},
            {handle({0, 0, 1}, 0, 0.02, 1.0), handle({0, 0.5, 1}, 0, 0.02, 0.95), handle({0, -0.5, 1}, 0, 0.02, 0.05),
             handle({0, -0.5, 2}, 0, 0.02, 0.9)});
  const Summary s = summary();
  EXPECT_EQ(s.reliability[9].right.of, 3u);
  EXPECT_EQ(s.reliability[9].right.count, 2u);
  EXPECT_NEAR(s.reliability[9].mean_confidence, 0.95, 1e-12);
  EXPECT_EQ(s.reliability[0].right.of, 1u);
  EXPECT_EQ(s.reliability[0].right.count, 0u);
  EXPECT_EQ(s.reliability[5].right.of, 0u);
  EXPECT_NEAR(s.calibration_error, (3 * (0.95 - 2.0 / 3) + 0.05) / 4, 1e-12);
}

// ---- Soundness ------------------------------------------------------------------------------------------------------

TEST(Soundness, HandlesAreCheckedInTheWorldsFrame) {
  // A free rod along the world's z, and a camera that looks at it from the side.
  sensor::Scene geometry;
  geometry.add({"rod", sensor::cylinder(0.02, 0.2), {}, {}});
  geometry.add({"wall", sensor::box(0.02, 1, 1), {}, {}}, sensor::translation(0.5, 0, 0));
  const sensor::Pose T = sensor::look_at({0, -1, 0.1}, {0, 0, 0.1});
  Scene scene;
  const sensor::Pose T_camera_world = T.inverse();
  const auto found = [&](const Vector3& at, double confidence) {
    Handle h = handle(T_camera_world.point(at), 0, 0.02, confidence);
    h.axis = T_camera_world.direction({0, 0, 1});
    return h;
  };
  scene.result.handles = {found({0, 0, 0.1}, 1), found({0.5, 0, 0.1}, 1), found({0, 0.3, 0.1}, 1),
                          found({0, 0, 0}, 0.1)};
  Affordance affordance;
  affordance.center = scene.result.handles[0].center;
  affordance.axis = scene.result.handles[0].axis;
  affordance.radius = 0.018;
  scene.result.affordances = {affordance, affordance};
  scene.result.affordances[1].center = scene.result.handles[1].center;
  scene.score = score_scene("s", {}, scene.result.handles, {0.08, 0.5, 0.5});
  check_soundness(scene, geometry, T, {});
  EXPECT_EQ(scene.score.handles[0].sound, true);
  EXPECT_EQ(scene.score.handles[1].sound, false);
  EXPECT_NE(scene.score.handles[1].unsound.find("wall"), std::string::npos) << scene.score.handles[1].unsound;
  EXPECT_EQ(scene.score.handles[2].sound, false);
  EXPECT_EQ(scene.score.handles[2].unsound, "nothing between the fingers");
  EXPECT_FALSE(scene.score.handles[3].sound) << "left out";
  EXPECT_EQ(scene.score.affordances, 2u);
  EXPECT_EQ(scene.score.sound_affordances, 1u);

  const Summary s = summarize({scene.score}, {{}}, {scene.result.handles});
  EXPECT_EQ(s.sound_handles.count, 1u);
  EXPECT_EQ(s.sound_handles.of, 3u);
  EXPECT_EQ(s.sound_false_handles.count, 1u);
  EXPECT_EQ(s.sound_affordances.of, 2u);
}

// ---- Objects --------------------------------------------------------------------------------------------------------

class Objects : public ::testing::Test {
 protected:
  Objects() {
    // Seen from above and the front: a rod along x and a box on a board, a ball in the air.
    geometry_.add({"table", sensor::box(1, 1, 0.02), {}, {}}, sensor::translation(0, 0, -0.01));
    geometry_.add({"rod_1", sensor::cylinder(0.01, 0.2), {}, {}},
                  sensor::translation(-0.1, 0, 0.01) * sensor::rotation({0, 1, 0}, kPi / 2));
    geometry_.add({"box_2", sensor::box(0.2, 0.2, 0.1), {}, {}}, sensor::translation(0, 0.2, 0.05));
    geometry_.add({"ball_3", sensor::revolve({{0, -0.05}, {0.05, 0}, {0, 0.05}}), {}, {}},
                  sensor::translation(0.3, 0, 0.3));
  }
  /// Name of the object that a handle lies on; all in the world's frame.
  std::string object_of(const Vector3& at, const Vector3& axis, double radius) {
    const sensor::Pose T = sensor::look_at({0, -0.8, 0.6}, {0, 0, 0}), T_camera_world = T.inverse();
    Handle h = handle(T_camera_world.point(at), 0, radius);
    h.axis = T_camera_world.direction(axis);
    scene_.result.handles = {h, h};
    scene_.result.handles[1].confidence = 0.1;
    scene_.score = score_scene("s", {}, scene_.result.handles, {0.08, 0.5, 0.5});
    find_objects(scene_, geometry_, {"board", "rod", "carton", "ball"}, T);
    EXPECT_EQ(scene_.score.handles[1].object, -1) << "left out";
    return scene_.score.objects.at(static_cast<std::size_t>(scene_.score.handles[0].object)).name;
  }

  sensor::Scene geometry_;
  Scene scene_;
};

TEST_F(Objects, AHandleLiesOnWhatItsSideTowardsTheCameraIsNearTo) {
  EXPECT_EQ(object_of({0, 0, 0.01}, {1, 0, 0}, 0.01), "rod_1") << "the board is as near to its axis";
  EXPECT_EQ(object_of({0.3, 0.3, 0.005}, {1, 0, 0}, 0.01), "table");
  EXPECT_EQ(object_of({0, 0.112, 0.088}, {1, 0, 0}, 0.012), "box_2") << "along its edge";
  EXPECT_EQ(object_of({0.3, 0, 0.3}, {0, 0, 1}, 0.03), "ball_3");
  EXPECT_EQ(object_of({0.4, -0.1, 0.4}, {0, 0, 1}, 0.02), "ball_3") << "the nearest one, however far";
  // The sight along the axis: any side will do.
  const Vector3 eye = {0, -0.8, 0.6};
  EXPECT_EQ(object_of({0.3 * eye[0], 0.3 * eye[1], 0.3 * eye[2]}, eye, 0.01), "table");
  ASSERT_EQ(scene_.score.objects.size(), 4u);
  EXPECT_EQ(scene_.score.objects[2].family, "carton");
  EXPECT_THROW(find_objects(scene_, geometry_, {"board"}, {}), std::invalid_argument);
}

TEST_F(Figures, FalseHandlesByFamily) {
  add_scene({rod("a")}, {handle({0, 0, 1}), handle({0, 0.3, 1}), handle({0, 0.4, 1}), handle({0, 0.5, 1})});
  add_scene({}, {handle({0, 0, 1})});
  add_scene({}, {});
  EXPECT_TRUE(summary().false_by_family.empty()) << "objects were not looked at";
  scores_[0].objects = {{"table", "board"}, {"book_1", "book"}, {"book_2", "book"}, {"mug_3", "mug"}};
  scores_[1].objects = {{"table", "board"}, {"book_1", "book"}};
  scores_[2].objects = {{"bowl_1", "bowl"}};
  const auto place = [](HandleCase& h, int object, bool sound) { h.object = object, h.sound = sound; };
  place(scores_[0].handles[0], 3, true);  // right
  place(scores_[0].handles[1], 1, true);
  place(scores_[0].handles[2], 1, false);
  place(scores_[0].handles[3], 0, false);
  place(scores_[1].handles[0], 1, true);
  const Summary s = summary();
  ASSERT_EQ(s.false_by_family.size(), 4u);
  EXPECT_EQ(s.false_by_family[0].family, "book");
  EXPECT_EQ(s.false_by_family[0].sound.of, 3u);
  EXPECT_EQ(s.false_by_family[0].sound.count, 2u);
  EXPECT_EQ(s.false_by_family[0].quiet.of, 3u);
  EXPECT_EQ(s.false_by_family[0].quiet.count, 1u);
  EXPECT_EQ(s.false_by_family[1].family, "board");
  EXPECT_EQ(s.false_by_family[1].quiet.count, 1u);
  EXPECT_EQ(s.false_by_family[2].family, "bowl");
  EXPECT_EQ(s.false_by_family[3].family, "mug");
  EXPECT_EQ(s.false_by_family[3].sound.of, 0u);
  EXPECT_EQ(s.sound_false_handles.count, 2u);
  const std::string text = summary_text(s);
  for (const char* part : {"2 of 4 false handles are sound, 2 unsound\n", "\nfalse handles on  count  sound",
                           "\nbook                  3      2                1/3\n", "\nnone on bowl (1), mug (1)\n"}) {
    EXPECT_NE(text.find(part), std::string::npos) << part << " in\n" << text;
  }
}

// ---- Causes and tables ----------------------------------------------------------------------------------------------

TEST(Causes, SayWhatKeptAPartFromBeingFound) {
  const std::vector<LabelledPart> parts = {rod("a"), rod("b", {0.02, 0, 1})};
  Result result;
  const auto cause = [&] {
    return why_missed(0, parts, result, score_scene("s", parts, result.handles, {0.08, 0.5, 0.4}));
  };
  EXPECT_NE(cause().find("no affordance near"), std::string::npos) << cause();
  Affordance affordance;
  affordance.center = {0.01, 0, 1};
  affordance.axis = {0, 1, 0};
  affordance.radius = 0.02;
  result.affordances = {affordance, affordance};
  EXPECT_NE(cause().find("2 affordances near, 0 with"), std::string::npos) << cause();
  result.handles = {handle({0, 0, 1}, 1.0, 0.035)};
  EXPECT_NE(cause().find("axis is 57 deg off"), std::string::npos) << cause();
  EXPECT_NE(cause().find("radius is 35 mm, not 20"), std::string::npos) << cause();
  result.handles = {handle({0, 0, 1}, 0, 0.02, 0.25)};
  EXPECT_NE(cause().find("confidence is only 0.25"), std::string::npos) << cause();
  result.handles = {handle({0.015, 0, 1})};
  EXPECT_NE(cause().find("counts for 'b'"), std::string::npos) << cause();
}

TEST(Causes, SayWhatIsWrongWithAHandle) {
  Result result;
  result.handles = {handle({0, 0, 1}), handle({0.01, 0, 1}), handle({0, 0.05, 1}), handle({0, 3, 1})};
  const std::vector<LabelledPart> parts = {rod("a")};
  SceneScore score = score_scene("s", parts, result.handles);
  EXPECT_NE(why_false(1, parts, result, score).find("on 'a', which handle 1 has found"), std::string::npos);
  EXPECT_NE(why_false(2, parts, result, score).find("nearest part 'a': 50 mm from its centre line"), std::string::npos)
      << why_false(2, parts, result, score);
  score.handles[3].sound = false;
  score.handles[3].unsound = "no room for the fingers (wall)";
  EXPECT_EQ(why_false(3, parts, result, score), "no part near; unsound: no room for the fingers (wall)");
  score.objects = {{"book_2", "book"}};
  score.handles[3].object = 0;
  EXPECT_EQ(why_false(3, parts, result, score),
            "on 'book_2' (book); no part near; unsound: no room for the fingers (wall)");
  EXPECT_NE(why_false(0, {}, result, score_scene("s", {}, result.handles)).find("no listed part"), std::string::npos);
}

TEST(Tables, EveryLineOfTheCsvHasAllColumns) {
  Scene scene;
  scene.name = "with, comma";
  scene.parts = {rod("a"), rod("a \"quoted\" one", {1, 1, 1})};
  scene.result.handles = {handle({0, 0, 1}), handle({0, 0.5, 1}), handle({0.01, 0, 1})};
  scene.score = score_scene(scene.name, scene.parts, scene.result.handles);
  scene.score.objects = {{"book, thick", "book"}};
  scene.score.handles[1].object = 0;
  scene.score.handles[1].sound = true;
  std::istringstream lines(csv({scene}));
  std::size_t columns = 0, count = 0;
  for (std::string line; std::getline(lines, line); ++count) {
    std::size_t cells = 1;
    bool quoted = false;
    for (const char c : line) {
      quoted ^= c == '"';
      cells += c == ',' && !quoted;
    }
    if (count == 0) columns = cells;
    EXPECT_EQ(cells, columns) << line;
  }
  EXPECT_EQ(count, 1 + 1 + 3 + 2u);
  const std::string text = csv({scene});
  EXPECT_NE(text.find("scene,\"with, comma\",,"), std::string::npos) << text;
  EXPECT_NE(text.find("\"a \"\"quoted\"\" one\",missed"), std::string::npos) << text;
  EXPECT_NE(text.find(",1,\"book, thick\",book,"), std::string::npos) << text;
  const std::string cases = cases_text({scene});
  EXPECT_NE(cases.find("missed 'a \"quoted\" one'"), std::string::npos) << cases;
  EXPECT_NE(cases.find("duplicate handle 3"), std::string::npos) << cases;
  EXPECT_NE(cases.find("false handle 2"), std::string::npos) << cases;
}

// ---- Files ----------------------------------------------------------------------------------------------------------

class Files : public ::testing::Test {
 protected:
  Files() {
    const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
    path_ = (std::filesystem::temp_directory_path() / (std::string("handhold-evaluation-") + test->name())).string();
  }
  ~Files() override { std::filesystem::remove(path_); }

  const std::string& file(const std::string& text) const {
    std::ofstream(path_) << text;
    return path_;
  }
  template <class Read>
  std::string problem(const Read& read, const std::string& text) const {
    try {
      read(file(text));
    } catch (const std::runtime_error& error) {
      EXPECT_NE(std::string(error.what()).find(path_), std::string::npos) << error.what();
      EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
      return error.what();
    }
    return "read it";
  }

  std::string path_;
};

TEST_F(Files, TruthWithAndWithoutWhatMayBeMissing) {
  const auto scenes = read_truth(file(R"({
    "b": [],
    "a": [{"what": "rod", "center": [1, 2, 3], "axis": [0, 0, 2], "radius": 0.01, "length": 0.2},
          {"what": "bow", "family": "mug", "center": [0, 0, 0], "axis": [1, 0, 0], "radius": 0.01, "length": 0.2,
           "confidence": 0.3, "centre_line": [[0, 0, 0], [1, 0, 0], [1, 1, 0]], "visible": 0.4, "graspable": false,
           "measured": false, "raised": true}]})"));
  ASSERT_EQ(scenes.size(), 2u);
  EXPECT_TRUE(scenes.at("b").empty());
  const LabelledPart &rod = scenes.at("a")[0], &bow = scenes.at("a")[1];
  EXPECT_EQ(rod.axis[2], 1);
  ASSERT_EQ(rod.centre_line.size(), 2u);
  EXPECT_NEAR(rod.centre_line[1][2], 3.1, 1e-12);
  EXPECT_EQ(rod.confidence, 1);
  EXPECT_TRUE(rod.measured && rod.graspable && !rod.raised && !rod.visible);
  EXPECT_EQ(bow.family, "mug");
  EXPECT_EQ(bow.centre_line.size(), 3u);
  EXPECT_EQ(bow.visible, 0.4);
  EXPECT_TRUE(!bow.measured && !bow.graspable && *bow.raised);
}

TEST_F(Files, TruthThatCannotBe) {
  const auto fails = [this](const std::string& text) { return problem(read_truth, text); };
  const auto one = [&](const std::string& part) { return fails("{\"s\": [" + part + "]}"); };
  EXPECT_NE(fails("").find("empty"), std::string::npos);
  EXPECT_NE(fails("{\"s\": [").find("not JSON"), std::string::npos);
  EXPECT_NE(fails("[1]").find("no truth file"), std::string::npos);
  EXPECT_NE(fails("{\"s\": 3}").find("scene 's': must be a list of parts"), std::string::npos);
  EXPECT_NE(one("{\"axis\": [1, 0, 0]}").find("part 1: has no \"center\""), std::string::npos);
  EXPECT_NE(one("{\"center\": [0, 0], \"axis\": [1, 0, 0]}").find("center: must be three numbers"), std::string::npos);
  EXPECT_NE(one("{\"center\": [0, 0, 0], \"axis\": [0, 0, 0]}").find("axis: must be a direction"), std::string::npos);
  EXPECT_NE(one(R"({"center": [0, 0, 0], "axis": [1, 0, 0], "radius": -1, "length": 1})").find("radius: must not be"),
            std::string::npos);
  EXPECT_NE(one(R"({"center": [0, 0, 0], "axis": [1, 0, 0], "radius": 1, "length": 0})").find("length above 0"),
            std::string::npos);
  EXPECT_NE(one(R"({"center": [0, 0, 0], "axis": [1, 0, 0], "radius": 1, "length": 1, "graspable": 1})")
                .find("graspable: must be true or false"),
            std::string::npos);
  std::filesystem::remove(path_);
  EXPECT_THROW(read_truth(path_), std::runtime_error);
}

TEST_F(Files, Results) {
  const Result result = read_result(file(R"({"handles": [{"center": [1, 2, 3], "axis": [0, 3, 0], "radius": 0.01,
    "length": 0.1, "confidence": 0.7, "approach": [0, 0, 1]}],
    "affordances": [{"center": [1, 2, 3], "axis": [1, 0, 0], "radius": 0.02}]})"));
  ASSERT_EQ(result.handles.size(), 1u);
  EXPECT_EQ(result.handles[0].axis[1], 1);
  EXPECT_EQ(result.handles[0].confidence, 0.7);
  ASSERT_EQ(result.affordances.size(), 1u);
  EXPECT_EQ(result.affordances[0].radius, 0.02);
  EXPECT_NE(problem(read_result, "{}").find("has no \"handles\""), std::string::npos);
  EXPECT_NE(problem(read_result, "{\"handles\": [{}]}").find("handle 1: has no \"center\""), std::string::npos);
  EXPECT_NE(problem(read_result, "{\"handles\": [], \"affordances\": [1]}").find("affordance 1"), std::string::npos);
}

}  // namespace
}  // namespace handhold::evaluation
