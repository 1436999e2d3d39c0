#include "pcd_header.h"

#include <charconv>
#include <cmath>
#include <cstring>
#include <limits>
#include <set>

#include "handhold/io.h"

namespace handhold::io {
namespace {

constexpr std::size_t kLargestPoints = std::numeric_limits<std::int32_t>::max();  // PCL's index_t
constexpr std::size_t kLargestPointStep = 1 << 20;                                // bytes; keeps products in 64 bits

std::vector<std::string_view> split(std::string_view line) {
  std::vector<std::string_view> words;
  std::size_t i = 0;
  while (true) {
    i = line.find_first_not_of(" \t\r", i);
    if (i == std::string_view::npos) return words;
    const std::size_t end = std::min(line.find_first_of(" \t\r", i), line.size());
    words.push_back(line.substr(i, end - i));
    i = end;
  }
}

// The line that starts at `offset`, which moves behind it.
std::string_view next_line(std::string_view bytes, std::size_t& offset) {
  const std::size_t end = std::min(bytes.find('\n', offset), bytes.size());
  const std::string_view line = bytes.substr(offset, end - offset);
  offset = std::min(end + 1, bytes.size());
  return line;
}

bool is_number(std::string_view word) {
  if (!word.empty() && word.front() == '+') word.remove_prefix(1);
  double value = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  return end == word.data() + word.size() && error != std::errc::invalid_argument;
}

class HeaderReader {
 public:
  HeaderReader(std::string_view bytes, const std::string& path) : bytes_(bytes), path_(path) {}

  PcdHeader read() {
    while (offset_ < bytes_.size()) {
      const std::vector<std::string_view> words = split(next_line(bytes_, offset_));
      if (words.empty() || words[0].front() == '#') continue;
      if (words[0] == "DATA") {
        read_data(words);
        finish();
        return header_;
      }
      read_entry(words);
    }
    fail("the header ends without a line DATA", "the file is truncated or not a PCD");
  }

 private:
  [[noreturn]] void fail(const std::string& what, const std::string& right) const {
    throw IoError(what + " in " + path_ + ": " + right);
  }

  std::size_t number(const std::vector<std::string_view>& words, std::size_t i, std::size_t largest) const {
    std::size_t value = 0;
    if (i < words.size()) {
      const char* last = words[i].data() + words[i].size();
      const auto [end, error] = std::from_chars(words[i].data(), last, value);
      if (end == last && error == std::errc() && value <= largest) return value;
    }
    fail(std::string(words[0]) + " has no valid number" + (i < words.size() ? " '" + printable(words[i]) + "'" : ""),
         "a whole number from 0 to " + std::to_string(largest) + " is needed");
  }

  // A message is one line of text, whatever stands in the file.
  static std::string printable(std::string_view word) {
    std::string text;
    for (char c : word.substr(0, 40)) text += c >= 32 && c < 127 ? c : '?';
    return text;
  }

  void need_one_per_field(const std::vector<std::string_view>& words) const {
    if (header_.fields.empty() || words.size() != header_.fields.size() + 1) {
      fail(std::string(words[0]) + " has " + std::to_string(words.size() - 1) + " entries",
           "it needs one for each of the " + std::to_string(header_.fields.size()) + " FIELDS, after that line");
    }
  }

