// Scenes that a program makes up: the same for the same seed, without overlap, with truth that makes sense.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

#include "handhold/grasp_check.h"
#include "handhold/random_scene.h"
#include "placement.h"
#include "sensor_test_helpers.h"

namespace handhold::sensor {
namespace {

using Eigen::Vector3d;

constexpr double kPi = 3.141592653589793;

bool is_furniture(const SceneObject& object) {
  return family(object.family).group == FamilyGroup::kFurniture;
}

/// Points just below the surface of an object (0.2 mm), one a triangle.
std::vector<Vector3d> inner_points(const Mesh& mesh) {
  std::vector<Vector3d> points;
  for (const auto& t : mesh.triangles) {
    const Vector3d a = eigen(mesh.vertices[t[0]]), b = eigen(mesh.vertices[t[1]]), c = eigen(mesh.vertices[t[2]]);
    points.push_back((a + b + c) / 3 - 2e-4 * (b - a).cross(c - a).normalized());
  }
  return points;
}

/// Names of two objects that overlap, or nothing.
std::string overlap(const Scene& scene) {
  std::vector<std::unique_ptr<GraspCheck>> solids;
  std::vector<Eigen::AlignedBox3d> boxes;
  std::vector<std::vector<Vector3d>> points;
  for (const Object& object : scene.objects) {
    Scene alone;
    alone.add(object);
    solids.push_back(std::make_unique<GraspCheck>(alone));
    points.push_back(inner_points(object.mesh));
    Eigen::AlignedBox3d& box = boxes.emplace_back();
    for (const Vector3& v : object.mesh.vertices) box.extend(eigen(v));
  }
  for (std::size_t i = 0; i < scene.objects.size(); ++i) {
    for (std::size_t j = 0; j < scene.objects.size(); ++j) {
      const bool walls = scene.objects[i].name == "wall" || scene.objects[j].name == "wall";
      if (i == j || walls || !boxes[i].intersects(boxes[j])) continue;  // a wall may cut the floor
      for (const Vector3d& p : points[i]) {
        if (boxes[j].contains(p) && solids[j]->inside({p[0], p[1], p[2]})) {
          return scene.objects[i].name + " is in " + scene.objects[j].name;
        }
      }
    }
  }
  return "";
}

TEST(RandomScene, IsAFunctionOfSeedAndOptions) {
  const RandomSceneOptions options = RandomSceneOptions::of_half(FamilyHalf::kTuning);
  EXPECT_EQ(to_toml(random_scene(5, options)), to_toml(random_scene(5, options)));
  EXPECT_NE(to_toml(random_scene(5, options)), to_toml(random_scene(8, options)));
  EXPECT_NE(to_toml(random_scene(5, options)), to_toml(random_scene(5 + (1ull << 40), options)));
}

TEST(RandomScene, HoldsWhatTheOptionsSay) {
  std::map<std::string, int> uses;
  std::map<int, int> levels;
  int lying = 0, all = 0, raised = 0, complete = 0;
  constexpr int kScenes = 60;
  for (int seed = 0; seed < kScenes; ++seed) {
    const FamilyHalf half = seed % 2 ? FamilyHalf::kTuning : FamilyHalf::kReport;
    const SceneFile file = random_scene(seed, RandomSceneOptions::of_half(half));
    SCOPED_TRACE(file.name);
    std::set<std::string> names;
    int things = 0;
    for (const SceneObject& object : file.objects) {
      EXPECT_TRUE(names.insert(object.name).second);
      if (is_furniture(object)) continue;
      ++things;
      ++uses[object.family];
      EXPECT_EQ(family(object.family).half, half);
      EXPECT_EQ(object.sizes.size(), family(object.family).sizes.size()) << "every size is drawn";
      ++all;
      lying += object.T_world_object.R[8] < 0.7;
      double low = 1e9;
      for (const Vector3& v : make_object(object.family, object.sizes).mesh.vertices) {
        low = std::min(low, object.T_world_object.point(v)[2]);
      }
      EXPECT_GE(low, -1e-9);
      raised += low > 0.01;
    }
    const int level = seed % 3 == 0 ? 0 : seed % 3 == 1 ? 3 : 8;
    ++levels[level];
    EXPECT_NE(file.name.find("_c" + std::to_string(level)), std::string::npos);
    // Where nothing more fits there is less clutter.
    EXPECT_GE(things, 1 + level / 2);
    complete += things >= 1 + level;
    EXPECT_LE(things, 4 + level);
    const Pose T_camera_world = file.T_world_camera.inverse();
    for (const SceneObject& object : file.objects) {
      if (is_furniture(object)) continue;
      for (const Vector3& v : make_object(object.family, object.sizes).mesh.vertices) {
        ASSERT_GT(T_camera_world.point(object.T_world_object.point(v))[2], file.camera.min_range) << object.name;
      }
    }
    const double distance = eigen(file.T_world_camera.t).norm();
    EXPECT_GT(distance, 0.3);
    EXPECT_LT(distance, 1.7);
    const double down = std::asin(-file.T_world_camera.direction({0, 0, 1})[2]) * 180 / kPi;
    EXPECT_GT(down, 19.9);
    EXPECT_LT(down, 65.1);
    EXPECT_NO_THROW(file.camera.validate());
  }
  EXPECT_GE(complete, kScenes - 3);
  EXPECT_EQ(levels[0], kScenes / 3);
  EXPECT_EQ(levels[8], kScenes / 3);
  EXPECT_GE(uses.size(), families().size() - 2) << "60 scenes show nearly every family";
  EXPECT_GT(lying, all / 5);
  EXPECT_LT(lying, 4 * all / 5);
  EXPECT_GT(raised, 3) << "some things stand on others";
}

TEST(RandomScene, NothingOverlaps) {
  for (int seed = 0; seed < 18; ++seed) {
    const SceneFile file = random_scene(seed, RandomSceneOptions::of_half(FamilyHalf::kBoth));
    EXPECT_EQ(overlap(build(file)), "") << file.name;
  }
}

TEST(RandomScene, TheCheckForOverlapSeesOne) {
  Scene scene;
  scene.add(make_object("ball"));
  scene.add(make_object("carton"), translation(0.08, 0, 0));
  scene.objects[1].name = "box";
  EXPECT_NE(overlap(scene), "");
}

TEST(RandomScene, TruthMakesSense) {
  int seen = 0, parts = 0;
  for (int seed = 30; seed < 34; ++seed) {
    const SceneFile file = random_scene(seed, RandomSceneOptions::of_half(FamilyHalf::kBoth));
    SCOPED_TRACE(file.name);
    const Scene scene = build(file);
    const Frame frame = DepthCamera(file.camera).capture(scene, file.T_world_camera);
    EXPECT_GT(measured_points(frame.cloud), 10000u);
    for (const Part& part : captured_truth(file, scene, frame)) {
      ++parts;
      EXPECT_GT(part.center[2], 0.1) << part.what << " is before the camera";
      if (part.visible == 0) {
        EXPECT_FALSE(part.measured) << part.what;
      }
      if (2 * part.radius > 0.081) {
        EXPECT_FALSE(part.graspable) << part.what;
      }
      seen += part.measured && part.graspable && part.confidence >= 0.5;
    }
  }
  EXPECT_GT(seen, 4);
  EXPECT_GT(parts, seen);
}

TEST(RandomScene, NegativesHaveNoParts) {
  const RandomSceneOptions options = RandomSceneOptions::negatives(FamilyHalf::kReport);
  for (int seed = 0; seed < 6; ++seed) {
    for (const Object& object : build(random_scene(seed, options)).objects) EXPECT_TRUE(object.parts.empty());
  }
}

TEST(RandomScene, OptionsThatCannotBeAreRefused) {
  const auto refused = [](const auto& change) {
    RandomSceneOptions options = RandomSceneOptions::of_half(FamilyHalf::kBoth);
    change(options);
    EXPECT_THROW(random_scene(1, options), std::invalid_argument);
  };
  refused([](RandomSceneOptions& o) { o.clutter.clear(); });
  refused([](RandomSceneOptions& o) { o.targets = {"nothing"}; });
  refused([](RandomSceneOptions& o) { o.clutter = {"board"}; });
  refused([](RandomSceneOptions& o) { o.min_targets = 5; });
  refused([](RandomSceneOptions& o) { o.max_targets = 17; });
  refused([](RandomSceneOptions& o) { o.clutter_level = -1; });
}

// ---- Fixed sets -----------------------------------------------------------------------------------------------------

TEST(FixedScenes, PaperScenesShowFiveNineAndTenParts) {
  const std::vector<SceneFile> files = paper_scenes();
  ASSERT_EQ(files.size(), 7u);
  const int handles[] = {5, 5, 5, 5, 5, 9, 10};
  std::set<std::string> used;
  for (std::size_t i = 0; i < files.size(); ++i) {
    SCOPED_TRACE(files[i].name);
    const Scene scene = build(files[i]);
    EXPECT_EQ(overlap(scene), "");
    const Frame frame = DepthCamera(files[i].camera).capture(scene, files[i].T_world_camera);
    int visible = 0;
    for (const Part& part : captured_truth(files[i], scene, frame)) {
      if (part.confidence < 0.5) continue;
      EXPECT_TRUE(part.graspable && part.measured) << part.what;
      EXPECT_GT(part.visible, 0.85) << part.what;
      ++visible;
    }
    EXPECT_EQ(visible, handles[i]);
    for (const SceneObject& object : files[i].objects) {
      if (!is_furniture(object)) used.insert(object.family);
    }
  }
  EXPECT_EQ(used.size(), 12u);
}

TEST(FixedScenes, SinglesShowAPartOfEachObject) {
  const std::vector<SceneFile> files = single_object_scenes();
  ASSERT_EQ(files.size(), 144u);
  std::set<std::string> names, used;
  for (std::size_t i = 0; i < files.size(); ++i) {
    names.insert(files[i].name);
    used.insert(files[i].objects.at(1).family);
    ASSERT_EQ(files[i].objects.size(), 2u);
    if (i % 3 != i / 3 % 3) continue;  // one position for each orientation is enough here
    const Scene scene = build(files[i]);
    const Frame frame = DepthCamera(files[i].camera).capture(scene, files[i].T_world_camera);
    int visible = 0;
    for (const Part& part : captured_truth(files[i], scene, frame)) {
      visible += part.graspable && part.measured && part.confidence >= 0.5;
    }
    EXPECT_GE(visible, 1) << files[i].name;
  }
  EXPECT_EQ(names.size(), 144u);
  EXPECT_EQ(used.size(), 12u);
}

// ---- Truth of a frame -----------------------------------------------------------------------------------------------

/// A rod of 12 mm radius along y on the camera's axis, 0.7 m away, with something before it.
std::vector<Part> truth_of_rod(const std::vector<Object>& others, double distance = 0.7) {
  Object rod = {"rod", cylinder(0.012, 0.2), {}};
  rod.parts.push_back({"rod", {0, 0, 0.1}, {0, 0, 1}, 0.012, 0.18, 1, {{0, 0, 0.01}, {0, 0, 0.19}}});
  Scene scene;
  scene.add(rod, translation(0, 0, distance) * rotation({1, 0, 0}, kPi / 2) * translation(0, 0, -0.1));
  for (const Object& other : others) scene.add(other);
  const CameraOptions bare;
  return captured_truth(scene, Pose{}, bare, DepthCamera(bare).capture(scene, Pose{}));
}

Object screen(double x, double y, double width, double height, double z) {
  return {"screen", transformed(box(width, height, 0.004), translation(x, y, z)), {}};
}

TEST(CapturedTruth, MeasuredNeedsTwentyMillimetresInARow) {
  EXPECT_TRUE(truth_of_rod({})[0].measured);
  EXPECT_TRUE(truth_of_rod({})[0].graspable);
  EXPECT_FALSE(truth_of_rod({screen(0, 0, 1, 1, 0.5)})[0].measured) << "hidden";
  // A slit of 40 mm at the rod's distance shows 20 mm and more; one of 8 mm touches three slices of 5 mm at most.
  const auto slit = [](double width) {
    const double w = width * 0.65 / 0.7;
    return std::vector<Object>{screen(0, 0.5 + w / 2, 1, 1, 0.65), screen(0, -0.5 - w / 2, 1, 1, 0.65)};
  };
  EXPECT_TRUE(truth_of_rod(slit(0.040))[0].measured);
  EXPECT_FALSE(truth_of_rod(slit(0.008))[0].measured);
  // Two slits of 8 mm are no 20 mm in a row.
  std::vector<Object> two = slit(0.046);
  two.push_back(screen(0, 0, 1, 0.030, 0.65));
  EXPECT_FALSE(truth_of_rod(two)[0].measured);
}

TEST(CapturedTruth, MeasuredNeedsSixtyDegreesOfArc) {
  // An edge lengthwise before the rod leaves a sliver of it.
  const auto edge = [](double shown) { return std::vector<Object>{screen(-0.5 + 0.012 - shown, 0, 1, 1, 0.684)}; };
  EXPECT_TRUE(truth_of_rod(edge(0.012))[0].measured);
  EXPECT_FALSE(truth_of_rod(edge(0.004))[0].measured);
}

TEST(CapturedTruth, MeasuredNeedsTenPointsASlice) {
  EXPECT_TRUE(truth_of_rod({}, 1.0)[0].measured);
  EXPECT_FALSE(truth_of_rod({}, 3.5)[0].measured) << "a slice of 5 mm is less than a pixel high";
}

TEST(CapturedTruth, GraspableAsksForRoomForTheFingersSomewhere) {
  const auto between = [](double from, double to) {
    std::vector<Object> jaws;
    for (const double side : {-1.0, 1.0}) {
      // Right and left, before and behind: nothing passes.
      jaws.push_back(
          {"jaw", transformed(box(0.04, to - from, 0.2), translation(side * 0.034, (from + to) / 2, 0.7)), {}});
      jaws.push_back(
          {"jaw", transformed(box(0.2, to - from, 0.04), translation(0, (from + to) / 2, 0.7 + side * 0.034)), {}});
    }
    return jaws;
  };
  EXPECT_FALSE(truth_of_rod(between(-0.1, 0.1))[0].graspable);
  EXPECT_TRUE(truth_of_rod(between(-0.1, 0.02))[0].graspable) << "not in the middle, but at an end";
}

TEST(CapturedTruth, RaisedIsFreeOfOthersAllAround) {
  const auto floor = [](double clearance) {
    return std::vector<Object>{screen(0, 0, 1, 1, 0.7 + 0.012 + clearance + 0.002)};  // behind the rod, 4 mm thick
  };
  EXPECT_TRUE(truth_of_rod({})[0].raised);
  EXPECT_TRUE(truth_of_rod(floor(0.011))[0].raised);
  EXPECT_FALSE(truth_of_rod(floor(0.007))[0].raised);
  EXPECT_FALSE(truth_of_rod(floor(0.0001))[0].raised);
  // Under less than half of it.
  EXPECT_TRUE(truth_of_rod({screen(0, 0.5 + 0.03, 1, 1, 0.7 + 0.015)})[0].raised);
}

TEST(CapturedTruth, AFrameOfAnotherSizeIsRefused) {
  const Scene scene = table_scene();
  CameraOptions small;
  small.width = 32;
  const Frame frame = DepthCamera(small).capture(scene, table_scene_camera());
  EXPECT_THROW(captured_truth(scene, table_scene_camera(), CameraOptions{}, frame), std::invalid_argument);
}

TEST(ClearTable, FiveDifferentThingsApart) {
  const std::vector<std::string> families = {"plunger", "pot",        "sponge",  "brush_1",
                                             "sprayer", "all_bottle", "dust_pan"};
  const std::vector<SceneFile> scenes = clear_table_scenes(families, 5, 4);
  ASSERT_EQ(scenes.size(), 4u);
  for (const SceneFile& file : scenes) {
    std::set<std::string> names;
    std::vector<Resting> things;
    for (const SceneObject& object : file.objects) {
      if (object.family == "board") continue;
      EXPECT_EQ(std::count(families.begin(), families.end(), object.family), 1) << object.family;
      names.insert(object.family);
      things.push_back(at_rest(object.name, object.family, object.sizes, object.T_world_object));
      // It was at rest already; only its place has to be put back.
      const Vector3& t = object.T_world_object.t;
      const Vector3& rest = things.back().object.T_world_object.t;
      things.back() = moved(things.back(), t[0] - rest[0], t[1] - rest[1], 0, 0);
    }
    EXPECT_EQ(names.size(), 5u);
    for (std::size_t i = 0; i < things.size(); ++i) {
      for (std::size_t j = 0; j < i; ++j) {
        EXPECT_TRUE(apart(things[i].footprint, things[j].footprint, 0.029)) << file.name << " " << i << " " << j;
      }
    }
  }
  EXPECT_EQ(to_toml(scenes[2]), to_toml(clear_table_scenes(families, 5, 4)[2]));
  EXPECT_NE(to_toml(scenes[0]), to_toml(clear_table_scenes(families, 6, 1)[0]));
  EXPECT_TRUE(clear_table_scenes(families, 5, 0).empty());
  EXPECT_THROW(clear_table_scenes(families, 5, -1), std::invalid_argument);
  EXPECT_THROW(clear_table_scenes({"plunger", "pot", "sponge", "brush_1"}, 1, 1), std::invalid_argument);
  EXPECT_THROW(clear_table_scenes({"plunger", "pot", "sponge", "brush_1", "pot"}, 1, 1), std::invalid_argument);
  EXPECT_THROW(clear_table_scenes({"plunger", "pot", "sponge", "brush_1", "mugg"}, 1, 1), std::invalid_argument);
}

// ---- Placement ------------------------------------------------------------------------------------------------------

TEST(Placement, ApartAndWithin) {
  const std::vector<Point2> square = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  const std::vector<Point2> diamond = {{2, 0.5}, {1.5, 1}, {1.2, 0.5}, {1.5, 0}};
  EXPECT_TRUE(apart(square, diamond, 0.15));
  EXPECT_FALSE(apart(square, diamond, 0.25));
  EXPECT_FALSE(apart(square, {{0.4, 0.4}, {0.6, 0.4}, {0.5, 0.6}}, 0)) << "one inside the other";
  EXPECT_TRUE(within(square, {0.5, 0.9}, 0.05));
  EXPECT_FALSE(within(square, {0.5, 0.97}, 0.05));
  EXPECT_FALSE(within(square, {1.5, 0.5}, 0));
}

}  // namespace
}  // namespace handhold::sensor
