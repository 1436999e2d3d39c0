#include <stdexcept>

#include "planning.h"

namespace handhold::ros_bridge {

ArmOptions planning_arm_options() {
  return nullptr;
}

void plan_grasps(const SearchedFrame&, const Settings&, const Lookup&, const handhold_ros::PlanGrasps::Request&,
                 handhold_ros::PlanGrasps::Response&) {
  throw std::invalid_argument("this node was built without handhold::plan; it needs liborocos-kdl-dev liburdfdom-dev");
}

}  // namespace handhold::ros_bridge
