// A small bitmap font for pictures that must not depend on fonts of the system.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

namespace handhold {

constexpr int kGlyphWidth = 5;    ///< px
constexpr int kGlyphHeight = 8;   ///< px; capitals stand on the seventh row, the eighth is for descenders
constexpr int kGlyphAdvance = 6;  ///< px from one character to the next

/// Rows of a printable ASCII character from the top; bit 4 is the leftmost pixel. A box for all other characters.
const std::array<std::uint8_t, kGlyphHeight>& glyph(char character);

/// Whether the text, set at (0, 0) and magnified by a whole number, covers pixel (x, y).
bool text_covers(std::string_view text, int scale, int x, int y);

/// Width of a text in pixels, without the gap after the last character.
inline int text_width(std::string_view text, int scale) {
  return text.empty() ? 0 : (static_cast<int>(text.size()) * kGlyphAdvance - (kGlyphAdvance - kGlyphWidth)) * scale;
}

}  // namespace handhold
