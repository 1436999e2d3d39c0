#include "handhold/result.h"

namespace handhold {

std::string_view to_string(Status status) {
  switch (status) {
    case Status::kOk:
      return "ok";
    case Status::kEmpty:
      return "empty";
    case Status::kNoFinitePoints:
      return "no_finite_points";
    case Status::kTooFewPoints:
      return "too_few_points";
    case Status::kSuspiciousUnits:
      return "suspicious_units";
    case Status::kDeadline:
      return "deadline";
    case Status::kCancelled:
      return "cancelled";
  }
  return "unknown";
}

std::string_view to_string(Step step) {
  switch (step) {
    case Step::kTooFewPoints:
      return "too_few_points";
    case Step::kFlat:
      return "flat";
    case Step::kCurvatureLow:
      return "curvature_low";
    case Step::kConcave:
      return "concave";
    case Step::kCircleWide:
      return "circle_wide";
    case Step::kCircleNarrow:
      return "circle_narrow";
    case Step::kPoorFit:
      return "poor_fit";
    case Step::kNoGap:
      return "no_gap";
    case Step::kShellEmpty:
      return "shell_empty";
    case Step::kAffordance:
      return "affordance";
    case Step::kCut:
      return "cut";
  }
  return "unknown";
}

}  // namespace handhold
