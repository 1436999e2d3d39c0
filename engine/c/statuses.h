// Statuses of C++ and their fixed numbers in C.
#pragma once

#include "handhold/handhold.h"
#include "handhold/result.h"

namespace handhold::c {

#pragma GCC diagnostic push
#pragma GCC diagnostic error "-Wswitch"  // a new status needs a number of its own in handhold.h
inline handhold_status status_of(Status status) noexcept {
  switch (status) {
    case Status::kOk:
      return HANDHOLD_STATUS_OK;
    case Status::kEmpty:
      return HANDHOLD_STATUS_EMPTY;
    case Status::kNoFinitePoints:
      return HANDHOLD_STATUS_NO_FINITE_POINTS;
    case Status::kTooFewPoints:
      return HANDHOLD_STATUS_TOO_FEW_POINTS;
    case Status::kSuspiciousUnits:
      return HANDHOLD_STATUS_SUSPICIOUS_UNITS;
    case Status::kDeadline:
      return HANDHOLD_STATUS_DEADLINE;
    case Status::kCancelled:
      return HANDHOLD_STATUS_CANCELLED;
  }
  return -1;
}
#pragma GCC diagnostic pop

/// The status of a number; false for one that is none.
inline bool status_from(handhold_status number, Status& status) noexcept {
  // The C++ enumerators count from 0 without a gap; the first without a number of its own is beyond the last.
  for (int i = 0; status_of(static_cast<Status>(i)) >= 0; ++i) {
    status = static_cast<Status>(i);
    if (status_of(status) == number) return true;
  }
  return false;
}

}  // namespace handhold::c
