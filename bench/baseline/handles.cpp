// Handles: every pair of affordances is compared.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "baseline/stages.h"

namespace handhold::baseline {
namespace {

Eigen::Vector3d eigen(const Vector3& v) {
  return {v[0], v[1], v[2]};
}
Vector3 array(const Eigen::Vector3d& v) {
  return {v[0], v[1], v[2]};
}

bool aligned(const Affordance& a, const Affordance& b, const Options& options, double max_sin) {
  if (std::abs(a.radius - b.radius) > options.align_radius) return false;
  const Eigen::Vector3d axis_a = eigen(a.axis), axis_b = eigen(b.axis), offset = eigen(b.center) - eigen(a.center);
  if (axis_a.cross(axis_b).squaredNorm() > max_sin * max_sin) return false;
  const double across2 = std::max(axis_a.cross(offset).squaredNorm(), axis_b.cross(offset).squaredNorm());
  return across2 <= options.align_offset * options.align_offset;
}

struct Member {
  double along;  // m; from the first affordance
  std::uint32_t sample;
};

// The stretch of `members` about `along` = 0 in which no gap is longer than `max_gap`; sorts them.
std::pair<std::size_t, std::size_t> contiguous_run(std::vector<Member>& members, double max_gap) {
  std::sort(members.begin(), members.end(), [](const Member& a, const Member& b) {
    return a.along != b.along ? a.along < b.along : a.sample < b.sample;
  });
  const auto zero = std::lower_bound(members.begin(), members.end(), 0.0,
                                     [](const Member& member, double value) { return member.along < value; });
  std::size_t begin = static_cast<std::size_t>(zero - members.begin()), end = begin + 1;
  while (begin > 0 && members[begin].along - members[begin - 1].along <= max_gap) --begin;
  while (end < members.size() && members[end].along - members[end - 1].along <= max_gap) ++end;
  return {begin, end};
}

}  // namespace

std::vector<Handle> find_handles(const std::vector<SampleResult>& samples, const Options& options) {
  std::vector<std::uint32_t> candidates;
  for (std::size_t i = 0; i < samples.size(); ++i)
    if (samples[i].outcome == Outcome::kAffordance) candidates.push_back(static_cast<std::uint32_t>(i));

  const double max_sin = options.align_angle < M_PI / 2 ? std::sin(options.align_angle) : 1.0;
  std::vector<Handle> handles;
  std::vector<char> used(samples.size(), 0);
  std::vector<Member> members;
  for (const std::uint32_t i : candidates) {
    if (used[i]) continue;
    const Affordance& seed = samples[i].affordance;
    members.clear();
    for (const std::uint32_t j : candidates)
      if (!used[j] && aligned(seed, samples[j].affordance, options, max_sin))
        members.push_back({eigen(seed.axis).dot(eigen(samples[j].affordance.center) - eigen(seed.center)), j});
    const auto [begin, end] = contiguous_run(members, options.handle_gap);
    const double length = members[end - 1].along - members[begin].along;
    if (static_cast<int>(end - begin) < options.handle_min_affordances || length < options.handle_min_length) continue;

    Handle handle{};
    const double middle = 0.5 * (members[begin].along + members[end - 1].along);
    handle.center = array(eigen(seed.center) + middle * eigen(seed.axis));
    handle.axis = seed.axis;
    handle.approach = array(-eigen(seed.normal));
    handle.length = length;
    for (std::size_t k = begin; k < end; ++k) {
      handle.radius += samples[members[k].sample].affordance.radius / static_cast<double>(end - begin);
      handle.affordances.push_back(members[k].sample);
      used[members[k].sample] = 1;
    }
    std::sort(handle.affordances.begin(), handle.affordances.end());
    handles.push_back(std::move(handle));
  }
  return handles;
}

}  // namespace handhold::baseline
