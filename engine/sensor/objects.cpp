// Household objects with the parts that a hand could hold. Sizes are those of real things; each is noted where a
// condition of the grasp depends on it (hand: aperture 80 mm, fingers 10 mm thick and 20 mm wide).
#include <algorithm>
#include <cmath>

#include "handhold/sensor.h"
#include "vec.h"

namespace handhold::sensor {
namespace {

constexpr double kHalfTurn = 3.141592653589793;

/// A straight part between two points of its axis.
Part straight_part(const char* what, const Vector3& from, const Vector3& to, double radius, double confidence,
                   bool graspable) {
  Part part;
  part.what = what;
  part.center = 0.5 * (from + to);
  part.axis = unit(to - from);
  part.radius = radius;
  part.length = norm(to - from);
  part.confidence = confidence;
  part.centre_line = {from, to};
  part.graspable = graspable;
  return transformed(part, Pose{});  // turns the axis
}

/// Centre line of a strap in the plane y = 0: from x = `wall` out to x = `reach` at z = low, up, and back at z = high.
std::vector<Vector3> strap_path(double wall, double reach, double low, double high, double bend) {
  constexpr int kBendSegments = 24;
  std::vector<Vector3> path = {{wall, 0, low}};
  for (int i = 0; i <= kBendSegments; ++i) {
    const double a = kHalfTurn / 2 * (static_cast<double>(i) / kBendSegments - 1);
    path.push_back({reach - bend + bend * std::cos(a), 0, low + bend + bend * std::sin(a)});
  }
  for (int i = 0; i <= kBendSegments; ++i) {
    const double a = kHalfTurn / 2 * i / kBendSegments;
    path.push_back({reach - bend + bend * std::cos(a), 0, high - bend + bend * std::sin(a)});
  }
  path.push_back({wall, 0, high});
  return path;
}

}  // namespace

Part transformed(const Part& part, const Pose& T) {
  Part result = part;
  result.center = T.point(part.center);
  result.axis = T.direction(part.axis);
  const auto largest = std::max_element(result.axis.begin(), result.axis.end(),
                                        [](double a, double b) { return std::abs(a) < std::abs(b); });
  if (*largest < 0) result.axis = -1.0 * result.axis;
  for (Vector3& p : result.centre_line) p = T.point(p);
  return result;
}

Object transformed(const Object& object, const Pose& T) {
  Object result = {object.name, transformed(object.mesh, T), {}, object.material};
  for (const Part& part : object.parts) result.parts.push_back(transformed(part, T));
  return result;
}

Object mug() {
  // 82 mm across: wider than the hand opens.
  constexpr double kRadius = 0.041, kWall = 0.004, kHeight = 0.105, kBottom = 0.006;
  // The strap's axis is 35 mm from the body: 28 mm of room for a finger behind a strap 14 mm thick and 18 mm wide.
  constexpr double kReach = kRadius + 0.035, kHalfThickness = 0.007, kHalfWidth = 0.009;
  constexpr double kLow = 0.016, kHigh = 0.090, kBend = 0.019, kMiddle = (kLow + kHigh) / 2;
  Object object;
  object.name = "mug";
  const Mesh body = revolve({{0, 0},
                             {kRadius - 0.002, 0},
                             {kRadius, 0.002},
                             {kRadius, kHeight - 0.001},
                             {kRadius - 0.001, kHeight},
                             {kRadius - kWall + 0.001, kHeight},
                             {kRadius - kWall, kHeight - 0.001},
                             {kRadius - kWall, kBottom},
                             {0, kBottom}});
  // The strap ends inside the wall, over its whole width: sqrt(41^2 - 9^2) = 40 mm.
  const std::vector<Vector3> path = strap_path(kRadius - 0.0022, kReach, kLow, kHigh, kBend);
  object.mesh = merged(body, tube(path, {0, 1, 0}, rounded_rectangle(kHalfThickness, kHalfWidth, 0.006)));
  const double strap = std::max(kHalfThickness, kHalfWidth);
  object.parts.push_back(straight_part("mug handle, outer vertical part", {kReach, 0, kMiddle - 0.020},
                                       {kReach, 0, kMiddle + 0.020}, strap, 1, true));
  object.parts.push_back(
      straight_part("mug handle, upper strut", {kRadius, 0, kHigh}, {kReach - 0.012, 0, kHigh}, strap, 0.3, false));
  object.parts.push_back(
      straight_part("mug handle, lower strut", {kRadius, 0, kLow}, {kReach - 0.012, 0, kLow}, strap, 0.3, false));
  object.parts.push_back(straight_part("mug body", {0, 0, 0.004}, {0, 0, kHeight - 0.002}, kRadius, 0.3, false));
  return object;
}

Object mallet() {
  constexpr double kShaft = 0.014, kLength = 0.250, kShaftHeight = 0.070;
  constexpr double kHead = 0.020, kHeadHeight = 0.104;
  // The block carries the shaft's far end, so that a hand's shell about the shaft stays 40 mm above the table.
  constexpr double kBlock = 0.030, kBlockEnd = kLength - 0.005;
  Object object;
  object.name = "mallet";
  const Mesh head = cylinder(kHead, kHeadHeight);
  const Mesh shaft =
      transformed(cylinder(kShaft, kLength), translation(0, 0, kShaftHeight) * rotation({0, 1, 0}, kHalfTurn / 2));
  const double block_height = kShaftHeight - kShaft;
  const Mesh block =
      transformed(box(kBlock, 0.040, block_height), translation(kBlockEnd - kBlock / 2, 0, block_height / 2));
  object.mesh = merged(merged(head, shaft), block);
  object.parts.push_back(straight_part("mallet shaft", {kHead + 0.004, 0, kShaftHeight},
                                       {kBlockEnd - kBlock - 0.004, 0, kShaftHeight}, kShaft, 1, true));
  object.parts.push_back(straight_part("mallet head, below the shaft", {0, 0, 0.004},
                                       {0, 0, kShaftHeight - kShaft - 0.004}, kHead, 1, true));
  object.parts.push_back(straight_part("mallet head, above the shaft", {0, 0, kShaftHeight + kShaft},
                                       {0, 0, kHeadHeight}, kHead, 0.3, false));
  return object;
}

Object bottle() {
  constexpr double kBody = 0.030, kBodyHeight = 0.130, kNeck = 0.014, kNeckFrom = 0.162, kHeight = 0.210;
  constexpr int kShoulderSegments = 16;
  Object object;
  object.name = "bottle";
  std::vector<Point2> profile = {{0, 0}, {kBody - 0.003, 0}, {kBody, 0.003}};
  for (int i = 0; i <= kShoulderSegments; ++i) {
    const double s = static_cast<double>(i) / kShoulderSegments;
    profile.push_back(
        {kNeck + (kBody - kNeck) * 0.5 * (1 + std::cos(kHalfTurn * s)), kBodyHeight + (kNeckFrom - kBodyHeight) * s});
  }
  profile.push_back({kNeck, kHeight - 0.002});
  profile.push_back({kNeck - 0.002, kHeight});
  profile.push_back({0, kHeight});
  object.mesh = revolve(profile);
  object.parts.push_back(straight_part("bottle body", {0, 0, 0.004}, {0, 0, kBodyHeight + 0.002}, kBody, 1, true));
  object.parts.push_back(straight_part("bottle neck", {0, 0, kNeckFrom}, {0, 0, kHeight - 0.002}, kNeck, 1, true));
  return object;
}

Object bowl() {
  constexpr double kFoot = 0.030, kSpread = 0.040, kHeight = 0.055, kWall = 0.005;
  constexpr int kSegments = 24;
  std::vector<Point2> profile = {{0, 0}};
  for (int i = 0; i <= kSegments; ++i) {
    const double a = kHalfTurn / 2 * i / kSegments;
    profile.push_back({kFoot + kSpread * std::sin(a), kHeight * (1 - std::cos(a))});
  }
  for (int i = kSegments; i >= 0; --i) {
    const double a = kHalfTurn / 2 * i / kSegments;
    profile.push_back({kFoot - kWall + kSpread * std::sin(a), kWall + (kHeight - kWall) * (1 - std::cos(a))});
  }
  profile.push_back({0, kWall});
  return {"bowl", revolve(profile), {}};
}

Object carton() {
  // Every side is wider than the hand opens.
  constexpr double kX = 0.120, kY = 0.090, kZ = 0.140;
  return {"carton", transformed(box(kX, kY, kZ), translation(0, 0, kZ / 2)), {}};
}

Object table(double x, double y) {
  constexpr double kThickness = 0.020;
  return {"table", transformed(box(x, y, kThickness), translation(0, 0, -kThickness / 2)), {}};
}

}  // namespace handhold::sensor
