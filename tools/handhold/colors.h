// Which colour stands for what, in pictures and in the 3-D view.
#pragma once

#include <cstddef>

#include "canvas.h"
#include "handhold/result.h"

namespace handhold {

constexpr std::size_t kStepCount = static_cast<std::size_t>(Step::kCut) + 1;
constexpr Color kCyan{0.1f, 0.87f, 0.95f};

constexpr std::size_t kHandleColors = 10;

// Told apart from each other, from gray, and from the affordances' cyan.
inline Color handle_color(std::size_t i) {
  static constexpr Color kColors[kHandleColors] = {{1.00f, 0.62f, 0.11f}, {0.55f, 0.90f, 0.25f}, {1.00f, 0.38f, 0.62f},
                                                   {0.98f, 0.88f, 0.25f}, {0.66f, 0.56f, 1.00f}, {1.00f, 0.36f, 0.28f},
                                                   {0.20f, 0.80f, 0.55f}, {0.90f, 0.55f, 0.95f}, {0.82f, 0.68f, 0.48f},
                                                   {0.35f, 0.62f, 1.00f}};
  return kColors[i % kHandleColors];
}

/// The further a sample came, the brighter: blue where the surface was not curved enough, red where the hand does not
/// fit, cyan as the affordance that it gave.
inline Color step_color(Step step) {
  switch (step) {
    case Step::kTooFewPoints:
    case Step::kCut:
      return {0.55f, 0.55f, 0.58f};
    case Step::kFlat:
    case Step::kCurvatureLow:
      return {0.35f, 0.45f, 0.85f};
    case Step::kConcave:
      return {0.62f, 0.42f, 0.90f};
    case Step::kCircleWide:
    case Step::kCircleNarrow:
      return {0.98f, 0.75f, 0.25f};
    case Step::kPoorFit:
      return {0.95f, 0.55f, 0.20f};
    case Step::kNoGap:
    case Step::kShellEmpty:
      return {1.00f, 0.33f, 0.30f};
    case Step::kAffordance:
      return kCyan;
  }
  return {};
}

}  // namespace handhold
