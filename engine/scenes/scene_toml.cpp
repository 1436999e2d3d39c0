// SceneFile <-> TOML.
#include <toml++/toml.h>

#include <charconv>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <optional>
#include <set>
#include <sstream>
#include <stdexcept>

#include "camera_fields.h"
#include "handhold/scene_file.h"
#include "vec.h"

namespace handhold::sensor {
namespace {

// ---- Reading --------------------------------------------------------------------------------------------------------

/// A table whose keys are taken one by one; what nobody took is unknown.
class Reader {
 public:
  Reader(const toml::table& table, std::string source, std::string where)
      : table_(table), source_(std::move(source)), where_(std::move(where)) {}

  [[noreturn]] void fail(const toml::node* node, const std::string& message) const {
    const auto line = (node ? *node : static_cast<const toml::node&>(table_)).source().begin.line;
    throw std::runtime_error(source_ + (line ? ", line " + std::to_string(line) : "") + ": " + where_ + message);
  }

  const toml::node* take(const char* key) {
    taken_.insert(key);
    known_ += (known_.empty() ? "" : ", ") + std::string(key);
    return table_.get(key);
  }
  bool has(const char* key) const { return table_.contains(key); }

  std::string text(const char* key) {
    const toml::node* node = take(key);
    if (!node) fail(nullptr, std::string(key) + " is missing; give a string");
    const auto value = node->value_exact<std::string>();
    if (!value || value->empty()) fail(node, std::string(key) + " must be a string that is not empty");
    return *value;
  }
  double number(const toml::node& node, const std::string& name) const {
    double value = NAN;
    if (const auto real = node.value_exact<double>()) {
      value = *real;
    } else if (const auto whole = node.value_exact<std::int64_t>()) {
      value = static_cast<double>(*whole);
    }
    if (!std::isfinite(value)) fail(&node, name + " must be a finite number");
    return value;
  }
  template <std::size_t n>
  std::array<double, n> numbers(const char* key) {
    const toml::node* node = take(key);
    const toml::array* array = node ? node->as_array() : nullptr;
    if (!array || array->size() != n) {
      fail(node, std::string(key) + (node ? " must be " : " is missing; give ") + std::to_string(n) + " numbers");
    }
    std::array<double, n> values;
    for (std::size_t i = 0; i < n; ++i) values[i] = number((*array)[i], key);
    return values;
  }

  // Fields of camera and noise; a key that is missing leaves the field alone.
  void operator()(const char* key, double& field) {
    if (const toml::node* node = take(key)) field = number(*node, key);
  }
  void operator()(const char* key, std::uint32_t& field) {
    const toml::node* node = take(key);
    if (!node) return;
    const auto value = node->value_exact<std::int64_t>();
    if (!value || *value < 1 || *value > 16384)
      fail(node, std::string(key) + " must be a whole number from 1 to 16384");
    field = static_cast<std::uint32_t>(*value);
  }
  /// A number above 2^63 - 1 is no TOML integer, but may be a string.
  void operator()(const char* key, std::uint64_t& field) {
    const toml::node* node = take(key);
    if (!node) return;
    if (const auto digits = node->value_exact<std::string>()) {
      const auto [end, error] = std::from_chars(digits->data(), digits->data() + digits->size(), field);
      if (!digits->empty() && error == std::errc() && end == digits->data() + digits->size()) return;
    } else if (const auto value = node->value_exact<std::int64_t>(); value && *value >= 0) {
      field = static_cast<std::uint64_t>(*value);
      return;
    }
    fail(node, std::string(key) + " must be a whole number of at least 0");
  }
  void operator()(const char* key, bool& field) {
    const toml::node* node = take(key);
    if (!node) return;
    const auto value = node->value_exact<bool>();
    if (!value) fail(node, std::string(key) + " must be true or false");
    field = *value;
  }

  /// A table inside; none when the key is missing.
  std::optional<Reader> table(const char* key) {
    const toml::node* node = take(key);
    if (!node) return std::nullopt;
    if (!node->is_table()) fail(node, std::string(key) + " must be a table");
    return Reader(*node->as_table(), source_, where_ + key + ".");
  }
  const toml::table& raw() const { return table_; }

  /// After all keys were asked for.
  void refuse_unknown() const {
    for (auto&& [key, node] : table_) {
      if (taken_.count(std::string(key.str()))) continue;
      fail(&node, "unknown key '" + std::string(key.str()) + "'; must be one of " + known_);
    }
  }

