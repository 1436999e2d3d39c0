// Parameters from the ROS 1 parameter server as texts.
#pragma once

#include <string>
#include <vector>

#include "settings.h"

namespace handhold::ros_bridge {

/// All parameters below `where` ("/handhold"). What is no number, text, truth value or list of numbers is described in
/// `problems` and left out.
Texts server_parameters(const std::string& where, std::vector<std::string>& problems);

}  // namespace handhold::ros_bridge
