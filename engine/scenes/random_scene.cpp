#include "handhold/random_scene.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <stdexcept>

#include "draw.h"
#include "placement.h"
#include "vec.h"

namespace handhold::sensor {
namespace {

constexpr double kHalfTurn = 3.141592653589793;

Material draw_material(Draw& draw) {
  Material material;
  const double kind = draw.uniform(0, 1);
  material.reflectance = draw.uniform(0.35, 0.90);
  material.specular = draw.uniform(0, 0.10);
  if (kind > 0.88) {
    material.specular = draw.uniform(0.30, 0.80);
  } else if (kind > 0.76) {
    material.reflectance = draw.uniform(0.05, 0.20);
  }
  return material;
}

Sizes draw_sizes(const Family& family, Draw& draw) {
  Sizes sizes;
  for (const SizeRange& range : family.sizes) sizes[range.name] = draw.uniform(range.low, range.high);
  return sizes;
}

/// What stands on the table already, and where the next thing may go.
class Table {
 public:
  Table(double width, double depth, Draw& draw) : half_x_(width / 2), half_y_(depth / 2), draw_(draw) {}

  /// Puts a thing near the middle, or on top of another one; false when nothing was free.
  bool put(const std::string& family_name, bool on_top) {
    const Family& kind = family(family_name);
    const Pose start = kind.stands && draw_.chance(0.5) ? Pose{} : draw_.orientation();
    const Resting thing = at_rest("", family_name, draw_sizes(kind, draw_), start);
    if (on_top && put_on_top(thing)) return true;
    constexpr int kTries = 60;
    double reach = 0.10 + 0.02 * static_cast<double>(things_.size());
    for (int i = 0; i < kTries; ++i, reach *= 1.04) {
      const double r = reach * std::sqrt(draw_.uniform(0, 1)), a = draw_.uniform(0, 2 * kHalfTurn);
      const Resting there = moved(thing, r * std::cos(a), r * std::sin(a), 0, draw_.uniform(0, 2 * kHalfTurn));
      if (!is_on_table(there) || !is_free(there, nullptr)) continue;
      add(there);
      return true;
    }
    return false;
  }
  const std::vector<Resting>& things() const { return things_; }

 private:
  static constexpr double kGap = 0.004;  // m between the shadows of two things

  bool put_on_top(const Resting& thing) {
    std::vector<const Resting*> carriers;
    for (const Resting& other : things_) {
      if (!other.top.empty() && other.height <= 0.20) carriers.push_back(&other);
    }
    for (int i = 0; i < 20 && !carriers.empty(); ++i) {
      const Resting& below = *carriers[draw_.index(carriers.size())];
      const Vector3 middle = below.object.T_world_object.t;
      const Resting there = moved(thing, middle[0] + draw_.uniform(-0.05, 0.05), middle[1] + draw_.uniform(-0.05, 0.05),
                                  below.height, draw_.uniform(0, 2 * kHalfTurn));
      const bool carried = std::all_of(there.contacts.begin(), there.contacts.end(),
                                       [&](const Point2& p) { return within(below.top, p, 0.002); });
      if (!carried || !is_free(there, &below)) continue;
      add(there);
      return true;
    }
    return false;
  }
  bool is_on_table(const Resting& thing) const {
    return std::all_of(thing.footprint.begin(), thing.footprint.end(), [&](const Point2& p) {
      return std::abs(p[0]) < half_x_ - 0.005 && std::abs(p[1]) < half_y_ - 0.005;
    });
  }
  bool is_free(const Resting& thing, const Resting* below) const {
    return std::all_of(things_.begin(), things_.end(), [&](const Resting& other) {
      return &other == below || apart(other.footprint, thing.footprint, kGap);
    });
  }
  void add(Resting thing) {
    thing.object.material = draw_material(draw_);
    thing.object.name = thing.object.family + "_" + std::to_string(things_.size() + 1);
    things_.push_back(std::move(thing));
  }

