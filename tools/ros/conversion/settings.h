// The node's parameters: the library's options by their names, and what only a node has. Knows no ROS: parameters come
// as texts by name.
#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "handhold/options.h"

namespace handhold::ros_bridge {

/// Texts by name; lists of numbers with blanks between.
using Texts = std::map<std::string, std::string>;

struct Settings {
  Options options;
  std::string config;           ///< TOML file with options; empty: none
  std::string hand;             ///< "baxter", or empty: the defaults
  std::string workspace_frame;  ///< frame of options.workspace; empty: the cloud's
  std::string viewpoint_frame;  ///< where the sensor stands; empty: in the cloud's origin; "none": no single viewpoint
  std::string fixed_frame;      ///< frame in which things stand still, for a camera that moves; empty: it does not
  std::string base_frame;       ///< the transforms' name of the arm's base; empty: the arm's own
  bool track = true;            ///< carry handles from cloud to cloud
  double transform_timeout = 0.1;  ///< s; how long a cloud waits for its transforms
  double input_timeout = 5;        ///< s; without a cloud for so long there is an error in the log
  double diagnostics_period = 1;   ///< s
  Texts arm;                       ///< those of arm_parameters() that are set
};

/// Names of the parameters that choose an arm and what is planned: "arm", "arm_file", "fingers", ...
const std::vector<std::string>& arm_parameters();

/// What an arm's hand asks of the localizer; throws std::exception, one line, for an arm that cannot be.
using ArmOptions = std::function<Options(const Texts& arm)>;

/// Settings from parameters: the defaults, or those of the hand or the arm's hand, then the file `config`, then single
/// parameters. What is wrong (an unknown name, a text that is no value, a value out of range, a GPU that is not there)
/// is described in `problems`, a line each, and stays as it is in `good`; the rest is taken.
/// @param where  what stands before a parameter's name in messages: the node's name
/// @param arm_options  null: this program cannot plan
Settings read_settings(const Texts& parameters, const Settings& good, const std::string& where,
                       const ArmOptions& arm_options, std::vector<std::string>& problems);

}  // namespace handhold::ros_bridge
