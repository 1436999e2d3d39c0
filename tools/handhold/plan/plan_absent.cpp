// handhold plan, built without KDL or urdfdom.
#include <stdexcept>

#include "subcommand.h"

namespace handhold {

Subcommand add_plan(CLI::App& parent) {
  CLI::App* app = parent.add_subcommand("plan", "Plan grasps of a robot's arm (not in this build)");
  app->allow_extras();
  app->prefix_command();
  return {app, []() -> int {
            throw std::runtime_error(
                "this build has no planner: KDL or urdfdom was missing; install liborocos-kdl-dev and liburdfdom-dev, "
                "and build again");
          }};
}

}  // namespace handhold