 private:
  const toml::table& table_;
  std::string source_, where_;
  std::set<std::string> taken_;
  std::string known_;
};

/// Nine numbers that are a rotation to within the rounding of a file written by hand.
void check_rotation(const Reader& reader, const toml::node* node, const std::array<double, 9>& R) {
  double error = 0;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      double product = 0;
      for (int k = 0; k < 3; ++k) product += R[3 * i + k] * R[3 * j + k];
      error = std::max(error, std::abs(product - (i == j)));
    }
  }
  const double determinant = dot({R[0], R[1], R[2]}, cross({R[3], R[4], R[5]}, {R[6], R[7], R[8]}));
  if (!(error < 1e-5) || !(determinant > 0)) {
    reader.fail(node, "rotation must be the nine numbers of a right-handed rotation matrix, row by row");
  }
}

/// position with rotation (nine numbers), or with axis and angle, or alone.
Pose read_pose(Reader& reader) {
  Pose pose;
  pose.t = reader.numbers<3>("position");
  if (reader.has("rotation")) {
    if (reader.has("axis") || reader.has("angle")) {
      reader.fail(reader.take("rotation"), "rotation and axis/angle are both given; give one of them");
    }
    pose.R = reader.numbers<9>("rotation");
    check_rotation(reader, reader.take("rotation"), pose.R);
  } else if (reader.has("axis") || reader.has("angle")) {
    const Vector3 axis = reader.numbers<3>("axis");
    double angle = NAN;
    reader("angle", angle);
    if (std::isnan(angle)) reader.fail(nullptr, "angle is missing; give it in rad");
    if (!(norm(axis) > 0)) reader.fail(reader.take("axis"), "axis must not be zero");
    pose.R = rotation(axis, angle).R;
  }
  // For the list of what is known.
  for (const char* key : {"rotation", "axis", "angle"}) reader.take(key);
  return pose;
}

void read_camera(Reader& reader, SceneFile& file) {
  if (reader.has("eye")) {
    const Vector3 eye = reader.numbers<3>("eye"), target = reader.numbers<3>("target");
    double roll = 0;
    reader("roll", roll);
    try {
      file.T_world_camera = look_at(eye, target) * rotation({0, 0, 1}, roll);
    } catch (const std::invalid_argument& error) {
      reader.fail(reader.take("eye"), error.what());
    }
  } else {
    if (!reader.has("position")) {
      reader.fail(nullptr, "eye and target are missing; give them, or position and rotation (optical frame)");
    }
    file.T_world_camera = read_pose(reader);
    for (const char* key : {"eye", "target", "roll"}) reader.take(key);
  }
  file.camera = CameraOptions::kinect();
  if (reader.has("preset")) {
    const std::string preset = reader.text("preset");
    if (preset == "xtion") {
      file.camera = CameraOptions::xtion();
    } else if (preset == "bare") {
      file.camera = CameraOptions();
    } else if (preset != "kinect") {
      reader.fail(reader.take("preset"), "preset is '" + preset + "'; must be kinect, xtion or bare");
    }
  }
  visit_camera(file.camera, [&](const char* name, auto& field) { reader(name, field); });
  if (auto noise = reader.table("noise")) {
    visit_noise(file.camera.noise, [&](const char* name, auto& field) { (*noise)(name, field); });
    noise->refuse_unknown();
  }
  reader.take("preset");
  reader.refuse_unknown();
  try {
    file.camera.validate();
  } catch (const std::invalid_argument& error) {
    reader.fail(nullptr, error.what());
  }
}

SceneObject read_object(Reader& reader) {
  SceneObject object;
  object.name = reader.text("name");
  object.family = reader.text("family");
  if (auto sizes = reader.table("sizes")) {
    for (auto&& [key, node] : sizes->raw()) {
      object.sizes[std::string(key.str())] = sizes->number(node, std::string(key.str()));
    }
  }
  if (auto material = reader.table("material")) {
    const auto share = [&](const char* key, double& field) {
      (*material)(key, field);
      if (!(field >= 0 && field <= 1)) material->fail(material->take(key), std::string(key) + " must be 0 to 1");
    };
    share("reflectance", object.material.reflectance);
    share("specular", object.material.specular);
    material->refuse_unknown();
  }
  object.T_world_object = read_pose(reader);
  reader.refuse_unknown();
  try {
    make_object(object.family, object.sizes);
  } catch (const std::invalid_argument& error) {
    reader.fail(nullptr, error.what());
  }
  return object;
}

