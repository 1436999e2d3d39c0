// URDF text -> urdfdom's model, quietly.
#pragma once

#include <urdf_world/types.h>

#include <string>

namespace handhold::plan {

/// @throws std::invalid_argument with one line for text that is no valid URDF
urdf::ModelInterfaceSharedPtr parse_urdf(const std::string& text);

}  // namespace handhold::plan
