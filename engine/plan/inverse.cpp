// Inverse kinematics: Levenberg-Marquardt from many seeds, then KDL's Newton-Raphson.
#include <algorithm>
#include <cmath>
#include <kdl/chain.hpp>
#include <kdl/chainfksolverpos_recursive.hpp>
#include <kdl/chainiksolverpos_nr_jl.hpp>
#include <kdl/chainiksolvervel_pinv.hpp>
#include <kdl/jntarray.hpp>
#include <stdexcept>

#include "marquardt.h"
#include "model.h"
#include "random.h"

namespace handhold::plan {
namespace {

constexpr double kPositionTolerance = 1e-5;  // m
constexpr double kRotationTolerance = 1e-4;  // rad
constexpr int kIterations = 30;  // of one try: those that need more are rarer than other seeds that need fewer
constexpr double kTurn = 6.283185307179586;

KDL::Chain chain_of(const ArmModel& model) {
  KDL::Chain chain;
  for (const Mount& mount : model.mounts) {
    const KDL::Frame& T = mount.T_parent_zero;
    const auto type = mount.motion == Mount::Motion::kTurn ? KDL::Joint::RotAxis : KDL::Joint::TransAxis;
    const KDL::Joint joint =
        mount.motion == Mount::Motion::kNone ? KDL::Joint(KDL::Joint::Fixed) : KDL::Joint(T.p, T.M * mount.axis, type);
    chain.addSegment(KDL::Segment(joint, T));
  }
  return chain;
}

/// The solvers for one pose. They keep state while they iterate, so every call has its own.
class Solver {
 public:
  Solver(const ArmModel& model, const Pose& T_base_tip, const JointVector& reference)
      : joints_(model.joints),
        reference_(reference),
        goal_(to_kdl(T_base_tip)),
        lower_(static_cast<unsigned>(joints_.size())),
        upper_(lower_),
        start_(lower_),
        end_(lower_),
        chain_(chain_of(model)),
        forward_(chain_),
        marquardt_(model, goal_) {
    for (unsigned i = 0; i < joints_.size(); ++i) {
      lower_(i) = joints_[i].lower;
      upper_(i) = joints_[i].upper;
    }
  }

  std::optional<JointVector> marquardt(JointVector seed) {
    if (!marquardt_.run(seed, kIterations)) return std::nullopt;
    for (unsigned i = 0; i < seed.size(); ++i) end_(i) = seed[i];
    return checked();
  }

  /// Slower; now and then it ends where the other one does not.
  std::optional<JointVector> newton(const JointVector& seed) {
    if (!newton_) {
      velocity_.emplace(chain_);
      newton_.emplace(chain_, lower_, upper_, forward_, *velocity_, kIterations, 1e-6);
    }
    set_start(seed);
    newton_->CartToJnt(start_, goal_, end_);
    return checked();
  }

 private:
  void set_start(const JointVector& seed) {
    for (unsigned i = 0; i < seed.size(); ++i) start_(i) = seed[i];
  }

  /// The same angle, whole turns off: of those within the limits, the nearest to the reference.
  static double unwound(double angle, const Joint& joint, double reference) {
    angle -= kTurn * std::round((angle - reference) / kTurn);
    if (angle > joint.upper) return angle - kTurn * std::ceil((angle - joint.upper) / kTurn);
    if (angle < joint.lower) return angle + kTurn * std::ceil((joint.lower - angle) / kTurn);
    return angle;
  }

  /// The solver's last positions, unwound, when they are within the limits and right.
  std::optional<JointVector> checked() {
    JointVector q(joints_.size());
    for (unsigned i = 0; i < q.size(); ++i) {
      const Joint& joint = joints_[i];
      q[i] = joint.prismatic ? end_(i) : unwound(end_(i), joint, reference_[i]);
      if (!(q[i] >= joint.lower && q[i] <= joint.upper)) return std::nullopt;
      end_(i) = q[i];
    }
    KDL::Frame reached;
    forward_.JntToCart(end_, reached);
    const KDL::Twist error = KDL::diff(reached, goal_);
    if (!(error.vel.Norm() <= kPositionTolerance && error.rot.Norm() <= kRotationTolerance)) return std::nullopt;
    return q;
  }

