#include "png_file.h"

#include <png.h>

#include <csetjmp>
#include <cstdio>
#include <stdexcept>

#include "atomic_file.h"

namespace handhold {
namespace {

[[noreturn]] void leave(png_structp png, png_const_charp) {
  png_longjmp(png, 1);
}
void ignore(png_structp, png_const_charp) {}

// libpng leaves by longjmp, which runs no destructors: no object here has one.
bool encode(png_structp png, png_infop info, std::FILE* file, int width, int height, const std::uint8_t* bytes) {
  if (setjmp(png_jmpbuf(png))) return false;
  png_init_io(png, file);
  png_set_IHDR(png, info, static_cast<png_uint_32>(width), static_cast<png_uint_32>(height), 8, PNG_COLOR_TYPE_RGB,
               PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  png_set_sRGB(png, info, PNG_sRGB_INTENT_PERCEPTUAL);
  png_write_info(png, info);
  for (int y = 0; y < height; ++y)
    png_write_row(png, bytes + static_cast<std::size_t>(y) * 3 * static_cast<std::size_t>(width));
  png_write_end(png, info);
  return true;
}

}  // namespace

void write_png(const std::string& path, const Canvas& canvas) {
  const std::vector<std::uint8_t> bytes = canvas.bytes();
  AtomicFile file(path);
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, leave, ignore);
  png_infop info = png ? png_create_info_struct(png) : nullptr;
  const bool done = info && encode(png, info, file.handle(), canvas.width(), canvas.height(), bytes.data());
  png_destroy_write_struct(&png, &info);
  if (!done) throw std::runtime_error("cannot write '" + path + "': libpng failed; the disk must have room");
  file.commit();
}

}  // namespace handhold
