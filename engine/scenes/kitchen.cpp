// Things of the kitchen: vessels with handles, and what one stirs and rolls with.
#include <algorithm>
#include <cmath>

#include "family_makers.h"
#include "vec.h"

namespace handhold::sensor {
namespace {

constexpr FamilyGroup kGraspable = FamilyGroup::kGraspable;
constexpr FamilyHalf kTuning = FamilyHalf::kTuning, kReport = FamilyHalf::kReport;

/// A D on the side of a vessel, in the plane y = 0: out of the wall at x = `wall` at two heights, `reach` to its axis.
std::vector<Vector3> side_handle(double wall, double reach, double low, double high, double bend) {
  return rounded_path({{wall, 0, low}, {wall + reach, 0, low}, {wall + reach, 0, high}, {wall, 0, high}}, bend);
}

Shape mug(const Sizes& s) {
  const double radius = at(s, "radius"), height = at(s, "height"), reach = at(s, "handle_reach");
  const double thick = at(s, "strap_thickness") / 2, wide = at(s, "strap_width") / 2;
  constexpr double kWall = 0.004;
  Shape shape;
  shape.add_vessel({{0, radius - 0.002, radius - 2 * kWall},
                    {0.002, radius, radius - kWall},
                    {height - 0.001, radius, radius - kWall},
                    {height, radius - 0.001, radius - kWall + 0.001}},
                   0.006);
  const auto path = side_handle(radius - 0.0022, reach + 0.0022, 0.16 * height, 0.86 * height, 0.019);
  shape.add_bar(path, {0, 1, 0}, rounded_rectangle(thick, wide, 0.9 * std::min(thick, wide)));
  shape.loop("mug handle", clipped_path(path, {radius + 0.002, 0, 0}, {1, 0, 0}), std::max(thick, wide));
  shape.incidental("mug body", {{0, 0, 0.004}, {0, 0, height - 0.002}}, radius);
  return shape;
}

Shape jug(const Sizes& s) {
  const double low = at(s, "bottom_radius"), high = at(s, "top_radius"), height = at(s, "height");
  const double reach = at(s, "handle_reach"), thick = at(s, "handle_thickness") / 2, wide = at(s, "handle_width") / 2;
  constexpr double kWall = 0.004;
  Shape shape;
  const double waist = std::max(low, high) + 0.006;
  const std::vector<WallRing> wall = {{0, low, low - kWall},
                                      {0.35 * height, waist, waist - kWall},
                                      {0.80 * height, high, high - kWall},
                                      {height, high + 0.004, high + 0.004 - kWall}};
  shape.add_vessel(wall, 0.005);
  // Both ends lie inside the wall, which is not upright.
  const double from_high = high + 0.001, from_low = waist - 0.003, out = waist + reach;
  const double z_low = 0.30 * height, z_high = 0.90 * height;
  const auto path =
      rounded_path({{from_low, 0, z_low}, {out, 0, z_low + 0.01}, {out, 0, z_high}, {from_high, 0, z_high}}, 0.025);
  shape.add_bar(path, {0, 1, 0}, rounded_rectangle(thick, wide, 0.9 * std::min(thick, wide)));
  // Beyond the line between where its ends leave the wall.
  const Vector3 from = {waist + 0.004, 0, z_low}, to = {high + 0.006, 0, z_high};
  shape.loop("jug handle", clipped_path(path, from, cross({0, 1, 0}, to - from)), std::max(thick, wide));
  std::vector<Point2> outline;
  for (const WallRing& w : wall) outline.push_back({w.outer, w.z});
  shape.incidental_turned("jug neck", outline, 0, height);
  return shape;
}

Shape pan(const Sizes& s) {
  const double radius = at(s, "radius"), height = at(s, "height"), length = at(s, "handle_length");
  const double thick = at(s, "handle_thickness") / 2, wide = at(s, "handle_width") / 2;
  constexpr double kWall = 0.004, kTilt = 0.18;
  Shape shape;
  shape.add_vessel({{0, 0.82 * radius, 0.82 * radius - kWall}, {height, radius, radius - kWall}}, 0.005);
  // The handle rises a little; it begins inside the wall.
  const Pose at_rim = translation(radius - 0.002, 0, height - 0.010) * rotation({0, 1, 0}, -kTilt);
  shape.add_bar({{-0.002, 0, 0}, {0.030, 0, 0}}, {0, 1, 0},
                rounded_rectangle(0.5 * thick, 0.5 * wide, 0.4 * std::min(thick, wide)), at_rim);
  shape.add_bar({{0.028, 0, 0}, {length, 0, 0}}, {0, 1, 0}, rounded_rectangle(thick, wide, 0.8 * std::min(thick, wide)),
                at_rim);
  shape.grip("pan handle", {0.030, 0, 0}, {length - 0.002, 0, 0}, std::max(thick, wide), 1, at_rim);
  shape.incidental("pan neck", {{0.002, 0, 0}, {0.028, 0, 0}}, 0.5 * std::max(thick, wide), at_rim);
  return shape;
}

/// Two bows, at +x and -x, and a lid with a knob.
Shape pot(const Sizes& s) {
  const double radius = at(s, "radius"), height = at(s, "height"), reach = at(s, "handle_reach");
  const double bar = at(s, "handle_radius"), half_width = at(s, "handle_width") / 2;
  constexpr double kWall = 0.003;
  Shape shape;
  shape.add_vessel(
      {{0, radius - 0.004, radius - 0.004 - kWall}, {0.004, radius, radius - kWall}, {height, radius, radius - kWall}},
      0.004);
  shape.add_turned({{radius + 0.002, 0}, {radius + 0.002, 0.003}, {0.55 * radius, 0.014}, {0.012, 0.018}},
                   translation(0, 0, height - 0.001));
  const std::vector<Point2> knob = {{0.008, 0}, {0.008, 0.008}, {0.017, 0.014}, {0.017, 0.022}, {0.010, 0.026}};
  const Pose on_lid = translation(0, 0, height + 0.014);
  shape.add_turned(knob, on_lid);
  const double wall = std::sqrt(radius * radius - half_width * half_width);
  const auto bow = rounded_path({{wall - 0.002, -half_width, 0},
                                 {radius + reach, -half_width, 0},
                                 {radius + reach, half_width, 0},
                                 {wall - 0.002, half_width, 0}},
                                0.020);
  const auto free = clipped_path(bow, {wall + 0.002, 0, 0}, {1, 0, 0});
  for (const double turn : {0.0, 2 * kRightAngle}) {
    const Pose side = rotation({0, 0, 1}, turn) * translation(0, 0, 0.75 * height);
    shape.add_rod(bow, {0, 0, 1}, bar, side);
    shape.loop(turn == 0 ? "pot handle, +x" : "pot handle, -x", free, bar, side);
  }
  shape.incidental_turned("pot lid knob", knob, 0.003, 0.026, on_lid);
  return shape;
}

Shape kettle(const Sizes& s) {
  const double radius = at(s, "radius"), height = at(s, "height"), bar = at(s, "handle_radius");
  const double rise = at(s, "handle_rise");
  Shape shape;
  std::vector<Point2> outline = {{0.90 * radius, 0}, {radius, 0.012}, {radius, 0.45 * height}};
  for (const Point2& p : shoulder({radius, 0.45 * height}, {0.45 * radius, height})) {
    if (p[1] > 0.46 * height) outline.push_back(p);
  }
  shape.add_turned(outline);
  shape.add_turned({{0.010, 0}, {0.014, 0.010}, {0.008, 0.018}}, translation(0, 0, height - 0.001));
  // Spout to +y.
  constexpr double kSpout = 0.012;
  const std::vector<Vector3> spout = {
      {0, 0.75 * radius, 0.40 * height}, {0, 1.25 * radius, 0.80 * height}, {0, 1.45 * radius, 0.95 * height}};
  shape.add_rod(spout, {1, 0, 0}, kSpout);
  const double foot = 0.62 * radius, top = height + rise;
  const auto bow = rounded_path(
      {{-foot, 0, 0.75 * height}, {-foot - 0.004, 0, top}, {foot + 0.004, 0, top}, {foot, 0, 0.75 * height}}, 0.030);
  shape.add_rod(bow, {0, 1, 0}, bar);
  // The feet are inside the shoulder up to about three quarters of the height.
  shape.loop("kettle handle", clipped_path(bow, {0, 0, 0.92 * height}, {0, 0, 1}), bar);
  shape.incidental("kettle spout", clipped_path(spout, {0, 0, 0.66 * height}, {0, 0, 1}), kSpout);
  shape.incidental_turned("kettle neck", outline, 0.46 * height, height);
  return shape;
}

/// Handle to +x, blade to -x; made lying flat.
Shape spatula(const Sizes& s) {
  const double length = at(s, "handle_length"), thick = at(s, "handle_thickness") / 2, wide = at(s, "handle_width") / 2;
  const double blade = at(s, "blade_length"), blade_width = at(s, "blade_width");
  Shape shape;
  shape.add_bar({{0, 0, thick}, {length, 0, thick}}, {0, 1, 0},
                rounded_rectangle(thick, wide, 0.8 * std::min(thick, wide)));
  const auto shank =
      rounded_path({{0.010, 0, thick}, {-0.060, 0, thick}, {-0.095, 0, 0.002}, {-0.110, 0, 0.002}}, 0.020);
  shape.add_bar(shank, {0, 1, 0}, rounded_rectangle(0.002, 0.006, 0.0018));
  shape.add_box(blade, blade_width, 0.002, translation(-0.100 - blade / 2, 0, 0.0015));
  shape.grip("spatula handle", {0.002, 0, thick}, {length - 0.002, 0, thick}, std::max(thick, wide));
  shape.incidental("spatula shank", clipped_path(clipped_path(shank, {0, 0, 0}, {-1, 0, 0}), {-0.100, 0, 0}, {1, 0, 0}),
                   0.006);
  return shape;
}

/// Axis along x; made lying.
Shape rolling_pin(const Sizes& s) {
  const double roller = at(s, "roller_radius"), length = at(s, "roller_length"), grip = at(s, "grip_radius");
  const double grip_length = at(s, "grip_length");
  const double end = length / 2 + 0.010;
  const Pose along = translation(0, 0, roller) * rotation({0, 1, 0}, kRightAngle);
  Shape shape;
  shape.add_turned({{0.6 * grip, -end - grip_length},
                    {grip, -end - grip_length + 0.006},
                    {grip, -end},
                    {0.55 * grip, -end + 0.001},
                    {0.55 * grip, -length / 2},
                    {roller - 0.003, -length / 2},
                    {roller, -length / 2 + 0.003},
                    {roller, length / 2 - 0.003},
                    {roller - 0.003, length / 2},
                    {0.55 * grip, length / 2},
                    {0.55 * grip, end - 0.001},
                    {grip, end},
                    {grip, end + grip_length - 0.006},
                    {0.6 * grip, end + grip_length}},
                   along);
  shape.grip("rolling pin roller", {0, 0, -length / 2 + 0.003}, {0, 0, length / 2 - 0.003}, roller, 1, along);
  shape.grip("rolling pin grip, -x", {0, 0, -end - grip_length + 0.006}, {0, 0, -end}, grip, 1, along);
  shape.grip("rolling pin grip, +x", {0, 0, end}, {0, 0, end + grip_length - 0.006}, grip, 1, along);
  return shape;
}

}  // namespace

std::vector<FamilyMaker> kitchen_families() {
  return {
      {{"mug",
        kGraspable,
        kTuning,
        true,
        {{"radius", 0.041, 0.034, 0.046},
         {"height", 0.105, 0.085, 0.120},
         {"handle_reach", 0.035, 0.029, 0.040},
         {"strap_thickness", 0.014, 0.009, 0.016},
         {"strap_width", 0.018, 0.012, 0.022}}},
       mug},
      {{"jug",
        kGraspable,
        kTuning,
        true,
        {{"bottom_radius", 0.052, 0.044, 0.060},
         {"top_radius", 0.048, 0.040, 0.058},
         {"height", 0.210, 0.170, 0.250},
         {"handle_reach", 0.045, 0.038, 0.052},
         {"handle_thickness", 0.016, 0.012, 0.022},
         {"handle_width", 0.024, 0.016, 0.030}}},
       jug},
      {{"pan",
        kGraspable,
        kTuning,
        true,
        {{"radius", 0.115, 0.080, 0.140},
         {"height", 0.045, 0.035, 0.070},
         {"handle_length", 0.180, 0.140, 0.210},
         {"handle_thickness", 0.018, 0.012, 0.024},
         {"handle_width", 0.024, 0.018, 0.030}}},
       pan},
      {{"spatula",
        kGraspable,
        kTuning,
        true,
        {{"handle_length", 0.190, 0.140, 0.230},
         {"handle_thickness", 0.013, 0.008, 0.020},
         {"handle_width", 0.022, 0.016, 0.028},
         {"blade_length", 0.090, 0.070, 0.120},
         {"blade_width", 0.080, 0.060, 0.100}}},
       spatula},
      {{"rolling_pin",
        kGraspable,
        kTuning,
        true,
        {{"roller_radius", 0.026, 0.020, 0.034},
         {"roller_length", 0.220, 0.160, 0.260},
         {"grip_radius", 0.013, 0.010, 0.016},
         {"grip_length", 0.085, 0.060, 0.100}}},
       rolling_pin},
      {{"pot",
        kGraspable,
        kReport,
        true,
        {{"radius", 0.090, 0.070, 0.115},
         {"height", 0.110, 0.080, 0.150},
         {"handle_reach", 0.042, 0.036, 0.050},
         {"handle_radius", 0.0075, 0.006, 0.010},
         {"handle_width", 0.095, 0.080, 0.110}}},
       pot},
      {{"kettle",
        kGraspable,
        kReport,
        true,
        {{"radius", 0.085, 0.070, 0.100},
         {"height", 0.130, 0.110, 0.160},
         {"handle_radius", 0.012, 0.008, 0.015},
         {"handle_rise", 0.075, 0.060, 0.090}}},
       kettle},
  };
}

}  // namespace handhold::sensor
