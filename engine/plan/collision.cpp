#include "handhold/collision.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "bodies.h"
#include "cloud_filter.h"
#include "kernels.h"
#include "point_tree.h"

namespace handhold::plan {
namespace {

[[noreturn]] void fail(const std::string& message) {
  throw std::invalid_argument(message);
}

void check(const CloudView& cloud) {
  if (cloud.size() > 0 && !cloud.data) fail("cloud view: data is null, but there are points");
  if (cloud.point_step < 12 || cloud.point_step % 4 != 0) {
    fail("cloud view: point_step must be a multiple of 4 and at least 12 bytes");
  }
  if (cloud.size() >= std::size_t{1} << 31) fail("cloud view: there must be fewer than 2^31 points");
}

void check(const CloudObstacleOptions& options) {
  if (options.speck_neighbours < 0 || options.speck_neighbours > 8) fail("speck_neighbours: must be from 0 to 8");
  if (!(options.speck_distance > 0 && options.speck_distance <= kFarthest)) {
    fail("speck_distance: must be above 0 and at most 1e6 m");
  }
  if (!(options.own_margin >= 0 && options.own_margin <= kFarthest)) fail("own_margin: must be from 0 to 1e6 m");
  for (std::size_t i = 0; i < options.own.size(); ++i) check(options.own[i], "own body", std::to_string(i));
}

/// @param T_cloud_base  puts the body into the cloud's frame
kernels::BodyQuery query_of(const Core& core, const Pose& T_cloud_base, double limit) {
  const Pose T_cloud_core = T_cloud_base * core.T_base_core;
  kernels::BodyQuery query;
  for (int i = 0; i < 3; ++i) {
    query.centre[i] = static_cast<float>(T_cloud_core.t[i]);
    query.half[i] = static_cast<float>(core.half[i]);
    for (int k = 0; k < 3; ++k) query.R_body_cloud[3 * i + k] = static_cast<float>(T_cloud_core.R[3 * k + i]);
  }
  query.limit = static_cast<float>(std::min(limit + core.radius, static_cast<double>(kernels::kMostDistance)));
  return query;
}

struct Known {
  std::string name;
  Core core;
  double reach = 0;  // m
};

/// Whether they may be nearer than `limit` (m): the ball about each of them against the other one.
bool may_be_near(const Core& core, double reach_of_core, const Known& known, double limit) {
  return distance(known.core, core.T_base_core.t) - reach_of_core < limit &&
         distance(core, known.core.T_base_core.t) - known.reach < limit;
}

}  // namespace

struct Obstacles::Impl {
  PointTree tree;
  CloudFilter filter;
  std::vector<Core> own;
  Pose T_base_cloud, T_cloud_base;
  std::vector<Known> known;
};

Obstacles::Obstacles() : impl_(std::make_unique<Impl>()) {}
Obstacles::~Obstacles() = default;
Obstacles::Obstacles(Obstacles&&) noexcept = default;
Obstacles& Obstacles::operator=(Obstacles&&) noexcept = default;

// ---- What is there --------------------------------------------------------------------------------------------------

void Obstacles::set_cloud(const CloudView& cloud, const Pose& T_base_cloud, const CloudObstacleOptions& options) {
  check(cloud);
  check(T_base_cloud, "T_base_cloud");
  check(options);
  Impl& my = *impl_;
  my.T_base_cloud = T_base_cloud;
  my.T_cloud_base = T_base_cloud.inverse();
  my.own.clear();
  for (const Body& body : options.own) {
    my.own.push_back(core_of(body));
    my.own.back().T_base_core = my.T_cloud_base * body.T_base_body;
  }
  my.tree.build(my.filter.run(cloud, my.own, options));
}

std::size_t Obstacles::points() const {
  return impl_->tree.points();
}

void Obstacles::add(const std::string& name, const Body& body) {
  check(body, "body", name);
  const Core core = core_of(body);
  impl_->known.push_back({name, core, reach(core)});
}

void Obstacles::clear_bodies() {
  impl_->known.clear();
}

const std::string& Obstacles::name(std::size_t body) const {
  if (body >= impl_->known.size()) fail("name: there is no body " + std::to_string(body));
  return impl_->known[body].name;
}

// ---- Queries --------------------------------------------------------------------------------------------------------

Obstacles::Nearest Obstacles::nearest(const Body& body, double limit) const {
  check(body, "nearest: body");
  if (std::isnan(limit)) fail("nearest: the limit is not a number");
  const Impl& my = *impl_;
  const Core core = core_of(body);
  const double reach_of_core = reach(core);
  Nearest nearest;
  nearest.distance = limit;
  for (std::size_t i = 0; i < my.known.size(); ++i) {
    if (!may_be_near(core, reach_of_core, my.known[i], nearest.distance)) continue;
    const double d = distance(core, my.known[i].core);
    if (d < nearest.distance) nearest.distance = d, nearest.body = i;
  }
  const kernels::BodyQuery query = query_of(core, my.T_cloud_base, nearest.distance);
  const std::int64_t found = kernels::kernels().nearest_to_body(my.tree.view(), query);
  if (found < 0) return nearest;
  const Vector3 point = my.T_base_cloud.point(my.tree.point(found));
  const double d = distance(core, point);
  if (d < nearest.distance) nearest = {d, true, point, 0};
  return nearest;
}

bool Obstacles::within(const Body& body, double margin) const {
  check(body, "within: body");
  if (std::isnan(margin)) fail("within: the margin is not a number");
  const Impl& my = *impl_;
  const Core core = core_of(body);
  const double reach_of_core = reach(core);
  for (const Known& known : my.known) {
    // Touching counts, whatever the margin.
    if (!may_be_near(core, reach_of_core, known, std::max(margin, 1e-9))) continue;
    const double d = distance(core, known.core);
    if (d <= 0 || d < margin) return true;
  }
  return kernels::kernels().any_point_within(my.tree.view(), query_of(core, my.T_cloud_base, margin));
}

}  // namespace handhold::plan
