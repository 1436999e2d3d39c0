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
  }
  return "unknown";
}

}  // namespace handhold
