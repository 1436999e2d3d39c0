// Levenberg-Marquardt iterations of inverse kinematics, within joint limits.
#pragma once

#include <Eigen/Dense>
#include <vector>

#include "model.h"

namespace handhold::plan {

/// Steps from joint positions towards a pose of the tip. Every step minimizes the error of the tip's pose, linearized,
/// plus a damping that grows with the error (T. Sugihara, "Solvability-unconcerned inverse kinematics by the
/// Levenberg-Marquardt method", IEEE T-RO 27, 2011); joints at a limit that would go beyond it are held for that step.
class Marquardt {
 public:
  Marquardt(const ArmModel& model, const KDL::Frame& goal);

  /// Whether the tip's pose was met, to 1e-6 m and 1e-5 rad, within `iterations` steps from `q` (within the limits).
  /// Gives up where steps no longer help. `q` is where it ended.
  bool run(JointVector& q, int iterations);

 private:
  using Vector6 = Eigen::Matrix<double, 6, 1>;
  using Jacobian = Eigen::Matrix<double, 6, Eigen::Dynamic>;

  struct Piece {
    Mount::Motion motion = Mount::Motion::kNone;
    Eigen::Matrix3d R;        ///< of T_parent_zero
    Eigen::Vector3d p, axis;  ///< m; unit
  };

  /// Error of the tip's pose at `q`, and its derivative by the joints with the sign of a motion towards the goal.
  void look_at(const Eigen::VectorXd& q, Vector6& error, Jacobian& jacobian) const;
  Eigen::VectorXd step_from(const Eigen::VectorXd& q, const Vector6& error, const Jacobian& jacobian,
                            double damping) const;

  std::vector<Piece> pieces_;  ///< base to tip
  Eigen::VectorXd lower_, upper_;
  Eigen::Matrix3d goal_R_;
  Eigen::Vector3d goal_p_;
};

}  // namespace handhold::plan
