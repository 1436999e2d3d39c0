#include "oni_structure.h"

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <set>
#include <stdexcept>
#include <vector>

namespace handhold::stream {
namespace {

enum Record : std::uint32_t {
  kNodeAdded4 = 2,  // of file version 1.0.0.4
  kIntProperty = 3,
  kRealProperty = 4,
  kStringProperty = 5,
  kGeneralProperty = 6,
  kStateReady = 9,
  kNewData = 10,
  kEnd = 11,
  kNodeAdded5 = 12,  // 1.0.0.5
  kNodeAdded = 13,
  kSeekTable = 14
};

constexpr std::uint32_t kDepthNode = 2;
/// What the player has room for: header and fields of 121 bytes, and 1600 x 1200 pixels of 3.
constexpr std::uint64_t kMaxRecordBytes = 121 + 1600 * 1200 * 3;
constexpr std::uint32_t kMaxNodes = 1000;

/// Little-endian integers from bytes that may end too early.
class Fields {
 public:
  explicit Fields(const std::vector<char>& bytes) : bytes_(bytes) {}

  template <class Integer>
  bool take(Integer& value) {
    if (bytes_.size() - at_ < sizeof value) return false;
    std::memcpy(&value, bytes_.data() + at_, sizeof value);
    at_ += sizeof value;
    return true;
  }
  /// A size, and so many bytes.
  bool take_block(std::size_t& begin, std::uint32_t& size) {
    if (!take(size) || bytes_.size() - at_ < size) return false;
    begin = at_;
    at_ += size;
    return true;
  }
  /// A block of letters that ends with a zero. (The player takes others for indices below 0.)
  bool take_name() {
    std::size_t begin = 0;
    std::uint32_t size = 0;
    if (!take_block(begin, size) || size < 2 || bytes_[at_ - 1] != '\0') return false;
    return std::all_of(bytes_.begin() + static_cast<std::ptrdiff_t>(begin),
                       bytes_.begin() + static_cast<std::ptrdiff_t>(at_ - 1),
                       [](char c) { return c >= ' ' && c <= '~'; });
  }

 private:
  const std::vector<char>& bytes_;
  std::size_t at_ = 0;
};

class Walk {
 public:
  explicit Walk(const std::string& path) : path_(path), file_(path, std::ios::binary) {
    if (!file_) throw std::runtime_error("cannot open the recording '" + path + "': " + std::strerror(errno));
    std::vector<char> header(24);
    std::uint32_t magic = 0, build = 0, max_node = 0;
    std::uint8_t major = 0, minor = 0;
    std::uint16_t maintenance = 0;
    std::uint64_t max_time = 0;
    file_.read(header.data(), static_cast<std::streamsize>(header.size()));
    if (file_.gcount() < 4 || std::memcmp(header.data(), "NI10", 4) != 0) {
      throw std::runtime_error("'" + path + "' is no OpenNI recording: it does not begin with NI10");
    }
    Fields fields(header);
    fields.take(magic), fields.take(major), fields.take(minor), fields.take(maintenance), fields.take(build);
    fields.take(max_time), fields.take(max_node);
    if (!file_ || max_node >= kMaxNodes) damaged("its header");
    nodes_ = max_node + 1;
    // From version 1.0.1.0 on positions have 64 bits.
    header_bytes_ = major > 1 || minor > 0 || maintenance > 0 ? 28 : 24;
    file_.seekg(0, std::ios::end);
    size_ = static_cast<std::uint64_t>(file_.tellg());
    file_.seekg(static_cast<std::streamoff>(header.size()));
  }

  OniStructure run() {
    while (!result_.complete && next()) {
    }
    return result_;
  }

 private:
  /// False: the file ends within the record.
  bool next() {
    const auto at = static_cast<std::uint64_t>(file_.tellg());
    std::vector<char> header(header_bytes_);
    std::uint32_t magic = 0, type = 0, node = 0, header_and_fields = 0, payload = 0;
    if (size_ - at < header_bytes_ || !read(header)) return false;
    Fields fields(header);
    fields.take(magic), fields.take(type), fields.take(node), fields.take(header_and_fields), fields.take(payload);
    const std::uint64_t bytes = std::uint64_t{header_and_fields} + payload;
    if (magic != ('N' | 'I' << 8 | 'R' << 16) || type < kNodeAdded4 || type > kSeekTable || node >= nodes_ ||
        header_and_fields < header_bytes_ || bytes > kMaxRecordBytes) {
      damaged("the record at byte " + std::to_string(at));
    }
    if (size_ - at < bytes) return false;
    std::vector<char> body(header_and_fields - header_bytes_);
    if (!read(body)) return false;
    if (!well_formed(type, node, body)) damaged("the record at byte " + std::to_string(at));
    if (type == kNewData && depth_.count(node)) ++result_.depth_frames;
    result_.complete = type == kEnd;
    file_.seekg(static_cast<std::streamoff>(at + bytes));
    return true;
  }

  bool well_formed(std::uint32_t type, std::uint32_t node, const std::vector<char>& body) {
    Fields fields(body);
    switch (type) {
      case kNodeAdded4:
      case kNodeAdded5:
      case kNodeAdded: {
        std::uint32_t node_type = 0, codec = 0;
        if (!fields.take_name() || !fields.take(node_type) || !fields.take(codec)) return false;
        if (node_type == kDepthNode) depth_.insert(node);
        if (codec != 0) coded_.insert(node);
        return true;
      }
      case kIntProperty:
      case kRealProperty:
      case kStringProperty:
      case kGeneralProperty: {
        std::size_t begin = 0;
        std::uint32_t size = 0;
        return fields.take_name() && fields.take_block(begin, size) &&
               (type != kStringProperty || (size > 0 && body[begin + size - 1] == '\0'));
      }
      case kStateReady:
        if (coded_.count(node)) ready_.insert(node);
        return true;
      case kNewData:
        return ready_.count(node) > 0;  // the player decodes it with what it has until then
      default:
        return true;
    }
  }

  bool read(std::vector<char>& bytes) {
    file_.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    return static_cast<bool>(file_);
  }

  [[noreturn]] void damaged(const std::string& where) const {
    throw std::runtime_error("the recording '" + path_ + "' is damaged: " + where + " is none that OpenNI2 writes");
  }

  std::string path_;
  std::ifstream file_;
  std::uint64_t size_ = 0;
  std::uint32_t nodes_ = 0;
  std::size_t header_bytes_ = 28;
  std::set<std::uint32_t> depth_, coded_, ready_;  ///< nodes
  OniStructure result_;
};

}  // namespace

OniStructure check_oni(const std::string& path) {
  return Walk(path).run();
}

}  // namespace handhold::stream
