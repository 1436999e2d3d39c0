// What there is to find in a scene, as the camera sees it.
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "handhold/sensor.h"
#include "ray_caster.h"
#include "vec.h"

namespace handhold::sensor {
namespace {

/// Distance to a polyline, or infinity for a point beyond its ends: a part's surface ends where its centre line does.
double distance_to_centre_line(const Vector3& p, const std::vector<Vector3>& line) {
  double best = HUGE_VAL;
  for (std::size_t i = 0; i + 1 < line.size(); ++i) {
    const Vector3 d = line[i + 1] - line[i];
    const double s = dot(p - line[i], d) / dot(d, d);
    const bool before = s < 0 && i == 0, beyond = s > 1 && i + 2 == line.size();
    if (before || beyond) continue;
    best = std::min(best, norm(p - line[i] - std::clamp(s, 0.0, 1.0) * d));
  }
  return best;
}

struct Box {
  Vector3 low, high;
  /// Whether the box about a triangle has no point in common with this one.
  bool misses(const Vector3& a, const Vector3& b, const Vector3& c) const {
    for (int k = 0; k < 3; ++k) {
      if (std::min({a[k], b[k], c[k]}) > high[k] || std::max({a[k], b[k], c[k]}) < low[k]) return true;
    }
    return false;
  }
};

/// What lies within `reach` of a polyline lies in this box.
Box box_about(const std::vector<Vector3>& line, double reach) {
  Box box = {line[0], line[0]};
  for (const Vector3& p : line) {
    for (int k = 0; k < 3; ++k) {
      box.low[k] = std::min(box.low[k], p[k] - reach);
      box.high[k] = std::max(box.high[k], p[k] + reach);
    }
  }
  return box;
}

/// Calls visit(point, normal, area) for pieces of a triangle no longer than `step`, at least for those in the box.
template <class Visitor>
void split(const Vector3& a, const Vector3& b, const Vector3& c, double step, const Box& box, const Visitor& visit) {
  if (box.misses(a, b, c)) return;
  const double ab = norm(b - a), bc = norm(c - b), ca = norm(a - c);
  const double longest = std::max({ab, bc, ca});
  if (longest <= step) {
    const Vector3 n = cross(b - a, c - a);
    if (norm(n) > 0) visit((1.0 / 3) * (a + b + c), unit(n), norm(n) / 2);
    return;
  }
  if (longest == ab) {
    const Vector3 m = 0.5 * (a + b);
    split(m, b, c, step, box, visit);
    split(a, m, c, step, box, visit);
  } else if (longest == bc) {
    const Vector3 m = 0.5 * (b + c);
    split(a, m, c, step, box, visit);
    split(a, b, m, step, box, visit);
  } else {
    const Vector3 m = 0.5 * (c + a);
    split(a, b, m, step, box, visit);
    split(m, b, c, step, box, visit);
  }
}

/// Share of a part's camera-facing surface that the camera sees.
double visible_share(const Object& object, const Part& part, const RayCaster& caster, const DepthCamera& camera,
                     const Pose& T_world_camera) {
  const Pose T_camera_world = T_world_camera.inverse();
  const CameraOptions& options = camera.options();
  const double step = std::clamp(part.radius / 4, 0.001, 0.005);
  // Sections that are not round reach beyond the mean of their half sizes.
  const double reach = 1.3 * part.radius + 0.001;
  const Box box = box_about(part.centre_line, reach);
  double facing = 0, seen = 0;
  for (const auto& t : object.mesh.triangles) {
    const Vector3 &a = object.mesh.vertices[t[0]], &b = object.mesh.vertices[t[1]], &c = object.mesh.vertices[t[2]];
    split(a, b, c, step, box, [&](const Vector3& p, const Vector3& n, double area) {
      const Vector3 to_camera = T_world_camera.t - p;
      if (dot(n, to_camera) <= 0 || distance_to_centre_line(p, part.centre_line) > reach) return;
      facing += area;
      const Vector3 q = T_camera_world.point(p);
      const std::optional<Point2> pixel = camera.project(q);
      const bool in_view = pixel && (*pixel)[0] >= 0 && (*pixel)[0] <= options.width - 1.0 && (*pixel)[1] >= 0 &&
                           (*pixel)[1] <= options.height - 1.0 && q[2] >= options.min_range &&
                           q[2] <= options.max_range;
      // Off the surface by more than what single precision loses.
      if (in_view && !caster.blocked(p + 1e-5 * n, T_world_camera.t)) seen += area;
    });
  }
  return facing > 0 ? seen / facing : 0;
}

std::string quoted(const std::string& text) {
  std::string result = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') result += '\\';
    if (static_cast<unsigned char>(c) < 0x20) {
      char escape[8];
      std::snprintf(escape, sizeof escape, "\\u%04x", static_cast<unsigned>(c));
      result += escape;
    } else {
      result += c;
    }
  }
  return result + "\"";
}

std::string number(double value) {
  const long long micro = std::llround(value * 1e6);  // integers do not depend on the locale's decimal point
  const unsigned long long magnitude = micro < 0 ? 0ull - static_cast<unsigned long long>(micro) : micro;
  std::string fraction = std::to_string(magnitude % 1000000);
  fraction.insert(0, 6 - fraction.size(), '0');
  while (!fraction.empty() && fraction.back() == '0') fraction.pop_back();
  return (micro < 0 ? "-" : "") + std::to_string(magnitude / 1000000) + (fraction.empty() ? "" : "." + fraction);
}

std::string list(const Vector3& v) {
  return "[" + number(v[0]) + ", " + number(v[1]) + ", " + number(v[2]) + "]";
}

}  // namespace

std::vector<Part> DepthCamera::truth(const Scene& scene, const Pose& T_world_camera) const {
  const RayCaster caster(scene);
  const Pose T_camera_world = T_world_camera.inverse();
  std::vector<Part> parts;
  for (const Object& object : scene.objects) {
    for (const Part& part : object.parts) {
      parts.push_back(transformed(part, T_camera_world));
      parts.back().visible = visible_share(object, part, caster, *this, T_world_camera);
    }
  }
  return parts;
}

std::string truth_json(const std::vector<std::pair<std::string, std::vector<Part>>>& scenes) {
  std::string text = "{";
  for (std::size_t s = 0; s < scenes.size(); ++s) {
    text += (s == 0 ? "\n  " : ",\n  ") + quoted(scenes[s].first) + ": [";
    const std::vector<Part>& parts = scenes[s].second;
    for (std::size_t i = 0; i < parts.size(); ++i) {
      const Part& part = parts[i];
      text += (i == 0 ? "\n    {" : ",\n    {");
      if (!part.family.empty()) text += "\"family\": " + quoted(part.family) + ", ";
      text +=
          "\"what\": " + quoted(part.what) + ", \"center\": " + list(part.center) + ", \"axis\": " + list(part.axis);
      text += ",\n     \"radius\": " + number(part.radius) + ", \"length\": " + number(part.length);
      text += ", \"confidence\": " + number(part.confidence) + ",\n     \"centre_line\": [";
      for (std::size_t k = 0; k < part.centre_line.size(); ++k) text += (k ? ", " : "") + list(part.centre_line[k]);
      text += "],\n     \"visible\": " + number(part.visible);
      text += std::string(", \"measured\": ") + (part.measured ? "true" : "false");
      text += std::string(", \"raised\": ") + (part.raised ? "true" : "false");
      text += std::string(", \"graspable\": ") + (part.graspable ? "true" : "false") + "}";
    }
    text += parts.empty() ? "]" : "\n  ]";
  }
  return text + "\n}\n";
}

}  // namespace handhold::sensor
