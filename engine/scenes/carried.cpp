// Things that are carried or pulled by a handle on their outside.
#include <algorithm>
#include <cmath>

#include "family_makers.h"
#include "vec.h"

namespace handhold::sensor {
namespace {

constexpr FamilyGroup kGraspable = FamilyGroup::kGraspable;
constexpr FamilyHalf kTuning = FamilyHalf::kTuning, kReport = FamilyHalf::kReport;

/// A case for a tool, standing, with a handle on top along x.
Shape carrying_case(const Sizes& s) {
  const double width = at(s, "width"), depth = at(s, "depth"), height = at(s, "height");
  const double half = at(s, "handle_length") / 2, rise = at(s, "handle_rise");
  const double thick = at(s, "handle_thickness") / 2, wide = at(s, "handle_width") / 2;
  Shape shape;
  shape.add_lofted({{0, width / 2 - 0.006, depth / 2 - 0.006, 0.012},
                    {0.006, width / 2, depth / 2, 0.012},
                    {height - 0.006, width / 2, depth / 2, 0.012},
                    {height, width / 2 - 0.006, depth / 2 - 0.006, 0.012}});
  const double foot = height - 0.010;
  const auto bow =
      rounded_path({{-half, 0, foot}, {-half, 0, height + rise}, {half, 0, height + rise}, {half, 0, foot}}, 0.022);
  shape.add_bar(bow, {0, 1, 0}, rounded_rectangle(thick, wide, 0.9 * std::min(thick, wide)));
  shape.loop("carrying case handle", clipped_path(bow, {0, 0, height + 0.002}, {0, 0, 1}), std::max(thick, wide));
  return shape;
}

/// A pail; its bow of wire stands up and carries a round grip.
Shape bucket(const Sizes& s) {
  const double low = at(s, "bottom_radius"), high = at(s, "top_radius"), height = at(s, "height");
  const double grip = at(s, "grip_radius"), half = at(s, "grip_length") / 2, rise = at(s, "bow_rise");
  constexpr double kWall = 0.003, kWire = 0.0025;
  Shape shape;
  shape.add_vessel({{0, low, low - kWall}, {height - 0.006, high, high - kWall}, {height, high + 0.003, high - kWall}},
                   0.003);
  const double top = height + rise, foot = high + 0.004;
  const auto bow = rounded_path({{-foot, 0, height - 0.020},
                                 {-foot, 0, height + 0.3 * rise},
                                 {-0.5 * foot - 0.5 * half, 0, top},
                                 {0.5 * foot + 0.5 * half, 0, top},
                                 {foot, 0, height + 0.3 * rise},
                                 {foot, 0, height - 0.020}},
                                0.030);
  shape.add_bar(bow, {0, 1, 0}, rounded_rectangle(kWire, kWire, kWire, 4));
  for (const double side : {-1.0, 1.0})
    shape.add_box(0.012, 0.014, 0.014, translation(side * (high + 0.002), 0, height - 0.016));
  const Pose along = translation(-half, 0, top) * rotation({0, 1, 0}, kRightAngle);
  shape.add_cylinder(grip, 2 * half, along);
  shape.grip("bucket grip", {0, 0, 0.001}, {0, 0, 2 * half - 0.001}, grip, 1, along);
  // The wire, from where it leaves the boxes at its feet.
  const auto above = clipped_path(bow, {0, 0, height - 0.009}, {0, 0, 1});
  shape.incidental("bucket bow, -x", clipped_path(above, {-half, 0, 0}, {-1, 0, 0}), kWire);
  shape.incidental("bucket bow, +x", clipped_path(above, {half, 0, 0}, {1, 0, 0}), kWire);
  return shape;
}

/// A basket with a broad bow across.
Shape basket(const Sizes& s) {
  const double width = at(s, "width"), depth = at(s, "depth"), height = at(s, "height"), rise = at(s, "bow_rise");
  const double thick = at(s, "strap_thickness") / 2, wide = at(s, "strap_width") / 2;
  Shape shape;
  shape.add_open_box(width, depth, height, 0.005);
  // A half ellipse; its feet stand inside the walls, which are wider than the bow is thick.
  std::vector<Vector3> bow, free;
  constexpr int kSteps = 48;
  const double half = width / 2 - thick;
  bow.push_back({half, 0, height - 0.020});
  for (int i = 0; i <= kSteps; ++i) {
    const double a = 2 * kRightAngle * i / kSteps;
    bow.push_back({half * std::cos(a), 0, height + 0.001 + rise * std::sin(a)});
    free.push_back(bow.back());
  }
  bow.push_back({-half, 0, height - 0.020});
  shape.add_bar(bow, {0, 1, 0}, rounded_rectangle(thick, wide, 0.9 * std::min(thick, wide)));
  shape.loop("basket bow", free, std::max(thick, wide));
  return shape;
}

/// An open tool box with a bar from one end board to the other.
Shape tool_tote(const Sizes& s) {
  const double width = at(s, "width"), depth = at(s, "depth"), height = at(s, "height"), rise = at(s, "bar_rise");
  const double bar = at(s, "bar_radius"), half = width / 2;
  constexpr double kWall = 0.008;
  Shape shape;
  shape.add_open_box(width, depth, height, kWall);
  for (const double side : {-1.0, 1.0}) {
    shape.add_box(kWall, 0.060, rise + 0.030, translation(side * (half - kWall / 2), 0, height + rise / 2 - 0.005));
  }
  const Pose along = translation(-half + kWall / 2, 0, height + rise - 0.010) * rotation({0, 1, 0}, kRightAngle);
  shape.add_cylinder(bar, width - kWall, along);
  shape.grip("tool tote bar", {0, 0, kWall / 2 + 0.001}, {0, 0, width - 1.5 * kWall - 0.001}, bar, 1, along);
  return shape;
}

/// A piece of a cupboard: a block with a drawer handle on its face towards +x.
Shape drawer_block(const Sizes& s) {
  const double width = at(s, "width"), depth = at(s, "depth"), height = at(s, "height"), bar = at(s, "handle_radius");
  const double half = at(s, "handle_length") / 2, reach = at(s, "handle_reach"), z = 0.6 * height;
  Shape shape;
  shape.add_box(depth, width, height, translation(-depth / 2, 0, height / 2));
  const auto bow = rounded_path({{-0.005, -half, z}, {reach, -half, z}, {reach, half, z}, {-0.005, half, z}}, 0.012);
  shape.add_rod(bow, {0, 0, 1}, bar);
  shape.loop("drawer handle", clipped_path(bow, {0.002, 0, 0}, {1, 0, 0}), bar);
  return shape;
}

}  // namespace

std::vector<FamilyMaker> carried_families() {
  return {
      {{"bucket",
        kGraspable,
        kTuning,
        true,
        {{"bottom_radius", 0.065, 0.055, 0.075},
         {"top_radius", 0.085, 0.078, 0.100},
         {"height", 0.140, 0.110, 0.180},
         {"grip_radius", 0.012, 0.009, 0.015},
         {"grip_length", 0.085, 0.070, 0.095},
         {"bow_rise", 0.085, 0.070, 0.100}}},
       bucket},
      {{"tool_tote",
        kGraspable,
        kTuning,
        true,
        {{"width", 0.260, 0.200, 0.340},
         {"depth", 0.150, 0.120, 0.200},
         {"height", 0.080, 0.060, 0.110},
         {"bar_rise", 0.090, 0.070, 0.110},
         {"bar_radius", 0.012, 0.008, 0.016}}},
       tool_tote},
      {{"carrying_case",
        kGraspable,
        kReport,
        true,
        {{"width", 0.300, 0.260, 0.340},
         {"depth", 0.095, 0.086, 0.110},
         {"height", 0.210, 0.180, 0.250},
         {"handle_length", 0.130, 0.110, 0.150},
         {"handle_rise", 0.042, 0.036, 0.050},
         {"handle_thickness", 0.016, 0.012, 0.020},
         {"handle_width", 0.024, 0.018, 0.030}}},
       carrying_case},
      {{"basket",
        kGraspable,
        kReport,
        true,
        {{"width", 0.220, 0.180, 0.260},
         {"depth", 0.160, 0.130, 0.190},
         {"height", 0.090, 0.070, 0.110},
         {"bow_rise", 0.110, 0.090, 0.130},
         {"strap_thickness", 0.008, 0.006, 0.012},
         {"strap_width", 0.024, 0.016, 0.030}}},
       basket},
      {{"drawer_block",
        kGraspable,
        kReport,
        true,
        {{"width", 0.260, 0.200, 0.320},
         {"depth", 0.160, 0.120, 0.200},
         {"height", 0.130, 0.110, 0.170},
         {"handle_length", 0.120, 0.096, 0.150},
         {"handle_radius", 0.006, 0.005, 0.009},
         {"handle_reach", 0.034, 0.030, 0.042}}},
       drawer_block},
  };
}

}  // namespace handhold::sensor
