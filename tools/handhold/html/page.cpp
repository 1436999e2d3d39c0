#include "page.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <utility>

#include "atomic_file.h"
#include "colors.h"
#include "page_cloud.h"
#include "page_template.h"
#include "report.h"
#include "result_json.h"
#include "start_view.h"

namespace handhold {
namespace {

using Json = nlohmann::ordered_json;

std::string hex(const Color& color) {
  std::string text = "#";
  for (const float part : {color.r, color.g, color.b}) {
    const auto value = static_cast<unsigned>(std::lround(255 * part));
    text += "0123456789abcdef"[value >> 4];
    text += "0123456789abcdef"[value & 15];
  }
  return text;
}

Json pose_json(const sensor::Pose& T) {
  return {{"R", T.R}, {"t", T.t}};
}

Json funnel_json(const std::vector<StepCount>& steps, const StepCount& last) {
  Json rows = Json::array();
  const auto add_row = [&](const StepCount& step) {
    rows.push_back({{"name", step.name},
                    {"count", step.count},
                    {"what", step.what},
                    {"settings", step.settings},
                    {"advice", step.advice}});
  };
  for (const StepCount& step : steps) add_row(step);
  add_row(last);
  return rows;
}

constexpr const char* kBodyKinds[] = {"box", "cylinder", "sphere"};  // by PageBody::Kind

Json plan_json(const PagePlan& plan) {
  Json json = {{"arm", plan.arm},         {"base", plan.base},
               {"tip", plan.tip},         {"T_base_cloud", pose_json(plan.T_base_cloud)},
               {"grasps", Json::array()}, {"rejected", Json::array()}};
  for (const PageGrasp& grasp : plan.grasps) {
    Json hand = Json::array();
    for (const PageBody& body : grasp.hand) {
      hand.push_back({{"kind", kBodyKinds[static_cast<std::size_t>(body.kind)]},
                      {"size", body.size},
                      {"R", body.T_cloud_body.R},
                      {"t", body.T_cloud_body.t}});
    }
    json["grasps"].push_back({{"handle", grasp.handle},
                              {"hand", hand},
                              {"from", grasp.from},
                              {"to", grasp.to},
                              {"width", grasp.width},
                              {"opening", grasp.opening},
                              {"time", grasp.time}});
  }
  for (const PageRejection& rejection : plan.rejected) {
    json["rejected"].push_back({{"handle", rejection.handle}, {"reason", rejection.reason}});
  }
  return json;
}

/// What the page needs beside the result itself.
Json view_json(const Page& page, const PageCloud& cloud) {
  const Funnel& funnel = page.result->funnel;
  StartView start = start_view(page.cloud->view());
  if (page.plan) start.up = page.plan->T_base_cloud.inverse().direction({0, 0, 1});
  Json json;
  json["schema"] = "handhold.view/1";
  json["name"] = page.name;
  json["cloud"] = {
      {"points", cloud.points}, {"far", cloud.far}, {"step", cloud.step}, {"lower", cloud.lower}, {"size", cloud.size}};
  json["start"] = {
      {"eye", start.eye}, {"target", start.target}, {"down", start.down}, {"up", start.up}, {"angle", start.angle}};
  json["min_confidence"] = page.options->effective_min_confidence();
  json["finger_width"] = page.options->finger_width;
  json["sample_steps"] = funnel_json(sample_steps(*page.options, funnel),
                                     {"affordances", funnel.affordances, "gave an affordance", {}, {}});
  json["affordance_steps"] = funnel_json(affordance_steps(*page.options, funnel),
                                         {"in_handles", funnel.in_handles, "ended in handles", {}, {}});
  json["samples"] = page.samples.size();
  // By Step; the page knows the names that the funnel's counts have.
  json["step_colors"] = Json::array();
  for (std::size_t i = 0; i < kStepCount; ++i) {
    const auto step = static_cast<Step>(i);
    const std::string name = step == Step::kAffordance ? "affordances" : std::string(to_string(step));
    json["step_colors"].push_back({{"name", name}, {"color", hex(step_color(step))}});
  }
  json["handle_colors"] = Json::array();
  for (std::size_t i = 0; i < kHandleColors; ++i) json["handle_colors"].push_back(hex(handle_color(i)));
  if (page.plan) json["plan"] = plan_json(*page.plan);
  return json;
}

/// JSON that no HTML parser takes for a tag: '<' can only stand in a text there.
std::string for_script(std::string json) {
  std::size_t at = 0;
  while ((at = json.find('<', at)) != std::string::npos) json.replace(at, 1, "\\u003c");
  return json;
}

std::string for_html(const std::string& text) {
  std::string escaped;
  for (const char c : text) {
    switch (c) {
      case '&':
        escaped += "&amp;";
        break;
      case '<':
        escaped += "&lt;";
        break;
      case '>':
        escaped += "&gt;";
        break;
      default:
        escaped += c;
    }
  }
  return escaped;
}

/// The template with each mark replaced, in their order there; what is put in is not searched.
std::string filled_template(const std::vector<std::pair<std::string, std::string>>& parts) {
  const std::string_view page = page_template();
  std::string text;
  std::size_t from = 0;
  for (const auto& [mark, part] : parts) {
    const std::size_t at = page.find(mark, from);
    if (at == std::string_view::npos) throw std::logic_error("the page's template has no " + mark);
    text.append(page, from, at - from);
    text += part;
    from = at + mark.size();
  }
  return text.append(page, from);
}

}  // namespace

void check_page_support() {
  if (page_template().empty()) {
    throw std::runtime_error(
        "--html: this build has no 3-D view: three.js was missing; install libjs-three, and build again");
  }
}

std::string page_text(const Page& page) {
  check_page_support();
  const Cloud& cloud = *page.cloud;
  const PageCloud points = page_cloud(cloud.view(), cloud.rgb);
  std::string samples, steps;
  for (const Sample& sample : page.samples) {
    points.append(sample.position, samples);
    steps += static_cast<char>(sample.step);
  }
  // A file's name need not be UTF-8.
  const std::string view = view_json(page, points).dump(-1, ' ', false, Json::error_handler_t::replace);
  return filled_template(
      {{"@TITLE@", for_html(page.name)},
       {"@RESULT@", for_script(to_json(cloud.view(), *page.options, page.backend, *page.result, nullptr))},
       {"@VIEW@", for_script(view)},
       {"@POSITIONS@", base64(points.positions)},
       {"@COLORS@", base64(points.colors)},
       {"@SAMPLES@", base64(samples)},
       {"@STEPS@", base64(steps)}});
}

void write_page(const std::string& path, const Page& page) {
  write_file(path, page_text(page));
}

}  // namespace handhold
