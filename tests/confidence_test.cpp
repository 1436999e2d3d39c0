// The model of confidence: what it must say whatever its weights are.
#include "confidence.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace handhold {
namespace {

/// A hammer's shaft as a camera at 0.8 m sees it.
Evidence shaft() {
  Evidence e;
  e.length = 0.15, e.radius = 0.016, e.sigma = 0.0011, e.arc = 2.4, e.residual = 0.0010, e.free = 0.95;
  e.normal_error = 0.12, e.members = 60, e.corner_gain = 0.1, e.bend = 0.0006, e.waviness = 0.0004;
  e.radius_spread = 0.08, e.axis_spread = 0.08, e.outer = 0.02;
  e.steps_less = 0.95, e.steps_more = 1, e.nearer_end = 0.9, e.farther_end = 0.95;
  e.fall_less = {0.03, 0.03, 0.03}, e.fall_more = {0.04, 0.045, 0.05}, e.followed = 0.16;
  return e;
}

TEST(Confidence, KnowsAShaftFromABoxEdge) {
  EXPECT_GT(confidence(shaft()), 0.9);
  Evidence edge = shaft();
  edge.length = 0.04, edge.radius = 0.012, edge.arc = 1.5, edge.residual = 0.0016, edge.normal_error = 0.36;
  edge.members = 5, edge.corner_gain = -0.3, edge.outer = 0.3, edge.radius_spread = 0.3, edge.axis_spread = 0.2;
  // A face goes on on one side, so that the outline cannot be followed.
  edge.steps_less = 0, edge.fall_less = {}, edge.nearer_end = 2, edge.followed = 0;
  EXPECT_LT(confidence(edge), 0.2);  // far below what is reported, 0.8
}

TEST(Confidence, WorseFitsAreLessLikely) {
  const double at_best = confidence(shaft());
  const auto changed = [](double Evidence::*field, double value) {
    Evidence e = shaft();
    e.*field = value;
    return confidence(e);
  };
  EXPECT_LT(changed(&Evidence::normal_error, 0.4), at_best);
  EXPECT_LE(changed(&Evidence::free, 0.7), at_best);
  EXPECT_LT(changed(&Evidence::corner_gain, -0.4), at_best);
  EXPECT_LT(changed(&Evidence::axis_spread, 0.35), at_best);
  EXPECT_LT(changed(&Evidence::members, 1), at_best);
}

TEST(Confidence, NeverRisesAsTheFingersHaveLessSpace) {
  for (const double length : {0.02, 0.06, 0.2})
    for (const double radius : {0.005, 0.012, 0.03})
      for (const double steps : {0.0, 0.5, 1.0}) {
        Evidence e = shaft();
        e.length = length, e.radius = radius, e.steps_less = steps;
        double last = 1;
        for (double free = 1; free >= 0; free -= 0.02) {
          e.free = free;
          const double p = confidence(e);
          EXPECT_LE(p, last) << free;
          last = p;
        }
      }
}

TEST(Confidence, IsAProbabilityForAnyMeasurement) {
  const double values[] = {0, 1e-12, 0.001, 0.02, 1, 30, 1e6};
  for (double Evidence::*field :
       {&Evidence::length, &Evidence::radius, &Evidence::sigma, &Evidence::arc, &Evidence::residual, &Evidence::free,
        &Evidence::normal_error, &Evidence::members, &Evidence::corner_gain, &Evidence::inner, &Evidence::outer,
        &Evidence::bend, &Evidence::waviness, &Evidence::radius_spread, &Evidence::axis_spread}) {
    for (const double value : values) {
      Evidence e = shaft();
      e.*field = value;
      const double p = confidence(e);
      EXPECT_TRUE(p >= 0 && p <= 1) << value;
    }
  }
}

}  // namespace
}  // namespace handhold
