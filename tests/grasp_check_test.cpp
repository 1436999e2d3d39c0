// Whether the fingers of a hand fit about a part, against complete geometry.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <stdexcept>
#include <string>

#include "handhold/grasp_check.h"
#include "sensor_test_helpers.h"

namespace handhold::sensor {
namespace {

constexpr double kPi = 3.141592653589793;
constexpr Vector3 kUp = {0, 0, 1}, kAlong = {1, 0, 0};

Object upright(double radius, double height = 0.2) {
  return {"cylinder", transformed(cylinder(radius, height), translation(0, 0, -height / 2)), {}};
}
/// Cylinder along x about the origin.
Object lying(double radius, double length = 0.2) {
  return transformed(upright(radius, length), rotation({0, 1, 0}, kPi / 2));
}

// ---- inside ---------------------------------------------------------------------------------------------------------

TEST(Inside, AgreesWithTheShapes) {
  Scene scene;
  scene.add({"ball",
             revolve([] {
               std::vector<Point2> profile;
               for (int i = 0; i <= 180; ++i)
                 profile.push_back({0.05 * std::sin(kPi * i / 180), -0.05 * std::cos(kPi * i / 180)});
               return profile;
             }()),
             {}},
            translation(0.1, 0, 0));
  scene.add({"ring", torus(0.06, 0.02), {}}, translation(-0.1, 0, 0));
  scene.add({"crossed boxes", merged(box(0.1, 0.02, 0.02), box(0.02, 0.1, 0.02)), {}}, translation(0, 0.2, 0));
  const GraspCheck check(scene);
  std::mt19937 random(7);
  std::uniform_real_distribution<double> x(-0.2, 0.2), y(-0.1, 0.3), z(-0.06, 0.06);
  int within = 0;
  for (int i = 0; i < 20000; ++i) {
    const Eigen::Vector3d p(x(random), y(random), z(random));
    // Distances to the surfaces, negative within; those nearer than the meshes' flat facets decide nothing.
    const double ball = (p - Eigen::Vector3d(0.1, 0, 0)).norm() - 0.05;
    const double ring = std::hypot(std::hypot(p.x() + 0.1, p.y()) - 0.06, p.z()) - 0.02;
    const auto boxed = [&](double a, double b) {
      return std::max({std::abs(p.x()) - a, std::abs(p.y() - 0.2) - b, std::abs(p.z()) - 0.01});
    };
    const double crossed = std::min(boxed(0.05, 0.01), boxed(0.01, 0.05));
    const double nearest = std::min({ball, ring, crossed});
    if (std::abs(nearest) < 1e-4) continue;
    ASSERT_EQ(check.inside({p.x(), p.y(), p.z()}), nearest < 0) << p.transpose();
    within += nearest < 0;
  }
  EXPECT_GT(within, 500);
}

// ---- Which parts fit ------------------------------------------------------------------------------------------------

TEST(GraspCheck, AFreeCylinderFits) {
  Scene scene;
  scene.add(upright(0.02));
  const GraspCheck check(scene);
  const GraspVerdict verdict = check.check({0, 0, 0}, {0, 0, -3}, 0.02);
  EXPECT_TRUE(verdict.fits) << verdict.reason;
  EXPECT_NEAR(verdict.opening, 0.04, 1e-4);
  EXPECT_NEAR(eigen(verdict.approach).norm(), 1, 1e-12);
  EXPECT_NEAR(eigen(verdict.approach).dot(eigen(kUp)), 0, 1e-12);
  EXPECT_EQ(verdict.blocked_by, -1);
  EXPECT_STREQ(verdict.reason, "");
}

TEST(GraspCheck, TheHandOpensAsWideAsItMustAndNotWider) {
  Scene scene;
  scene.add(upright(0.0399));
  EXPECT_TRUE(GraspCheck(scene).check({0, 0, 0}, kUp, 0.0399).fits);
  Scene can;
  can.add(upright(0.05));
  const GraspVerdict verdict = GraspCheck(can).check({0, 0, 0}, kUp, 0.05);
  EXPECT_FALSE(verdict.fits);
  // Said to be thinner than it is: the fingers do not get past it either.
  EXPECT_FALSE(GraspCheck(can).check({0, 0, 0}, kUp, 0.03).fits);
  Hand wide;
  wide.aperture = 0.11;
  EXPECT_TRUE(GraspCheck(can).check({0, 0, 0}, kUp, 0.05, wide).fits);
}

TEST(GraspCheck, ACylinderInAWallDoesNotFit) {
  Scene scene;
  scene.add(upright(0.02));
  scene.add({"wall", box(0.03, 0.4, 0.4), {}});
  const GraspVerdict verdict = GraspCheck(scene).check({0, 0, 0}, kUp, 0.02);
  EXPECT_FALSE(verdict.fits);
  EXPECT_EQ(verdict.blocked_by, 1);
  // Wholly within a solid no surface is near the fingers.
  Scene block;
  block.add(upright(0.02));
  block.add({"block", box(0.5, 0.5, 0.5), {}});
  EXPECT_FALSE(GraspCheck(block).check({0, 0, 0}, kUp, 0.02).fits);
}

TEST(GraspCheck, AWallThinnerThanAnyGridStopsAFinger) {
  Scene scene;
  scene.add(upright(0.02));
  // Sheets around it, far thinner than a finger, for a hand that does not open beyond them.
  Hand hand;
  hand.aperture = 0.052;
  for (int i = 0; i < 8; ++i) {
    scene.add({"sheet", box(0.00002, 0.03, 0.001), {}}, rotation(kUp, kPi / 4 * i) * translation(0.025, 0, 0.004));
  }
  EXPECT_FALSE(GraspCheck(scene).check({0, 0, 0}, kUp, 0.02, hand).fits);
  EXPECT_TRUE(GraspCheck(scene).check({0, 0, 0.015}, kUp, 0.02, hand).fits) << "above the sheets";
}

TEST(GraspCheck, LyingOnATableItFitsFromAboveWhenThereIsRoomForTheFingertips) {
  for (const double radius : {0.002, 0.0028, 0.004, 0.01, 0.03}) {
    Scene scene;
    scene.add(lying(radius), translation(0, 0, radius));
    scene.add(table(1, 1));
    const GraspVerdict verdict = GraspCheck(scene).check({0, 0, radius}, kAlong, radius);
    EXPECT_EQ(verdict.fits, radius > 0.003) << radius << verdict.reason;
    if (verdict.fits) {
      EXPECT_LT(verdict.approach[2], 0) << "downwards";
    } else {
      EXPECT_EQ(verdict.blocked_by, 1) << "the table";
    }
  }
}

TEST(GraspCheck, TwoCylindersCloserThanAFinger) {
  for (const double gap : {0.006, 0.0099, 0.0101, 0.02}) {
    Scene scene;
    scene.add(upright(0.02));
    scene.add(upright(0.02), translation(0.04 + gap, 0, 0));
    const GraspCheck check(scene);
    // From the side that faces the other one no finger passes; along the line of both centers both do, as far as the
    // fingertips stand only a little beyond the axis: so shut that way with a wall.
    scene.add({"wall", box(0.3, 0.01, 0.3), {}}, translation(0.1, 0.026, 0));
    scene.add({"wall", box(0.3, 0.01, 0.3), {}}, translation(0.1, -0.026, 0));
    scene.add({"wall", box(0.01, 0.3, 0.3), {}}, translation(-0.036, 0, 0));
    EXPECT_TRUE(check.check({0, 0, 0}, kUp, 0.02).fits) << "approached along the line of both centers";
    EXPECT_FALSE(GraspCheck(scene).check({0, 0, 0}, kUp, 0.02).fits) << gap;
  }
  // Lying side by side on a table, only an approach from above is left.
  for (const double gap : {0.006, 0.0099, 0.0101, 0.02}) {
    Scene scene;
    scene.add(table(1, 1));
    for (const double sign : {-1.0, 0.0, 1.0}) scene.add(lying(0.02), translation(0, sign * (0.04 + gap), 0.02));
    const GraspVerdict verdict = GraspCheck(scene).check({0, 0, 0.02}, kAlong, 0.02);
    EXPECT_EQ(verdict.fits, gap > 0.01) << gap;
  }
}

TEST(GraspCheck, APlatesRim) {
  constexpr double kRadius = 0.12, kThickness = 0.006;
  const Object plate = {"plate", cylinder(kRadius, kThickness), {}};
  const Vector3 rim = {kRadius - 0.003, 0, kThickness / 2}, tangent = {0, 1, 0};
  Scene flat;
  flat.add(plate);
  flat.add(table(1, 1));
  EXPECT_FALSE(GraspCheck(flat).check(rim, tangent, 0.005).fits) << "lying flat, no finger gets under it";
  EXPECT_FALSE(GraspCheck(flat).check(rim, tangent, 0.02).fits);
  Scene held;
  held.add(plate);
  const GraspVerdict verdict = GraspCheck(held).check(rim, tangent, 0.005);
  EXPECT_TRUE(verdict.fits) << "in the air its edge can be pinched";
  EXPECT_LT(verdict.approach[0], -0.5) << "from outside";
}

TEST(GraspCheck, TheFingersDoNotStandAboveAndBelowATableTop) {
  Scene scene;
  scene.add(lying(0.002), translation(0, 0, 0.002));
  scene.add(table(1, 1));  // 20 mm thick: the hand opens wider than that
  EXPECT_STREQ(GraspCheck(scene).check({0, 0, 0.002}, kAlong, 0.002).reason, "no room for the palm");
  EXPECT_TRUE(GraspCheck(scene).check({0.495, 0, -0.01}, {0, 1, 0}, 0.01).fits) << "its edge can be held";
}

TEST(GraspCheck, NothingThere) {
  Scene scene;
  scene.add(table(1, 1));
  const GraspVerdict verdict = GraspCheck(scene).check({0, 0, 0.1}, kAlong, 0.02);
  EXPECT_FALSE(verdict.fits);
  EXPECT_STREQ(verdict.reason, "nothing between the fingers");
  EXPECT_EQ(verdict.blocked_by, -1);
  EXPECT_STREQ(GraspCheck(Scene{}).check({0, 0, 0}, kUp, 0.01).reason, "nothing between the fingers");
}

TEST(GraspCheck, AHollowPipeIsHeldThoughItsAxisIsEmpty) {
  Scene scene;
  scene.add({"pipe", revolve({{0.018, -0.1}, {0.02, -0.1}, {0.02, 0.1}, {0.018, 0.1}}), {}});
  const GraspCheck check(scene);
  EXPECT_FALSE(check.inside({0, 0, 0}));
  EXPECT_TRUE(check.inside({0.019, 0, 0}));
  // Said to be so thin that the fingers fit inside the pipe: it is held from outside.
  const GraspVerdict verdict = check.check({0, 0, 0}, kUp, 0.005, {0.08, 0, 0.002, 0.02, 0.04});
  EXPECT_TRUE(verdict.fits) << verdict.reason;
  EXPECT_GT(verdict.opening, 0.035);
}

TEST(GraspCheck, EachFingerKeepsItsOwnDistance) {
  Scene scene;
  scene.add(upright(0.02), translation(0.012, 0.009, 0));  // the axis given is 15 mm off
  const GraspVerdict verdict = GraspCheck(scene).check({0, 0, 0}, kUp, 0.02);
  EXPECT_TRUE(verdict.fits) << verdict.reason;
  EXPECT_LE(verdict.opening, 0.08);
}

TEST(GraspCheck, AHandThatDoesNotCloseFarEnoughOpensToItsMinimum) {
  Scene scene;
  scene.add(upright(0.01));
  Hand hand;
  hand.minimum = 0.05;
  const GraspVerdict verdict = GraspCheck(scene).check({0, 0, 0}, kUp, 0.01, hand);
  EXPECT_TRUE(verdict.fits);
  EXPECT_NEAR(verdict.opening, 0.05, 1e-12);
  // With walls at 25 mm, fingers 50 mm apart do not fit between them.
  for (const double sign : {-1.0, 1.0}) {
    scene.add({"wall", box(0.01, 0.2, 0.2), {}}, translation(sign * 0.03, 0, 0));
    scene.add({"wall", box(0.2, 0.01, 0.2), {}}, translation(0, sign * 0.03, 0));
  }
  EXPECT_FALSE(GraspCheck(scene).check({0, 0, 0}, kUp, 0.01, hand).fits);
  EXPECT_TRUE(GraspCheck(scene).check({0, 0, 0}, kUp, 0.01, {0.08, 0, 0.005, 0.02, 0.02}).fits);
}

TEST(GraspCheck, DoesNotDependOnWhereTheSceneStands) {
  for (const double gap : {0.008, 0.012}) {
    const Pose T = translation(0.8, -1.2, 0.4) * rotation({0.3, 0.9, -0.5}, 1.1);
    Scene scene;
    scene.add(table(1, 1), T);
    for (const double sign : {-1.0, 0.0, 1.0}) scene.add(lying(0.02), T * translation(0, sign * (0.04 + gap), 0.02));
    const GraspVerdict verdict = GraspCheck(scene).check(T.point({0, 0, 0.02}), T.direction(kAlong), 0.02);
    EXPECT_EQ(verdict.fits, gap > 0.01);
  }
}

TEST(GraspCheck, TheTableSceneIsAsItsLabelsSay) {
  const Scene scene = table_scene();
  const GraspCheck check(scene);
  for (const Object& object : scene.objects) {
    for (const Part& part : object.parts) {
      if (part.confidence < 0.5) continue;
      EXPECT_TRUE(check.check(part.center, part.axis, part.radius).fits) << part.what;
    }
  }
}

TEST(GraspCheck, FitsSaysTheSame) {
  const Scene scene = table_scene();
  const GraspCheck check(scene);
  std::mt19937 random(3);
  std::uniform_real_distribution<double> x(-0.4, 0.4), z(0, 0.15), r(0, 0.05), d(-1, 1);
  int count = 0;
  for (int i = 0; i < 300; ++i) {
    const Object& object = scene.objects[static_cast<std::size_t>(i) % scene.objects.size()];
    const Vector3& near = object.mesh.vertices[static_cast<std::size_t>(random()) % object.mesh.vertices.size()];
    const Vector3 center = i % 3 ? near : Vector3{x(random), x(random), z(random)}, axis = {d(random), d(random), 1};
    const double radius = r(random);
    const bool fits = check.check(center, axis, radius).fits;
    EXPECT_EQ(check.fits(center, axis, radius), fits);
    count += fits;
  }
  EXPECT_GT(count, 20);
  EXPECT_LT(count, 280);
}

// ---- What is refused ------------------------------------------------------------------------------------------------

TEST(GraspCheck, RefusesWhatCannotBe) {
  const GraspCheck check(Scene{});
  EXPECT_THROW(check.check({0, 0, std::numeric_limits<double>::quiet_NaN()}, kUp, 0.01), std::invalid_argument);
  EXPECT_THROW(check.check({0, 0, 0}, {0, 0, 0}, 0.01), std::invalid_argument);
  EXPECT_THROW(check.check({0, 0, 0}, kUp, -0.01), std::invalid_argument);
  EXPECT_THROW(check.check({0, 0, 0}, kUp, HUGE_VAL), std::invalid_argument);
  Hand hand;
  hand.minimum = 0.09;
  try {
    check.check({0, 0, 0}, kUp, 0.01, hand);
    FAIL();
  } catch (const std::invalid_argument& error) {
    EXPECT_NE(std::string(error.what()).find("minimum"), std::string::npos) << error.what();
  }
  EXPECT_FALSE(check.check({0, 0, 0}, kUp, 0.5).fits) << "wider than any hand";
}

}  // namespace
}  // namespace handhold::sensor