bool is_file_name(const std::string& name) {
  for (const char c : name) {
    const bool fine =
        (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-' || c == '.';
    if (!fine) return false;
  }
  return !name.empty() && name[0] != '.' && name.size() <= 100;
}

// ---- Writing --------------------------------------------------------------------------------------------------------

/// The shortest text that reads back to the same double.
std::string number_text(double value) {
  char digits[64];
  const auto result = std::to_chars(digits, digits + sizeof digits, value);
  std::string text(digits, result.ptr);
  if (text.find_first_of(".en") == std::string::npos) text += ".0";  // 25 would be an integer
  return text;
}
std::string text_of(double value) {
  return number_text(value);
}
std::string text_of(std::uint32_t value) {
  return std::to_string(value);
}
std::string text_of(std::uint64_t value) {
  const std::string digits = std::to_string(value);
  return value >> 63 ? "\"" + digits + "\"" : digits;
}
std::string text_of(bool value) {
  return value ? "true" : "false";
}
template <std::size_t n>
std::string text_of(const std::array<double, n>& values) {
  std::string text = "[";
  for (std::size_t i = 0; i < n; ++i) text += (i ? ", " : "") + number_text(values[i]);
  return text + "]";
}
std::string quoted(const std::string& value) {
  std::ostringstream text;
  text << toml::value<std::string>(value);
  return text.str();
}

std::string pose_lines(const Pose& pose) {
  std::string text = "position = " + text_of(pose.t) + "\n";
  if (pose.R != Pose{}.R) text += "rotation = " + text_of(pose.R) + "\n";
  return text;
}

}  // namespace

SceneFile parse_scene(const std::string& text, const std::string& source) {
  toml::table table;
  try {
    table = toml::parse(text, source);
  } catch (const toml::parse_error& error) {
    std::string message(error.description());
    for (char& c : message) {
      if (c == '\n') c = ' ';
    }
    throw std::runtime_error(source + ", line " + std::to_string(error.source().begin.line) + ": " + message);
  }
  SceneFile file;
  Reader reader(table, source, "");
  file.name = reader.text("name");
  if (!is_file_name(file.name)) {
    reader.fail(reader.take("name"), "name '" + file.name + "' must be letters, digits, '_', '-' and '.'");
  }
  auto camera = reader.table("camera");
  const toml::node* objects = reader.take("object");
  const toml::array* list = objects ? objects->as_array() : nullptr;
  reader.refuse_unknown();
  if (!camera) reader.fail(nullptr, "camera is missing; give a table [camera] with eye and target");
  if (objects && (!list || !list->is_array_of_tables())) reader.fail(objects, "object must be tables [[object]]");
  read_camera(*camera, file);
  std::set<std::string> names;
  for (std::size_t i = 0; list && i < list->size(); ++i) {
    Reader object(*(*list)[i].as_table(), source, "object " + std::to_string(i + 1) + ": ");
    file.objects.push_back(read_object(object));
    if (!names.insert(file.objects.back().name).second) {
      object.fail(object.take("name"), "name '" + file.objects.back().name + "' is taken; give every object its own");
    }
  }
  return file;
}

SceneFile read_scene(const std::string& path) {
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored)) {
    throw std::runtime_error("cannot read '" + path + "': it is a folder; give the name of a scene file");
  }
  std::ifstream file(path, std::ios::binary);
  if (!file) {
    const bool exists = std::filesystem::exists(path, ignored);
    throw std::runtime_error("cannot read '" + path + "': " + (exists ? "permission denied" : "no such file") +
                             "; give the name of a scene file");
  }
  std::ostringstream text;
  text << file.rdbuf();
  if (file.bad()) throw std::runtime_error("cannot read '" + path + "': the disk failed; give another scene file");
  return parse_scene(text.str(), path);
}

std::string to_toml(const SceneFile& file) {
  std::string text = "name = " + quoted(file.name) + "\n\n[camera]\n" + pose_lines(file.T_world_camera);
  text += "preset = \"bare\"\n";
  const auto write = [&](const char* name, const auto& field) { text += name + (" = " + text_of(field)) + "\n"; };
  visit_camera(file.camera, write);
  text += "[camera.noise]\n";
  visit_noise(file.camera.noise, write);
  for (const SceneObject& object : file.objects) {
    text += "\n[[object]]\nname = " + quoted(object.name) + "\nfamily = " + quoted(object.family) + "\n";
    text += pose_lines(object.T_world_object);
    text += "material = {reflectance = " + text_of(object.material.reflectance) +
            ", specular = " + text_of(object.material.specular) + "}\n";
    if (object.sizes.empty()) continue;
    text += "sizes = {";
    const char* comma = "";
    for (const auto& [name, value] : object.sizes) {
      text += comma + name + " = " + text_of(value);
      comma = ", ";
    }
    text += "}\n";
  }
  return text;
}

}  // namespace handhold::sensor
