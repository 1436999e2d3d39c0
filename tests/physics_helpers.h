// What the tests of the physics world share: things put on the table, and ways for the arm.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "handhold/physics.h"
#include "placement.h"

namespace handhold::physics {

using plan::JointVector;

inline const double kTableTop = [] {
  const Table table;
  return table.T_world_table.t[2] + table.size[2] / 2;
}();

/// A thing of default size above the table, as it rests there. @param above  m; gap below its lowest point
inline Thing on_table(const std::string& family, double x, double y, double yaw = 0, double above = 0.002) {
  const sensor::Resting resting = sensor::moved(sensor::at_rest(family, family, {}, {}), x, y, kTableTop + above, yaw);
  Thing thing;
  thing.name = family;
  thing.family = family;
  thing.T_world_object = resting.object.T_world_object;
  for (const ObjectFacts& facts : paper_objects()) {
    if (facts.family == family) thing.mass = facts.mass, thing.friction = facts.friction;
  }
  return thing;
}

/// The hand looks down at a point and closes along a direction of the table that is `yaw` from -y (rad).
inline Pose from_above(double x, double y, double z, double yaw = 0) {
  return sensor::translation(x, y, z) * sensor::rotation({0, 0, 1}, yaw) *
         Pose{{1, 0, 0, 0, -1, 0, 0, 0, -1}, {0, 0, 0}};
}

/// A path and its times.
struct Way {
  std::vector<JointVector> path;
  std::vector<double> times;
};

/// Postures joined by straight lines in joint space; at rest at both ends, at its fastest as fast as plans are: 0.3 of
/// the limits.
inline Way timed(const plan::Arm& arm, const std::vector<JointVector>& postures) {
  constexpr double kSpeed = 0.3, kPeak = 1.875, kSample = 0.02;  // peak: of the time law below; s
  std::vector<double> marks = {0};                               // s, at full speed
  for (std::size_t i = 1; i < postures.size(); ++i) {
    double most = 0;
    for (std::size_t k = 0; k < postures[i].size(); ++k) {
      most = std::max(most, std::abs(postures[i][k] - postures[i - 1][k]) / (kSpeed * arm.joints()[k].velocity));
    }
    marks.push_back(marks.back() + most);
  }
  const int samples = std::max(2, static_cast<int>(std::ceil(kPeak * marks.back() / kSample)));
  Way way;
  for (int n = 0; n <= samples; ++n) {
    const double u = static_cast<double>(n) / samples;
    const double mark = marks.back() * u * u * u * (10 + u * (6 * u - 15));
    std::size_t next = 1;
    while (next + 1 < postures.size() && marks[next] < mark) ++next;
    const double span = marks[next] - marks[next - 1], share = span > 0 ? (mark - marks[next - 1]) / span : 0;
    JointVector q = postures[next - 1];
    for (std::size_t k = 0; k < q.size(); ++k) q[k] += share * (postures[next][k] - postures[next - 1][k]);
    way.path.push_back(q);
    way.times.push_back(n * kSample);
  }
  return way;
}

/// Straight on in space from where the arm stands.
inline Way straight(const plan::Arm& arm, const JointVector& from, const Pose& to) {
  constexpr int kPieces = 20;
  const Pose start = arm.forward(from);
  std::vector<JointVector> postures = {from};
  for (int i = 1; i <= kPieces; ++i) {
    Pose pose = to;  // turns at once: these tests only move along lines
    for (int k = 0; k < 3; ++k) pose.t[k] = start.t[k] + (to.t[k] - start.t[k]) * i / kPieces;
    plan::IkOptions options;
    options.reference = postures.back();
    const auto q = arm.inverse(pose, options);
    if (!q) {
      ADD_FAILURE() << "no joint positions for piece " << i << " of a way";
      break;
    }
    postures.push_back(*q);
  }
  return timed(arm, postures);
}

inline World::Tracking follow(World& world, const Way& way, double opening) {
  return world.follow(way.path, way.times, opening);
}

}  // namespace handhold::physics
