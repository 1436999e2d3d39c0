#include <pcl/io/pcd_io.h>

#include <cstring>
#include <istream>
#include <streambuf>

#include "file.h"
#include "handhold/io.h"
#include "pcd_header.h"
#include "readers.h"

namespace handhold::io {
namespace {

// Lets PCL read from memory: what was checked is then what is read, and the file is read once.
class MemoryBuffer : public std::streambuf {
 public:
  explicit MemoryBuffer(std::string& bytes) { setg(bytes.data(), bytes.data(), bytes.data() + bytes.size()); }

 protected:
  pos_type seekoff(off_type offset, std::ios_base::seekdir from, std::ios_base::openmode) override {
    char* base = from == std::ios_base::beg ? eback() : from == std::ios_base::cur ? gptr() : egptr();
    char* target = base + offset;
    if (target < eback() || target > egptr()) return pos_type(off_type(-1));
    setg(eback(), target, egptr());
    return pos_type(target - eback());
  }
  pos_type seekpos(pos_type position, std::ios_base::openmode mode) override {
    return seekoff(off_type(position), std::ios_base::beg, mode);
  }
};

[[noreturn]] void fail(const std::string& path) {
  throw IoError("cannot read " + path + ": PCL refuses it although its header and sizes are right; write it again");
}

// PCL must have understood the header as we did; otherwise the sizes that were checked are not those that it uses.
void check_agreement(const PcdHeader& header, const pcl::PCLPointCloud2& cloud, const std::string& path) {
  bool same = cloud.width == header.width && cloud.height == header.height && cloud.point_step == header.point_step &&
              cloud.fields.size() == header.fields.size() && cloud.data.size() == header.points * header.point_step;
  for (std::size_t i = 0; same && i < header.fields.size(); ++i) {
    same = cloud.fields[i].name == header.fields[i].name && cloud.fields[i].offset == header.fields[i].offset &&
           cloud.fields[i].count == header.fields[i].count &&
           static_cast<std::size_t>(pcl::getFieldSize(cloud.fields[i].datatype)) == header.fields[i].size;
  }
  if (!same) {
    throw IoError("cannot read " + path +
                  ": this version of PCL does not know one of its field types; write x y z alone");
  }
}

float coordinate(const std::uint8_t* point, const PcdField& field) {
  if (field.size == 4) {
    float value;
    std::memcpy(&value, point + field.offset, sizeof value);
    return value;
  }
  double value;
  std::memcpy(&value, point + field.offset, sizeof value);
  return static_cast<float>(value);
}

Cloud convert(const PcdHeader& header, const std::vector<std::uint8_t>& data) {
  Cloud cloud;
  cloud.width = static_cast<std::uint32_t>(header.width);
  cloud.height = static_cast<std::uint32_t>(header.height);
  cloud.viewpoint = header.origin;
  cloud.xyz.resize(3 * header.points);
  const PcdField &x = *header.find("x"), &y = *header.find("y"), &z = *header.find("z");
  for (std::size_t i = 0; i < header.points; ++i) {
    const std::uint8_t* point = data.data() + i * header.point_step;
    cloud.xyz[3 * i] = coordinate(point, x);
    cloud.xyz[3 * i + 1] = coordinate(point, y);
    cloud.xyz[3 * i + 2] = coordinate(point, z);
  }

  const PcdField* color = header.find("rgb");
  if (!color) color = header.find("rgba");
  if (color && color->size == 4 && color->count == 1) {  // the same four bytes, whatever TYPE says
    cloud.rgb.resize(header.points);
    for (std::size_t i = 0; i < header.points; ++i) {
      std::memcpy(&cloud.rgb[i], data.data() + i * header.point_step + color->offset, 4);
      cloud.rgb[i] &= 0xffffffu;
    }
  }
  return cloud;
}

}  // namespace

Cloud read_pcd(const std::string& path, std::size_t file_size) {
  std::string bytes = read_bytes(path, file_size);
  const PcdHeader header = parse_pcd_header(bytes, path);
  if (header.points == 0) {  // PCL takes this for an error; here the localizer says what to think of it
    Cloud empty;
    empty.viewpoint = header.origin;
    return empty;
  }
  check_pcd_data(header, bytes, path);

  const QuietPcl quiet;
  pcl::PCDReader reader;
  pcl::PCLPointCloud2 cloud;
  Eigen::Vector4f origin;
  Eigen::Quaternionf orientation;
  int version = 0, data_type = 0;
  unsigned data_offset = 0;
  MemoryBuffer buffer(bytes);
  std::istream stream(&buffer);
  if (reader.readHeader(stream, cloud, origin, orientation, version, data_type, data_offset) != 0) fail(path);
  check_agreement(header, cloud, path);
  if (data_offset != header.data_offset || data_type != static_cast<int>(header.data)) fail(path);

  int error = 0;
  if (header.data == PcdData::kAscii) {
    stream.clear();
    stream.seekg(static_cast<std::streamoff>(data_offset));
    error = reader.readBodyASCII(stream, cloud, version);
  } else {
    error = reader.readBodyBinary(reinterpret_cast<const unsigned char*>(bytes.data()), cloud, version,
                                  header.data == PcdData::kBinaryCompressed, data_offset);
  }
  if (error != 0 || cloud.data.size() < header.points * header.point_step) fail(path);
  return convert(header, cloud.data);
}

}  // namespace handhold::io
