// From handles to grasps: candidates one by one, cheap tests first.
#include "handhold/planner.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

#include "bodies.h"
#include "hand_poses.h"
#include "path.h"
#include "robot_check.h"
#include "vec3.h"

namespace handhold::plan {
namespace {

constexpr double kPi = 3.141592653589793;
constexpr double kHandStep = 0.005;  ///< m; between two places of the hand on its straight way
constexpr double kLiftStep = 0.03;   ///< m; between two poses of the way up that inverse kinematics is asked for
constexpr double kSameWay = 0.6;     ///< rad (m); farther apart, two solutions do not belong to one motion

void require(bool holds, const char* option, const char* what) {
  if (!holds) throw std::invalid_argument(std::string(option) + ": must be " + what);
}
bool at_least(double value, double low) {
  return value >= low && std::isfinite(value);
}
bool is_within(double value, double low, double high) {
  return value >= low && value <= high;
}

double largest_difference(const JointVector& a, const JointVector& b) {
  double largest = 0;
  for (std::size_t i = 0; i < a.size(); ++i) largest = std::max(largest, std::fabs(a[i] - b[i]));
  return largest;
}

}  // namespace

std::string_view to_string(Reason reason) {
  switch (reason) {
    case Reason::kTooWide:
      return "too wide";
    case Reason::kTooThin:
      return "too thin";
    case Reason::kOutOfReach:
      return "out of reach";
    case Reason::kHandHits:
      return "hand hits";
    case Reason::kJointLimits:
      return "joint limits";
    case Reason::kArmHitsItself:
      return "arm hits itself";
    case Reason::kArmHits:
      return "arm hits";
    case Reason::kPathHits:
      return "path hits";
    case Reason::kLiftHits:
      return "lift hits";
  }
  return "";
}

void PlannerOptions::validate() const {
  require(is_within(pregrasp_distance, 1e-3, 10), "pregrasp_distance", "from 0.001 to 10 m");
  require(is_within(lift, 0, 10), "lift", "from 0 to 10 m");
  require(at_least(nearest_tolerance, 0), "nearest_tolerance", "at least 0 m");
  require(!depths.empty(), "depths", "one or more");
  for (const double depth : depths) require(is_within(depth, -1, 1), "depths", "from -1 to 1 m");
  require(!places.empty(), "places", "one or more");
  for (const double place : places) require(std::fabs(place) <= 1, "places", "from -1 to 1");
  require(at_least(angle_step, 0.01), "angle_step", "at least 0.01 rad");
  require(!tilts.empty(), "tilts", "one or more");
  for (const double tilt : tilts) require(std::fabs(tilt) <= 1, "tilts", "from -1 to 1 rad");
  require(is_within(max_angle, 0, kPi + 1e-9), "max_angle", "from 0 to pi");
  require(at_least(finger_clearance, 0), "finger_clearance", "at least 0 m");
  require(at_least(hand_clearance, 0), "hand_clearance", "at least 0 m");
  require(at_least(self_clearance, 0), "self_clearance", "at least 0 m");
  require(at_least(arm_clearance, 0), "arm_clearance", "at least 0 m");
  require(at_least(path_clearance, 0), "path_clearance", "at least 0 m");
  require(at_least(step, 1e-3), "step", "at least 0.001 rad");
  require(speed > 0 && speed <= 1, "speed", "above 0, up to 1");
  require(approach_speed > 0 && approach_speed <= 1, "approach_speed", "above 0, up to 1");
  require(at_least(acceleration_time, 0), "acceleration_time", "at least 0 s");
  require(solutions >= 1, "solutions", "at least 1");
  require(approach_pieces >= 1, "approach_pieces", "at least 1");
  require(inverse.restarts >= 0, "inverse.restarts", "at least 0");
  require(inverse.fallback_restarts >= 0, "inverse.fallback_restarts", "at least 0");
  require(inverse.candidates >= 1, "inverse.candidates", "at least 1");
  require(inverse.min_distance >= 0, "inverse.min_distance", "at least 0 rad");
}

struct GraspPlanner::Impl {
  Arm arm;
  PlannerOptions options;
  RobotCheck check, path_check;
  Obstacles obstacles;
};

namespace {

/// Looks for grasps of one handle after the other.
class Search {
 public:
  /// @param path_check  for the way to the pre-grasp
  Search(const Arm& arm, const PlannerOptions& options, const RobotCheck& check, const RobotCheck& path_check,
         const Obstacles& obstacles, Plan& plan)
      : arm_(arm), options_(options), check_(check), path_check_(path_check), obstacles_(obstacles), plan_(plan) {}

