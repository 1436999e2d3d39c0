#include "marquardt.h"

#include <algorithm>

namespace handhold::plan {
namespace {

constexpr double kRadian = 0.1;  ///< m; what an error of a radian weighs
constexpr double kMet = 1e-12;   ///< m^2; squared error at which the pose is met: 1e-6 m, 1e-5 rad
constexpr double kLeastDamping = 1e-9;

Eigen::Vector3d eigen(const KDL::Vector& v) {
  return {v.x(), v.y(), v.z()};
}
Eigen::Matrix3d eigen(const KDL::Rotation& R) {
  return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(R.data);
}

}  // namespace

Marquardt::Marquardt(const ArmModel& model, const KDL::Frame& goal)
    : lower_(model.joints.size()), upper_(model.joints.size()), goal_R_(eigen(goal.M)), goal_p_(eigen(goal.p)) {
  for (std::size_t i = 0; i < model.joints.size(); ++i) {
    lower_[static_cast<Eigen::Index>(i)] = model.joints[i].lower;
    upper_[static_cast<Eigen::Index>(i)] = model.joints[i].upper;
  }
  for (const Mount& mount : model.mounts) {
    pieces_.push_back({mount.motion, eigen(mount.T_parent_zero.M), eigen(mount.T_parent_zero.p), eigen(mount.axis)});
  }
}

void Marquardt::look_at(const Eigen::VectorXd& q, Vector6& error, Jacobian& jacobian) const {
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  Eigen::Vector3d p = Eigen::Vector3d::Zero();
  Eigen::Index joint = 0;
  for (const Piece& piece : pieces_) {
    p += R * piece.p;
    R = R * piece.R;
    if (piece.motion == Mount::Motion::kNone) continue;
    const Eigen::Vector3d axis = R * piece.axis;
    // Until the tip is known, the joint's own place stands for its arm.
    jacobian.col(joint) << (piece.motion == Mount::Motion::kTurn ? p : axis), axis;
    if (piece.motion == Mount::Motion::kTurn) {
      R = R * Eigen::AngleAxisd(q[joint], piece.axis).toRotationMatrix();
    } else {
      p += q[joint] * axis;
    }
    ++joint;
  }
  joint = 0;
  for (const Piece& piece : pieces_) {
    if (piece.motion == Mount::Motion::kNone) continue;
    auto column = jacobian.col(joint++);
    if (piece.motion == Mount::Motion::kTurn) {
      const Eigen::Vector3d axis = column.tail<3>(), arm = p - column.head<3>();
      column << axis.cross(arm), kRadian * axis;
    } else {
      column.tail<3>().setZero();
    }
  }
  const Eigen::AngleAxisd turn(Eigen::Matrix3d(goal_R_ * R.transpose()));
  error << goal_p_ - p, kRadian * turn.angle() * turn.axis();
}

Eigen::VectorXd Marquardt::step_from(const Eigen::VectorXd& q, const Vector6& error, const Jacobian& jacobian,
                                     double damping) const {
  Jacobian free = jacobian;
  Eigen::VectorXd step;
  for (Eigen::Index pass = 0; pass <= q.size(); ++pass) {
    Eigen::Matrix<double, 6, 6> normal = free * free.transpose();
    normal.diagonal().array() += damping;
    step = free.transpose() * normal.llt().solve(error);
    bool held = false;
    for (Eigen::Index j = 0; j < q.size(); ++j) {
      const bool outwards = (step[j] < 0 && q[j] <= lower_[j]) || (step[j] > 0 && q[j] >= upper_[j]);
      if (outwards) free.col(j).setZero(), held = true;
    }
    if (!held) break;
  }
  return step;
}

bool Marquardt::run(JointVector& joints, int iterations) {
  Eigen::VectorXd q = Eigen::Map<const Eigen::VectorXd>(joints.data(), static_cast<Eigen::Index>(joints.size()));
  Vector6 error, next_error;
  Jacobian jacobian(6, q.size()), next_jacobian(6, q.size());
  look_at(q, error, jacobian);
  double squares = error.squaredNorm(), factor = 1;
  for (int i = 0; i < iterations && squares > kMet; ++i) {
    const Eigen::VectorXd next =
        (q + step_from(q, error, jacobian, factor * squares + kLeastDamping)).cwiseMax(lower_).cwiseMin(upper_);
    look_at(next, next_error, next_jacobian);
    const double next_squares = next_error.squaredNorm();
    if (next_squares < squares) {
      const bool helps = next_squares < 0.98 * squares;
      q = next, error = next_error, jacobian.swap(next_jacobian), squares = next_squares;
      factor = std::max(factor / 4, 1e-3);
      if (!helps) break;
    } else {
      factor *= 8;
      if (factor > 1e4) break;
    }
  }
  std::copy_n(q.data(), q.size(), joints.begin());
  return squares <= kMet;
}

}  // namespace handhold::plan
