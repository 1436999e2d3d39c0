// Tools of the workshop and the garden.
#include <algorithm>
#include <cmath>

#include "family_makers.h"
#include "vec.h"

namespace handhold::sensor {
namespace {

constexpr FamilyGroup kGraspable = FamilyGroup::kGraspable;
constexpr FamilyHalf kTuning = FamilyHalf::kTuning, kReport = FamilyHalf::kReport;

/// From z along an object's own axis to x: tools are made with their shaft along +x.
const Pose kAlongX = rotation({0, 1, 0}, kRightAngle);

/// Stands on its head; the shaft runs along +x.
Shape mallet(const Sizes& s) {
  const double shaft = at(s, "shaft_radius"), length = at(s, "shaft_length"), head = at(s, "head_radius");
  const double height = at(s, "head_length"), middle = height / 2;
  Shape shape;
  shape.add_turned({{head - 0.002, 0}, {head, 0.002}, {head, height - 0.002}, {head - 0.002, height}});
  shape.add_cylinder(shaft, length, translation(0, 0, middle) * kAlongX);
  shape.grip("mallet shaft", {head + 0.003, 0, middle}, {length - 0.002, 0, middle}, shaft);
  shape.incidental("mallet head, below", {{0, 0, 0.003}, {0, 0, middle - shaft}}, head);
  shape.incidental("mallet head, above", {{0, 0, middle + shaft}, {0, 0, height - 0.003}}, head);
  return shape;
}

/// A claw hammer; it lies on its side, the claw to -y.
Shape hammer(const Sizes& s) {
  const double thick = at(s, "shaft_thickness") / 2, wide = at(s, "shaft_width") / 2, length = at(s, "shaft_length");
  const double face = at(s, "face_radius"), head = at(s, "head_length");
  const double z = face;
  Shape shape;
  shape.add_bar({{-0.010, 0, z}, {length, 0, z}}, {0, 1, 0},
                rounded_rectangle(thick, wide, 0.9 * std::min(thick, wide)));
  // The head: a face, a block, and two claws that bend back.
  const Pose to_y = translation(0, 0, z) * rotation({1, 0, 0}, -kRightAngle);
  const std::vector<Point2> outline = {
      {0.8 * face, 0.010}, {0.8 * face, 0.45 * head - 0.016}, {face, 0.45 * head - 0.012}, {face, 0.45 * head}};
  shape.add_turned(outline, to_y);
  shape.add_box(0.026, 0.036, 0.024, translation(0, 0, z));
  const auto claw = [&](double side) -> std::vector<Vector3> {
    return {{0, -0.010, z + side}, {0.004, -0.30 * head, z + side}, {0.018, -0.55 * head, z + side}};
  };
  for (const double side : {-0.006, 0.006}) {
    shape.add_bar(claw(side), {0, 0, 1}, rounded_rectangle(0.006, 0.0045, 0.003));
  }
  shape.grip("hammer shaft", {0.018, 0, z}, {length - 0.002, 0, z}, std::max(thick, wide));
  shape.incidental_turned("hammer face", outline, 0.018, 0.45 * head, to_y);
  for (const double side : {-0.006, 0.006}) {
    shape.incidental(side < 0 ? "hammer claw, below" : "hammer claw, above",
                     clipped_path(claw(side), {0, -0.018, 0}, {0, -1, 0}), 0.006);
  }
  return shape;
}

Shape screwdriver(const Sizes& s) {
  const double grip = at(s, "grip_radius"), length = at(s, "grip_length"), blade = at(s, "blade_length");
  const Pose along = translation(0, 0, grip) * kAlongX;
  Shape shape;
  const std::vector<Point2> outline = {
      {0.70 * grip, 0}, {grip, 0.006}, {grip, 0.80 * length}, {0.65 * grip, 0.92 * length}, {0.75 * grip, length}};
  shape.add_turned(outline, along);
  shape.add_turned({{0.0032, -blade}, {0.0032, 0.010}}, along);
  shape.grip("screwdriver grip", {0, 0, 0.006}, {0, 0, 0.80 * length}, grip, 1, along);
  shape.incidental("screwdriver blade", {{0, 0, -blade}, {0, 0, 0}}, 0.0032, along);
  shape.incidental_turned("screwdriver butt", outline, 0.80 * length, length, along);
  return shape;
}

/// A cordless drill, standing on its battery; the chuck points to +x.
Shape drill(const Sizes& s) {
  const double body = at(s, "body_radius"), length = at(s, "body_length"), grip_length = at(s, "grip_length");
  const double deep = at(s, "grip_depth") / 2, wide = at(s, "grip_width") / 2;
  constexpr double kBattery = 0.045;
  const double axis_z = kBattery + grip_length + body;
  Shape shape;
  shape.add_lofted({{0, 0.055, 0.036, 0.010, 0.010, 0}, {kBattery, 0.050, 0.034, 0.010, 0.010, 0}});
  // The grip leans back a little: straight below the body, from the battery to within it.
  const std::vector<Vector3> path = {{0.012, 0, kBattery - 0.010}, {0, 0, axis_z - 0.4 * body}};
  shape.add_bar(path, {0, 1, 0}, rounded_rectangle(deep, wide, 0.9 * std::min(deep, wide)));
  const Pose along = translation(-0.40 * length, 0, axis_z) * kAlongX;
  const std::vector<Point2> housing = {
      {0.8 * body, 0}, {body, 0.008}, {body, 0.75 * length}, {0.7 * body, 0.80 * length}, {0.7 * body, length}};
  shape.add_turned(housing, along);
  const double jaws = 0.62 * body;
  const std::vector<Point2> chuck = {{jaws, length - 0.002}, {jaws, length + 0.025}, {0.4 * jaws, length + 0.045}};
  shape.add_turned(chuck, along);
  const Vector3 axis = unit(path[1] - path[0]);
  const auto at_height = [&](double z) { return path[0] + ((z - path[0][2]) / axis[2]) * axis; };
  shape.grip("drill grip", at_height(kBattery + 0.004), at_height(axis_z - body - 0.002), std::max(deep, wide));
  shape.grip("drill body", {0, 0, 0.008}, {0, 0, 0.75 * length}, body, 0.4, along);
  shape.incidental_turned("drill gearbox", housing, 0.80 * length, length, along);
  shape.incidental_turned("drill chuck", chuck, length, length + 0.045, along);
  return shape;
}

Shape torch(const Sizes& s) {
  const double body = at(s, "body_radius"), length = at(s, "body_length"), head = at(s, "head_radius");
  const double head_length = at(s, "head_length"), end = length + 0.015 + head_length;
  Shape shape;
  shape.add_turned({{body - 0.002, 0},
                    {body, 0.002},
                    {body, length},
                    {head, length + 0.015},
                    {head, end - 0.002},
                    {head - 0.002, end}});
  shape.grip("torch body", {0, 0, 0.002}, {0, 0, length}, body);
  shape.grip("torch head", {0, 0, length + 0.015}, {0, 0, end - 0.002}, head);
  return shape;
}

/// Blade to -x, hollow side up.
Shape trowel(const Sizes& s) {
  const double grip = at(s, "grip_radius"), length = at(s, "grip_length"), blade = at(s, "blade_length");
  const double half = at(s, "blade_width") / 2, rise = 0.030 + grip;
  Shape shape;
  shape.add_turned(
      {{0.75 * grip, 0}, {grip, 0.010}, {0.92 * grip, 0.5 * length}, {grip, length - 0.008}, {0.7 * grip, length}},
      translation(0.060, 0, rise) * kAlongX);
  constexpr double kNeck = 0.0045;
  const auto neck = rounded_path({{0.070, 0, rise}, {0.030, 0, rise}, {0, 0, 0.005}, {-0.030, 0, 0.005}}, 0.020);
  shape.add_rod(neck, {0, 1, 0}, kNeck);
  // Three plates: the floor of the blade and its raised sides.
  shape.add_box(blade, 1.2 * half, 0.003, translation(-blade / 2, 0, 0.0025));
  for (const double side : {-1.0, 1.0}) {
    shape.add_box(0.92 * blade, 0.5 * half, 0.003,
                  translation(-0.46 * blade, side * 0.80 * half, 0.011) * rotation({1, 0, 0}, side * 0.6));
  }
  shape.grip("trowel grip", {0.070, 0, rise}, {0.060 + length - 0.008, 0, rise}, grip);
  shape.incidental("trowel neck", clipped_path(clipped_path(neck, {0.060, 0, 0}, {-1, 0, 0}), {0, 0, 0}, {1, 0, 0}),
                   kNeck);
  return shape;
}

Shape dumbbell(const Sizes& s) {
  const double grip = at(s, "grip_radius"), length = at(s, "grip_length"), head = at(s, "head_radius");
  const double head_length = at(s, "head_length"), half = length / 2;
  const Pose along = translation(0, 0, head) * kAlongX;
  Shape shape;
  shape.add_cylinder(grip, length + 0.020, along * translation(0, 0, -half - 0.010));
  for (const double z : {-half - head_length, half}) {
    shape.add_turned({{head - 0.004, 0}, {head, 0.004}, {head, head_length - 0.004}, {head - 0.004, head_length}},
                     along * translation(0, 0, z));
  }
  shape.grip("dumbbell grip", {0, 0, -half + 0.001}, {0, 0, half - 0.001}, grip, 1, along);
  if (head <= 0.041) {
    shape.grip("dumbbell head, -x", {0, 0, -half - head_length + 0.004}, {0, 0, -half - 0.004}, head, 0.4, along);
    shape.grip("dumbbell head, +x", {0, 0, half + 0.004}, {0, 0, half + head_length - 0.004}, head, 0.4, along);
  }
  return shape;
}

}  // namespace

std::vector<FamilyMaker> tool_families() {
  return {
      {{"mallet",
        kGraspable,
        kTuning,
        true,
        {{"shaft_radius", 0.014, 0.010, 0.017},
         {"shaft_length", 0.250, 0.200, 0.320},
         {"head_radius", 0.024, 0.020, 0.036},
         {"head_length", 0.104, 0.085, 0.130}}},
       mallet},
      {{"hammer",
        kGraspable,
        kTuning,
        false,
        {{"shaft_thickness", 0.024, 0.018, 0.030},
         {"shaft_width", 0.032, 0.024, 0.038},
         {"shaft_length", 0.260, 0.210, 0.310},
         {"face_radius", 0.015, 0.012, 0.018},
         {"head_length", 0.115, 0.095, 0.135}}},
       hammer},
      {{"screwdriver",
        kGraspable,
        kTuning,
        false,
        {{"grip_radius", 0.015, 0.011, 0.019},
         {"grip_length", 0.105, 0.085, 0.125},
         {"blade_length", 0.110, 0.060, 0.160}}},
       screwdriver},
      {{"drill",
        kGraspable,
        kTuning,
        true,
        {{"body_radius", 0.030, 0.026, 0.034},
         {"body_length", 0.150, 0.130, 0.180},
         {"grip_length", 0.095, 0.080, 0.110},
         {"grip_depth", 0.044, 0.036, 0.050},
         {"grip_width", 0.034, 0.028, 0.040}}},
       drill},
      {{"torch",
        kGraspable,
        kTuning,
        true,
        {{"body_radius", 0.016, 0.012, 0.020},
         {"body_length", 0.120, 0.090, 0.180},
         {"head_radius", 0.024, 0.021, 0.032},
         {"head_length", 0.040, 0.030, 0.055}}},
       torch},
      {{"trowel",
        kGraspable,
        kReport,
        false,
        {{"grip_radius", 0.0145, 0.011, 0.018},
         {"grip_length", 0.120, 0.100, 0.140},
         {"blade_length", 0.150, 0.120, 0.180},
         {"blade_width", 0.080, 0.060, 0.095}}},
       trowel},
      {{"dumbbell",
        kGraspable,
        kReport,
        true,
        {{"grip_radius", 0.015, 0.012, 0.018},
         {"grip_length", 0.125, 0.110, 0.140},
         {"head_radius", 0.036, 0.028, 0.050},
         {"head_length", 0.045, 0.035, 0.060}}},
       dumbbell},
  };
}

}  // namespace handhold::sensor
