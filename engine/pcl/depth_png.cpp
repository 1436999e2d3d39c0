#include <png.h>

#include <cmath>
#include <csetjmp>
#include <cstdio>
#include <cstring>
#include <limits>
#include <new>

#include "file.h"
#include "handhold/io.h"

namespace handhold {
namespace {

struct Input {
  const unsigned char* data;
  std::size_t size, offset;
  char error[160];
};

void take(png_structp png, png_bytep out, std::size_t count) {
  auto* input = static_cast<Input*>(png_get_io_ptr(png));
  if (count > input->size - input->offset) png_error(png, "the file is truncated");
  std::memcpy(out, input->data + input->offset, count);
  input->offset += count;
}

[[noreturn]] void remember_error(png_structp png, png_const_charp message) {
  auto* input = static_cast<Input*>(png_get_error_ptr(png));
  std::snprintf(input->error, sizeof input->error, "%s", message);
  png_longjmp(png, 1);
}

void ignore_warning(png_structp, png_const_charp) {}

struct Image {
  png_uint_32 width = 0, height = 0;
  int depth = 0, color = 0;
};

// libpng leaves its functions by longjmp, which runs no destructors: these two hold no objects that have one.
bool read_header(png_structp png, png_infop info, Image* image) {
  if (setjmp(png_jmpbuf(png))) return false;
  png_read_info(png, info);
  image->width = png_get_image_width(png, info);
  image->height = png_get_image_height(png, info);
  image->depth = png_get_bit_depth(png, info);
  image->color = png_get_color_type(png, info);
  return true;
}

bool read_rows(png_structp png, png_infop info, png_bytep* rows) {
  if (setjmp(png_jmpbuf(png))) return false;
  png_set_interlace_handling(png);
  png_read_update_info(png, info);
  png_read_image(png, rows);
  png_read_end(png, nullptr);
  return true;
}

const char* color_name(int color) {
  switch (color) {
    case PNG_COLOR_TYPE_GRAY:
      return "gray";
    case PNG_COLOR_TYPE_GRAY_ALPHA:
      return "gray with alpha";
    case PNG_COLOR_TYPE_PALETTE:
      return "palette";
    case PNG_COLOR_TYPE_RGB:
      return "colour";
    default:
      return "colour with alpha";
  }
}

class PngReader {
 public:
  explicit PngReader(const std::string& bytes)
      : input_{reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size(), 0, {}},
        png_(png_create_read_struct(PNG_LIBPNG_VER_STRING, &input_, remember_error, ignore_warning)),
        info_(png_ ? png_create_info_struct(png_) : nullptr) {
    if (!info_) {
      png_destroy_read_struct(&png_, nullptr, nullptr);
      throw std::bad_alloc();
    }
    png_set_read_fn(png_, &input_, take);
  }
  ~PngReader() { png_destroy_read_struct(&png_, &info_, nullptr); }
  PngReader(const PngReader&) = delete;
  PngReader& operator=(const PngReader&) = delete;

  bool header(Image* image) { return read_header(png_, info_, image); }
  bool rows(png_bytep* rows) { return read_rows(png_, info_, rows); }
  std::string error() const { return input_.error; }

 private:
  Input input_;
  png_structp png_;
  png_infop info_;
};

void need_positive(double value, const char* name, const std::string& path) {
  if (std::isfinite(value) && value > 0) return;
  throw IoError(std::string(name) + " = " + std::to_string(value) + " for the depth image " + path +
                ": a finite number above 0 is needed");
}

/// PNG is big-endian.
std::vector<std::uint16_t> values_of(const std::vector<unsigned char>& pixels) {
  std::vector<std::uint16_t> values(pixels.size() / 2);
  for (std::size_t i = 0; i < values.size(); ++i) {
    values[i] = static_cast<std::uint16_t>(pixels[2 * i] << 8 | pixels[2 * i + 1]);
  }
  return values;
}

}  // namespace

Cloud cloud_of_depth(const std::vector<std::uint16_t>& values, std::uint32_t width, const Intrinsics& k,
                     double depth_unit_m) {
  Cloud cloud;
  cloud.width = width;
  cloud.height = width == 0 ? 0 : static_cast<std::uint32_t>(values.size() / width);
  cloud.xyz.assign(3 * cloud.size(), std::numeric_limits<float>::quiet_NaN());
  for (std::size_t v = 0, i = 0; v < cloud.height; ++v) {
    for (std::size_t u = 0; u < cloud.width; ++u, ++i) {
      if (values[i] == 0) continue;
      const double z = values[i] * depth_unit_m;
      cloud.xyz[3 * i] = static_cast<float>((static_cast<double>(u) - k.cx) / k.fx * z);
      cloud.xyz[3 * i + 1] = static_cast<float>((static_cast<double>(v) - k.cy) / k.fy * z);
      cloud.xyz[3 * i + 2] = static_cast<float>(z);
    }
  }
  return cloud;
}

Cloud read_depth_png(const std::string& path, const Intrinsics& intrinsics, double depth_unit_m) {
  need_positive(intrinsics.fx, "fx", path);
  need_positive(intrinsics.fy, "fy", path);
  need_positive(depth_unit_m, "the depth unit", path);
  if (!std::isfinite(intrinsics.cx) || !std::isfinite(intrinsics.cy)) {
    throw IoError("cx or cy is not finite for the depth image " + path + ": the principal point in pixels is needed");
  }

  const std::string bytes = io::read_bytes(path, io::checked_file_size(path));
  if (bytes.compare(0, 8, "\x89PNG\r\n\x1a\n") != 0) {
    throw IoError("cannot read " + path + ": it is no PNG; a depth image is a 16-bit gray PNG");
  }
  PngReader reader(bytes);
  Image image;
  const auto fail = [&] {
    throw IoError("cannot read " + path + ": libpng says '" + reader.error() + "'; write the image again");
  };
  if (!reader.header(&image)) fail();
  if (image.color != PNG_COLOR_TYPE_GRAY || image.depth != 16) {
    throw IoError("cannot read " + path + " as a depth image: it is " + std::to_string(image.depth) + "-bit " +
                  color_name(image.color) + "; 16-bit gray is needed");
  }
  const std::size_t row_bytes = 2 * static_cast<std::size_t>(image.width);
  // Deflate shrinks to 1/1032 at best: a header that promises more would only cost memory.
  if (row_bytes * image.height / 1032 > bytes.size()) {
    throw IoError("cannot read " + path + ": " + std::to_string(image.width) + " x " + std::to_string(image.height) +
                  " pixels cannot stand in " + std::to_string(bytes.size()) + " bytes; write the image again");
  }
  try {
    std::vector<unsigned char> pixels(row_bytes * image.height);
    std::vector<png_bytep> rows(image.height);
    for (std::size_t v = 0; v < rows.size(); ++v) rows[v] = pixels.data() + v * row_bytes;
    if (!reader.rows(rows.data())) fail();
    return cloud_of_depth(values_of(pixels), image.width, intrinsics, depth_unit_m);
  } catch (const std::bad_alloc&) {
    throw IoError("not enough memory to read " + path + ": use a smaller image");
  }
}

}  // namespace handhold
