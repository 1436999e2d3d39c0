// An arm from a TOML file.
#include <toml++/toml.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <string_view>

#include "handhold/arm.h"

namespace handhold::plan {
namespace {

[[noreturn]] void fail(const std::string& file, const std::string& message) {
  throw std::invalid_argument(file + ": " + message);
}

/// None when there is no such file.
std::optional<std::string> read_text(const std::filesystem::path& path) {
  std::error_code ignored;
  std::ifstream file(path, std::ios::binary);
  if (!file || std::filesystem::is_directory(path, ignored)) return std::nullopt;
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

toml::table parse(const std::string& path) {
  const auto text = read_text(path);
  if (!text) fail(path, "cannot be read; give the name of a TOML file");
  try {
    return toml::parse(*text, path);
  } catch (const toml::parse_error& error) {
    std::string message(error.description());
    for (char& c : message) {
      if (c == '\n') c = ' ';
    }
    fail(path, "line " + std::to_string(error.source().begin.line) + ": " + message);
  }
}

/// One table of the file; its keys are asked for by name.
class Table {
 public:
  /// @param prefix  of the keys in messages, "hand."
  Table(const std::string& path, const toml::table& table, std::string prefix)
      : path_(path), table_(table), prefix_(std::move(prefix)) {}

  template <class Names>
  void check_names(const Names& known) const {
    for (auto&& [key, node] : table_) {
      if (std::find(known.begin(), known.end(), key.str()) != known.end()) continue;
      std::string names;
      for (const std::string_view name : known) names += (names.empty() ? "" : ", ") + std::string(name);
      fail(path_, "unknown key '" + prefix_ + std::string(key.str()) + "'; known are " + names);
    }
  }

  std::string text(std::string_view key) const {
    const auto value = needed(key).value_exact<std::string>();
    if (!value) wrong(key, "a string");
    return *value;
  }
  std::optional<double> number_if_there(std::string_view key) const {
    const toml::node* node = table_.get(key);
    if (!node) return std::nullopt;
    if (const auto whole = node->value_exact<std::int64_t>()) return static_cast<double>(*whole);
    const auto value = node->value_exact<double>();
    if (!value) wrong(key, "a number");
    return value;
  }
  double number(std::string_view key) const {
    needed(key);
    return *number_if_there(key);
  }
  std::vector<std::string> texts_if_there(std::string_view key) const {
    std::vector<std::string> texts;
    const toml::node* node = table_.get(key);
    if (!node) return texts;
    const toml::array* array = node->as_array();
    if (!array) wrong(key, "a list of strings");
    for (const toml::node& element : *array) {
      const auto value = element.value_exact<std::string>();
      if (!value) wrong(key, "a list of strings");
      texts.push_back(*value);
    }
    return texts;
  }
  std::optional<Table> table_if_there(std::string_view key) const {
    const toml::node* node = table_.get(key);
    if (!node) return std::nullopt;
    if (!node->is_table()) wrong(key, "a table");
    return Table(path_, *node->as_table(), std::string(key) + ".");
  }
  Posture numbers() const {
    Posture numbers;
    for (auto&& [key, node] : table_) numbers[std::string(key.str())] = number(key.str());
    return numbers;
  }

 private:
  const toml::node& needed(std::string_view key) const {
    const toml::node* node = table_.get(key);
    if (!node) fail(path_, "'" + prefix_ + std::string(key) + "' is missing");
    return *node;
  }
  [[noreturn]] void wrong(std::string_view key, const std::string& right) const {
    fail(path_, "'" + prefix_ + std::string(key) + "' must be " + right);
  }

  const std::string& path_;
  const toml::table& table_;
  std::string prefix_;
};

Hand read_hand(const Table& table) {
  constexpr std::array<std::string_view, 5> kKeys = {"opening_min_m", "opening_max_m", "finger_joints", "finger_closed",
                                                     "finger_open"};
  table.check_names(kKeys);
  Hand hand;
  hand.opening_min = table.number("opening_min_m");
  hand.opening_max = table.number("opening_max_m");
  hand.finger_joints = table.texts_if_there("finger_joints");
  hand.finger_closed = table.number_if_there("finger_closed");
  hand.finger_open = table.number_if_there("finger_open");
  return hand;
}

}  // namespace

Arm read_arm(const std::string& path) {
  const toml::table root = parse(path);
  const Table table(path, root, "");
  constexpr std::array<std::string_view, 5> kKeys = {"urdf", "base", "tip", "hand", "rest"};
  table.check_names(kKeys);

  const std::filesystem::path urdf = std::filesystem::path(path).parent_path() / table.text("urdf");
  const std::string base = table.text("base"), tip = table.text("tip");
  const auto hand_table = table.table_if_there("hand"), rest = table.table_if_there("rest");
  if (!hand_table) fail(path, "the table 'hand' is missing");
  const Hand hand = read_hand(*hand_table);
  const Posture posture = rest ? rest->numbers() : Posture();
  const auto text = read_text(urdf);
  if (!text) fail(path, "'urdf': '" + urdf.string() + "' cannot be read; give the name of a URDF file");
  try {
    return Arm::from_urdf(*text, base, tip, hand, posture);
  } catch (const std::invalid_argument& error) {
    fail(path, error.what());
  }
}

}  // namespace handhold::plan
