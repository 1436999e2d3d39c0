#include "causes.h"

#include <algorithm>
#include <cmath>

#include "text.h"

namespace handhold::evaluation {
namespace {

double degrees(double angle) {
  return angle * 180 / 3.14159265358979323846;
}

/// What keeps something near a part from matching it: "its axis is 48 deg off, its radius 12 mm instead of 20".
std::string differences(const Offset& o, const LabelledPart& part) {
  std::string text;
  const auto also = [&text](const std::string& what) { text += (text.empty() ? "" : ", ") + what; };
  if (o.along > 0 && !near(o, part)) also(format("%.0f mm beyond its end", 1000 * o.along));
  if (!near(o, part)) also(format("%.0f mm from its centre line", 1000 * o.across));
  Offset there = o;
  there.along = there.across = 0;
  there.radius = 0;
  if (!matches(there, part)) also(format("the axis is %.0f deg off", degrees(o.angle)));
  there = o;
  there.along = there.across = 0;
  there.angle = 0;
  if (!matches(there, part)) {
    also(format("the radius is %.0f mm, not %.0f", 1000 * (part.radius + o.radius), 1000 * part.radius));
  }
  return text;
}

}  // namespace

std::string why_missed(std::size_t index, const std::vector<LabelledPart>& parts, const Result& result,
                       const SceneScore& score) {
  const LabelledPart& part = parts[index];
  std::string askew;
  for (std::size_t i = 0; i < result.handles.size(); ++i) {
    const Handle& handle = result.handles[i];
    const Offset o = offset(handle.center, handle.axis, handle.radius, part);
    const std::string name = "handle " + std::to_string(i + 1);
    if (matches(o, part)) {
      if (score.handles[i].verdict == Verdict::kLeftOut) {
        return name + format(" is there, but its confidence is only %.2f", handle.confidence);
      }
      return name + " would do, but it counts for '" + parts[static_cast<std::size_t>(score.handles[i].part)].what +
             "'";
    }
    if (askew.empty() && near(o, part)) askew = name + " is there, but " + differences(o, part);
  }
  if (!askew.empty()) return askew;
  std::size_t close = 0, alike = 0;
  for (const Affordance& affordance : result.affordances) {
    const Offset o = offset(affordance.center, affordance.axis, affordance.radius, part);
    close += near(o, part);
    alike += matches(o, part);
  }
  if (close == 0) {
    return "no affordance near" + (part.visible ? format(" (%.0f %% of it is visible)", 100 * *part.visible) : "");
  }
  return format("%zu affordance%s near, %zu with its axis and radius, but no handle", close, close == 1 ? "" : "s",
                alike);
}

std::string why_false(std::size_t index, const std::vector<LabelledPart>& parts, const Result& result,
                      const SceneScore& score) {
  const HandleCase& handle = score.handles[index];
  if (handle.verdict == Verdict::kDuplicate) {
    const auto part = static_cast<std::size_t>(handle.part);
    return "on '" + parts[part].what + "', which handle " + std::to_string(score.parts[part].handle + 1) + " has found";
  }
  std::string text;
  if (handle.object >= 0) {
    const SceneObject& object = score.objects[static_cast<std::size_t>(handle.object)];
    text = "on '" + object.name + "' (" + object.family + "); ";
  }
  const Handle& found = result.handles[index];
  const LabelledPart* nearest = nullptr;
  Offset from_nearest;
  for (const LabelledPart& part : parts) {
    const Offset o = offset(found.center, found.axis, found.radius, part);
    if (nearest && o.distance >= from_nearest.distance) continue;
    nearest = &part;
    from_nearest = o;
  }
  constexpr double kNearby = 0.1;  // m; beyond that a part explains nothing
  if (nearest && from_nearest.distance < kNearby + nearest->radius) {
    text += "nearest part '" + nearest->what + "': " + differences(from_nearest, *nearest);
  } else {
    text += nearest ? "no part near" : "the scene has no listed part";
  }
  if (handle.sound) text += *handle.sound ? "; a hand would hold something there" : "; unsound: " + handle.unsound;
  return text;
}

}  // namespace handhold::evaluation
