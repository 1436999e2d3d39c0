// The physics world: is it Baxter, does it obey mechanics, and does a grasp by hand-written poses work in it?
#include "handhold/physics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <set>
#include <thread>

#include "arm_helpers.h"
#include "physics_helpers.h"

namespace handhold::physics {
namespace {

constexpr double kDegree = 3.141592653589793 / 180;

double distance(const Vector3& a, const Vector3& b) {
  return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
}

double most(const JointVector& a, const JointVector& b) {
  double result = 0;
  for (std::size_t i = 0; i < a.size(); ++i) result = std::max(result, std::abs(a[i] - b[i]));
  return result;
}

/// m; of the camera's mesh, not of MuJoCo's.
double lowest_point(const World& world, std::size_t thing) {
  const sensor::Scene scene = world.scene({false, false});
  double low = HUGE_VAL;
  for (const Vector3& v : scene.objects[thing].mesh.vertices) low = std::min(low, v[2]);
  return low;
}

// ---- The robot ------------------------------------------------------------------------------------------------------

TEST(PhysicsRobot, TipIsWhereTheArmsKinematicsHaveIt) {
  std::mt19937_64 generator(5);
  for (const plan::Side side : {plan::Side::kRight, plan::Side::kLeft}) {
    for (const plan::ElectricGripper& gripper : {plan::ElectricGripper{}, plan::kExtendedNarrow}) {
      WorldOptions options;
      options.gripper = gripper;
      options.side = side;
      const plan::Arm arm = plan::Arm::baxter(side, gripper);
      options.start = plan::random_positions(arm, generator);
      const World world(options, {});
      const Pose expected = arm.forward(options.start);
      EXPECT_LT(plan::distance(world.tip(), expected), 1e-6);
      EXPECT_LT(plan::angle(world.tip(), expected), 1e-6);
      EXPECT_NEAR(world.opening(), gripper.opening_open(), 1e-6);
    }
  }
}

TEST(PhysicsRobot, FollowsAPathAndHoldsItsEnd) {
  World world({}, {});
  const plan::Arm& arm = world.arm();
  const JointVector start = arm.rest(), end = {0.4, -0.9, 0.8, 1.6, -0.7, 0.4, 1.2};
  const World::Tracking tracking = follow(world, timed(arm, {start, end}), 0.05);
  EXPECT_TRUE(tracking.finished);
  EXPECT_LT(tracking.error, 0.005);
  EXPECT_GT(most(world.joints(), start), 0.5);
  world.step(0.5);
  EXPECT_LT(most(world.joints(), end), 1e-4);
  EXPECT_LT(most(world.velocities(), JointVector(7)), 1e-3);
}

TEST(PhysicsRobot, CarriesItsOwnWeightAtAnyGravity) {
  WorldOptions options;
  options.gravity = 98.1;
  World world(options, {});
  world.step(0.5);
  EXPECT_LT(most(world.joints(), world.arm().rest()), 1e-4);
}

TEST(PhysicsRobot, FingersOpenAndCloseAtTheirSpeed) {
  WorldOptions options;
  options.gripper.slot = 2;
  World world(options, {});
  const double open = options.gripper.opening_open(), closed = options.gripper.opening_closed();
  world.command(world.arm().rest(), 0);
  world.step(0.2);
  EXPECT_NEAR(world.opening(), open - 0.2 * options.finger_speed, 0.002);
  world.step(0.8);
  EXPECT_NEAR(world.opening(), closed, 5e-4);  // end stops are stiff springs, pressed with full force
  world.command(world.arm().rest(), 0.03);
  world.step(1);
  EXPECT_NEAR(world.opening(), 0.03, 2e-4);
  EXPECT_EQ(world.finger_forces()[0], 0);
}

TEST(PhysicsRobot, StopsWhenItIsToldTo) {
  World world({}, {});
  const Way way = timed(world.arm(), {world.arm().rest(), {0.4, -0.9, 0.8, 1.6, -0.7, 0.4, 1.2}});
  const World::Tracking tracking =
      world.follow(way.path, way.times, 0.05, [&] { return world.time() < way.times.back() / 2; });
  EXPECT_FALSE(tracking.finished);
  EXPECT_NEAR(world.time(), way.times.back() / 2, 0.011);
  const JointVector here = world.joints();
  world.step(0.5);
  EXPECT_LT(most(world.joints(), here), 0.05);
  EXPECT_GT(most(world.joints(), way.path.back()), 0.3);
}

// ---- Mechanics ------------------------------------------------------------------------------------------------------

TEST(PhysicsThings, FallAsGravityHasIt) {
  World world({}, {on_table("sponge", 0.75, 0, 0, 0.5)});
  const double height = world.center_of_mass(0)[2];
  world.step(0.2);
  EXPECT_NEAR(world.speed(0), 9.81 * 0.2, 1e-6);
  EXPECT_NEAR(height - world.center_of_mass(0)[2], 9.81 * 0.2 * 0.2 / 2, 1.1e-3);  // steps of 1 ms
  EXPECT_TRUE(world.touching(0).empty());
  EXPECT_FALSE(world.at_rest(0));
}

/// A table tilted by an angle, and a sponge lying on it, its face to the table's.
World tilted(double angle, double friction) {
  WorldOptions options;
  const Pose tilt = sensor::translation(0.85, 0, 0) * sensor::rotation({1, 0, 0}, angle);
  options.table.T_world_table = tilt * sensor::translation(0, 0, -options.table.size[2] / 2);
  Thing thing = on_table("sponge", 0, 0);
  thing.friction = friction;
  thing.T_world_object = tilt * sensor::translation(0, 0, -kTableTop - 0.0019) * thing.T_world_object;
  return World(options, {thing});
}

TEST(PhysicsThings, SlideOnATableThatIsSteeperThanItsFriction) {
  // 0.5 is the tangent of 26.6 degrees; what things rub on fingers with does not matter.
  for (const double friction : {0.1, 0.9}) {
    World flat = tilted(24 * kDegree, friction), steep = tilted(29 * kDegree, friction);
    const Vector3 on_flat = flat.center_of_mass(0), on_steep = steep.center_of_mass(0);
    flat.step(0.7);
    steep.step(0.7);
    EXPECT_LT(distance(flat.center_of_mass(0), on_flat), 0.001);
    const double slope = std::sin(29 * kDegree) - 0.5 * std::cos(29 * kDegree);
    const double expected = 9.81 * slope * 0.7 * 0.7 / 2;
    EXPECT_NEAR(distance(steep.center_of_mass(0), on_steep), expected, 0.1 * expected + 0.002);
  }
}

class PhysicsSettling : public ::testing::TestWithParam<std::string> {};

TEST_P(PhysicsSettling, ComesToRestOnTheTableAndStays) {
  World world({}, {on_table(GetParam(), 0.75, -0.1, 0.3)});
  // Of which it has been at rest for 0.5 s. The lint roller is put down on an edge of MuJoCo's 32 and rocks.
  ASSERT_TRUE(world.settle(GetParam() == "lint_roller" ? 4 : 2));
  EXPECT_EQ(world.touching(0), std::vector<std::string>{"table"});
  EXPECT_LT(world.penetration(0), 5e-5);
  EXPECT_NEAR(lowest_point(world, 0), kTableTop, 2e-4);
  const Vector3 before = world.center_of_mass(0);
  for (int i = 0; i < 25; ++i) {
    world.step(0.02);
    EXPECT_TRUE(world.at_rest(0));
  }
  EXPECT_LT(distance(world.center_of_mass(0), before), 1e-4);
}

INSTANTIATE_TEST_SUITE_P(TableOne, PhysicsSettling, ::testing::ValuesIn([] {
                           std::vector<std::string> families;
                           for (const ObjectFacts& facts : paper_objects()) families.push_back(facts.family);
                           return families;
                         }()),
                         [](const auto& family) { return family.param; });

TEST(PhysicsThings, LieInTheBinOrBesideIt) {
  const WorldOptions options;
  const Vector3& bin = options.bin.T_world_bin.t;
  const double rim = bin[2] + options.bin.inner[2];
  const Thing inside = on_table("sponge", bin[0], bin[1], 0, rim - kTableTop), beside = on_table("brush_2", 0.75, 0.2);
  World world(options, {inside, beside});
  EXPECT_FALSE(world.in_bin(0));  // above it
  ASSERT_TRUE(world.settle(3));
  EXPECT_TRUE(world.in_bin(0));
  EXPECT_FALSE(world.in_bin(1));
  EXPECT_EQ(world.touching(0), std::vector<std::string>{"bin"});
}

TEST(PhysicsThings, FallToTheFloorBesideTheTable) {
  const WorldOptions options;
  World world(options, {on_table("sponge", 0.85, options.table.size[1] / 2 + 0.03)});
  ASSERT_TRUE(world.settle(6));  // it tumbles, and rocks for a while
  EXPECT_EQ(world.touching(0), std::vector<std::string>{"floor"});
  EXPECT_NEAR(lowest_point(world, 0), options.floor, 5e-4);
}

TEST(PhysicsThings, AreMovedByAnArmThatHitsThem) {
  WorldOptions options;
  const plan::Arm arm = plan::Arm::baxter(options.side, options.gripper);
  const auto start = arm.inverse(from_above(0.7, -0.45, kTableTop + 0.12));
  ASSERT_TRUE(start);
  options.start = *start;
  World world(options, {on_table("blue_bottle", 0.7, -0.25)});
  ASSERT_TRUE(world.settle(2));
  const Vector3 before = world.center_of_mass(0);
  const Way way = straight(arm, *start, from_above(0.7, -0.25, kTableTop + 0.12));
  std::set<std::pair<std::string, std::string>> contacts;
  world.follow(way.path, way.times, 0.05, [&] {
    for (const auto& contact : world.robot_contacts()) contacts.insert(contact);
    return true;
  });
  EXPECT_GT(distance(world.center_of_mass(0), before), 0.05);
  EXPECT_FALSE(contacts.empty());
  for (const auto& [link, other] : contacts) {
    EXPECT_NE(link.find("gripper"), std::string::npos) << link;
    EXPECT_EQ(other, "blue_bottle");
  }
}

// ---- Grasps ---------------------------------------------------------------------------------------------------------

/// A plunger is taken by the end of its rod, from above.
class PhysicsGrasp : public ::testing::Test {
 protected:
  static constexpr double kX = 0.7, kY = -0.25, kTop = 0.40;  // m; kTop: of the rod above the table

