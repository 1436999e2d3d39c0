#include "agreement.h"

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>
#include <stdexcept>

namespace handhold::bench {
namespace {

using baseline::Outcome;
using baseline::SampleResult;

Eigen::Vector3d eigen(const Vector3& v) {
  return Eigen::Vector3d(v.data());
}

// Empty when both are the same affordance, otherwise what differs most tellingly.
std::string difference(const SampleResult& engine, const SampleResult& classic, const Tolerance& tolerance) {
  if (engine.outcome != Outcome::kAffordance)
    return "baseline only; engine says " + std::string(to_string(engine.outcome));
  if (classic.outcome == Outcome::kNoGap || classic.outcome == Outcome::kShellEmpty)
    return "engine only; the baseline's 1 mm steps met no gap (" + std::string(to_string(classic.outcome)) + ")";
  if (classic.outcome != Outcome::kAffordance)
    return "engine only; baseline says " + std::string(to_string(classic.outcome));
  const Eigen::Vector3d a = eigen(engine.affordance.axis), b = eigen(classic.affordance.axis);
  if (std::atan2(a.cross(b).norm(), std::abs(a.dot(b))) > tolerance.axis) return "axis differs";
  if ((eigen(engine.affordance.center) - eigen(classic.affordance.center)).norm() > tolerance.center)
    return "center differs";
  if (std::abs(engine.affordance.radius - classic.affordance.radius) > tolerance.radius) return "radius differs";
  return "";
}

}  // namespace

Agreement compare(const std::vector<SampleResult>& engine, const std::vector<SampleResult>& classic,
                  const Tolerance& tolerance) {
  if (engine.size() != classic.size()) throw std::invalid_argument("compare: both lists must hold the same samples");
  Agreement agreement;
  agreement.samples = engine.size();
  for (std::size_t i = 0; i < engine.size(); ++i) {
    const Outcome e = engine[i].outcome, c = classic[i].outcome;
    ++agreement.outcomes[static_cast<std::size_t>(c)][static_cast<std::size_t>(e)];
    agreement.same_outcome += e == c;
    if (e != Outcome::kAffordance && c != Outcome::kAffordance) continue;
    ++agreement.either;
    const std::string reason = difference(engine[i], classic[i], tolerance);
    if (!reason.empty()) {
      ++agreement.reasons[reason];
      continue;
    }
    ++agreement.same;
    const double later = classic[i].affordance.shell_radius - engine[i].affordance.shell_radius;
    agreement.same_shell += later > tolerance.shell - 0.001 - 1e-4 && later <= tolerance.shell;
  }
  return agreement;
}

}  // namespace handhold::bench
