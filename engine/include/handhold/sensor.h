// A simulated depth camera: objects made by code, a pinhole camera that casts a ray through every pixel, a model of
// what a structured-light sensor does to depth, and the truth about the parts that a hand can hold.
//
//   sensor::Scene scene = sensor::table_scene();
//   sensor::DepthCamera camera(sensor::CameraOptions::kinect());
//   Cloud cloud = camera.capture(scene, T_world_camera).cloud;
//   std::vector<sensor::Part> truth = camera.truth(scene, T_world_camera);
//
// Metres and radians. Functions that take sizes throw std::invalid_argument for one that cannot be.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "handhold/cloud.h"

namespace handhold::sensor {

// ---- Rigid motions --------------------------------------------------------------------------------------------------

/// A rigid motion p -> R p + t. `T_a_b` takes points of frame b to frame a.
struct Pose {
  std::array<double, 9> R = {1, 0, 0, 0, 1, 0, 0, 0, 1};  ///< row-major rotation
  Vector3 t = {0, 0, 0};                                  ///< m

  Vector3 point(const Vector3& p) const;
  Vector3 direction(const Vector3& d) const;
  Pose inverse() const;
  Pose operator*(const Pose& other) const;
};
Pose translation(double x, double y, double z);
/// Rotation by `angle` (rad, right-handed) about an axis through the origin; the axis need not be a unit vector.
Pose rotation(const Vector3& axis, double angle);
/// Optical frame (x right, y down, z forward) of a camera at `eye` that looks at `target`; `up` shows upwards in the
/// image. Returns T_world_camera. @throws std::invalid_argument when the view direction is zero or parallel to `up`
Pose look_at(const Vector3& eye, const Vector3& target, const Vector3& up = {0, 0, 1});

// ---- Meshes ---------------------------------------------------------------------------------------------------------

/// Triangles over shared vertices. The makers below return closed surfaces: every edge belongs to two triangles, which
/// run through it in opposite directions, and normals (right-hand rule) point out of the solid.
struct Mesh {
  std::vector<Vector3> vertices;                        ///< m
  std::vector<std::array<std::uint32_t, 3>> triangles;  ///< indices into vertices
};

/// A point (x, y) of a profile or cross-section (m).
using Point2 = std::array<double, 2>;

/// Box centred on the origin with edges of these lengths.
Mesh box(double x, double y, double z);
/// Truncated cone about z with caps, from z = 0 (radius `bottom`) to `height` (radius `top`); a radius may be zero.
Mesh frustum(double bottom, double top, double height, int segments = 128);
/// Cylinder about z with caps, from z = 0 to `height`.
Mesh cylinder(double radius, double height, int segments = 128);
/// Ring about z in the plane z = 0.
Mesh torus(double major_radius, double minor_radius, int segments = 128, int section_segments = 64);
/// Surface of revolution about z of a closed profile of points (distance to z, z), counter-clockwise in that plane (the
/// last point joins the first). Points on the axis make poles.
Mesh revolve(const std::vector<Point2>& profile, int segments = 128);
/// Tube with flat ends along a path of at least two points in a plane whose normal is `binormal`. `section` is a closed
/// convex polygon, counter-clockwise; its x runs along (binormal x tangent), its y along `binormal`.
Mesh tube(const std::vector<Vector3>& path, const Vector3& binormal, const std::vector<Point2>& section);
/// Rectangle with rounded corners, counter-clockwise, for `tube`; corner = both half sizes makes a circle.
std::vector<Point2> rounded_rectangle(double half_x, double half_y, double corner, int corner_segments = 8);

Mesh transformed(const Mesh& mesh, const Pose& T);
/// The triangles of both. Solids may overlap; each stays closed.
Mesh merged(const Mesh& a, const Mesh& b);

/// Volume (m^3) that a closed mesh encloses; negative when it is inside out. Overlaps count twice.
double volume(const Mesh& mesh);
/// Number of directed edges without exactly one opposite; 0 for a watertight mesh.
std::size_t open_edges(const Mesh& mesh);

// ---- Objects and scenes ---------------------------------------------------------------------------------------------

/// A part that a hand could hold: what the localizer ought to find. The fields are those of truth files.
struct Part {
  std::string what;
  Vector3 center;                    ///< m; middle of the centre line
  Vector3 axis;                      ///< unit, tangent of the centre line there; largest component positive
  double radius = 0;                 ///< m; of a section that is not round: half of its larger side
  double length = 0;                 ///< m; along the centre line
  double confidence = 1;             ///< 0..1; below 0.5: right if it is found, but not asked for
  std::vector<Vector3> centre_line;  ///< m; at least two points
  double visible = 1;     ///< 0..1; share of the camera-facing surface that the camera sees; 1 before truth is taken
  bool graspable = true;  ///< an 0.08 m hand with 0.01 m fingers can envelop it where it stands
  /// At least 20 mm of the centre line are *visible* in a frame: every 5 mm slice there has 10 measured points that
  /// span 60 degrees of arc. True before a frame is taken.
  bool measured = true;
  /// At half or more of its centre line, a ring as thick as a finger (10 mm) about it is free of other objects; false:
  /// it lies on something or leans against it. True before a frame is taken.
  bool raised = true;
  std::string family = {};  ///< of its object; empty: none
};
Part transformed(const Part& part, const Pose& T);

/// What a surface does to the projector's light.
struct Material {
  double reflectance = 0.6;  ///< 0..1; share of the light that it scatters, at the projector's wavelength
  double specular = 0;       ///< 0..1; how mirror-like: 0 scatters evenly, 1 is polished
};

struct Object {
  std::string name;
  Mesh mesh;
  std::vector<Part> parts;
  Material material = {};
};
Object transformed(const Object& object, const Pose& T);

/// Objects in one common frame, in which +z is up.
struct Scene {
  std::vector<Object> objects;
  void add(const Object& object, const Pose& T_world_object = {}) {
    objects.push_back(transformed(object, T_world_object));
  }
};

/// Things that stand on z = 0 about the origin. The mug's handle points to +x; the mallet's shaft runs along +x, its
/// head stands at the origin and a block props up the shaft's far end, so that the shaft is free of the table.
Object mug();
Object mallet();
Object bottle();
Object bowl();
Object carton();
/// A board whose top is z = 0.
Object table(double x, double y);

/// The scene of data/table_scene.pcd: mug, mallet, bottle, bowl and carton on a table.
Scene table_scene();
/// Where the camera of data/table_scene.pcd stands.
Pose table_scene_camera();

// ---- Camera ---------------------------------------------------------------------------------------------------------

/// What the sensor does to depth z. Each effect stands alone, and the default changes nothing. In this order:
///   1. lateral noise: a pixel looks a little beside its ray, so that outlines and the borders of shadows jitter;
///   2. shadows: what the projector does not reach is not measured;
///   3. drop-outs: at grazing incidence, in highlights, on dark surfaces, beside depth edges;
///   4. mixed pixels beside depth edges;
///   5. axial noise, then quantization.
/// Points stay on the ray of their pixel. The incidence theta is the angle between a surface's normal and the way to
/// the camera.
struct NoiseOptions {
  /// Standard deviation along the optical axis, before quantization (Nguyen, Izadi, Lovell: "Modeling Kinect sensor
  /// noise for improved 3D reconstruction and tracking", 3DIMPVT 2012):
  /// axial_sigma + axial_growth * max(0, z - axial_from)^2 + axial_slant / sqrt(z) * theta^2 / (pi/2 - theta)^2.
  double axial_sigma = 0;   ///< m, >= 0
  double axial_growth = 0;  ///< 1/m, >= 0
  double axial_from = 0.4;  ///< m, >= 0
  double axial_slant = 0;   ///< m^(3/2), >= 0
  /// Standard deviation across the optical axis, in each direction of the image (same paper):
  /// lateral_sigma + lateral_slant * theta / (pi/2 - theta). It moves outlines and leaves depth within a surface alone:
  /// there, the axial noise as published has it already.
  double lateral_sigma = 0;  ///< px, >= 0
  double lateral_slant = 0;  ///< px, >= 0
  /// A sensor that matches windows of its image errs alike at neighbouring pixels: axial noise, lateral noise and
  /// drop-outs of pixels (du, dv) apart correlate by exp(-(du/correlation_u)^2 - (dv/correlation_v)^2), less where
  /// these are below 2 px. What happens at a single pixel is as likely as without. 0: independent along that direction.
  double correlation_u = 0;  ///< px, 0 .. 16; along rows
  double correlation_v = 0;  ///< px, 0 .. 16; along columns
  /// Triangulation measures disparity = disparity_focal * baseline / z in steps; 0 turns it off.
  double disparity_step = 0;     ///< px, >= 0
  double disparity_focal = 575;  ///< px, > 0
  /// The projector stands this far from the camera along the image's +x, so that shadows fall to the left of things.
  double baseline = 0.075;  ///< m, > 0
  bool shadows = false;     ///< whether only what the projector reaches is measured
  /// A surface with an incidence below dropout_from is always measured, beyond dropout_to never; the probability is
  /// linear in between.
  double dropout_from = 1.5707963267948966;  ///< rad, 0 .. pi/2
  double dropout_to = 1.5707963267948966;    ///< rad, dropout_from .. pi/2
  /// The mirror image of the projector blinds the camera: where the normal and the bisector of the ways to camera and
  /// projector are an angle a apart, a surface is lost with probability specular * exp(-(a / glare_width)^2).
  double glare_width = 0;  ///< rad, 0 .. pi/2; 0: no glare
  /// Light that comes back: reflectance * (1 - specular) * cos(theta) / distance^2. A surface with signal_full or more
  /// is always measured, below signal_none never; the probability is linear in between.
  double signal_full = 0;  ///< 1/m^2, >= signal_none; 0: darkness does not matter
  double signal_none = 0;  ///< 1/m^2, >= 0
  /// Neighbouring pixels (of four) have a depth edge between them when no plane through either explains the other's
  /// depth to within edge_step. Of the pixels beside an edge, a share edge_dropout gives nothing, and a share mixed
  /// gives a depth anywhere between its own surface and the one across the edge if that was measurable.
  double edge_step = 0.01;  ///< m, > 0; lateral noise takes the same edges
  double edge_dropout = 0;  ///< 0 .. 1
  double mixed = 0;         ///< 0 .. 1 - edge_dropout

