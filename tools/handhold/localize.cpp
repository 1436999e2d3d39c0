// handhold localize: reads a cloud, finds handles, writes them.
#include <algorithm>
#include <cstdio>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "atomic_file.h"
#include "backend.h"
#include "cloud_input.h"
#include "command_line.h"
#include "handhold/config.h"
#include "handhold/localizer.h"
#include "html/page.h"
#include "kernels.h"
#include "option_arguments.h"
#include "picture.h"
#include "progress.h"
#include "report.h"
#include "result_json.h"
#include "run_times.h"
#include "subcommand.h"
#include "threads.h"
#include "usage_error.h"
#include "why_failed.h"

namespace handhold {
namespace {

struct Arguments {
  OptionArguments options;
  CloudArguments input;
  std::string json, picture, html;
  std::string repeat;
  bool explain = false, print_options = false, no_times = false, show_samples = false;
};

void add_flags(CLI::App& app, Arguments& a) {
  const auto text = [&app](const char* flag, std::string& target, const char* value, const char* help,
                           const char* group) { add_text_flag(app, flag, target, value, help, group); };
  const auto flag = [&app](const char* name, bool& target, const char* help, const char* group) {
    app.add_flag(name, target, help)->disable_flag_override()->group(group);
  };
  const char* input = "Input";
  add_cloud_flags(app, a.input, input);
  add_preset_flags(app, a.options, input);

  const char* output = "Output";
  text("--json", a.json, "F", "Write the result as JSON; '-' is standard output", output);
  text("--picture", a.picture, "F.png", "Write a picture of the cloud and its handles", output);
  text("--html", a.html, "F.html",
       "Write a page that shows cloud, handles, affordances and samples in three dimensions; it opens in a browser, "
       "without a network",
       output);
  flag("--show-samples", a.show_samples, "Draw every sample into --picture, coloured by the step at which it ended",
       output);
  flag("--explain", a.explain, "Say which step ended how many samples, and what would change that", output);
  flag("--print-options", a.print_options, "Print the options in effect as TOML for --config, and exit", output);
  text("--repeat", a.repeat, "N", "Run N times after a warm-up: times are medians and 99th percentiles", output);
  flag("--no-times", a.no_times, "Leave out what differs from run to run: times, number of threads", output);
  add_option_flags(app, a.options.texts);
}

int parse_repeat(const std::string& text) {
  return text.empty() ? 0 : static_cast<int>(whole_number("--repeat", text, 1, 1'000'000));
}

/// One run, or a warm-up and `repeat` runs.
std::vector<StageTimes> run_repeatedly(Localizer& localizer, const CloudView& cloud, int repeat, Result& result,
                                       Progress& progress) {
  progress.show("searching");
  localizer.localize(cloud, result);
  const bool searched = result.status == Status::kOk || result.status == Status::kDeadline;
  if (repeat == 0 || !searched) return {result.times_ms};
  std::vector<StageTimes> times;
  for (int i = 0; i < repeat; ++i) {
    progress.show("run " + std::to_string(i + 1) + " of " + std::to_string(repeat));
    localizer.localize(cloud, result);
    times.push_back(result.times_ms);
  }
  return times;
}

int run(const Arguments& a) {
  const Options options = effective_options(a.options);
  const int repeat = parse_repeat(a.repeat);
  if (a.print_options) {
    write_and_flush(stdout, to_toml(options), "standard output");
    return 0;
  }
  const CloudInput input(a.input, "localize");
  if (const char* problem = kernels::isa_error()) throw UsageError(problem);
  if (a.show_samples && a.picture.empty()) throw UsageError("--show-samples needs --picture, which shows them");
  check_result_paths({a.json, a.picture, a.html}, input.path());
  const auto more_threads = allow_threads(options.threads);
  Localizer localizer = make_localizer(a.options, options);
  note_backend(localizer);

  Result result;
  RunTimes run_times;
  PictureOptions picture;
  Page page;
  Cloud cloud;
  {
    Progress progress;
    progress.show("reading " + input.path());
    cloud = input.read();
    run_times = summarize(run_repeatedly(localizer, cloud.view(), repeat, result, progress));
    if (a.show_samples) picture.samples = localizer.samples();
    if (!a.html.empty()) page.samples = localizer.samples();
  }
  const RunTimes* times = a.no_times ? nullptr : &run_times;
  const std::string failure = why_failed(input.path(), cloud.view(), options, result);

  // A program that reads the JSON of a frame that failed learns the status from it.
  if (!a.json.empty()) {
    const std::string json = to_json(cloud.view(), options, localizer.backend(), result, times);
    if (a.json == "-") {
      write_and_flush(stdout, json, "standard output");
    } else {
      write_file(a.json, json);
    }
  }
  if (!failure.empty()) throw std::runtime_error(failure);
  if (!a.picture.empty()) write_picture(a.picture, cloud.view(), cloud.rgb, result, picture);
  if (!a.html.empty()) {
    page.name = input.name();
    page.cloud = &cloud;
    page.options = &options;
    page.backend = localizer.backend();
    page.result = &result;
    write_page(a.html, page);
  }

  std::string text;
  if (a.json.empty()) {
    text += summary_table(input.path(), result, times);
    if (repeat && times) text += times_table(run_times);
    if (result.handles.empty() && !a.explain) text += "add --explain to see why\n";
  }
  if (a.explain) text += backend_line(localizer) + explanation(options, result);
  // JSON on standard output stays JSON.
  if (!text.empty()) write_and_flush(a.json == "-" ? stderr : stdout, text, "standard output");
  return 0;
}

}  // namespace

Subcommand add_localize(CLI::App& parent) {
  CLI::App* app = parent.add_subcommand("localize", "Find the handles in a point cloud or a depth image");
  app->allow_extras();
  auto arguments = std::make_shared<Arguments>();
  add_flags(*app, *arguments);
  return {app, [arguments] { return run(*arguments); }};
}

}  // namespace handhold
