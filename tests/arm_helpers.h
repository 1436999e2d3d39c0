// What the tests of arms share.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <stdexcept>
#include <string>

#include "handhold/arm.h"

namespace handhold::plan {

using Finger = ElectricGripper::Finger;
using Tip = ElectricGripper::Tip;

inline constexpr ElectricGripper kExtendedNarrow = {Finger::kExtendedNarrow, 2, Tip::kHalfRound};

inline double distance(const Pose& a, const Pose& b) {
  return std::hypot(a.t[0] - b.t[0], a.t[1] - b.t[1], a.t[2] - b.t[2]);
}
/// rad
inline double angle(const Pose& a, const Pose& b) {
  double squares = 0;  // of the chords: of small angles, exact to the last digits
  for (int i = 0; i < 9; ++i) squares += (a.R[i] - b.R[i]) * (a.R[i] - b.R[i]);
  return 2 * std::asin(std::min(1.0, std::sqrt(squares / 8)));
}

inline JointVector random_positions(const Arm& arm, std::mt19937_64& generator) {
  JointVector q;
  for (const Joint& joint : arm.joints()) {
    q.push_back(std::uniform_real_distribution<>(joint.lower, joint.upper)(generator));
  }
  return q;
}

/// Runs `action`, which must throw std::invalid_argument, and returns the message, which must be one line.
template <class Action>
inline std::string message_of(Action action) {
  try {
    action();
  } catch (const std::invalid_argument& error) {
    const std::string message = error.what();
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
    return message;
  }
  ADD_FAILURE() << "nothing was thrown";
  return {};
}
#define EXPECT_MENTIONS(message, part) EXPECT_NE(std::string(message).find(part), std::string::npos) << message

inline std::string text_of_file(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

inline const std::filesystem::path kUrdfFile = std::filesystem::path(HANDHOLD_DATA) / "../engine/plan/baxter.urdf";

}  // namespace handhold::plan
