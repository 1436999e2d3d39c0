#include "result_json.h"

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string_view>
#include <type_traits>

namespace handhold {
namespace {

using Json = nlohmann::ordered_json;

template <class T>
Json option_json(const T& value) {
  if constexpr (std::is_enum_v<T>) {
    return std::string(to_string(value));
  } else {
    return value;
  }
}
template <class T>
Json option_json(const std::optional<T>& value) {
  return value ? Json(*value) : Json(nullptr);
}

Json options_json(const Options& options, bool with_threads) {
  Json json = Json::object();
  visit_options(options, [&](const auto& field, const OptionInfo& info) {
    if (with_threads || std::string_view(info.name) != "threads") json[info.name] = option_json(field);
  });
  return json;
}

Json funnel_json(const Funnel& funnel) {
  return {{"samples", funnel.samples},
          {"too_few_points", funnel.too_few_points},
          {"flat", funnel.flat},
          {"curvature_low", funnel.curvature_low},
          {"concave", funnel.concave},
          {"circle_wide", funnel.circle_wide},
          {"circle_narrow", funnel.circle_narrow},
          {"poor_fit", funnel.poor_fit},
          {"no_gap", funnel.no_gap},
          {"shell_empty", funnel.shell_empty},
          {"affordances", funnel.affordances},
          {"cut", funnel.cut},
          {"not_aligned", funnel.not_aligned},
          {"unconfirmed", funnel.unconfirmed},
          {"too_short", funnel.too_short},
          {"low_confidence", funnel.low_confidence},
          {"in_handles", funnel.in_handles}};
}

Json times_json(const StageTimes& times) {
  Json json = Json::object();
  for (const auto& [name, stage] : kStages) {
    json[name] = times.*stage;
  }
  return json;
}

Json affordance_json(const Affordance& affordance) {
  return {{"center", affordance.center}, {"axis", affordance.axis}, {"normal", affordance.normal},
          {"radius", affordance.radius}, {"gap", affordance.gap},   {"observed_free", affordance.observed_free}};
}

}  // namespace

Json handle_json(const Handle& handle) {
  Json json = {{"center", handle.center},
               {"axis", handle.axis},
               {"approach", handle.approach},
               {"radius", handle.radius},
               {"length", handle.length},
               {"confidence", handle.confidence},
               {"arc", handle.arc},
               {"residual", handle.residual},
               {"observed_free", handle.observed_free},
               {"normal_error", handle.normal_error},
               {"affordances", handle.affordances}};
  if (!handle.path.empty()) json["path"] = handle.path;
  return json;
}

std::string to_lines(const Json& json) {
  std::string text = "{";
  const char* separator = "\n";
  for (const auto& [key, value] : json.items()) {
    text += separator + Json(key).dump() + ": ";
    separator = ",\n";
    if (!value.is_array() || value.empty()) {
      text += value.dump();
      continue;
    }
    const char* before = "[\n  ";
    for (const Json& element : value) {
      text += before + element.dump();
      before = ",\n  ";
    }
    text += "]";
  }
  return text + "\n}\n";
}

std::string to_json(const CloudView& cloud, const Options& options, Backend backend, const Result& result,
                    const RunTimes* times) {
  Json json;
  json["schema"] = "handhold/1";
  json["status"] = std::string(to_string(result.status));
  json["backend"] = std::string(to_string(backend));
  json["cloud"] = {{"points", result.points},
                   {"finite", result.finite_points},
                   {"organized", cloud.organized()},
                   {"viewpoint", option_json(cloud.viewpoint)}};
  json["options"] = options_json(options, times != nullptr);
  json["funnel"] = funnel_json(result.funnel);
  if (times) {
    json["times_ms"] = times_json(times->median_ms);
    if (times->runs > 1) json["times_p99_ms"] = times_json(times->p99_ms);
  }
  json["handles"] = Json::array();
  for (const Handle& handle : result.handles) json["handles"].push_back(handle_json(handle));
  json["affordances"] = Json::array();
  for (const Affordance& affordance : result.affordances) json["affordances"].push_back(affordance_json(affordance));
  return to_lines(json);
}

}  // namespace handhold