  /// Whether the handle has a grasp; it or the rejection goes into the plan.
  bool handle(const Handle& handle, std::size_t index) {
    index_ = index;
    width_ = 2 * handle.radius;
    Rejection rejection;
    rejection.handle = index;
    bool found = false;
    int furthest = -1;  // reason
    const auto take = [&](Candidate& candidate, Grasp& grasp) {
      if (!candidate.reason) candidate.what.clear();
      if (!candidate.reason && !found) plan_.grasps.push_back(std::move(grasp)), found = true;
      if (candidate.reason) {
        ++rejection.counts[static_cast<std::size_t>(*candidate.reason)];
        if (furthest < static_cast<int>(*candidate.reason)) {
          furthest = static_cast<int>(*candidate.reason);
          rejection.reason = *candidate.reason;
          rejection.what = candidate.what;
        }
      }
    };
    if (options_.all) {
      std::vector<Looked> looked = look_at_all(handle);
      for (Looked& one : looked) {
        take(one.candidate, one.grasp);
        plan_.candidates.push_back(std::move(one.candidate));
      }
    } else {
      for_each_candidate(handle, [&](const HandlePlace& place, const Approach& approach, bool flipped) {
        Looked one = look(place, approach, flipped);
        take(one.candidate, one.grasp);
        return found;
      });
    }
    if (!found) plan_.rejected.push_back(std::move(rejection));
    return found;
  }

 private:
  struct Looked {
    Candidate candidate;
    Grasp grasp;
  };
  Looked look(const HandlePlace& place, const Approach& approach, bool flipped) const {
    Looked one{{index_, place.shift, approach.angle, approach.tilt, flipped, std::nullopt, {}}, {}};
    one.candidate.reason = look_at(place, approach, flipped, one.grasp, one.candidate.what);
    return one;
  }

  /// One candidate has nothing to do with another: in parallel in the caller's arena, in their order.
  std::vector<Looked> look_at_all(const Handle& handle) const {
    struct Way {
      HandlePlace place;
      Approach approach;
      bool flipped;
    };
    std::vector<Way> ways;
    for_each_candidate(handle, [&](const HandlePlace& place, const Approach& approach, bool flipped) {
      ways.push_back({place, approach, flipped});
      return false;
    });
    std::vector<Looked> looked(ways.size());
    tbb::parallel_for(std::size_t{0}, ways.size(),
                      [&](std::size_t i) { looked[i] = look(ways[i].place, ways[i].approach, ways[i].flipped); });
    return looked;
  }

  /// Until `visit` returns true.
  template <class Visit>
  void for_each_candidate(const Handle& handle, Visit visit) const {
    const std::vector<HandlePlace> places = places_along(handle, options_.places);
    for (const double tilt : options_.tilts) {
      for (const HandlePlace& place : places) {
        for (const Approach& across :
             approaches_to(place, arm_.mount(), handle.approach, options_.angle_step, options_.max_angle)) {
          const Approach approach = tilted(across, place.axis, tilt);
          const bool first = prefers_flip(hand_pose(place, approach.direction, 0, false));
          if (visit(place, approach, first) || visit(place, approach, !first)) return;
        }
      }
    }
  }

  /// Whether the hand has to turn less, from where the arm starts, to the flipped pose.
  bool prefers_flip(const Pose& pose) const {
    const Pose start = arm_.forward(options_.start);
    // The cosine of the turn grows with the trace of R_start^T R; a flip turns the signs of x and y about.
    double trace = 0;
    for (const std::size_t i : {0, 1, 3, 4, 6, 7}) trace += pose.R[i] * start.R[i];
    return trace < 0;
  }

