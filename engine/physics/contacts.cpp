#include "contacts.h"

#include <cmath>
#include <utility>
#include <vector>

#include "handhold/cloud.h"
#include "vec3.h"

namespace handhold::physics {
namespace {

constexpr int kDirections = 8;     // in which the outermost contact stays
constexpr double kAligned = 0.98;  // cosine; normals of one plane

Vector3 vector_of(const mjtNum* v) {
  return {v[0], v[1], v[2]};
}

std::pair<int, int> bodies_of(const mjModel& m, const mjContact& contact) {
  return {m.geom_bodyid[contact.geom1], m.geom_bodyid[contact.geom2]};
}

bool same_plane(const mjModel& m, const mjContact& a, const mjContact& b) {
  const auto [a1, a2] = bodies_of(m, a);
  const auto [b1, b2] = bodies_of(m, b);
  const double cosine = dot(vector_of(a.frame), vector_of(b.frame));
  // Which of the two geoms comes first depends on their kinds, and with it the sign of the normal.
  return (a1 == b1 && a2 == b2 && cosine > kAligned) || (a1 == b2 && a2 == b1 && -cosine > kAligned);
}

/// Marks those contacts of a plane that stay.
void mark(const mjData& d, const std::vector<int>& plane, std::vector<char>& stays) {
  const auto best = [&](const auto& value) {
    int winner = plane.front();
    for (const int i : plane) {
      if (value(d.contact[i]) > value(d.contact[winner])) winner = i;
    }
    stays[static_cast<std::size_t>(winner)] = 1;
  };
  best([](const mjContact& contact) { return -contact.dist; });
  const Vector3 x = vector_of(d.contact[plane.front()].frame + 3), y = vector_of(d.contact[plane.front()].frame + 6);
  for (int k = 0; k < kDirections; ++k) {
    const double angle = 2 * 3.141592653589793 * k / kDirections;
    const Vector3 direction = std::cos(angle) * x + std::sin(angle) * y;
    best([&](const mjContact& contact) { return dot(direction, vector_of(contact.pos)); });
  }
}

}  // namespace

void keep_bounding_contacts(const mjModel& m, mjData& d) {
  if (d.ncon <= kDirections) return;
  std::vector<std::vector<int>> planes;
  for (int i = 0; i < d.ncon; ++i) {
    std::size_t k = 0;
    while (k < planes.size() && !same_plane(m, d.contact[planes[k].front()], d.contact[i])) ++k;
    if (k == planes.size()) planes.emplace_back();
    planes[k].push_back(i);
  }
  std::vector<char> stays(static_cast<std::size_t>(d.ncon), 0);
  for (const std::vector<int>& plane : planes) {
    if (plane.size() > kDirections) {
      mark(d, plane, stays);
    } else {
      for (const int i : plane) stays[static_cast<std::size_t>(i)] = 1;
    }
  }
  int kept = 0;
  for (int i = 0; i < d.ncon; ++i) {
    if (stays[static_cast<std::size_t>(i)]) d.contact[kept++] = d.contact[i];
  }
  d.ncon = kept;
}

}  // namespace handhold::physics
