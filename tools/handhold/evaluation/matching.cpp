#include "matching.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "projection.h"

namespace handhold::evaluation {
namespace {

constexpr double kBeyond = 0.020, kAcrossRadii = 0.5, kAcross = 0.010;  // m
constexpr double kLeastCosine = 0.8, kRadiusShare = 0.4, kRadius = 0.005;

}  // namespace

LabelledPart labelled(const sensor::Part& part) {
  LabelledPart l;
  l.what = part.what;
  l.family = part.family;
  l.center = part.center;
  l.axis = part.axis;
  l.radius = part.radius;
  l.length = part.length;
  l.confidence = part.confidence;
  l.centre_line = part.centre_line;
  l.visible = part.visible;
  l.measured = part.measured;
  l.graspable = part.graspable;
  l.raised = part.raised;
  return l;
}

Offset offset(const Vector3& center, const Vector3& axis, double radius, const LabelledPart& part) {
  Offset best;
  best.distance = HUGE_VAL;
  const std::vector<Vector3>& line = part.centre_line;
  for (std::size_t i = 0; i + 1 < line.size(); ++i) {
    const Vector3 step = add(line[i + 1], line[i], -1), from = add(center, line[i], -1);
    const double length = norm(step);
    if (!(length > 0)) continue;
    const Vector3 tangent = unit(step);
    const double s = dot(from, tangent), clamped = std::clamp(s, 0.0, length);
    const double distance = norm(add(from, tangent, -clamped));
    if (distance >= best.distance) continue;
    const bool beyond = (s < 0 && i == 0) || (s > length && i + 2 == line.size());
    best.distance = distance;
    best.along = beyond ? std::abs(s - clamped) : 0;
    best.across = beyond ? norm(add(from, tangent, -s)) : distance;
    best.angle = std::acos(std::min(1.0, std::abs(dot(unit(axis), tangent))));
  }
  best.radius = radius - part.radius;
  return best;
}

bool near(const Offset& offset, const LabelledPart& part) {
  return offset.along <= kBeyond && offset.across <= kAcrossRadii * part.radius + kAcross;
}

bool matches(const Offset& offset, const LabelledPart& part) {
  return near(offset, part) && std::cos(offset.angle) >= kLeastCosine &&
         std::abs(offset.radius) <= std::max(kRadius, kRadiusShare * part.radius);
}

bool needed(const LabelledPart& part, const MatchOptions& options) {
  return part.confidence >= options.part_confidence && 2 * part.radius <= options.hand_aperture && part.graspable &&
         part.measured;
}

SceneScore score_scene(const std::string& name, const std::vector<LabelledPart>& parts,
                       const std::vector<Handle>& handles, const MatchOptions& options) {
  SceneScore score;
  score.name = name;
  for (const LabelledPart& part : parts) score.parts.push_back({needed(part, options), -1});
  for (std::size_t i = 0; i < handles.size(); ++i) {
    const Handle& handle = handles[i];
    HandleCase result;
    std::pair<double, double> nearest(HUGE_VAL, HUGE_VAL);  // to the centre line, to its middle
    for (std::size_t k = 0; k < parts.size(); ++k) {
      const Offset from_part = offset(handle.center, handle.axis, handle.radius, parts[k]);
      const std::pair distance(from_part.distance, norm(add(handle.center, parts[k].center, -1)));
      if (!matches(from_part, parts[k]) || distance >= nearest) continue;
      nearest = distance;
      result.part = static_cast<int>(k);
      result.offset = from_part;
      result.length_error = handle.length - parts[k].length;
    }
    if (handle.confidence < options.min_confidence) {
      result.verdict = Verdict::kLeftOut;
    } else if (result.part >= 0) {
      int& finder = score.parts[static_cast<std::size_t>(result.part)].handle;
      result.verdict = finder < 0 ? Verdict::kRight : Verdict::kDuplicate;
      if (finder < 0) finder = static_cast<int>(i);
    }
    score.handles.push_back(result);
  }
  return score;
}

}  // namespace handhold::evaluation