  /// Axial standard deviation (m) at depth z (m) and incidence (rad; beyond 85 degrees as at 85).
  double sigma(double z, double incidence = 0) const;
  /// Lateral standard deviation (px) at this incidence (rad; beyond 85 degrees as at 85).
  double lateral(double incidence) const;
  /// z after disparity quantization (m).
  double quantized(double z) const;
  /// Probability that a surface at this angle of incidence (rad) gives no measurement.
  double dropout(double incidence) const;
  /// Probability that a highlight takes the measurement; `angle` (rad) as in glare_width.
  double glare(double specular, double angle) const;
  /// Probability that too little light (1/m^2) comes back.
  double darkness(double signal) const;
};

struct CameraOptions {
  // Pinhole: a point (x, y, z) of the optical frame falls on pixel (fx x/z + cx, fy y/z + cy); the first pixel's centre
  // is (0, 0).
  std::uint32_t width = 640;      ///< px, 1 .. 16384
  std::uint32_t height = 480;     ///< px, 1 .. 16384
  double fx = 575, fy = 575;      ///< px, > 0
  double cx = 319.5, cy = 239.5;  ///< px
  double min_range = 0.3;         ///< m, > 0; smallest depth z that is measured
  double max_range = 5.0;         ///< m, > min_range
  NoiseOptions noise;
  std::uint64_t seed = 1;  ///< of noise and drop-outs: the same seed gives the same bytes