  const std::vector<Joint>& joints_;
  const JointVector& reference_;
  const KDL::Frame goal_;
  KDL::JntArray lower_, upper_, start_, end_;
  const KDL::Chain chain_;
  KDL::ChainFkSolverPos_recursive forward_;
  Marquardt marquardt_;
  std::optional<KDL::ChainIkSolverVel_pinv> velocity_;
  std::optional<KDL::ChainIkSolverPos_NR_JL> newton_;
};

/// Seed 0 is the reference; the later ones lie anywhere within the limits.
JointVector seed_of(const ArmModel& model, const JointVector& reference, std::uint64_t seed, int index) {
  if (index == 0) return reference;
  constexpr std::uint64_t kStream = 0x1f;
  CounterRandom random(seed, kStream, static_cast<std::uint64_t>(index));
  JointVector q;
  for (const Joint& joint : model.joints) q.push_back(joint.lower + random.uniform() * (joint.upper - joint.lower));
  return q;
}

double distance(const JointVector& a, const JointVector& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
  return std::sqrt(sum);
}
double largest_difference(const JointVector& a, const JointVector& b) {
  double largest = 0;
  for (std::size_t i = 0; i < a.size(); ++i) largest = std::max(largest, std::fabs(a[i] - b[i]));
  return largest;
}

void check_pose(const Pose& pose) {
  constexpr double kSlack = 1e-6;
  const KDL::Frame frame = to_kdl(pose);
  const KDL::Vector x = frame.M.UnitX(), y = frame.M.UnitY(), z = frame.M.UnitZ();
  const bool is_rotation = (x * y - z).Norm() < kSlack && std::fabs(x.Norm() - 1) < kSlack &&
                           std::fabs(y.Norm() - 1) < kSlack && std::fabs(KDL::dot(x, y)) < kSlack;
  if (!is_rotation || !std::isfinite(frame.p.Norm())) {
    throw std::invalid_argument("the pose is none: R must be a rotation and t finite");
  }
}

/// The reference, after checking all options.
JointVector checked_reference(const Arm& arm, const IkOptions& options) {
  if (options.restarts < 0) throw std::invalid_argument("restarts: must be at least 0");
  if (options.fallback_restarts < 0) throw std::invalid_argument("fallback_restarts: must be at least 0");
  if (options.candidates < 1) throw std::invalid_argument("candidates: must be at least 1");
  if (!(options.min_distance >= 0)) throw std::invalid_argument("min_distance: must be at least 0");
  if (options.reference.empty()) return arm.rest();
  if (!arm.within_limits(options.reference)) {
    throw std::invalid_argument("reference: must have a position for each joint, within its limits");
  }
  return options.reference;
}

/// Hands solutions and the index of their seed to `take`, until it returns true or the seeds are used up. The fallback
/// is for poses that have no solution without it.
template <class Take>
void for_each_solution(const ArmModel& model, const Pose& T_base_tip, const JointVector& reference,
                       const IkOptions& options, Take take) {
  Solver solver(model, T_base_tip, reference);
  bool found = false;
  for (int i = 0; i <= options.restarts; ++i) {
    const auto q = solver.marquardt(seed_of(model, reference, options.seed, i));
    if (q && take(*q, i)) return;
    found = found || q;
  }
  for (int i = 0; i <= options.fallback_restarts && !found; ++i) {
    const auto q = solver.newton(seed_of(model, reference, options.seed, i));
    if (q && take(*q, i)) return;
  }
}

}  // namespace

std::optional<JointVector> Arm::inverse(const Pose& T_base_tip, const IkOptions& options) const {
  check_pose(T_base_tip);
  const JointVector reference = checked_reference(*this, options);
  if (!may_reach(T_base_tip)) return std::nullopt;
  std::optional<JointVector> nearest;
  int found = 0;
  for_each_solution(*model_, T_base_tip, reference, options, [&](const JointVector& q, int seed) {
    if (!nearest || distance(q, reference) < distance(*nearest, reference)) nearest = q;
    return seed == 0 || ++found == options.candidates;
  });
  return nearest;
}

std::size_t Arm::inverse_all(const Pose& T_base_tip, std::size_t count, const IkOptions& options,
                             std::vector<JointVector>& solutions) const {
  check_pose(T_base_tip);
  const JointVector reference = checked_reference(*this, options);
  if (count == 0 || !may_reach(T_base_tip)) return 0;
  std::vector<JointVector> found;
  for_each_solution(*model_, T_base_tip, reference, options, [&](const JointVector& q, int) {
    const auto is_near = [&](const JointVector& other) { return largest_difference(q, other) < options.min_distance; };
    if (std::none_of(found.begin(), found.end(), is_near)) found.push_back(q);
    return found.size() == count;
  });
  std::stable_sort(found.begin(), found.end(), [&](const JointVector& a, const JointVector& b) {
    return distance(a, reference) < distance(b, reference);
  });
  solutions.insert(solutions.end(), found.begin(), found.end());
  return found.size();
}

}  // namespace handhold::plan
