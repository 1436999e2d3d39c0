// Bottles, cans and cups: bodies of revolution that a hand goes around, and detergent bottles with a handle.
#include "family_makers.h"
#include "vec.h"

namespace handhold::sensor {
namespace {

constexpr FamilyGroup kGraspable = FamilyGroup::kGraspable;
constexpr FamilyHalf kTuning = FamilyHalf::kTuning, kReport = FamilyHalf::kReport;

void append(std::vector<Point2>& to, const std::vector<Point2>& points) {
  to.insert(to.end(), points.begin(), points.end());
}

Shape bottle(const Sizes& s) {
  const double body = at(s, "body_radius"), body_height = at(s, "body_height"), neck = at(s, "neck_radius");
  const double neck_from = body_height + at(s, "shoulder_height"), height = neck_from + at(s, "neck_height");
  std::vector<Point2> outline = {{body - 0.003, 0}, {body, 0.003}};
  append(outline, shoulder({body, body_height}, {neck, neck_from}));
  append(outline, {{neck, height - 0.002}, {neck - 0.002, height}});
  Shape shape;
  shape.add_turned(outline);
  shape.grip("bottle body", {0, 0, 0.003}, {0, 0, body_height}, body);
  shape.grip("bottle neck", {0, 0, neck_from}, {0, 0, height - 0.002}, neck);
  shape.incidental_turned("bottle shoulder", outline, body_height, neck_from);
  return shape;
}

Shape wine_bottle(const Sizes& s) {
  const double body = at(s, "body_radius"), body_height = at(s, "body_height"), neck = at(s, "neck_radius");
  const double neck_from = body_height + at(s, "shoulder_height"), height = neck_from + at(s, "neck_height");
  std::vector<Point2> outline = {{body - 0.003, 0}, {body, 0.003}};
  append(outline, shoulder({body, body_height}, {neck, neck_from}));
  append(outline, {{neck, height - 0.015}, {neck + 0.0015, height - 0.014}, {neck + 0.0015, height}});
  Shape shape;
  shape.add_turned(outline);
  shape.grip("wine bottle body", {0, 0, 0.003}, {0, 0, body_height}, body);
  shape.grip("wine bottle neck", {0, 0, neck_from}, {0, 0, height - 0.002}, neck);
  shape.incidental_turned("wine bottle shoulder", outline, body_height, neck_from);
  return shape;
}

/// A vase: foot, waist and mouth in one smooth line.
Shape vase(const Sizes& s) {
  const double foot = at(s, "foot_radius"), waist = at(s, "waist_radius"), mouth = at(s, "mouth_radius");
  const double height = at(s, "height"), low = 0.35 * height, high = low + at(s, "waist_length");
  std::vector<Point2> outline = {{foot - 0.003, 0}, {foot, 0.003}};
  append(outline, shoulder({foot, low - 0.025}, {waist, low}));
  append(outline, shoulder({waist, high}, {mouth, high + 0.025}));
  append(outline, {{mouth, height - 0.002}, {mouth - 0.002, height}});
  Shape shape;
  shape.add_turned(outline);
  shape.grip("vase foot", {0, 0, 0.003}, {0, 0, low - 0.025}, foot);
  shape.grip("vase waist", {0, 0, low}, {0, 0, high}, waist);
  shape.grip("vase mouth", {0, 0, high + 0.025}, {0, 0, height - 0.002}, mouth);
  return shape;
}

/// A drinking bottle with a waist for the hand.
Shape blue_bottle(const Sizes& s) {
  const double body = at(s, "body_radius"), waist = at(s, "waist_radius"), cap = at(s, "cap_radius");
  const double low = at(s, "low_height"), waist_length = at(s, "waist_length");
  const double waist_from = low + 0.015, waist_to = waist_from + waist_length, top = waist_to + 0.015 + 0.040;
  const double cap_from = top + 0.018, height = cap_from + at(s, "cap_height");
  std::vector<Point2> outline = {{body - 0.004, 0}, {body, 0.004}};
  append(outline, shoulder({body, low}, {waist, waist_from}));
  append(outline, shoulder({waist, waist_to}, {body, waist_to + 0.015}));
  append(outline, shoulder({body, top}, {cap, cap_from}));
  append(outline, {{cap, height - 0.002}, {cap - 0.002, height}});
  Shape shape;
  shape.add_turned(outline);
  shape.grip("blue bottle lower body", {0, 0, 0.004}, {0, 0, low}, body);
  shape.grip("blue bottle waist", {0, 0, waist_from}, {0, 0, waist_to}, waist);
  shape.grip("blue bottle upper body", {0, 0, waist_to + 0.015}, {0, 0, top}, body);
  shape.grip("blue bottle cap", {0, 0, cap_from}, {0, 0, height - 0.002}, cap);
  return shape;
}

/// A detergent bottle: a block, on it a column that carries the cap, and beside the column the handle.
Shape detergent_bottle(const Sizes& s, const std::string& name, bool upright_handle) {
  const double half_x = at(s, "width") / 2, half_y = at(s, "depth") / 2, height = at(s, "height");
  const double bar = at(s, "handle_radius");
  const double block = 0.46 * height, column_half = 0.24 * at(s, "width"), column_x = -half_x + column_half;
  const double top = 0.88 * height, corner = 0.3 * half_y;
  Shape shape;
  shape.add_lofted({{0, half_x - 0.004, half_y - 0.004, corner},
                    {0.006, half_x, half_y, corner},
                    {block - 0.020, half_x, half_y, corner},
                    {block, half_x - 0.008, half_y - 0.012, corner}});
  const double thin_y = 0.7 * half_y;
  shape.add_lofted({{block - 0.030, column_half, thin_y, corner, column_x, 0},
                    {top - 0.020, column_half, thin_y, corner, column_x, 0},
                    {top, 0.026, 0.026, 0.024, column_x, 0}});
  const double cap = at(s, "cap_radius");
  shape.add_cylinder(cap, height - top + 0.004, translation(column_x, 0, top - 0.004));
  // Out of the column at the top, down, and into the block. A slanted one falls all the way to the block's far corner.
  const double high = top - 0.022 - bar, out = half_x - bar - 0.010, side = column_x + column_half;
  const double over = upright_handle ? out : 0.6 * side + 0.4 * out;
  const auto handle = rounded_path({{column_x, 0, high}, {over, 0, high}, {out, 0, block - 0.020}}, 0.022);
  shape.add_bar(handle, {0, 1, 0}, rounded_rectangle(bar, 1.15 * bar, 0.95 * bar));
  const auto beside_column = clipped_path(handle, {side + 0.001, 0, 0}, {1, 0, 0});
  shape.loop(name + " handle", clipped_path(beside_column, {0, 0, block + 0.002}, {0, 0, 1}), 1.15 * bar);
  shape.grip(name + " cap", {column_x, 0, top}, {column_x, 0, height}, cap, 0.4);
  return shape;
}

Shape purex_bottle(const Sizes& s) {
  return detergent_bottle(s, "white Purex bottle", true);
}
Shape all_bottle(const Sizes& s) {
  return detergent_bottle(s, "white All bottle", false);
}

Shape sprayer(const Sizes& s) {
  const double body = at(s, "body_radius"), body_height = at(s, "body_height"), neck = at(s, "neck_radius");
  const double neck_from = body_height + 0.030, neck_to = neck_from + at(s, "neck_length"), head = at(s, "head_length");
  std::vector<Point2> outline = {{body - 0.003, 0}, {body, 0.003}};
  append(outline, shoulder({body, body_height}, {neck, neck_from}));
  append(outline, {{neck, neck_to + 0.004}});
  Shape shape;
  shape.add_turned(outline);
  // The head points to +x; the trigger hangs before the neck.
  const double head_x = head / 2 - 0.028;
  shape.add_lofted({{neck_to, head / 2 - 0.004, 0.012, 0.005, head_x, 0},
                    {neck_to + 0.008, head / 2, 0.014, 0.006, head_x, 0},
                    {neck_to + 0.030, head / 2 - 0.006, 0.012, 0.006, head_x, 0}});
  const double trigger_x = 0.60 * head - 0.028;
  const std::vector<Vector3> trigger = {{trigger_x, 0, neck_to + 0.006},
                                        {trigger_x + 0.002, 0, neck_to - 0.015},
                                        {trigger_x + 0.010, 0, neck_to - 0.045}};
  shape.add_bar(trigger, {0, 1, 0}, rounded_rectangle(0.0035, 0.008, 0.003));
  shape.grip("sprayer body", {0, 0, 0.003}, {0, 0, body_height}, body);
  shape.grip("sprayer neck", {0, 0, neck_from}, {0, 0, neck_to}, neck);
  shape.incidental_turned("sprayer shoulder", outline, body_height, neck_from);
  shape.incidental("sprayer trigger", clipped_path(trigger, {0, 0, neck_to}, {0, 0, -1}), 0.008);
  return shape;
}

Shape spray_can(const Sizes& s) {
  const double body = at(s, "body_radius"), body_height = at(s, "body_height"), cap = 0.80 * body;
  const double height = body_height + at(s, "cap_height");
  Shape shape;
  shape.add_turned({{body - 0.002, 0},
                    {body, 0.002},
                    {body, body_height - 0.012},
                    {cap + 0.002, body_height},
                    {cap, body_height},
                    {cap, height - 0.003},
                    {cap - 0.003, height}});
  shape.grip("spray can body", {0, 0, 0.002}, {0, 0, body_height - 0.012}, body);
  shape.grip("spray can cap", {0, 0, body_height}, {0, 0, height - 0.003}, cap);
  return shape;
}

Shape soup_can(const Sizes& s) {
  const double radius = at(s, "radius"), height = at(s, "height");
  Shape shape;
  shape.add_turned({{radius, 0},
                    {radius, 0.003},
                    {radius - 0.001, 0.004},
                    {radius - 0.001, height - 0.004},
                    {radius, height - 0.003},
                    {radius, height}});
  shape.grip("soup can", {0, 0, 0.002}, {0, 0, height - 0.002}, radius - 0.001);
  return shape;
}

Shape cup(const Sizes& s) {
  const double bottom = at(s, "bottom_radius"), top = at(s, "top_radius"), height = at(s, "height");
  constexpr double kWall = 0.002;
  Shape shape;
  shape.add_vessel({{0, bottom, bottom - kWall}, {height, top, top - kWall}}, 0.003);
  shape.grip("cup", {0, 0, 0.004}, {0, 0, height - 0.004}, (bottom + top) / 2);
  return shape;
}

}  // namespace

std::vector<FamilyMaker> bottle_families() {
  return {
      {{"bottle",
        kGraspable,
        kTuning,
        true,
        {{"body_radius", 0.030, 0.022, 0.037},
         {"body_height", 0.130, 0.090, 0.170},
         {"shoulder_height", 0.032, 0.025, 0.045},
         {"neck_radius", 0.014, 0.011, 0.017},
         {"neck_height", 0.048, 0.030, 0.060}}},
       bottle},
      {{"wine_bottle",
        kGraspable,
        kTuning,
        true,
        {{"body_radius", 0.0375, 0.0345, 0.0390},
         {"body_height", 0.190, 0.165, 0.210},
         {"shoulder_height", 0.040, 0.030, 0.060},
         {"neck_radius", 0.0145, 0.0135, 0.0160},
         {"neck_height", 0.080, 0.065, 0.090}}},
       wine_bottle},
      {{"spray_can",
        kGraspable,
        kTuning,
        true,
        {{"body_radius", 0.0285, 0.0240, 0.0335},
         {"body_height", 0.160, 0.120, 0.200},
         {"cap_height", 0.040, 0.030, 0.050}}},
       spray_can},
      {{"cup",
        kGraspable,
        kTuning,
        true,
        {{"bottom_radius", 0.030, 0.026, 0.033},
         {"top_radius", 0.037, 0.0345, 0.039},
         {"height", 0.100, 0.080, 0.130}}},
       cup},
      {{"vase",
        kGraspable,
        kTuning,
        true,
        {{"foot_radius", 0.036, 0.030, 0.040},
         {"waist_radius", 0.024, 0.018, 0.027},
         {"mouth_radius", 0.033, 0.028, 0.038},
         {"height", 0.240, 0.200, 0.280},
         {"waist_length", 0.055, 0.040, 0.070}}},
       vase},
      {{"blue_bottle",
        kGraspable,
        kReport,
        true,
        {{"body_radius", 0.036, 0.033, 0.039},
         {"waist_radius", 0.029, 0.025, 0.031},
         {"cap_radius", 0.017, 0.014, 0.020},
         {"low_height", 0.070, 0.050, 0.090},
         {"waist_length", 0.060, 0.045, 0.075},
         {"cap_height", 0.030, 0.025, 0.035}}},
       blue_bottle},
      {{"purex_bottle",
        kGraspable,
        kReport,
        true,
        {{"width", 0.160, 0.150, 0.180},
         {"depth", 0.095, 0.088, 0.110},
         {"height", 0.280, 0.260, 0.310},
         {"handle_radius", 0.014, 0.011, 0.016},
         {"cap_radius", 0.026, 0.022, 0.030}}},
       purex_bottle},
      {{"all_bottle",
        kGraspable,
        kReport,
        true,
        {{"width", 0.175, 0.165, 0.200},
         {"depth", 0.090, 0.086, 0.105},
         {"height", 0.250, 0.240, 0.290},
         {"handle_radius", 0.013, 0.010, 0.015},
         {"cap_radius", 0.030, 0.026, 0.034}}},
       all_bottle},
      {{"sprayer",
        kGraspable,
        kReport,
        true,
        {{"body_radius", 0.036, 0.030, 0.039},
         {"body_height", 0.150, 0.120, 0.180},
         {"neck_radius", 0.013, 0.011, 0.015},
         {"neck_length", 0.045, 0.035, 0.055},
         {"head_length", 0.095, 0.085, 0.110}}},
       sprayer},
      {{"soup_can", kGraspable, kReport, true, {{"radius", 0.033, 0.026, 0.0385}, {"height", 0.105, 0.070, 0.130}}},
       soup_can},
  };
}

}  // namespace handhold::sensor