  std::optional<Reason> look_at(const HandlePlace& place, const Approach& approach, bool flipped, Grasp& grasp,
                                std::string& what) const {
    const Hand& hand = arm_.hand();
    if (width_ + 2 * options_.finger_clearance > hand.opening_max) return Reason::kTooWide;
    if (width_ <= hand.opening_min) return Reason::kTooThin;
    const auto may_reach = [&](double depth) {
      return arm_.may_reach(hand_pose(place, approach.direction, depth, flipped));
    };
    if (std::none_of(options_.depths.begin(), options_.depths.end(), may_reach)) return Reason::kOutOfReach;
    if (!fit_hand(place, approach, flipped, grasp, what)) return Reason::kHandHits;
    grasp.handle = index_;
    grasp.width = width_;
    grasp.approach = approach.direction;
    grasp.angle = approach.angle;
    grasp.tilt = approach.tilt;
    grasp.flipped = flipped;
    return move_arm(grasp, what);
  }

  Pose back(const Pose& grasp, double distance) const {
    Pose pose = grasp;
    for (int k = 0; k < 3; ++k) pose.t[k] -= distance * grasp.R[3 * k + 2];
    return pose;
  }

  /// The deepest pose and the widest opening for which the hand has room, at the part and on its straight way there.
  bool fit_hand(const HandlePlace& place, const Approach& approach, bool flipped, Grasp& grasp,
                std::string& what) const {
    const double widest = arm_.hand().opening_max, least = width_ + 2 * options_.finger_clearance;
    const double openings[] = {widest, (widest + least) / 2, least};
    for (const double depth : options_.depths) {
      const Pose pose = hand_pose(place, approach.direction, depth, flipped);
      for (const double opening : openings) {
        if (!has_room(pose, opening, what)) continue;
        grasp.grasp = pose;
        grasp.pregrasp = back(pose, options_.pregrasp_distance);
        grasp.lifted = pose;
        grasp.lifted.t[2] += options_.lift;
        grasp.opening = opening;
        return true;
      }
    }
    return false;
  }

  bool has_room(const Pose& grasp, double opening, std::string& what) const {
    const int steps = static_cast<int>(std::ceil(options_.pregrasp_distance / kHandStep));
    for (int i = 0; i <= steps; ++i) {
      const auto hit = check_.hand(obstacles_, back(grasp, i * options_.pregrasp_distance / steps), opening);
      if (hit) {
        what = *hit;
        return false;
      }
    }
    return true;
  }

  IkOptions ik(const JointVector& reference, int restarts) const {
    IkOptions ik = options_.inverse;
    ik.reference = reference;
    ik.restarts = restarts;
    if (restarts == 0) ik.fallback_restarts = 0;
    return ik;
  }

  /// The arm's solutions for the grasp, the one that grows from the start first: of many, most are never needed.
  std::optional<Reason> move_arm(Grasp& grasp, std::string& what) const {
    std::optional<Reason> furthest;
    const auto attempt = [&](const JointVector& q) {
      std::string hit;
      const std::optional<Reason> reason = try_solution(q, grasp, hit);
      if (!reason) return true;
      if (!furthest || *furthest < *reason) furthest = reason, what = hit;
      return false;
    };
    const int restarts = options_.inverse.restarts;
    const auto first = arm_.inverse(grasp.grasp, ik(options_.start, restarts));
    if (!first) {
      what.clear();
      return Reason::kJointLimits;
    }
    if (attempt(*first)) return std::nullopt;
    std::vector<JointVector> others;
    if (options_.solutions > 1) {
      arm_.inverse_all(grasp.grasp, static_cast<std::size_t>(options_.solutions), ik(options_.start, restarts), others);
    }
    for (const JointVector& q : others) {
      if (largest_difference(q, *first) < options_.inverse.min_distance) continue;
      if (attempt(q)) return std::nullopt;
    }
    return furthest;
  }

  /// Joint positions on a straight way of the hand, from `q` at its beginning; none when the arm cannot follow.
  std::optional<std::vector<JointVector>> follow(const JointVector& q, const std::vector<Pose>& poses) const {
    std::vector<JointVector> way = {q};
    for (const Pose& pose : poses) {
      auto next = arm_.inverse(pose, ik(way.back(), 0));
      if (!next || largest_difference(*next, way.back()) > kSameWay) return std::nullopt;
      way.push_back(std::move(*next));
    }
    return way;
  }