  static WorldOptions options() {
    WorldOptions result;
    result.gripper.slot = 2;  // 16 .. 58 mm; the rod has 23
    const plan::Arm arm = plan::Arm::baxter(result.side, result.gripper);
    result.start = arm.inverse(from_above(kX, kY, kTableTop + kTop + 0.05)).value();
    return result;
  }
  static Thing plunger(double mass, double friction) {
    Thing thing = on_table("plunger", kX, kY);
    thing.mass = mass;
    thing.friction = friction;
    return thing;
  }
  /// Descends, closes the hand and lifts it by 15 cm. Returns the largest error of the joints on the way (rad).
  static double lift(World& world) {
    const JointVector above = world.options().start;
    world.settle(2);
    const Way down = straight(world.arm(), above, from_above(kX, kY, kTableTop + kTop - 0.03));
    double error = follow(world, down, 0.05).error;
    EXPECT_TRUE(world.touching(0) == std::vector<std::string>{"table"});
    world.command(down.path.back(), 0);
    world.step(0.8);
    const Way up = straight(world.arm(), down.path.back(), from_above(kX, kY, kTableTop + kTop + 0.12));
    error = std::max(error, follow(world, up, 0).error);
    return error;
  }
};

TEST_F(PhysicsGrasp, LiftsHoldsCarriesAndDropsIntoTheBin) {
  World world(options(), {plunger(0.35, 0.9)});
  const double height = world.center_of_mass(0)[2];
  EXPECT_LT(lift(world), 0.005);
  EXPECT_TRUE(world.held(0));
  EXPECT_NEAR(world.center_of_mass(0)[2] - height, 0.15, 0.005);
  EXPECT_NEAR(world.opening(), 0.023, 5e-4);
  for (const double force : world.finger_forces()) EXPECT_NEAR(force, 20, 1);
  const Vector3 in_hand = (world.tip().inverse() * world.pose(0)).t;
  world.step(2);
  EXPECT_LT(distance((world.tip().inverse() * world.pose(0)).t, in_hand), 0.0005);

  const Vector3& bin = world.options().bin.T_world_bin.t;
  const auto over = world.arm().inverse(from_above(bin[0], bin[1], bin[2] + 0.71));
  ASSERT_TRUE(over);
  follow(world, timed(world.arm(), {world.joints(), *over}), 0);
  EXPECT_TRUE(world.held(0));
  world.command(*over, 0.05);
  world.step(0.5);
  EXPECT_TRUE(world.settle(4));
  EXPECT_FALSE(world.held(0));
  EXPECT_TRUE(world.in_bin(0));
}

TEST_F(PhysicsGrasp, HoldsAKilogramByFrictionAloneAndLetsGoWithTooLittle) {
  // Two fingers of 20 N hold 1 kg with a friction of 9.81 / 40 = 0.245 and more.
  World enough(options(), {plunger(1, 0.28)});
  lift(enough);
  EXPECT_TRUE(enough.held(0));
  const Vector3 in_hand = (enough.tip().inverse() * enough.pose(0)).t;
  const JointVector there = enough.joints();
  enough.step(2);
  EXPECT_LT(distance((enough.tip().inverse() * enough.pose(0)).t, in_hand), 0.005);
  EXPECT_LT(most(enough.joints(), there), 0.001);
  const Pose expected = from_above(kX, kY, kTableTop + kTop + 0.12);
  EXPECT_LT(plan::distance(enough.tip(), expected), 0.005);

  for (const double friction : {0.22, 0.02}) {
    World slips(options(), {plunger(1, friction)});
    lift(slips);
    EXPECT_FALSE(slips.held(0)) << friction;
    EXPECT_TRUE(slips.settle(3));
    EXPECT_EQ(slips.touching(0), std::vector<std::string>{"table"});
  }
}

TEST_F(PhysicsGrasp, HoldsAHandleThatLiesOnTheTable) {
  const Thing thing = on_table("dust_pan", kX, kY, 90 * kDegree);
  const sensor::Part handle =
      sensor::transformed(sensor::make_object(thing.family).parts.front(), thing.T_world_object);
  WorldOptions lying = options();
  lying.gripper.slot = 2;
  const double x = handle.center[0], y = handle.center[1], z = handle.center[2] - 0.012;
  const double yaw = std::atan2(handle.axis[1], handle.axis[0]);  // the fingers close across it
  const plan::Arm arm = plan::Arm::baxter(lying.side, lying.gripper);
  lying.start = arm.inverse(from_above(x, y, z + 0.1, yaw)).value();
  World world(lying, {thing});
  ASSERT_TRUE(world.settle(2));
  const Way down = straight(arm, lying.start, from_above(x, y, z, yaw));
  follow(world, down, 0.05);
  world.command(down.path.back(), 0);
  world.step(0.8);
  const double height = world.center_of_mass(0)[2];
  follow(world, straight(arm, down.path.back(), from_above(x, y, z + 0.15, yaw)), 0);
  EXPECT_TRUE(world.held(0));
  EXPECT_GT(world.center_of_mass(0)[2] - height, 0.1);
  // The pan hangs on its handle's side: friction has to keep it from turning, too.
  const Vector3 in_hand = (world.tip().inverse() * world.pose(0)).t;
  world.step(2);
  EXPECT_LT(distance((world.tip().inverse() * world.pose(0)).t, in_hand), 0.0005);
  EXPECT_EQ(world.touching(0).size(), 2u);  // two of the hand
}

TEST_F(PhysicsGrasp, SameCallsSameNumbersOnAnyThread) {
  std::vector<std::vector<Pose>> ends(2);
  std::vector<std::thread> threads;
  for (std::vector<Pose>& end : ends) {
    threads.emplace_back([&end] {
      World world(options(), {plunger(0.35, 0.9), on_table("sponge", 0.8, 0.2), on_table("brush_2", 0.6, 0.1)});
      lift(world);
      for (std::size_t i = 0; i < 3; ++i) end.push_back(world.pose(i));
      end.push_back(world.tip());
    });
  }
  for (std::thread& thread : threads) thread.join();
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(ends[0][i].t, ends[1][i].t);
    EXPECT_EQ(ends[0][i].R, ends[1][i].R);
  }
}

// ---- Seeing ---------------------------------------------------------------------------------------------------------

TEST(PhysicsScene, ShowsThingsSurroundingsAndArms) {
  World world({}, {on_table("sponge", 0.8, 0.1), on_table("brush_2", 0.6, -0.2)});
  ASSERT_TRUE(world.settle(2));
  const sensor::Scene bare = world.scene({false, false}), full = world.scene();
  ASSERT_EQ(bare.objects.size(), 2u);
  EXPECT_EQ(bare.objects[0].name, "sponge");
  EXPECT_FALSE(bare.objects[1].parts.empty());
  EXPECT_EQ(full.objects[2].name, "table");
  EXPECT_EQ(full.objects[3].name, "bin");
  EXPECT_EQ(full.objects[4].name, "floor");
  bool has_hand = false;
  for (const sensor::Object& object : full.objects) {
    EXPECT_EQ(sensor::open_edges(object.mesh), 0u) << object.name;
    EXPECT_GT(sensor::volume(object.mesh), 0) << object.name;
    has_hand |= object.name == "right_hand";
    EXPECT_NE(object.name, "torso");
  }
  EXPECT_TRUE(has_hand);

  // A camera at the chest sees each thing where it is.
  const sensor::DepthCamera camera{sensor::CameraOptions{}};
  const Pose T_world_camera = sensor::look_at({0.15, 0, 0.5}, {0.75, 0, kTableTop});
  const sensor::Frame frame = camera.capture(full, T_world_camera);
  for (std::size_t i = 0; i < 2; ++i) {
    const auto pixel = camera.project(T_world_camera.inverse().point(world.center_of_mass(i)));
    ASSERT_TRUE(pixel);
    const std::size_t u = static_cast<std::size_t>((*pixel)[0] + 0.5), v = static_cast<std::size_t>((*pixel)[1] + 0.5);
    EXPECT_EQ(frame.object[v * camera.options().width + u], static_cast<std::int32_t>(i));
  }
}

// ---- Errors ---------------------------------------------------------------------------------------------------------

TEST(PhysicsErrors, SayWhatIsWrong) {
  const auto message = [](auto change) {
    return plan::message_of([&] {
      WorldOptions options;
      std::vector<Thing> things = {on_table("sponge", 0.8, 0.1)};
      change(options, things[0]);
      World(options, things);
    });
  };
  EXPECT_MENTIONS(message([](WorldOptions& options, Thing&) { options.timestep = 0.01; }), "timestep");
  EXPECT_MENTIONS(message([](WorldOptions& options, Thing&) { options.bin.wall = 0; }), "wall");
  EXPECT_MENTIONS(message([](WorldOptions& options, Thing&) { options.gravity = NAN; }), "gravity");
  EXPECT_MENTIONS(message([](WorldOptions& options, Thing&) { options.table.T_world_table.R[0] = 2; }), "the table");
  EXPECT_MENTIONS(message([](WorldOptions& options, Thing&) { options.start = {1, 2}; }), "7 joint positions");
  EXPECT_MENTIONS(message([](WorldOptions& options, Thing&) { options.gripper.slot = 5; }), "slot");
  EXPECT_MENTIONS(message([](WorldOptions&, Thing& thing) { thing.mass = 0; }), "mass");
  EXPECT_MENTIONS(message([](WorldOptions&, Thing& thing) { thing.friction = -1; }), "friction");
  EXPECT_MENTIONS(message([](WorldOptions&, Thing& thing) { thing.family = "cloud"; }), "unknown family");
  EXPECT_MENTIONS(message([](WorldOptions&, Thing& thing) { thing.name = "bin"; }), "'bin' is taken");

  World world({}, {});
  const JointVector rest = world.arm().rest();
  EXPECT_MENTIONS(plan::message_of([&] { world.command({0}, 0); }), "command");
  EXPECT_MENTIONS(plan::message_of([&] { world.command(rest, NAN); }), "opening");
  EXPECT_MENTIONS(plan::message_of([&] { world.step(-1); }), "pass");
  EXPECT_MENTIONS(plan::message_of([&] { world.follow({}, {}, 0); }), "path");
  EXPECT_MENTIONS(plan::message_of([&] { world.follow({rest, rest}, {0, 0}, 0); }), "increase");
  EXPECT_THROW(world.pose(0), std::out_of_range);
}

TEST(PhysicsErrors, AWorldThatBreaksDownSaysSo) {
  std::vector<Thing> things;
  for (int i = 0; i < 12; ++i) {  // all at one place
    things.push_back(on_table("brush_2", 0.75, 0));
    things.back().name += std::to_string(i);
  }
  World world({}, things);
  try {
    world.step(0.001);
    ADD_FAILURE() << "more contacts than there is room for went unnoticed";
  } catch (const std::runtime_error& error) {
    EXPECT_MENTIONS(error.what(), "broke down");
  }
}

}  // namespace
}  // namespace handhold::physics
