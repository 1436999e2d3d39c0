// The camera of depth images as a command line gives it.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "handhold/io.h"

namespace handhold {

/// What the user gave; empty: not given.
struct CameraArguments {
  std::string fx, fy, cx, cy, depth_unit;

  bool any() const { return !(fx.empty() && fy.empty() && cx.empty() && cy.empty() && depth_unit.empty()); }
};

struct DepthCamera {
  Intrinsics intrinsics;
  double depth_unit_m = 0;
};

/// Adds --fx, --fy, --cx, --cy and --depth-unit-m; what the user gives ends in `a`, which must outlive the parsing.
void add_camera_flags(CLI::App& app, CameraArguments& a, const std::string& group);

/// All five are needed. `who` needs them ("--depth"). @throws UsageError that names the flag, and what would be right
DepthCamera depth_camera(const CameraArguments& a, const std::string& who);

/// None of the five makes sense without `what` ("--depth"). @throws UsageError that names one that was given
void refuse_camera(const CameraArguments& a, const std::string& what);

}  // namespace handhold
