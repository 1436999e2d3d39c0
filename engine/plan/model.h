// An arm's bodies and joints, as KDL computes with them.
#pragma once

#include <kdl/frames.hpp>
#include <string>
#include <vector>

#include "handhold/arm.h"

namespace handhold::plan {

KDL::Frame to_kdl(const Pose& pose);
Pose from_kdl(const KDL::Frame& frame);

/// How a link is joined to its parent. KDL's own joints keep their last pose in mutable members, so that not even const
/// ones may be shared by threads: every solver has its own copy of the chain, and all else goes through here.
struct Mount {
  enum class Motion { kNone, kTurn, kSlide };
  Motion motion = Motion::kNone;
  KDL::Frame T_parent_zero;  ///< the link's place at position 0
  KDL::Vector axis;          ///< unit; link frame

  /// T_parent_link. @param position  rad, m
  KDL::Frame at(double position) const {
    switch (motion) {
      case Motion::kNone:
        break;
      case Motion::kTurn:
        return T_parent_zero * KDL::Frame(KDL::Rotation::Rot2(axis, position));
      case Motion::kSlide:
        return T_parent_zero * KDL::Frame(position * axis);
    }
    return T_parent_zero;
  }
};

/// What moves a link against its parent.
struct Drive {
  enum class By {
    kNothing,  ///< position `offset`
    kArm,      ///< factor * position of the arm's joint `joint` + offset
    kHand,     ///< factor * the hand's share open (0..1) + offset
  };
  By by = By::kNothing;
  std::size_t joint = 0;
  double factor = 0;
  double offset = 0;  ///< rad, m
};

struct Link {
  std::string name;
  std::size_t parent = 0;  ///< of the root: itself
  Mount mount;
  Drive drive;
};

struct ArmModel {
  std::string base, tip;
  Hand hand;
  JointVector rest;
  std::vector<Joint> joints;
  std::vector<Mount> mounts;             ///< base to tip
  std::vector<std::string> link_names;   ///< of `links`
  std::vector<Link> links;               ///< each after its parent
  std::vector<std::size_t> link_joints;  ///< of `links`: how many of the arm's joints move it
  std::size_t base_link = 0;
  std::vector<Shape> shapes;
  std::vector<std::size_t> links_with_meshes;

  std::vector<double> sweeps;  ///< m; of `joints`
  Vector3 mount = {0, 0, 0};   ///< m; base frame: the link that the first joint hangs on

  // What may_reach() needs.
  KDL::Vector shoulder;    ///< m; base frame: the first joint
  KDL::Vector last_joint;  ///< m; tip's frame: the origin of the last joint
  double reach = 0;        ///< m; between the two at most
};

}  // namespace handhold::plan
