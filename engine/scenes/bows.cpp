// Things with a bow, a loop or a bar that stands out from them: thin parts that are raised and often curved.
#include <algorithm>
#include <cmath>

#include "family_makers.h"
#include "vec.h"

namespace handhold::sensor {
namespace {

constexpr FamilyGroup kGraspable = FamilyGroup::kGraspable;
constexpr FamilyHalf kTuning = FamilyHalf::kTuning;

/// A low round dish; two straps on edge, each an arc of a circle, at +x and -x.
Shape casserole(const Sizes& s) {
  const double radius = at(s, "radius"), height = at(s, "height"), bend = at(s, "handle_bend");
  const double thick = at(s, "strap_thickness") / 2, wide = at(s, "strap_width") / 2;
  constexpr double kWall = 0.004;
  Shape shape;
  shape.add_vessel({{0, 0.92 * radius, 0.92 * radius - kWall}, {height, radius, radius - kWall}}, 0.006);
  // About where the circle through its ends leaves the wall; the ends stand inside the wall.
  const double z = 0.72 * height, wall = radius * (0.92 + 0.08 * 0.72);
  const double center = std::sqrt(wall * wall - bend * bend);
  const auto bow = arc_path({center, 0, 0}, {1, 0, 0}, {0, 1, 0}, bend, -kRightAngle - 0.06, kRightAngle + 0.06);
  const auto free = clipped_path(bow, {center + 0.004 + thick, 0, 0}, {1, 0, 0});
  for (const double turn : {0.0, 2 * kRightAngle}) {
    const Pose side = rotation({0, 0, 1}, turn) * translation(0, 0, z);
    shape.add_bar(bow, {0, 0, 1}, rounded_rectangle(thick, wide, 0.9 * std::min(thick, wide)), side);
    shape.loop(turn == 0 ? "casserole handle, +x" : "casserole handle, -x", free, std::max(thick, wide), side);
  }
  return shape;
}

/// A stiff bag, full and closed, with two strap handles that stand up side by side.
Shape shopping_bag(const Sizes& s) {
  const double width = at(s, "width"), depth = at(s, "depth"), height = at(s, "height");
  const double half = at(s, "handle_width") / 2, rise = at(s, "handle_rise");
  const double thick = at(s, "strap_thickness") / 2, wide = at(s, "strap_width") / 2;
  Shape shape;
  shape.add_lofted({{0, width / 2 - 0.010, depth / 2 - 0.010, 0.015},
                    {0.012, width / 2, depth / 2, 0.015},
                    {height, width / 2 - 0.015, depth / 2 - 0.020, 0.015}});
  // Upright, then half a circle; the height of the upright ends takes up the rest of the rise.
  const double straight = std::max(0.0, rise - half);
  std::vector<Vector3> bow = {{half, 0, height - 0.015}};
  for (const Vector3& p : arc_path({0, 0, height + straight}, {1, 0, 0}, {0, 0, 1}, half, 0, 2 * kRightAngle)) {
    bow.push_back(p);
  }
  bow.push_back({-half, 0, height - 0.015});
  const auto free = clipped_path(bow, {0, 0, height + 0.002}, {0, 0, 1});
  for (const double side : {-1.0, 1.0}) {
    const Pose at_side = translation(0, side * (depth / 2 - 0.021 - wide), 0);
    shape.add_bar(bow, {0, 1, 0}, rounded_rectangle(thick, wide, 0.9 * std::min(thick, wide)), at_side);
    shape.loop(side < 0 ? "shopping bag handle, -y" : "shopping bag handle, +y", free, std::max(thick, wide), at_side);
  }
  return shape;
}

/// A piece of a cupboard with an upright bar on two posts before its face towards +x.
Shape cupboard_door(const Sizes& s) {
  const double width = at(s, "width"), depth = at(s, "depth"), height = at(s, "height");
  const double bar = at(s, "bar_radius"), length = at(s, "bar_length"), reach = at(s, "bar_reach");
  Shape shape;
  shape.add_box(depth, width, height, translation(-depth / 2, 0, height / 2));
  const double y = 0.30 * width, middle = 0.55 * height, low = middle - length / 2, post = 0.75 * bar;
  shape.add_cylinder(bar, length, translation(reach, y, low));
  shape.grip("cupboard door bar", {reach, y, low + 0.001}, {reach, y, low + length - 0.001}, bar);
  for (const double side : {-1.0, 1.0}) {
    const Pose out = translation(-0.004, y, middle + side * 0.32 * length) * rotation({0, 1, 0}, kRightAngle);
    shape.add_cylinder(post, reach + 0.004 + 0.4 * bar, out);
    shape.incidental(side < 0 ? "cupboard door post, low" : "cupboard door post, high",
                     {{0, 0, 0.005}, {0, 0, reach + 0.004 - bar}}, post, out);
  }
  return shape;
}

/// A can with a spout to +x and a bow from its top over to its back at -x.
Shape watering_can(const Sizes& s) {
  const double radius = at(s, "radius"), height = at(s, "height"), bar = at(s, "handle_radius");
  const double rise = at(s, "handle_rise"), reach = at(s, "handle_reach");
  Shape shape;
  shape.add_turned({{radius, 0}, {radius, 0.8 * height}, {0.75 * radius, height}});
  constexpr double kSpout = 0.011;
  const std::vector<Vector3> spout = {
      {0.8 * radius, 0, 0.22 * height}, {1.5 * radius, 0, 0.62 * height}, {2.1 * radius, 0, 1.05 * height}};
  shape.add_rod(spout, {0, 1, 0}, kSpout);
  shape.incidental("watering can spout", clipped_path(spout, {radius + 0.012, 0, 0}, {1, 0, 0}), kSpout);
  const double front = 0.35 * radius, back = radius + reach;
  const auto bow = rounded_path({{front, 0, height - 0.012},
                                 {front - 0.02, 0, height + rise},
                                 {-0.75 * radius, 0, height + 0.8 * rise},
                                 {-back, 0, 0.72 * height},
                                 {-radius + 0.008, 0, 0.30 * height}},
                                0.040);
  shape.add_rod(bow, {0, 1, 0}, bar);
  // Beyond the line between where its ends leave the can.
  const Vector3 from = {front, 0, height + 0.003}, to = {-radius - 0.004 - bar, 0, 0.30 * height};
  shape.loop("watering can handle", clipped_path(bow, from, cross({0, 1, 0}, to - from)), bar);
  return shape;
}

/// A clothes iron on its sole, tip towards +x, with a closed grip above.
Shape flat_iron(const Sizes& s) {
  const double length = at(s, "length"), width = at(s, "width"), height = at(s, "body_height");
  const double rise = at(s, "grip_rise"), thick = at(s, "grip_thickness") / 2, wide = at(s, "grip_width") / 2;
  Shape shape;
  shape.add_lofted({{0, length / 2, width / 2, 0.45 * width},
                    {0.010, length / 2, width / 2, 0.45 * width},
                    {height, 0.36 * length, 0.25 * width, 0.2 * width, -0.04 * length}});
  const double foot = height - 0.012, top = height + rise, back = -0.33 * length, front = 0.22 * length;
  const auto bow =
      rounded_path({{back, 0, foot}, {back - 0.006, 0, top}, {front + 0.006, 0, top}, {front, 0, foot}}, 0.024);
  shape.add_bar(bow, {0, 1, 0}, rounded_rectangle(thick, wide, 0.9 * std::min(thick, wide)));
  shape.loop("flat iron grip", clipped_path(bow, {0, 0, height + 0.002}, {0, 0, 1}), std::max(thick, wide));
  return shape;
}

/// A closed box; a straight grip along x between two flat arms stands up from its lid.
Shape toolbox(const Sizes& s) {
  const double width = at(s, "width"), depth = at(s, "depth"), height = at(s, "height");
  const double grip = at(s, "grip_radius"), half = at(s, "grip_length") / 2, rise = at(s, "grip_rise");
  constexpr double kArm = 0.005;
  Shape shape;
  shape.add_box(width, depth, height, translation(0, 0, height / 2));
  const double top = height + rise;
  for (const double side : {-1.0, 1.0}) {
    shape.add_box(kArm, 2 * grip, rise + 0.010 + grip,
                  translation(side * (half + kArm / 2), 0, top + grip - (rise + 0.010 + grip) / 2));
  }
  const Pose along = translation(-half - kArm / 2, 0, top) * rotation({0, 1, 0}, kRightAngle);
  shape.add_cylinder(grip, 2 * half + kArm, along);
  shape.grip("toolbox grip", {0, 0, kArm / 2 + 0.001}, {0, 0, 2 * half + kArm / 2 - 0.001}, grip, 1, along);
  return shape;
}

}  // namespace

std::vector<FamilyMaker> bow_families() {
  return {
      {{"casserole",
        kGraspable,
        kTuning,
        true,
        {{"radius", 0.115, 0.095, 0.135},
         {"height", 0.080, 0.065, 0.100},
         {"handle_bend", 0.050, 0.042, 0.060},
         {"strap_thickness", 0.009, 0.007, 0.012},
         {"strap_width", 0.020, 0.014, 0.026}}},
       casserole},
      {{"shopping_bag",
        kGraspable,
        kTuning,
        true,
        {{"width", 0.260, 0.210, 0.300},
         {"depth", 0.130, 0.110, 0.160},
         {"height", 0.200, 0.150, 0.240},
         {"handle_width", 0.120, 0.090, 0.150},
         {"handle_rise", 0.100, 0.080, 0.130},
         {"strap_thickness", 0.007, 0.005, 0.010},
         {"strap_width", 0.022, 0.015, 0.028}}},
       shopping_bag},
      {{"cupboard_door",
        kGraspable,
        kTuning,
        true,
        {{"width", 0.240, 0.180, 0.320},
         {"depth", 0.140, 0.110, 0.180},
         {"height", 0.260, 0.200, 0.320},
         {"bar_radius", 0.0065, 0.005, 0.010},
         {"bar_length", 0.140, 0.100, 0.170},
         {"bar_reach", 0.038, 0.032, 0.046}}},
       cupboard_door},
      {{"watering_can",
        kGraspable,
        kTuning,
        true,
        {{"radius", 0.075, 0.062, 0.090},
         {"height", 0.150, 0.120, 0.180},
         {"handle_radius", 0.010, 0.0075, 0.014},
         {"handle_rise", 0.065, 0.055, 0.080},
         {"handle_reach", 0.055, 0.045, 0.065}}},
       watering_can},
      {{"flat_iron",
        kGraspable,
        kTuning,
        true,
        {{"length", 0.230, 0.200, 0.260},
         {"width", 0.115, 0.100, 0.130},
         {"body_height", 0.055, 0.045, 0.070},
         {"grip_rise", 0.060, 0.050, 0.070},
         {"grip_thickness", 0.022, 0.018, 0.026},
         {"grip_width", 0.028, 0.024, 0.032}}},
       flat_iron},
      {{"toolbox",
        kGraspable,
        kTuning,
        true,
        {{"width", 0.320, 0.260, 0.380},
         {"depth", 0.160, 0.130, 0.190},
         {"height", 0.130, 0.100, 0.170},
         {"grip_radius", 0.010, 0.007, 0.014},
         {"grip_length", 0.130, 0.100, 0.170},
         {"grip_rise", 0.055, 0.045, 0.070}}},
       toolbox},
  };
}

}  // namespace handhold::sensor