  void read_entry(const std::vector<std::string_view>& words) {
    const std::string key(words[0] == "COLUMNS" ? "FIELDS" : words[0]);
    if (!seen_.insert(key).second) fail("a second line " + printable(key), "each may stand there once");
    // PCL allocates at POINTS and computes offsets at each of these lines, so that their order matters to it.
    const bool layout = key == "FIELDS" || key == "SIZE" || key == "TYPE" || key == "COUNT";
    if (layout && seen_.count("POINTS")) fail("a line " + key + " after POINTS", "the fields come first");
    if (key == "TYPE" && !seen_.count("SIZE"))
      fail("a line TYPE before SIZE", "the order is FIELDS, SIZE, TYPE, COUNT");
    if (key == "COUNT" && !seen_.count("TYPE")) {
      fail("a line COUNT before TYPE", "the order is FIELDS, SIZE, TYPE, COUNT");
    }

    if (key == "FIELDS") {
      for (std::size_t i = 1; i < words.size(); ++i) {
        header_.fields.emplace_back();
        header_.fields.back().name = std::string(words[i]);
      }
    } else if (key == "SIZE") {
      need_one_per_field(words);
      for (std::size_t i = 1; i < words.size(); ++i) {
        const std::size_t size = number(words, i, 8);
        if (size != 1 && size != 2 && size != 4 && size != 8)
          fail("SIZE " + std::to_string(size), "1, 2, 4 or 8 is needed");
        header_.fields[i - 1].size = size;
      }
    } else if (key == "TYPE") {
      need_one_per_field(words);
      for (std::size_t i = 1; i < words.size(); ++i) {
        if (words[i] != "I" && words[i] != "U" && words[i] != "F") {
          fail("TYPE '" + printable(words[i]) + "'", "I, U or F is needed");
        }
        header_.fields[i - 1].type = words[i].front();
      }
    } else if (key == "COUNT") {
      need_one_per_field(words);
      for (std::size_t i = 1; i < words.size(); ++i) {
        header_.fields[i - 1].count = number(words, i, kLargestPointStep);
        if (header_.fields[i - 1].count == 0) fail("COUNT 0", "1 or more is needed");
      }
    } else if (key == "WIDTH") {
      header_.width = number(words, 1, kLargestPoints);
    } else if (key == "HEIGHT") {
      header_.height = number(words, 1, kLargestPoints);
    } else if (key == "POINTS") {
      header_.points = number(words, 1, kLargestPoints);
    } else if (key == "VIEWPOINT") {
      read_viewpoint(words);
    } else if (key != "VERSION") {
      fail("a header line '" + printable(key) + "'",
           "VERSION, FIELDS, SIZE, TYPE, COUNT, WIDTH, HEIGHT, VIEWPOINT, POINTS and DATA are known");
    }
  }

  void read_viewpoint(const std::vector<std::string_view>& words) {
    if (words.size() != 8) fail("VIEWPOINT has " + std::to_string(words.size() - 1) + " numbers", "7 are needed");
    for (std::size_t i = 0; i < 3; ++i) {
      const std::string_view word = words[i + 1].substr(words[i + 1].front() == '+');
      const char* last = word.data() + word.size();
      const auto [end, error] = std::from_chars(word.data(), last, header_.origin[i]);
      if (end != last || error != std::errc() || !std::isfinite(header_.origin[i])) {
        fail("VIEWPOINT '" + printable(words[i + 1]) + "'", "a finite number is needed");
      }
    }
  }

  void read_data(const std::vector<std::string_view>& words) {
    const std::string_view kind = words.size() > 1 ? words[1] : std::string_view();
    if (kind == "ascii") {
      header_.data = PcdData::kAscii;
    } else if (kind == "binary") {
      header_.data = PcdData::kBinary;
    } else if (kind == "binary_compressed") {
      header_.data = PcdData::kBinaryCompressed;
    } else {
      fail("DATA '" + printable(kind) + "'", "ascii, binary or binary_compressed is needed");
    }
    header_.data_offset = offset_;
  }

  void finish() {
    for (PcdField& field : header_.fields) {
      field.offset = header_.point_step;
      field.value = header_.values;
      header_.point_step += field.size * field.count;
      header_.values += field.count;
      if (header_.point_step > kLargestPointStep) fail("a point of over a megabyte", "SIZE or COUNT is too large");
    }
    check_coordinates();
    if (!seen_.count("POINTS")) fail("no line POINTS", "the file is truncated or not a PCD");
    if (!seen_.count("WIDTH") && !seen_.count("HEIGHT")) {  // before version 0.6
      header_.width = header_.points;
      header_.height = 1;
    }
    if (header_.width * header_.height != header_.points) {
      fail("WIDTH " + std::to_string(header_.width) + " x HEIGHT " + std::to_string(header_.height) +
               " differs from POINTS " + std::to_string(header_.points),
           "the three must agree");
    }
  }

  void check_coordinates() const {
    for (const char* name : {"x", "y", "z"}) {
      const PcdField* field = header_.find(name);
      if (!field) fail(std::string("no field ") + name, "a point cloud needs the fields x, y and z");
      if (field->type != 'F') {
        fail(std::string("the field ") + name + " holds integers (TYPE " + field->type + ")",
             "x, y and z must be floating point, in metres (TYPE F)");
      }
      if (field->size < 4) fail(std::string("the field ") + name + " has a SIZE below 4", "4 or 8 is needed");
      if (field->count != 1) fail(std::string("the field ") + name + " has a COUNT above 1", "one value is needed");
    }
  }

