#include "mjcf.h"

#include <cstdio>
#include <utility>

#include "handhold/families.h"
#include "vec.h"

namespace handhold::physics {
namespace {

// Contacts as stiff as the time step allows: softer ones let go of what two fingers hold. Cones are elliptic, and
// friction is much stiffer than normal forces (impratio) and corrected for slip: what is held creeps by less than
// 0.2 mm/s, also when it is held far from its centre of mass.
constexpr const char* kContact = "solref=\"0.004 1\" solimp=\"0.95 0.99 0.001\" condim=\"4\"";
constexpr const char* kLimit = "solreflimit=\"0.004 1\" solimplimit=\"0.95 0.99 0.001\"";
constexpr double kTorsional = 0.005, kRolling = 0.0001;  // m; friction

// Which bodies may touch, as bits: a pair does when the kind of one is among those that the other takes.
constexpr int kRobot = 1, kThing = 2, kSurroundings = 4;

std::string geom_class(const std::string& name, int kind, int takes, double friction, int priority) {
  return "    <default class=\"" + name + "\"><geom contype=\"" + std::to_string(kind) + "\" conaffinity=\"" +
         std::to_string(takes) + "\" friction=\"" + text_of(Vector3{friction, kTorsional, kRolling}) +
         "\" priority=\"" + std::to_string(priority) + "\"/></default>\n";
}

/// Of two geoms in contact the friction of the one with the higher priority counts; otherwise the larger one does.
/// Tips have next to none, so that a thing's own counts there.
std::string classes_text(const WorldOptions& options) {
  return "  <default>\n    <geom " + std::string(kContact) + "/>\n    <joint " + kLimit + "/>\n" +
         geom_class("link", kRobot, 0, options.surface_friction, 1) + geom_class("tip", kRobot, 0, 0, 0) +
         geom_class("surroundings", kSurroundings, kRobot, options.surface_friction, 1) +
         geom_class("thing", kThing, kRobot | kThing | kSurroundings, 0, 0) + "  </default>\n";
}

std::string box_text(const Vector3& size, const Pose& pose) {
  return "      <geom class=\"surroundings\" type=\"box\" size=\"" + text_of(0.5 * size) + "\"" + place_text(pose) +
         "/>\n";
}

// ---- Things ---------------------------------------------------------------------------------------------------------

std::string mesh_text(const std::string& name, const sensor::Mesh& mesh) {
  std::string text = "    <mesh name=\"" + name + "\" vertex=\"";
  for (const Vector3& v : mesh.vertices) text += text_of(v) + " ";
  text += "\" face=\"";
  for (const auto& t : mesh.triangles) {
    text += std::to_string(t[0]) + " " + std::to_string(t[1]) + " " + std::to_string(t[2]) + " ";
  }
  return text + "\"/>\n";
}

struct ThingText {
  std::string meshes, body;
};

/// The mass is spread over the convex pieces by their volumes.
ThingText thing_text(std::size_t index, const Thing& thing) {
  const std::vector<sensor::Mesh> pieces = sensor::convex_pieces(thing.family, thing.sizes);
  double total = 0;
  for (const sensor::Mesh& piece : pieces) total += sensor::volume(piece);
  const std::string name = thing_name(index);
  ThingText text;
  text.body = "    <body name=\"" + name + "\"" + place_text(thing.T_world_object) + ">\n      <freejoint/>\n";
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    const std::string mesh = name + "_" + std::to_string(i);
    text.meshes += mesh_text(mesh, pieces[i]);
    text.body += "      <geom class=\"thing\" type=\"mesh\" mesh=\"" + mesh + "\" mass=\"" +
                 text_of(thing.mass * sensor::volume(pieces[i]) / total) + "\" friction=\"" +
                 text_of(Vector3{thing.friction, kTorsional, kRolling}) + "\"/>\n";
  }
  text.body += "    </body>\n";
  return text;
}

// ---- Surroundings ---------------------------------------------------------------------------------------------------

std::string table_text(const Table& table) {
  return "    <body name=\"table\"" + place_text(table.T_world_table) + ">\n" + box_text(table.size, {}) +
         "    </body>\n";
}

/// Floor and walls of a bin: edges and centre of each box (m, the bin's frame).
std::vector<std::pair<Vector3, Vector3>> bin_walls(const Bin& bin) {
  const double x = bin.inner[0], y = bin.inner[1], z = bin.inner[2], wall = bin.wall;
  const Vector3 across_x = {wall, y + 2 * wall, z}, across_y = {x, wall, z};
  return {{{x + 2 * wall, y + 2 * wall, wall}, {0, 0, -wall / 2}},
          {across_x, {-(x + wall) / 2, 0, z / 2}},
          {across_x, {(x + wall) / 2, 0, z / 2}},
          {across_y, {0, -(y + wall) / 2, z / 2}},
          {across_y, {0, (y + wall) / 2, z / 2}}};
}

std::string bin_text(const Bin& bin) {
  std::string text = "    <body name=\"bin\"" + place_text(bin.T_world_bin) + ">\n";
  for (const auto& [size, center] : bin_walls(bin)) {
    text += box_text(size, sensor::translation(center[0], center[1], center[2]));
  }
  return text + "    </body>\n";
}

std::string floor_text(double height) {
  // The size of a plane is for drawing only: it has no end.
  return "    <body name=\"floor\"" + place_text(sensor::translation(0, 0, height)) +
         "><geom class=\"surroundings\" type=\"plane\" size=\"1 1 1\"/></body>\n";
}

}  // namespace

std::string thing_name(std::size_t thing) {
  return "thing " + std::to_string(thing);
}

std::string text_of(double value) {
  char digits[32];
  std::snprintf(digits, sizeof digits, "%.17g", value);
  return digits;
}

std::string text_of(const Vector3& v) {
  return text_of(v[0]) + " " + text_of(v[1]) + " " + text_of(v[2]);
}

std::string place_text(const Pose& pose) {
  const auto& R = pose.R;
  return " pos=\"" + text_of(pose.t) + "\" xyaxes=\"" + text_of(Vector3{R[0], R[3], R[6]}) + " " +
         text_of(Vector3{R[1], R[4], R[7]}) + "\"";
}

std::string world_mjcf(const WorldOptions& options, const plan::Arm& arm, const std::vector<Thing>& things) {
  const RobotText robot = robot_text(options, arm);
  std::string meshes,
      bodies = robot.bodies + table_text(options.table) + bin_text(options.bin) + floor_text(options.floor);
  for (std::size_t i = 0; i < things.size(); ++i) {
    const ThingText thing = thing_text(i, things[i]);
    meshes += thing.meshes;
    bodies += thing.body;
  }
  return "<mujoco model=\"grasping\">\n  <compiler angle=\"radian\" autolimits=\"true\"/>\n"
         "  <size nconmax=\"1000\" njmax=\"2000\"/>\n"
         "  <option timestep=\"" +
         text_of(options.timestep) + "\" gravity=\"" + text_of(Vector3{0, 0, -options.gravity}) +
         "\" integrator=\"implicit\" jacobian=\"sparse\" cone=\"elliptic\" impratio=\"100\" noslip_iterations=\"3\">\n"
         "    <flag multiccd=\"enable\"/>\n  </option>\n" +
         classes_text(options) + "  <asset>\n" + meshes + "  </asset>\n  <worldbody>\n" + bodies +
         "  </worldbody>\n  <equality>\n" + robot.equalities + "  </equality>\n  <actuator>\n" + robot.motors +
         "  </actuator>\n</mujoco>\n";
}

}  // namespace handhold::physics
