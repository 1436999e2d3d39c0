// handhold plan: from a cloud to grasps of an arm.
#include <memory>
#include <stdexcept>
#include <string>

#include "arm_arguments.h"
#include "atomic_file.h"
#include "backend.h"
#include "cloud_input.h"
#include "command_line.h"
#include "handhold/localizer.h"
#include "html/page.h"
#include "kernels.h"
#include "option_arguments.h"
#include "picture.h"
#include "plan_output.h"
#include "progress.h"
#include "subcommand.h"
#include "threads.h"
#include "usage_error.h"
#include "why_failed.h"

namespace handhold {
namespace {

struct Arguments {
  CloudArguments input;
  planning::ArmArguments arm;
  OptionArguments options;
  std::string json, picture, html;
};

int run(const Arguments& a) {
  const planning::ChosenArm chosen = planning::chosen_arm(a.arm);
  const Options options = effective_options(a.options, chosen.options);
  const CloudInput input(a.input, "plan");
  const plan::Pose T_base_camera = planning::camera_pose(a.arm);
  plan::GraspPlanner planner(chosen.arm, planning::planner_options(a.arm, chosen.arm));
  planning::add_known(a.arm, planner.obstacles());
  if (const char* problem = kernels::isa_error()) throw UsageError(problem);
  check_result_paths({a.json, a.picture, a.html}, input.path());
  const auto more_threads = allow_threads(options.threads);
  Localizer localizer = make_localizer(a.options, options);
  note_backend(localizer);

  Cloud cloud;
  Result result;
  plan::Plan plan;
  Page page;
  {
    Progress progress;
    progress.show("reading " + input.path());
    cloud = input.read();
    progress.show("searching");
    localizer.localize(cloud.view(), result);
    const std::string failure = why_failed(input.path(), cloud.view(), options, result);
    if (!failure.empty()) throw std::runtime_error(failure);
    if (!a.html.empty()) page.samples = localizer.samples();
    progress.show("planning");
    // The arm stands where the camera may see it.
    plan::CloudObstacleOptions seen;
    seen.own = plan::bodies_of(chosen.arm, planner.options().start);
    with_threads(options.threads, [&] {
      planner.obstacles().set_cloud(cloud.view(), T_base_camera, seen);
      plan = planner.plan(result.handles, T_base_camera);
    });
  }

  const std::string table = planning::plan_table(chosen.arm, plan);
  if (!a.json.empty()) {
    const std::string json = planning::plan_json(chosen.arm, chosen.name, result.handles, plan, a.arm.all);
    if (a.json == "-") {
      write_and_flush(stdout, json, "standard output");
    } else {
      write_file(a.json, json);
    }
  }
  if (!a.picture.empty()) {
    PictureOptions picture;
    picture.affordances = false;
    picture.lines = planning::plan_lines(chosen.arm, plan, T_base_camera);
    write_picture(a.picture, cloud.view(), cloud.rgb, result, picture);
  }
  if (!a.html.empty()) {
    page.name = input.name();
    page.cloud = &cloud;
    page.options = &options;
    page.backend = localizer.backend();
    page.result = &result;
    page.plan = planning::page_plan(chosen.arm, chosen.name, plan, T_base_camera);
    write_page(a.html, page);
  }
  if (a.json.empty()) write_and_flush(stdout, table, "standard output");
  return 0;
}

}  // namespace

Subcommand add_plan(CLI::App& parent) {
  CLI::App* app = parent.add_subcommand("plan", "Plan grasps of a robot's arm for the handles in a point cloud");
  app->allow_extras();
  auto a = std::make_shared<Arguments>();
  const char* input = "Input";
  add_cloud_flags(*app, a->input, input);
  add_preset_flags(*app, a->options, input);
  planning::add_arm_flags(*app, a->arm);
  const char* output = "Output";
  add_text_flag(*app, "--json", a->json, "F", "Write the grasps as JSON; '-' is standard output", output);
  add_text_flag(*app, "--picture", a->picture, "F.png",
                "Write a picture of the cloud, its handles and the hand at each grasp", output);
  add_text_flag(*app, "--html", a->html, "F.html",
                "Write a page that shows them in three dimensions; it opens in a browser, without a network", output);
  add_option_flags(*app, a->options.texts);
  return {app, [a] { return run(*a); }};
}

}  // namespace handhold
