// Pixels in memory with anti-aliased lines and text. Part of picture.cpp.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

#include "font.h"

namespace handhold {

/// 0..1 each, as stored in the file (sRGB): blending by eye needs no more.
struct Color {
  float r = 0, g = 0, b = 0;
};
inline Color mix(const Color& a, const Color& b, float t) {
  return {a.r + (b.r - a.r) * t, a.g + (b.g - a.g) * t, a.b + (b.b - a.b) * t};
}
inline Color scaled(const Color& a, float f) {
  return {a.r * f, a.g * f, a.b * f};
}

struct Segment {
  double x0, y0, x1, y1;  ///< px; the centre of the upper left pixel is (0, 0)
};

class Canvas {
 public:
  Canvas(int width, int height, Color background)
      : width_(width),
        height_(height),
        pixels_(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), background) {}

  int width() const { return width_; }
  int height() const { return height_; }
  Color& at(int x, int y) { return pixels_[index(x, y)]; }

  void blend(int x, int y, const Color& color, float alpha) {
    if (x < 0 || y < 0 || x >= width_ || y >= height_) return;
    Color& pixel = at(x, y);
    pixel = mix(pixel, color, alpha);
  }

  /// Lines of a width (px) with round ends, as one shape: where segments meet or cross nothing is drawn twice.
  void stroke(const std::vector<Segment>& segments, double width, const Color& color, float alpha) {
    const double reach = width / 2 + 0.5;
    int left = width_, right = -1, top = height_, bottom = -1;
    for (const Segment& s : segments) {
      if (!drawable(s)) continue;
      left = std::min(left, pixel(std::min(s.x0, s.x1) - reach, width_));
      right = std::max(right, pixel(std::max(s.x0, s.x1) + reach, width_));
      top = std::min(top, pixel(std::min(s.y0, s.y1) - reach, height_));
      bottom = std::max(bottom, pixel(std::max(s.y0, s.y1) + reach, height_));
    }
    if (right < left || bottom < top) return;
    const int columns = right - left + 1;
    coverage_.assign(static_cast<std::size_t>(columns) * static_cast<std::size_t>(bottom - top + 1), 0.0f);
    for (const Segment& s : segments) {
      if (!drawable(s)) continue;
      const double dx = s.x1 - s.x0, dy = s.y1 - s.y0, length2 = dx * dx + dy * dy;
      for (int y = pixel(std::min(s.y0, s.y1) - reach, height_); y <= pixel(std::max(s.y0, s.y1) + reach, height_);
           ++y) {
        for (int x = pixel(std::min(s.x0, s.x1) - reach, width_); x <= pixel(std::max(s.x0, s.x1) + reach, width_);
             ++x) {
          const double t = length2 > 0 ? std::clamp(((x - s.x0) * dx + (y - s.y0) * dy) / length2, 0.0, 1.0) : 0.0;
          const double distance = std::hypot(x - s.x0 - t * dx, y - s.y0 - t * dy);
          float& covered = coverage_[static_cast<std::size_t>((y - top) * columns + x - left)];
          covered = std::max(covered, static_cast<float>(std::clamp(reach - distance, 0.0, 1.0)));
        }
      }
    }
    for (int y = top; y <= bottom; ++y) {
      for (int x = left; x <= right; ++x) {
        const float covered = coverage_[static_cast<std::size_t>((y - top) * columns + x - left)];
        if (covered > 0) blend(x, y, color, alpha * covered);
      }
    }
  }

  void fill(int x0, int y0, int x1, int y1, const Color& color, float alpha) {
    for (int y = std::max(y0, 0); y < std::min(y1, height_); ++y) {
      for (int x = std::max(x0, 0); x < std::min(x1, width_); ++x) blend(x, y, color, alpha);
    }
  }

  /// Another canvas with its upper left corner at (x0, y0); what does not fit is cut off.
  void paste(const Canvas& other, int x0, int y0) {
    for (int y = std::max(0, -y0); y < std::min(other.height_, height_ - y0); ++y) {
      for (int x = std::max(0, -x0); x < std::min(other.width_, width_ - x0); ++x) {
        at(x0 + x, y0 + y) = other.pixels_[other.index(x, y)];
      }
    }
  }

  /// Text with its upper left corner at (x0, y0) and a halo of `halo` px in the background's colour.
  void text(std::string_view line, int x0, int y0, int scale, const Color& color, int halo, const Color& background) {
    const int width = text_width(line, scale), height = kGlyphHeight * scale;
    for (int y = -halo; halo > 0 && y < height + halo; ++y) {
      for (int x = -halo; x < width + halo; ++x) {
        float nearest = static_cast<float>(halo) + 1;
        for (int v = -halo; v <= halo; ++v) {
          for (int u = -halo; u <= halo; ++u) {
            if (text_covers(line, scale, x + u, y + v)) nearest = std::min(nearest, std::hypot(float(u), float(v)));
          }
        }
        blend(x0 + x, y0 + y, background, 0.85f * std::clamp(static_cast<float>(halo) + 0.7f - nearest, 0.0f, 1.0f));
      }
    }
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        if (text_covers(line, scale, x, y)) blend(x0 + x, y0 + y, color, 1);
      }
    }
  }

  /// Rows from the top, three bytes a pixel.
  std::vector<std::uint8_t> bytes() const {
    std::vector<std::uint8_t> out;
    out.reserve(3 * pixels_.size());
    for (const Color& c : pixels_) {
      for (float value : {c.r, c.g, c.b})
        out.push_back(static_cast<std::uint8_t>(std::clamp(value, 0.0f, 1.0f) * 255 + 0.5f));
    }
    return out;
  }

 private:
  std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x);
  }
  static bool drawable(const Segment& s) { return std::isfinite(s.x0 + s.y0 + s.x1 + s.y1); }
  static int pixel(double value, int size) { return static_cast<int>(std::clamp(std::round(value), 0.0, size - 1.0)); }

  int width_, height_;
  std::vector<Color> pixels_;
  std::vector<float> coverage_;  // scratch of stroke()
};

}  // namespace handhold
