// Things to clean with: six of the twelve objects of the paper's Table 1.
#include <cmath>

#include "family_makers.h"
#include "vec.h"

namespace handhold::sensor {
namespace {

constexpr FamilyGroup kGraspable = FamilyGroup::kGraspable;
constexpr FamilyHalf kReport = FamilyHalf::kReport;

const Pose kAlongX = rotation({0, 1, 0}, kRightAngle);

/// A dish brush: round handle along +x, round head with bristles downwards.
Shape brush_1(const Sizes& s) {
  const double grip = at(s, "grip_radius"), length = at(s, "grip_length"), head = at(s, "head_radius");
  const double bristles = at(s, "bristle_length"), z = bristles + 0.008;
  Shape shape;
  const std::vector<Point2> handle = {{0.6 * grip, head - 0.004},
                                      {0.8 * grip, head + 0.030},
                                      {grip, head + 0.050},
                                      {grip, head + 0.050 + length},
                                      {0.7 * grip, head + 0.058 + length}};
  const Pose out = translation(0, 0, z) * kAlongX;
  shape.add_turned(handle, out);
  shape.add_turned({{head, 0}, {head, 0.014}}, translation(0, 0, bristles));
  const std::vector<Point2> tuft = {{0.95 * head, 0}, {0.85 * head, bristles + 0.002}};
  shape.add_turned(tuft);
  shape.grip("brush 1 handle", {head + 0.050, 0, z}, {head + 0.050 + length, 0, z}, grip);
  shape.incidental_turned("brush 1 neck", handle, head + 0.001, head + 0.050, out);
  shape.incidental_turned("brush 1 head",
                          {tuft[0], {0.85 * head, bristles}, {head, bristles}, {head, bristles + 0.014}}, 0,
                          bristles + 0.014);
  return shape;
}

/// A hand broom: a long row of bristles and a handle in line with it.
Shape brush_2(const Sizes& s) {
  const double grip = at(s, "grip_radius"), length = at(s, "grip_length"), block = at(s, "block_length");
  const double bristles = at(s, "bristle_length"), half_width = at(s, "block_width") / 2, z = bristles + 0.010;
  Shape shape;
  shape.add_bar({{-block, 0, z}, {0, 0, z}}, {0, 1, 0}, rounded_rectangle(0.010, half_width, 0.005));
  shape.add_lofted({{0, block / 2, half_width + 0.004, 0.004, -block / 2, 0},
                    {bristles + 0.001, block / 2 - 0.006, half_width - 0.003, 0.004, -block / 2, 0}});
  const std::vector<Point2> handle = {
      {0.0095, -0.010}, {0.0095, 0.012}, {grip, 0.030}, {grip, 0.030 + length}, {0.7 * grip, 0.038 + length}};
  const Pose out = translation(0, 0, z) * kAlongX;
  shape.add_turned(handle, out);
  shape.grip("brush 2 handle", {0.030, 0, z}, {0.030 + length, 0, z}, grip);
  shape.incidental_turned("brush 2 neck", handle, 0.001, 0.030, out);
  return shape;
}

Shape plunger(const Sizes& s) {
  const double rod = at(s, "rod_radius"), length = at(s, "rod_length"), cup = at(s, "cup_radius");
  const double height = at(s, "cup_height");
  std::vector<Point2> outline = {{cup, 0}, {cup, 0.30 * height}};
  for (int i = 1; i <= 8; ++i) {
    const double a = kRightAngle * i / 8;
    outline.push_back({rod + 0.006 + (cup - rod - 0.006) * std::cos(a), height * (0.30 + 0.55 * std::sin(a))});
  }
  outline.push_back({rod + 0.005, height});
  Shape shape;
  shape.add_turned(outline);
  shape.add_turned({{rod, height - 0.010}, {rod, height + length - 0.004}, {0.6 * rod, height + length}});
  shape.grip("plunger rod", {0, 0, height + 0.002}, {0, 0, height + length - 0.004}, rod);
  return shape;
}

/// The scoop opens to -x; the handle rises a little.
Shape dust_pan(const Sizes& s) {
  const double depth = at(s, "depth"), width = at(s, "width"), wall = at(s, "wall_height");
  const double grip = at(s, "grip_radius"), length = at(s, "grip_length");
  constexpr double kPlate = 0.003, kRise = 0.20;
  Shape shape;
  shape.add_box(depth, width, kPlate, translation(-depth / 2, 0, kPlate / 2));
  shape.add_box(kPlate, width, wall, translation(-kPlate / 2, 0, wall / 2));
  for (const double side : {-0.5, 0.5}) {
    shape.add_box(0.8 * depth, kPlate, wall, translation(-0.4 * depth, side * (width - kPlate), wall / 2));
  }
  const Pose out = translation(-0.002, 0, wall - grip - 0.002) * rotation({0, 1, 0}, -kRise) * kAlongX;
  const std::vector<Point2> handle = {
      {0.6 * grip, 0}, {0.6 * grip, 0.022}, {grip, 0.030}, {grip, 0.030 + length}, {0.7 * grip, 0.036 + length}};
  shape.add_turned(handle, out);
  shape.grip("dust pan handle", {0, 0, 0.030}, {0, 0, 0.030 + length}, grip, 1, out);
  shape.incidental_turned("dust pan neck", handle, 0.004, 0.030, out);
  return shape;
}

/// A block of sponge on a hollow handle for soap.
Shape sponge(const Sizes& s) {
  const double grip = at(s, "grip_radius"), length = at(s, "grip_length"), block = at(s, "block_length");
  const double width = at(s, "block_width"), height = at(s, "block_height");
  constexpr double kTilt = 0.25;
  Shape shape;
  shape.add_lofted(
      {{0, block / 2, width / 2, 0.008, -block / 2, 0}, {height, block / 2, width / 2, 0.008, -block / 2, 0}});
  shape.add_lofted({{height - 0.001, 0.9 * block / 2, 0.8 * width / 2, 0.008, -block / 2, 0},
                    {height + 0.008, 0.7 * block / 2, 0.6 * width / 2, 0.008, -block / 2, 0}});
  const Pose out = translation(-0.35 * block, 0, height + 0.002) * rotation({0, 1, 0}, -kTilt) * kAlongX;
  const double from = 0.50 * block;
  const std::vector<Point2> handle = {{0.5 * grip, 0},
                                      {0.6 * grip, from - 0.014},
                                      {grip, from},
                                      {grip, from + length - 0.010},
                                      {0.75 * grip, from + length}};
  shape.add_turned(handle, out);
  shape.grip("sponge handle", {0, 0, from}, {0, 0, from + length - 0.010}, grip, 1, out);
  // Nearer to the block the neck is half within its mount.
  shape.incidental_turned("sponge neck", handle, 0.28 * block, from, out);
  return shape;
}

/// Roller along +x on a thin bent wire, handle along -x.
Shape lint_roller(const Sizes& s) {
  const double roller = at(s, "roller_radius"), length = at(s, "roller_length"), grip = at(s, "grip_radius");
  const double grip_length = at(s, "grip_length");
  const Pose along = translation(0, 0, roller) * kAlongX;
  Shape shape;
  shape.add_cylinder(roller, length, along);
  constexpr double kWire = 0.0045;
  shape.add_turned({{kWire, -0.040}, {kWire, 0.010}}, along);
  shape.add_turned(
      {{0.75 * grip, -0.030 - grip_length}, {grip, -0.022 - grip_length}, {grip, -0.038}, {0.6 * grip, -0.028}}, along);
  shape.grip("lint roller", {0, 0, 0.001}, {0, 0, length - 0.001}, roller, 1, along);
  shape.grip("lint roller handle", {0, 0, -0.022 - grip_length}, {0, 0, -0.038}, grip, 1, along);
  shape.incidental("lint roller wire", {{0, 0, -0.028}, {0, 0, 0}}, kWire, along);
  return shape;
}

}  // namespace

std::vector<FamilyMaker> cleaning_families() {
  return {
      {{"brush_1",
        kGraspable,
        kReport,
        false,
        {{"grip_radius", 0.0115, 0.009, 0.014},
         {"grip_length", 0.150, 0.120, 0.180},
         {"head_radius", 0.034, 0.028, 0.038},
         {"bristle_length", 0.026, 0.020, 0.032}}},
       brush_1},
      {{"brush_2",
        kGraspable,
        kReport,
        false,
        {{"grip_radius", 0.0125, 0.0105, 0.015},
         {"grip_length", 0.115, 0.095, 0.130},
         {"block_length", 0.170, 0.140, 0.200},
         {"block_width", 0.032, 0.026, 0.040},
         {"bristle_length", 0.055, 0.045, 0.065}}},
       brush_2},
      {{"plunger",
        kGraspable,
        kReport,
        true,
        {{"rod_radius", 0.0115, 0.010, 0.014},
         {"rod_length", 0.320, 0.250, 0.380},
         {"cup_radius", 0.062, 0.052, 0.070},
         {"cup_height", 0.080, 0.065, 0.095}}},
       plunger},
      {{"dust_pan",
        kGraspable,
        kReport,
        false,
        {{"depth", 0.200, 0.170, 0.220},
         {"width", 0.230, 0.200, 0.260},
         {"wall_height", 0.045, 0.038, 0.060},
         {"grip_radius", 0.013, 0.011, 0.016},
         {"grip_length", 0.105, 0.090, 0.130}}},
       dust_pan},
      {{"sponge",
        kGraspable,
        kReport,
        false,
        {{"grip_radius", 0.0155, 0.012, 0.019},
         {"grip_length", 0.130, 0.105, 0.150},
         {"block_length", 0.095, 0.085, 0.110},
         {"block_width", 0.065, 0.055, 0.075},
         {"block_height", 0.032, 0.025, 0.040}}},
       sponge},
      {{"lint_roller",
        kGraspable,
        kReport,
        false,
        {{"roller_radius", 0.0255, 0.021, 0.030},
         {"roller_length", 0.105, 0.090, 0.120},
         {"grip_radius", 0.0135, 0.011, 0.016},
         {"grip_length", 0.105, 0.090, 0.120}}},
       lint_roller},
  };
}

}  // namespace handhold::sensor
