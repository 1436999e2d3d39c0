// PLY through PCL's parser with callbacks of our own: pcl::PLYReader allocates what a header promises before it has
// seen the data, and places colours wrongly unless red, green and blue follow one another.
#include <pcl/io/ply/ply_parser.h>

#include <charconv>
#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <tuple>

#include "handhold/io.h"
#include "readers.h"

namespace handhold::io {
namespace {

using pcl::io::ply::ply_parser;
template <class T>
using Setter = std::function<void(T)>;
using ElementCallbacks = std::tuple<std::function<void()>, std::function<void()>>;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

class PlyReader {
 public:
  PlyReader(const std::string& path, std::size_t file_size) : path_(path), file_size_(file_size) {}

  Cloud read() {
    ply_parser parser;
    parser.error_callback([this](std::size_t line, const std::string&) { error_line_ = line; });
    parser.element_definition_callback(
        [this](const std::string& name, std::size_t count) { return element(name, count); });
    parser.obj_info_callback([this](const std::string& line) { obj_info(line); });
    parser.end_header_callback([this] {
      check_header();
      return true;
    });
    ply_parser::scalar_property_definition_callbacks_type scalars;
    take<pcl::io::ply::int8>(scalars);
    take<pcl::io::ply::int16>(scalars);
    take<pcl::io::ply::int32>(scalars);
    take<pcl::io::ply::uint8>(scalars);
    take<pcl::io::ply::uint16>(scalars);
    take<pcl::io::ply::uint32>(scalars);
    take<pcl::io::ply::float32>(scalars);
    take<pcl::io::ply::float64>(scalars);
    parser.scalar_property_definition_callbacks(scalars);
    ply_parser::list_property_definition_callbacks_type lists;
    take_list<pcl::io::ply::int32>(lists);
    take_list<pcl::io::ply::uint32>(lists);
    parser.list_property_definition_callbacks(lists);

    if (!parser.parse(path_) || !header_done_ || cloud_.xyz.size() != 3 * vertices_) {
      fail(header_done_ ? "its data are truncated or damaged (" + std::to_string(cloud_.xyz.size() / 3) + " of " +
                              std::to_string(vertices_) + " vertices were read)"
                        : "its header is damaged at line " + std::to_string(error_line_),
           "write the file again");
    }
    arrange();
    return std::move(cloud_);
  }

 private:
  [[noreturn]] void fail(const std::string& what, const std::string& right) const {
    throw IoError("cannot read " + path_ + ": " + what + "; " + right);
  }

  ElementCallbacks element(const std::string& name, std::size_t count) {
    // Every item takes a byte or more, so that nothing is allocated and no loop runs for a count out of thin air.
    if (count > file_size_) {
      fail("it promises " + std::to_string(count) + " items of one kind in " + std::to_string(file_size_) + " bytes",
           "it is truncated or damaged");
    }
    if (name == "vertex") {
      has_vertices_ = true;
      vertices_ = count;
      cloud_.xyz.reserve(3 * count);
      return {[this] { vertex_ = Vertex(); }, [this] { finish_vertex(); }};
    }
    if (name == "range_grid") {
      range_grid_.reserve(count);
      return {[this] { range_grid_.push_back(-1); }, [] {}};
    }
    return {[] {}, [] {}};
  }

  // "obj_info num_cols 640": the size of a range_grid. Other lines say nothing that we need.
  void obj_info(const std::string& line) {
    const char* keys[2] = {"num_cols ", "num_rows "};
    for (int i = 0; i < 2; ++i) {
      const std::size_t at = line.find(keys[i]);
      if (at == std::string::npos) continue;
      const char* first = line.data() + at + std::strlen(keys[i]);
      std::uint32_t value = 0;
      if (std::from_chars(first, line.data() + line.size(), value).ec == std::errc()) grid_size_[i] = value;
    }
  }

  template <class T>
  void take(ply_parser::scalar_property_definition_callbacks_type& callbacks) {
    ply_parser::at<T>(callbacks) = [this](const std::string& element_name, const std::string& name) -> Setter<T> {
      if (element_name == "vertex") return vertex_setter<T>(name);
      if (element_name == "camera") return camera_setter<T>(name);
      return [](T) {};
    };
  }

  template <class T>
  Setter<T> vertex_setter(const std::string& name) {
    for (int i = 0; i < 3; ++i) {
      if (name != std::string(1, "xyz"[i])) continue;
      if (!std::is_floating_point<T>::value)
        fail(name + " holds integers", "x, y and z must be float or double, in metres");
      has_coordinate_[i] = true;
      return [this, i](T value) { vertex_.position[i] = static_cast<float>(value); };
    }
    const char* colors[3][2] = {{"red", "diffuse_red"}, {"green", "diffuse_green"}, {"blue", "diffuse_blue"}};
    for (int i = 0; i < 3; ++i) {
      if (name != colors[i][0] && name != colors[i][1]) continue;
      if (!std::is_same<T, pcl::io::ply::uint8>::value) break;
      has_color_[i] = true;
      const int shift = 16 - 8 * i;
      return [this, shift](T value) {
        vertex_.rgb |= static_cast<std::uint32_t>(static_cast<std::uint8_t>(value)) << shift;
      };
    }
    return [](T) {};
  }