  std::optional<Reason> try_solution(const JointVector& q, Grasp& grasp, std::string& what) const {
    if (const auto hit = check_.posture(obstacles_, q, grasp.opening, true)) {
      what = hit->what;
      return hit->reason;
    }
    std::vector<Pose> poses;
    for (int i = 1; i <= options_.approach_pieces; ++i) {
      poses.push_back(back(grasp.grasp, options_.pregrasp_distance * i / options_.approach_pieces));
    }
    const auto backwards = follow(q, poses);
    if (!backwards) return Reason::kJointLimits;
    std::vector<JointVector> approach = {backwards->back()};
    for (std::size_t i = backwards->size() - 1; i-- > 0;) extend_straight(approach, (*backwards)[i], options_.step);
    if (const auto hit = check_.path(obstacles_, approach, grasp.opening, true)) {
      what = hit->what;
      return hit->reason;
    }
    grasp.path = straight_path(options_.start, approach.front(), options_.step);
    if (const auto hit = path_check_.path(obstacles_, grasp.path, grasp.opening, true)) {
      what = hit->what;
      return Reason::kPathHits;
    }
    if (const auto reason = raise(q, grasp, what)) return reason;
    grasp.pregrasp_index = grasp.path.size() - 1;
    grasp.times = path_times(grasp.path, arm_.joints(), options_.speed, options_.acceleration_time);
    const std::vector<double> more =
        path_times(approach, arm_.joints(), options_.approach_speed, options_.acceleration_time);
    const double begin = grasp.times.back();
    for (std::size_t i = 1; i < approach.size(); ++i) {
      grasp.path.push_back(approach[i]);
      grasp.times.push_back(begin + more[i]);
    }
    return std::nullopt;
  }

  /// The way up: the hand holds something, so only the rest of the arm is held against obstacles.
  std::optional<Reason> raise(const JointVector& q, Grasp& grasp, std::string& what) const {
    std::vector<Pose> poses;
    const int pieces = static_cast<int>(std::ceil(options_.lift / kLiftStep));
    for (int i = 1; i <= pieces; ++i) {
      Pose pose = grasp.grasp;
      pose.t[2] += options_.lift * i / pieces;
      poses.push_back(pose);
    }
    const auto way = follow(q, poses);
    if (!way) return Reason::kLiftHits;
    grasp.lift_path = {q};
    for (std::size_t i = 1; i < way->size(); ++i) extend_straight(grasp.lift_path, (*way)[i], options_.step);
    if (const auto hit = check_.path(obstacles_, grasp.lift_path, grasp.width, false)) {
      what = hit->what;
      return Reason::kLiftHits;
    }
    grasp.lift_times = path_times(grasp.lift_path, arm_.joints(), options_.approach_speed, options_.acceleration_time);
    return std::nullopt;
  }

