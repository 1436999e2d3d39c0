// Things without a part that an 0.08 m hand could go around, and the boards that everything stands on.
#include <cmath>

#include "family_makers.h"

namespace handhold::sensor {
namespace {

constexpr FamilyGroup kPlain = FamilyGroup::kPlain;
constexpr FamilyHalf kTuning = FamilyHalf::kTuning, kReport = FamilyHalf::kReport;

Shape block(const Sizes& s) {
  const double x = at(s, "width"), y = at(s, "depth"), z = at(s, "height");
  Shape shape;
  shape.add_box(x, y, z, translation(0, 0, z / 2));
  return shape;
}

/// A book: covers that stand out beyond the pages, and a round spine at -x.
Shape book(const Sizes& s) {
  const double x = at(s, "width"), y = at(s, "height"), z = at(s, "thickness");
  constexpr double kCover = 0.003;
  Shape shape;
  for (const double h : {kCover / 2, z - kCover / 2}) shape.add_box(x, y, kCover, translation(0, 0, h));
  shape.add_box(x - 0.006, y - 0.008, z - kCover, translation(0, 0, z / 2));
  shape.add_bar({{-x / 2 + 0.003, -y / 2, z / 2}, {-x / 2 + 0.003, y / 2, z / 2}}, {0, 0, 1},
                rounded_rectangle(0.006, z / 2, 0.005));
  return shape;
}

Shape bowl(const Sizes& s) {
  const double foot = at(s, "foot_radius"), rim = at(s, "rim_radius"), height = at(s, "height");
  constexpr double kWall = 0.004;
  constexpr int kSteps = 8;
  std::vector<WallRing> wall;
  for (int i = 0; i <= kSteps; ++i) {
    const double a = kRightAngle * i / kSteps, r = foot + (rim - foot) * std::sin(a);
    wall.push_back({height * (1 - std::cos(a)), r, r - kWall});
  }
  Shape shape;
  shape.add_vessel(wall, 0.005);
  return shape;
}

Shape plate(const Sizes& s) {
  const double rim = at(s, "radius"), height = at(s, "height");
  constexpr double kWall = 0.004;
  Shape shape;
  // The wall's radii differ by far more than its thickness: it is nearly flat.
  shape.add_vessel({{0, 0.60 * rim, 0.60 * rim - kWall},
                    {0.35 * height, 0.68 * rim, 0.68 * rim - 2 * kWall},
                    {height, rim, rim - 4 * kWall}},
                   0.004);
  return shape;
}

Shape ball(const Sizes& s) {
  const double radius = at(s, "radius");
  Shape shape;
  shape.add_sphere(radius, translation(0, 0, radius));
  return shape;
}

Shape big_can(const Sizes& s) {
  const double radius = at(s, "radius"), height = at(s, "height");
  Shape shape;
  shape.add_turned({{radius, 0}, {radius, height - 0.004}, {radius - 0.003, height - 0.003}, {radius - 0.003, height}});
  return shape;
}

Shape open_box(const Sizes& s) {
  Shape shape;
  shape.add_open_box(at(s, "width"), at(s, "depth"), at(s, "height"), at(s, "wall"));
  return shape;
}

Shape planter(const Sizes& s) {
  const double low = at(s, "bottom_radius"), high = at(s, "top_radius"), height = at(s, "height");
  constexpr double kWall = 0.005;
  Shape shape;
  shape.add_vessel({{0, low, low - kWall},
                    {0.78 * height, high - 0.005, high - 0.005 - kWall},
                    {0.80 * height, high, high - 2 * kWall},
                    {height, high, high - 2 * kWall}},
                   0.006);
  return shape;
}

/// A basin with a lip that is turned outwards.
Shape basin(const Sizes& s) {
  const double low = at(s, "bottom_radius"), high = at(s, "top_radius"), height = at(s, "height"), lip = at(s, "lip");
  constexpr double kWall = 0.003;
  Shape shape;
  shape.add_vessel({{0, low, low - kWall},
                    {height - 0.008, high, high - kWall},
                    {height - 0.005, high + lip, high - kWall},
                    {height, high + lip, high - kWall}},
                   0.004);
  return shape;
}

/// A closed box with round corners all around its outline.
Shape tin(const Sizes& s) {
  const double half_x = at(s, "width") / 2, half_y = at(s, "depth") / 2, height = at(s, "height");
  const double corner = at(s, "corner");
  Shape shape;
  shape.add_lofted({{0, half_x - 0.003, half_y - 0.003, corner},
                    {0.003, half_x, half_y, corner},
                    {height - 0.003, half_x, half_y, corner},
                    {height, half_x - 0.003, half_y - 0.003, corner}});
  return shape;
}

/// Its top is z = 0.
Shape board(const Sizes& s) {
  const double z = at(s, "thickness");
  Shape shape;
  shape.add_box(at(s, "width"), at(s, "depth"), z, translation(0, 0, -z / 2));
  return shape;
}

}  // namespace

std::vector<FamilyMaker> plain_families() {
  return {
      // No side of a box is narrow enough for the hand.
      {{"carton",
        kPlain,
        kTuning,
        true,
        {{"width", 0.120, 0.090, 0.220}, {"depth", 0.090, 0.086, 0.150}, {"height", 0.140, 0.088, 0.260}}},
       block},
      {{"book",
        kPlain,
        kTuning,
        true,
        {{"width", 0.150, 0.110, 0.200}, {"height", 0.220, 0.170, 0.280}, {"thickness", 0.030, 0.018, 0.055}}},
       book},
      {{"bowl",
        kPlain,
        kTuning,
        true,
        {{"foot_radius", 0.032, 0.028, 0.045}, {"rim_radius", 0.072, 0.060, 0.095}, {"height", 0.058, 0.045, 0.080}}},
       bowl},
      {{"ball", kPlain, kTuning, true, {{"radius", 0.060, 0.046, 0.090}}}, ball},
      {{"bin",
        kPlain,
        kTuning,
        true,
        {{"width", 0.180, 0.130, 0.260},
         {"depth", 0.130, 0.100, 0.190},
         {"height", 0.110, 0.086, 0.160},
         {"wall", 0.004, 0.003, 0.006}}},
       open_box},
      {{"basin",
        kPlain,
        kTuning,
        true,
        {{"bottom_radius", 0.080, 0.060, 0.110},
         {"top_radius", 0.115, 0.112, 0.150},
         {"height", 0.090, 0.060, 0.130},
         {"lip", 0.008, 0.004, 0.012}}},
       basin},
      {{"crate",
        kPlain,
        kTuning,
        true,
        {{"width", 0.260, 0.180, 0.340},
         {"depth", 0.180, 0.130, 0.240},
         {"height", 0.060, 0.030, 0.100},
         {"wall", 0.009, 0.006, 0.014}}},
       open_box},
      {{"tin",
        kPlain,
        kTuning,
        true,
        {{"width", 0.170, 0.120, 0.230},
         {"depth", 0.120, 0.090, 0.150},
         {"height", 0.050, 0.030, 0.085},
         {"corner", 0.015, 0.008, 0.025}}},
       tin},
      {{"brick",
        kPlain,
        kReport,
        true,
        {{"width", 0.215, 0.190, 0.240}, {"depth", 0.105, 0.090, 0.115}, {"height", 0.090, 0.086, 0.110}}},
       block},
      {{"big_can", kPlain, kReport, true, {{"radius", 0.050, 0.046, 0.075}, {"height", 0.130, 0.090, 0.180}}}, big_can},
      {{"plate", kPlain, kReport, true, {{"radius", 0.110, 0.090, 0.135}, {"height", 0.022, 0.018, 0.030}}}, plate},
      {{"tray",
        kPlain,
        kReport,
        true,
        {{"width", 0.300, 0.240, 0.360},
         {"depth", 0.210, 0.170, 0.260},
         {"height", 0.025, 0.018, 0.040},
         {"wall", 0.006, 0.004, 0.010}}},
       open_box},
      {{"planter",
        kPlain,
        kReport,
        true,
        {{"bottom_radius", 0.046, 0.044, 0.055}, {"top_radius", 0.068, 0.062, 0.085}, {"height", 0.115, 0.095, 0.140}}},
       planter},
      {{"board",
        FamilyGroup::kFurniture,
        FamilyHalf::kBoth,
        true,
        {{"width", 1.000, 0.050, 10.0}, {"depth", 0.700, 0.050, 10.0}, {"thickness", 0.020, 0.005, 1.0}}},
       board},
  };
}

}  // namespace handhold::sensor