  double half_x_, half_y_;
  Draw& draw_;
  std::vector<Resting> things_;
};

SceneObject board(const char* name, double width, double depth, double thickness, const Pose& T, Draw& draw) {
  SceneObject object;
  object.name = name;
  object.family = "board";
  object.sizes = {{"width", width}, {"depth", depth}, {"thickness", thickness}};
  object.material = {draw.uniform(0.35, 0.85), draw.uniform(0, 0.08)};
  object.T_world_object = T;
  return object;
}

/// An eye 0.5 to 1.3 m from `target`, at least `near` from everything along its line of sight.
Vector3 draw_eye(const Vector3& target, double near, const std::vector<Resting>& things, Draw& draw) {
  constexpr int kTries = 200;
  for (int i = 0;; ++i) {
    // When it gets tight, from far.
    const double distance = i < kTries ? draw.uniform(0.5, 1.3) : 1.3;
    const double down = draw.uniform(20, 65) * kHalfTurn / 180, around = draw.uniform(0, 2 * kHalfTurn);
    const Vector3 back = {std::cos(down) * std::cos(around), std::cos(down) * std::sin(around), std::sin(down)};
    const bool clear = std::all_of(things.begin(), things.end(), [&](const Resting& thing) {
      return std::all_of(thing.footprint.begin(), thing.footprint.end(), [&](const Point2& p) {
        const Vector3 top = {p[0], p[1], thing.height};
        return distance - dot(top - target, back) > near;
      });
    });
    if (clear || i > 2 * kTries) return target + distance * back;
  }
}

std::vector<std::string> family_names(FamilyHalf half, bool graspable, bool plain) {
  std::vector<std::string> names;
  for (const Family& f : families()) {
    const bool in_half = half == FamilyHalf::kBoth || f.half == half || f.half == FamilyHalf::kBoth;
    const bool wanted = (f.group == FamilyGroup::kGraspable && graspable) || (f.group == FamilyGroup::kPlain && plain);
    if (in_half && wanted) names.push_back(f.name);
  }
  return names;
}

}  // namespace

RandomSceneOptions RandomSceneOptions::of_half(FamilyHalf half) {
  RandomSceneOptions options;
  options.targets = family_names(half, true, false);
  options.clutter = family_names(half, true, true);
  return options;
}

RandomSceneOptions RandomSceneOptions::negatives(FamilyHalf half) {
  RandomSceneOptions options;
  options.targets = options.clutter = family_names(half, false, true);
  return options;
}

void RandomSceneOptions::validate() const {
  for (const auto* list : {&targets, &clutter}) {
    for (const std::string& name : *list) {
      if (family(name).group == FamilyGroup::kFurniture) {
        throw std::invalid_argument("random scene: family '" + name + "' is furniture; give things that stand on it");
      }
    }
  }
  if (clutter.empty()) throw std::invalid_argument("random scene: no families of clutter given; give at least one");
  if (min_targets < 0 || max_targets < min_targets || max_targets > 16) {
    throw std::invalid_argument("random scene: " + std::to_string(min_targets) + " to " + std::to_string(max_targets) +
                                " targets; must be 0 <= min_targets <= max_targets <= 16");
  }
  if (clutter_level && (*clutter_level < 0 || *clutter_level > 16)) {
    throw std::invalid_argument("random scene: clutter level " + std::to_string(*clutter_level) + "; must be 0 to 16");
  }
}

SceneFile random_scene(std::uint64_t seed, const RandomSceneOptions& options) {
  options.validate();
  Draw draw(seed);
  constexpr int kLevels[] = {0, 3, 8};
  const int level = options.clutter_level.value_or(kLevels[seed % 3]);
  const double width = draw.uniform(0.8, 1.5), depth = draw.uniform(0.7, 1.1), thickness = draw.uniform(0.015, 0.050);

  Table table(width, depth, draw);
  std::vector<std::string> left = options.targets;
  const std::size_t targets =
      options.targets.empty() ? 0 : options.min_targets + draw.index(options.max_targets - options.min_targets + 1);
  constexpr int kTries = 5;  // other families, where one has no room
  for (std::size_t i = 0; i < targets; ++i) {
    if (left.empty()) left = options.targets;  // each family once, as long as they last
    for (int k = 0; k < kTries; ++k) {
      const std::size_t which = draw.index(left.size());
      if (!table.put(left[which], false)) continue;
      left.erase(left.begin() + static_cast<std::ptrdiff_t>(which));
      break;
    }
  }
  Vector3 target = {0, 0, 0.05};
  for (const Resting& thing : table.things()) {
    target = target + (1.0 / static_cast<double>(table.things().size())) * thing.object.T_world_object.t;
  }
  target[2] = 0.05;
  std::vector<std::string> blocks;
  std::copy_if(options.clutter.begin(), options.clutter.end(), std::back_inserter(blocks), is_block);
  for (int i = 0; i < level; ++i) {
    // In some scenes the first thing is one that others can stand on.
    const bool block = i == 0 && !blocks.empty() && draw.chance(0.4);
    const std::vector<std::string>& from = block ? blocks : options.clutter;
    for (int k = 0; k < kTries; ++k) {
      if (table.put(from[draw.index(from.size())], draw.chance(0.4))) break;
    }
  }

  SceneFile file;
  file.name = "random_" + std::to_string(seed) + "_c" + std::to_string(level);
  file.objects.push_back(board("table", width, depth, thickness, {}, draw));
  for (const Resting& thing : table.things()) file.objects.push_back(thing.object);

  target = target + Vector3{draw.uniform(-0.03, 0.03), draw.uniform(-0.03, 0.03), draw.uniform(-0.02, 0.04)};
  file.camera = draw.chance(0.5) ? CameraOptions::kinect() : CameraOptions::xtion();
  file.camera.seed = draw.bits();
  const Vector3 eye = draw_eye(target, file.camera.min_range + 0.02, table.things(), draw);
  const double roll = draw.uniform(-6, 6) * kHalfTurn / 180;
  file.T_world_camera = look_at(eye, target) * rotation({0, 0, 1}, roll);

  if (draw.chance(0.35)) {
    file.objects.push_back(board("floor", 5, 5, 0.02, translation(0, 0, -draw.uniform(0.45, 0.75)), draw));
  }
  if (draw.chance(0.35)) {
    // Upright across the line of sight, behind the table's farthest corner.
    const double around = std::atan2(target[1] - eye[1], target[0] - eye[0]) + draw.uniform(-0.3, 0.3);
    const double away = std::hypot(width, depth) / 2 + draw.uniform(0.02, 0.40);
    file.objects.push_back(
        board("wall", 3, 4, 0.02,
              rotation({0, 0, 1}, around) * translation(away, 0, 0) * rotation({0, 1, 0}, -kHalfTurn / 2), draw));
  }
  return file;
}

}  // namespace handhold::sensor