  const Arm& arm_;
  const PlannerOptions& options_;
  const RobotCheck &check_, &path_check_;
  const Obstacles& obstacles_;
  Plan& plan_;
  std::size_t index_ = 0;
  double width_ = 0;
};

std::vector<std::size_t> in_order(const std::vector<Handle>& handles, const PlannerOptions& options,
                                  const Vector3& mount) {
  std::vector<std::pair<double, std::size_t>> keys;
  for (std::size_t i = 0; i < handles.size(); ++i) {
    const Handle& handle = handles[i];
    const double key = options.order == Order::kNearest      ? norm(handle.center - mount)
                       : options.order == Order::kConfidence ? -handle.confidence
                                                             : -handle.center[2];
    keys.emplace_back(std::isnan(key) ? std::numeric_limits<double>::infinity() : key, i);
  }
  std::sort(keys.begin(), keys.end());
  std::vector<std::size_t> indices;
  const double tolerance = options.order == Order::kNearest ? options.nearest_tolerance : 0;
  while (!keys.empty()) {
    auto next = keys.begin();
    for (auto key = next + 1; key != keys.end() && key->first <= keys.front().first + tolerance; ++key) {
      if (tolerance > 0 && handles[key->second].length > handles[next->second].length) next = key;
    }
    indices.push_back(next->second);
    keys.erase(next);
  }
  return indices;
}

PlannerOptions checked(const Arm& arm, PlannerOptions options) {
  options.validate();
  if (options.start.empty()) options.start = arm.rest();
  if (!arm.within_limits(options.start)) {
    throw std::invalid_argument("start: must have a position for each of the arm's joints, within its limits");
  }
  if (!(arm.hand().opening_max > 0)) {
    throw std::invalid_argument("the arm has no hand: its opening_max must be above 0 m");
  }
  for (const Joint& joint : arm.joints()) {
    if (joint.velocity > 0) continue;
    throw std::invalid_argument("joint '" + joint.name + "' has no velocity: its limit must be above 0");
  }
  return options;
}

}  // namespace

GraspPlanner::GraspPlanner(const Arm& arm, const PlannerOptions& options) {
  PlannerOptions ours = checked(arm, options);
  const Clearances clearances = {ours.hand_clearance, ours.self_clearance, ours.arm_clearance};
  RobotCheck check(arm, clearances);
  RobotCheck on_path =
      check.with(std::max(ours.hand_clearance, ours.path_clearance), std::max(ours.arm_clearance, ours.path_clearance));
  impl_.reset(new Impl{arm, std::move(ours), std::move(check), std::move(on_path), {}});
}
GraspPlanner::~GraspPlanner() = default;
GraspPlanner::GraspPlanner(GraspPlanner&&) noexcept = default;
GraspPlanner& GraspPlanner::operator=(GraspPlanner&&) noexcept = default;

const Arm& GraspPlanner::arm() const {
  return impl_->arm;
}
const PlannerOptions& GraspPlanner::options() const {
  return impl_->options;
}
Obstacles& GraspPlanner::obstacles() {
  return impl_->obstacles;
}
const Obstacles& GraspPlanner::obstacles() const {
  return impl_->obstacles;
}

Plan GraspPlanner::plan(const std::vector<Handle>& handles, const Pose& T_base_camera) const {
  check(T_base_camera, "T_base_camera");
  std::vector<Handle> ours;
  for (std::size_t i = 0; i < handles.size(); ++i) ours.push_back(in_base(handles[i], T_base_camera, i));
  const PlannerOptions& options = impl_->options;
  const std::size_t wanted = options.max_grasps == 0 ? handles.size() : options.max_grasps;
  Plan plan;
  Search search(impl_->arm, options, impl_->check, impl_->path_check, impl_->obstacles, plan);
  for (const std::size_t index : in_order(ours, options, impl_->arm.mount())) {
    if (plan.grasps.size() >= wanted && !options.all) break;
    search.handle(ours[index], index);
  }
  if (plan.grasps.size() > wanted) plan.grasps.resize(wanted);
  return plan;
}

std::vector<JointVector> GraspPlanner::straight(const JointVector& from, const JointVector& to) const {
  if (!impl_->arm.within_limits(from) || !impl_->arm.within_limits(to)) {
    throw std::invalid_argument("a path's ends must have a position for each joint, within its limits");
  }
  return straight_path(from, to, impl_->options.step);
}

std::vector<double> GraspPlanner::times(const std::vector<JointVector>& path, double speed) const {
  require(speed > 0 && speed <= 1, "speed", "above 0, up to 1");
  const std::size_t joints = impl_->arm.joints().size();
  for (const JointVector& q : path) {
    if (q.size() != joints) throw std::invalid_argument("a path must have a position for each joint at every sample");
  }
  return path_times(path, impl_->arm.joints(), speed, impl_->options.acceleration_time);
}

std::optional<GraspPlanner::Hit> GraspPlanner::hit(const JointVector& q, double opening, bool hand) const {
  return impl_->check.posture(impl_->obstacles, q, opening, hand);
}
std::optional<GraspPlanner::Hit> GraspPlanner::hit(const std::vector<JointVector>& path, double opening,
                                                   bool hand) const {
  return impl_->check.path(impl_->obstacles, path, opening, hand);
}

}  // namespace handhold::plan
