// Tables for people and, the same numbers, for programs.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace handhold::bench {

using Json = nlohmann::ordered_json;

struct Column {
  std::string key;      ///< in JSON, with the unit
  std::string heading;  ///< in print
  int decimals = 0;     ///< of numbers that are not whole; -1: two digits and an exponent
};

class Table {
 public:
  Table(std::string title, std::vector<Column> columns) : title_(std::move(title)), columns_(std::move(columns)) {}

  /// Texts, whole numbers, numbers, or null for what there is not; a cell a column.
  void add(std::vector<Json> cells) {
    if (cells.size() != columns_.size()) throw std::logic_error(title_ + ": a row has another number of cells");
    rows_.push_back(std::move(cells));
  }

  /// Title, headings and rows; texts to the left, numbers to the right.
  std::string text() const {
    std::vector<std::vector<std::string>> lines(1);
    for (const Column& c : columns_) lines[0].push_back(c.heading);
    for (const auto& row : rows_) {
      lines.emplace_back();
      for (std::size_t k = 0; k < row.size(); ++k) lines.back().push_back(cell(row[k], columns_[k].decimals));
    }
    std::string all = "\n" + title_ + "\n";
    for (const auto& line : lines) {
      for (std::size_t k = 0; k < line.size(); ++k) {
        std::size_t width = 0;
        for (const auto& other : lines) width = std::max(width, other[k].size());
        const std::string room(width - line[k].size(), ' ');
        const bool left = !rows_.empty() && rows_[0][k].is_string();
        all += (k ? "  " : "") + (left ? line[k] + room : room + line[k]);
      }
      all.erase(all.find_last_not_of(' ') + 1);
      all += '\n';
    }
    return all;
  }

  /// An array of objects.
  Json json() const {
    Json all = Json::array();
    for (const auto& row : rows_) {
      Json& object = all.emplace_back(Json::object());
      for (std::size_t k = 0; k < row.size(); ++k) object[columns_[k].key] = row[k];
    }
    return all;
  }

 private:
  static std::string cell(const Json& value, int decimals) {
    if (value.is_null()) return "-";
    if (value.is_string()) return value.get<std::string>();
    if (value.is_number_integer()) return std::to_string(value.get<std::int64_t>());
    char digits[64];
    if (decimals < 0) {
      std::snprintf(digits, sizeof digits, "%.2g", value.get<double>());
    } else {
      std::snprintf(digits, sizeof digits, "%.*f", decimals, value.get<double>());
    }
    return digits;
  }

  std::string title_;
  std::vector<Column> columns_;
  std::vector<std::vector<Json>> rows_;
};

}  // namespace handhold::bench
