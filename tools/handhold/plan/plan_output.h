// A plan as JSON, as a table, as lines of a picture and as a part of a page.
#pragma once

#include <string>
#include <vector>

#include "handhold/planner.h"
#include "html/page.h"
#include "picture.h"

namespace handhold::planning {

/// JSON of schema "handhold.plan/1", ending in a newline: what was planned for an arm called `name`.
std::string plan_json(const plan::Arm& arm, const std::string& name, const std::vector<Handle>& handles,
                      const plan::Plan& plan, bool candidates);

/// Grasps and rejected handles in words, for a terminal.
std::string plan_table(const plan::Arm& arm, const plan::Plan& plan);

/// The hand's outline at each grasp, and the way that it comes, in the camera's frame.
std::vector<PictureLine> plan_lines(const plan::Arm& arm, const plan::Plan& plan, const plan::Pose& T_base_camera);

/// The hand at each grasp, and why other handles have none, in the camera's frame.
PagePlan page_plan(const plan::Arm& arm, const std::string& name, const plan::Plan& plan,
                   const plan::Pose& T_base_camera);

}  // namespace handhold::planning
