#include "files.h"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "projection.h"

namespace handhold::evaluation {
namespace {

using Json = nlohmann::json;

/// A place in a file, for messages.
struct Place {
  std::string text;

  Place operator/(const std::string& name) const { return {text + ", " + name}; }
  [[noreturn]] void fail(const std::string& problem) const { throw std::runtime_error(text + ": " + problem); }
};

Json parse(const std::string& path) {
  std::error_code ignored;  // a folder can be opened, but reading it throws
  std::ifstream file(path, std::ios::binary);
  if (!file || std::filesystem::is_directory(path, ignored))
    throw std::runtime_error("cannot read '" + path + "'; it must be a JSON file");
  const std::string text((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  if (file.bad() || text.empty())
    throw std::runtime_error("'" + path + "' is empty or cannot be read; it must hold JSON");
  try {
    return Json::parse(text);
  } catch (const Json::exception& error) {
    // nlohmann's text has its own prefix in brackets and tells the line.
    const std::string message = error.what();
    const std::size_t end = message.find("] ");
    throw std::runtime_error("'" + path +
                             "' is not JSON: " + (end == std::string::npos ? message : message.substr(end + 2)));
  }
}

const Json& member(const Json& object, const char* name, const Place& place) {
  const auto found = object.find(name);
  if (found == object.end()) place.fail(std::string("has no \"") + name + "\"");
  return *found;
}

double number(const Json& json, const Place& place) {
  if (!json.is_number() || !std::isfinite(json.get<double>())) place.fail("must be a finite number");
  return json.get<double>();
}
double number(const Json& object, const char* name, const Place& place) {
  return number(member(object, name, place), place / name);
}

double size(const Json& object, const char* name, const Place& place) {
  const double value = number(object, name, place);
  if (value < 0) (place / name).fail("must not be negative");
  return value;
}

Vector3 vector(const Json& json, const Place& place) {
  if (!json.is_array() || json.size() != 3) place.fail("must be three numbers");
  return {number(json[0], place), number(json[1], place), number(json[2], place)};
}
Vector3 vector(const Json& object, const char* name, const Place& place) {
  return vector(member(object, name, place), place / name);
}
Vector3 direction(const Json& object, const char* name, const Place& place) {
  const Vector3 v = vector(object, name, place);
  if (!(norm(v) > 0)) (place / name).fail("must be a direction; it has no length");
  return unit(v);
}

template <class T>
void optional_flag(const Json& object, const char* name, T& target, const Place& place) {
  const auto found = object.find(name);
  if (found == object.end()) return;
  if (!found->is_boolean()) (place / name).fail("must be true or false");
  target = found->get<bool>();
}

LabelledPart part(const Json& json, const Place& place) {
  if (!json.is_object()) place.fail("must be an object with \"center\", \"axis\", \"radius\" and \"length\"");
  LabelledPart part;
  part.what = json.contains("what") && json["what"].is_string() ? json["what"].get<std::string>() : "part";
  if (json.contains("family") && json["family"].is_string()) part.family = json["family"].get<std::string>();
  part.center = vector(json, "center", place);
  part.axis = direction(json, "axis", place);
  part.radius = size(json, "radius", place);
  part.length = size(json, "length", place);
  if (json.contains("confidence")) part.confidence = number(json, "confidence", place);
  if (json.contains("visible")) part.visible = number(json, "visible", place);
  optional_flag(json, "measured", part.measured, place);
  optional_flag(json, "graspable", part.graspable, place);
  optional_flag(json, "raised", part.raised, place);
  if (json.contains("centre_line")) {
    const Json& line = json["centre_line"];
    if (!line.is_array()) (place / "centre_line").fail("must be a list of points");
    for (const Json& point : line) part.centre_line.push_back(vector(point, place / "centre_line"));
  }
  if (part.centre_line.size() < 2) {
    part.centre_line = {add(part.center, part.axis, -part.length / 2), add(part.center, part.axis, part.length / 2)};
  }
  double length = 0;
  for (std::size_t i = 0; i + 1 < part.centre_line.size(); ++i) {
    length += norm(add(part.centre_line[i + 1], part.centre_line[i], -1));
  }
  if (!(length > 0)) place.fail("its centre line must have a length above 0");
  return part;
}

const Json& list(const Json& object, const char* name, const Place& place) {
  const Json& json = member(object, name, place);
  if (!json.is_array()) (place / name).fail("must be a list");
  return json;
}

}  // namespace

std::map<std::string, std::vector<LabelledPart>> read_truth(const std::string& path) {
  const Json json = parse(path);
  const Place file{"'" + path + "'"};
  if (!json.is_object()) file.fail("is no truth file; it must be an object: scene -> list of parts");
  std::map<std::string, std::vector<LabelledPart>> scenes;
  for (const auto& [name, parts] : json.items()) {
    const Place scene = file / ("scene '" + name + "'");
    if (!parts.is_array()) scene.fail("must be a list of parts");
    std::vector<LabelledPart>& labelled = scenes[name];
    for (std::size_t i = 0; i < parts.size(); ++i) {
      labelled.push_back(part(parts[i], scene / ("part " + std::to_string(i + 1))));
    }
  }
  return scenes;
}

Result read_result(const std::string& path) {
  const Json json = parse(path);
  const Place file{"'" + path + "'"};
  if (!json.is_object()) file.fail("is no result; 'handhold localize --json' writes one");
  Result result;
  const Json& handles = list(json, "handles", file);
  for (std::size_t i = 0; i < handles.size(); ++i) {
    const Place place = file / ("handle " + std::to_string(i + 1));
    if (!handles[i].is_object()) place.fail("must be an object");
    Handle handle;
    handle.center = vector(handles[i], "center", place);
    handle.axis = direction(handles[i], "axis", place);
    handle.approach = handles[i].contains("approach") ? vector(handles[i], "approach", place) : Vector3{0, 0, 0};
    handle.radius = size(handles[i], "radius", place);
    handle.length = size(handles[i], "length", place);
    handle.confidence = handles[i].contains("confidence") ? number(handles[i], "confidence", place) : 1;
    result.handles.push_back(handle);
  }
  if (!json.contains("affordances")) return result;
  const Json& affordances = list(json, "affordances", file);
  for (std::size_t i = 0; i < affordances.size(); ++i) {
    const Place place = file / ("affordance " + std::to_string(i + 1));
    if (!affordances[i].is_object()) place.fail("must be an object");
    Affordance affordance;
    affordance.center = vector(affordances[i], "center", place);
    affordance.axis = direction(affordances[i], "axis", place);
    affordance.radius = size(affordances[i], "radius", place);
    result.affordances.push_back(affordance);
  }
  return result;
}

}  // namespace handhold::evaluation