  std::string_view bytes_;
  const std::string& path_;
  std::size_t offset_ = 0;
  std::set<std::string> seen_;
  PcdHeader header_;
};

[[noreturn]] void fail_truncated(const std::string& path, const std::string& have, const std::string& need) {
  throw IoError("the data of " + path + " are truncated or damaged: " + have + ", the header promises " + need +
                "; write the file again");
}

void check_ascii(const PcdHeader& header, std::string_view bytes, const std::string& path) {
  const std::string promised = std::to_string(header.points) + " points";
  // A value takes a digit and a separator; so the check comes before any memory is taken for the points.
  if (header.points * header.values > (bytes.size() - header.data_offset + 1) / 2) {
    fail_truncated(path, std::to_string(bytes.size() - header.data_offset) + " bytes", promised);
  }
  std::size_t offset = header.data_offset, lines = 0;
  while (offset < bytes.size() && lines < header.points) {
    const std::vector<std::string_view> words = split(next_line(bytes, offset));
    if (words.empty()) continue;
    const std::string where = "point " + std::to_string(lines);
    if (words.size() != header.values) {  // PCL would skip the line and leave zeros
      fail_truncated(path, where + " has " + std::to_string(words.size()) + " values", std::to_string(header.values));
    }
    for (const char* name : {"x", "y", "z"}) {
      if (!is_number(words[header.find(name)->value])) fail_truncated(path, where + " has no number as " + name, "one");
    }
    ++lines;
  }
  if (lines < header.points) fail_truncated(path, std::to_string(lines) + " points", promised);
}

// Walks over an LZF stream without decoding it. Returns the length it decodes to; 0 when it is damaged.
std::size_t lzf_decoded_size(const unsigned char* in, std::size_t size) {
  std::size_t out = 0, i = 0;
  while (i < size) {
    const unsigned control = in[i++];
    if (control < 32) {  // a run of control + 1 bytes as they are
      i += control + 1;
      if (i > size) return 0;
      out += control + 1;
    } else {  // a copy of what was decoded `distance` bytes before
      std::size_t length = control >> 5;
      if (length == 7) {
        if (i >= size) return 0;
        length += in[i++];
      }
      if (i >= size) return 0;
      const std::size_t distance = ((control & 31u) << 8) + in[i++] + 1;
      if (distance > out) return 0;
      out += length + 2;
    }
  }
  return out;
}

void check_compressed(const PcdHeader& header, std::string_view bytes, const std::string& path) {
  if (header.find("_")) {
    throw IoError("padding (a field _) in compressed data in " + path + ": PCL cannot read that; write it without");
  }
  const std::size_t left = bytes.size() - header.data_offset;
  const std::size_t need = header.points * header.point_step;
  if (left < 8) fail_truncated(path, std::to_string(left) + " bytes", "8 bytes of sizes and the data");
  std::uint32_t sizes[2];  // compressed, uncompressed
  std::memcpy(sizes, bytes.data() + header.data_offset, 8);
  if (sizes[1] != need) {
    fail_truncated(path, std::to_string(sizes[1]) + " bytes uncompressed", std::to_string(need));
  }
  if (sizes[0] > left - 8) {
    fail_truncated(path, std::to_string(left - 8) + " compressed bytes", std::to_string(sizes[0]));
  }
  const auto* stream = reinterpret_cast<const unsigned char*>(bytes.data()) + header.data_offset + 8;
  if (lzf_decoded_size(stream, sizes[0]) != need) {
    fail_truncated(path, "the compressed stream is broken", std::to_string(need) + " bytes");
  }
}

}  // namespace

const PcdField* PcdHeader::find(std::string_view name) const {
  for (const PcdField& field : fields) {
    if (field.name == name) return &field;
  }
  return nullptr;
}

bool looks_like_pcd(std::string_view bytes) {
  std::size_t offset = 0;
  while (offset < bytes.size()) {
    const std::vector<std::string_view> words = split(next_line(bytes, offset));
    if (words.empty() || words[0].front() == '#') continue;
    return words[0] == "VERSION" || words[0] == "FIELDS" || words[0] == "COLUMNS";
  }
  return bytes.substr(0, 6) == "# .PCD";  // nothing but comments: let the header say that it is truncated
}

PcdHeader parse_pcd_header(std::string_view bytes, const std::string& path) {
  return HeaderReader(bytes, path).read();
}

void check_pcd_data(const PcdHeader& header, std::string_view bytes, const std::string& path) {
  const std::size_t left = bytes.size() - header.data_offset;
  switch (header.data) {
    case PcdData::kAscii:
      return check_ascii(header, bytes, path);
    case PcdData::kBinary:
      if (left < header.points * header.point_step) {
        fail_truncated(path, std::to_string(left) + " bytes", std::to_string(header.points * header.point_step));
      }
      return;
    case PcdData::kBinaryCompressed:
      return check_compressed(header, bytes, path);
  }
}

}  // namespace handhold::io