  // PCL writes an organized cloud's size and sensor position into an element "camera".
  template <class T>
  Setter<T> camera_setter(const std::string& name) {
    if (name == "viewportx") return [this](T value) { viewport_[0] = static_cast<double>(value); };
    if (name == "viewporty") return [this](T value) { viewport_[1] = static_cast<double>(value); };
    for (int i = 0; i < 3; ++i) {
      if (name == std::string("view_p") + "xyz"[i])
        return [this, i](T value) { origin_[i] = static_cast<double>(value); };
    }
    return [](T) {};
  }

  // A range_grid lists, pixel by pixel, which vertex was seen there, if any.
  template <class T>
  void take_list(ply_parser::list_property_definition_callbacks_type& callbacks) {
    using Size = pcl::io::ply::uint8;
    using Callbacks = std::tuple<Setter<Size>, Setter<T>, std::function<void()>>;
    ply_parser::at<Size, T>(callbacks) = [this](const std::string& element_name, const std::string&) -> Callbacks {
      if (element_name != "range_grid") return {[](Size) {}, [](T) {}, [] {}};
      return {[](Size) {}, [this](T value) { range_grid_.back() = static_cast<std::int64_t>(value); }, [] {}};
    };
  }

  void check_header() {
    header_done_ = true;
    if (!has_vertices_) fail("it has no element vertex", "a point cloud is needed");
    for (int i = 0; i < 3; ++i) {
      if (!has_coordinate_[i]) fail(std::string("its vertices have no ") + "xyz"[i], "x, y and z are needed");
    }
  }

  void finish_vertex() {
    cloud_.xyz.insert(cloud_.xyz.end(), vertex_.position, vertex_.position + 3);
    if (has_color_[0] && has_color_[1] && has_color_[2]) cloud_.rgb.push_back(vertex_.rgb);
  }

  void arrange() {
    for (int i = 0; i < 3; ++i) {
      if (std::isfinite(origin_[i])) (*cloud_.viewpoint)[i] = origin_[i];
    }
    cloud_.width = static_cast<std::uint32_t>(vertices_);
    cloud_.height = 1;
    if (!range_grid_.empty()) unfold_range_grid();
    const double width = viewport_[0], height = viewport_[1];
    if (width >= 1 && height >= 1 && width * height == static_cast<double>(cloud_.size())) {
      cloud_.width = static_cast<std::uint32_t>(width);
      cloud_.height = static_cast<std::uint32_t>(height);
    }
  }

  void unfold_range_grid() {
    if (grid_size_[0] * grid_size_[1] != range_grid_.size()) return;  // no grid that we know: a list of points
    Cloud grid;
    grid.viewpoint = cloud_.viewpoint;
    grid.width = static_cast<std::uint32_t>(grid_size_[0]);
    grid.height = static_cast<std::uint32_t>(grid_size_[1]);
    grid.xyz.assign(3 * range_grid_.size(), kNan);
    if (!cloud_.rgb.empty()) grid.rgb.assign(range_grid_.size(), 0);
    for (std::size_t i = 0; i < range_grid_.size(); ++i) {
      if (range_grid_[i] < 0) continue;
      const auto vertex = static_cast<std::size_t>(range_grid_[i]);
      if (vertex >= vertices_) {
        fail("its range_grid names vertex " + std::to_string(vertex) + " of " + std::to_string(vertices_),
             "write the file again");
      }
      for (std::size_t k = 0; k < 3; ++k) grid.xyz[3 * i + k] = cloud_.xyz[3 * vertex + k];
      if (!cloud_.rgb.empty()) grid.rgb[i] = cloud_.rgb[vertex];
    }
    cloud_ = std::move(grid);
  }

  struct Vertex {
    float position[3] = {kNan, kNan, kNan};
    std::uint32_t rgb = 0;
  };

  const std::string& path_;
  std::size_t file_size_;
  std::size_t error_line_ = 0;
  bool header_done_ = false, has_vertices_ = false;
  bool has_coordinate_[3] = {}, has_color_[3] = {};
  std::size_t vertices_ = 0;
  Vertex vertex_;
  double viewport_[2] = {}, origin_[3] = {};
  std::size_t grid_size_[2] = {};  // columns, rows: from obj_info
  std::vector<std::int64_t> range_grid_;
  Cloud cloud_;
};

}  // namespace

Cloud read_ply(const std::string& path, std::size_t file_size) {
  const QuietPcl quiet;
  return PlyReader(path, file_size).read();
}

}  // namespace handhold::io