  /// @throws std::invalid_argument naming the first option that is out of range, its value and what would be valid
  void validate() const;

  /// Structured light as in the first Kinect, every effect on: axial and lateral noise as Nguyen et al. published
  /// them, disparity in eighths of a pixel (Khoshelham, Elberink: "Accuracy and resolution of Kinect depth data",
  /// Sensors 12, 2012). Correlation and the shares at edges were measured on frames of such a sensor.
  static CameraOptions kinect();
  /// Asus Xtion Pro: the same principle with its own lens and range.
  static CameraOptions xtion();
};

/// The camera of data/table_scene.pcd: quantization, independent axial noise and drop-outs at grazing incidence only.
CameraOptions table_scene_camera_options();

/// What one shot gives.
struct Frame {
  Cloud cloud;  ///< organized, in the camera's optical frame, viewpoint 0 0 0; NaN where nothing was measured
  std::vector<std::int32_t> object;  ///< width * height; index into Scene::objects of the surface measured, -1 for none
};

/// Holds its options only; capture and truth may run at the same time on several threads. Work runs in the caller's TBB
/// arena; the result does not depend on the number of threads.
class DepthCamera {
 public:
  /// @throws std::invalid_argument for an option that is out of range
  explicit DepthCamera(const CameraOptions& options = {});

  /// One frame. A surface seen from behind (the camera is inside a solid) is not measured.
  /// @throws std::invalid_argument for a mesh with an index that is out of range or a vertex that is not finite, and
  /// for a material outside 0 .. 1
  Frame capture(const Scene& scene, const Pose& T_world_camera) const;

  /// The scene's parts in the camera's optical frame, with Part::visible filled in.
  std::vector<Part> truth(const Scene& scene, const Pose& T_world_camera) const;

  /// Direction of a pixel's ray with z = 1 (optical frame), so that depth times it is the point.
  Vector3 ray(double u, double v) const;
  /// Pixel coordinates (u, v) of a point in front of the camera (optical frame, m); none for z <= 0.
  std::optional<Point2> project(const Vector3& p) const;

  const CameraOptions& options() const { return options_; }

 private:
  CameraOptions options_;
};

/// Truth file: one JSON object, scene name -> list of parts. Lengths are rounded to 1e-6 m.
std::string truth_json(const std::vector<std::pair<std::string, std::vector<Part>>>& scenes);

}  // namespace handhold::sensor
