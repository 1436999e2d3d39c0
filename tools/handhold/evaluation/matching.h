// When a handle counts as a part of the truth, and what becomes of all handles and parts of a scene.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "handhold/result.h"
#include "handhold/sensor.h"

namespace handhold::evaluation {

/// A part of a truth file: what there is to find. Frame of the scene's cloud.
struct LabelledPart {
  std::string what;                  ///< "bottle neck"
  std::string family;                ///< of its object, for tables; empty: not said
  Vector3 center = {0, 0, 0};        ///< m; middle of the centre line
  Vector3 axis = {0, 0, 1};          ///< unit; tangent there
  double radius = 0;                 ///< m
  double length = 0;                 ///< m; along the centre line
  double confidence = 1;             ///< 0..1; below 0.5 the part is not asked for
  std::vector<Vector3> centre_line;  ///< m; at least two points
  std::optional<double> visible;     ///< 0..1; share of the camera-facing surface that the camera sees
  bool measured = true;              ///< enough of it was measured to find it
  bool graspable = true;             ///< a hand could hold it where it stands
  std::optional<bool> raised;        ///< free of its support; false: lying on it
};

/// A simulated part as a truth file would give it.
LabelledPart labelled(const sensor::Part& part);

/// Where something lies with respect to a part: measured at the nearest point of the part's centre line, which may be
/// curved.
struct Offset {
  double along = 0;     ///< m; beyond the end of the centre line; 0 beside it
  double across = 0;    ///< m; from the centre line (beyond an end: from its straight continuation)
  double distance = 0;  ///< m; from the nearest point of the centre line
  double angle = 0;     ///< rad, 0..pi/2; between its axis and the tangent
  double radius = 0;    ///< m; its radius less the part's
};
Offset offset(const Vector3& center, const Vector3& axis, double radius, const LabelledPart& part);

/// Close enough to be at the part: at most 20 mm beyond its end and radius/2 + 10 mm across.
bool near(const Offset& offset, const LabelledPart& part);
/// Near, axes that agree to |cos| >= 0.8, and radii to max(5 mm, 0.4 radius).
bool matches(const Offset& offset, const LabelledPart& part);

enum class Verdict {
  kRight,      ///< the first handle on a listed part
  kDuplicate,  ///< on a part that another handle has found
  kFalse,      ///< on no listed part
  kLeftOut,    ///< below the confidence that was asked for: not counted
};

struct HandleCase {
  Verdict verdict = Verdict::kFalse;
  int part = -1;              ///< index of the part that it is on; -1: none
  Offset offset;              ///< from that part
  double length_error = 0;    ///< m; its length less the part's
  std::optional<bool> sound;  ///< whether a hand would hold something there; empty: not checked
  std::string unsound;        ///< why not, when it is not sound
  int object = -1;            ///< index into SceneScore::objects of what it lies on; -1: not looked at
};

struct PartCase {
  bool needed = false;  ///< has to be found
  int handle = -1;      ///< index of the handle that found it; -1: none
};

struct MatchOptions {
  double hand_aperture = 0.08;   ///< m; wider parts are not needed
  double part_confidence = 0.5;  ///< parts less sure than this are not needed
  double min_confidence = 0;     ///< handles below it are left out
};

/// A thing of a scene.
struct SceneObject {
  std::string name;
  std::string family;
};

struct SceneScore {
  std::string name;
  std::vector<HandleCase> handles;    ///< one for each handle of the result
  std::vector<PartCase> parts;        ///< one for each part of the truth
  std::size_t affordances = 0;        ///< checked for soundness, ...
  std::size_t sound_affordances = 0;  ///< ... and found sound
  std::vector<SceneObject> objects;   ///< of the scene; empty when they were not looked at
};

/// Whether a result has to have a handle there: sure enough, no wider than the hand opens, graspable and measured.
bool needed(const LabelledPart& part, const MatchOptions& options);

/// Decides every handle, in their order: each counts for the part with the nearest centre line among those it
/// matches (of equally near ones, with the nearest middle).
SceneScore score_scene(const std::string& name, const std::vector<LabelledPart>& parts,
                       const std::vector<Handle>& handles, const MatchOptions& options = {});

}  // namespace handhold::evaluation
