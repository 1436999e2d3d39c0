// The experiments in physics, built without MuJoCo.
#include <stdexcept>

#include "experiments.h"

namespace handhold::experiments {
namespace {

Subcommand absent(CLI::App& parent, const char* name) {
  CLI::App* app = parent.add_subcommand(name, "Grasping in physics (not in this build)");
  app->allow_extras();
  app->prefix_command();
  return {app, []() -> int {
            throw std::runtime_error(
                "this build has no physics: MuJoCo, KDL or urdfdom was missing; install libmujoco-dev, "
                "liborocos-kdl-dev and liburdfdom-dev, and build again");
          }};
}

}  // namespace

Subcommand add_table1(CLI::App& parent) {
  return absent(parent, "table1");
}
Subcommand add_table2(CLI::App& parent) {
  return absent(parent, "table2");
}

}  // namespace handhold::experiments
