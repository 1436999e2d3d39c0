// Figures over all scenes.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "matching.h"

namespace handhold::evaluation {

struct Share {
  std::size_t count = 0, of = 0;
  /// count / of; none of none: 0.
  double value() const { return of ? static_cast<double>(count) / static_cast<double>(of) : 0; }
};

/// Medians over found parts, absolute values; empty when there are none.
struct Errors {
  std::optional<double> center;  ///< m; from the centre line
  std::optional<double> axis;    ///< rad
  std::optional<double> radius;  ///< m
  std::optional<double> length;  ///< m
};

struct Group {
  std::string name;
  Share recall;  ///< of its needed parts
  Errors errors;
  Share precision;  ///< of the handles with a radius in this class; only in Summary::by_radius
};

/// False handles on the objects of a family.
struct FamilyFalse {
  std::string family;
  Share quiet;  ///< of its objects: without a false handle
  Share sound;  ///< of its false handles: would hold something
};

struct ConfidenceBin {
  double from = 0, to = 0;     ///< confidence, from <= c < to (the last one: <= to)
  Share right;                 ///< of its handles
  double mean_confidence = 0;  ///< of its handles; what `right` would be if confidence were calibrated
};

struct Summary {
  std::size_t scenes = 0;
  Share recall;           ///< needed parts that were found
  Share precision;        ///< handles that are the first on a listed part
  Share duplicates;       ///< handles on a part that another handle has found
  Share quiet;            ///< scenes without listed parts that have no handle
  Share unneeding_quiet;  ///< scenes without needed parts (listed ones or not) that have no false handle
  Errors errors;
  std::vector<Group> by_what;     ///< by family where the truth says it, otherwise by name; sorted
  std::vector<Group> by_radius;   ///< classes of 10 mm; empty ones above 40 mm are left out
  std::vector<Group> by_support;  ///< "raised" and "lying"; empty when the truth does not say
  std::array<ConfidenceBin, 10> reliability;
  /// Mean over all handles of |confidence - share right| of their bins; 0 when confidence is calibrated.
  double calibration_error = 0;
  Share sound_handles, sound_affordances;    ///< of those checked
  Share sound_false_handles;                 ///< false handles that would hold something all the same
  std::vector<FamilyFalse> false_by_family;  ///< of all families in the scenes, most false handles first
};

/// parts[i] is the truth of scores[i], handles[i] what was found there.
Summary summarize(const std::vector<SceneScore>& scores, const std::vector<std::vector<LabelledPart>>& parts,
                  const std::vector<std::vector<Handle>>& handles);

}  // namespace handhold::evaluation
