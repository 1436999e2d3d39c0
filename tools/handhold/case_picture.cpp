#include "case_picture.h"

#include <algorithm>
#include <cmath>

#include "painter.h"
#include "png_file.h"

namespace handhold {
namespace {

constexpr int kWidth = 640, kHeight = 480, kScale = 2, kPadding = 6, kLine = (kGlyphHeight + 3) * kScale;  // px
constexpr Color kSubject{1.0f, 0.25f, 0.95f}, kOther{0.95f, 0.95f, 0.95f}, kWrong{1.0f, 0.15f, 0.12f};
constexpr double kMostMagnified = 12;

/// Lines of at most `columns` characters, broken at blanks.
std::vector<std::string> wrapped(const std::string& text, std::size_t columns) {
  std::vector<std::string> lines;
  std::size_t at = 0;
  while (at < text.size()) {
    std::size_t end = std::min(text.size(), at + columns);
    if (end < text.size()) {
      const std::size_t blank = text.rfind(' ', end);
      if (blank != std::string::npos && blank > at) end = blank;
    }
    lines.push_back(text.substr(at, end - at));
    at = end;
    while (at < text.size() && text[at] == ' ') ++at;
  }
  return lines;
}

void draw(Painter& painter, const Result& result, const CasePicture& picture) {
  for (const Affordance& affordance : result.affordances) painter.draw_affordance(affordance);
  for (const bool subject : {false, true}) {
    for (const TruthMark& mark : picture.parts) {
      if (mark.subject == subject) painter.draw_tube(mark.centre_line, mark.radius, subject ? kSubject : kOther);
    }
  }
  const auto color = [&](std::size_t i) { return picture.handle == i ? kWrong : handle_color(i); };
  for (std::size_t i = result.handles.size(); i-- > 0;) painter.draw_handle(result.handles[i], color(i));
  for (std::size_t i = 0; i < result.handles.size(); ++i) {
    painter.draw_number(result.handles[i], std::to_string(i + 1), color(i));
  }
}

/// Frame about what the enlarged view shows.
void draw_frame(Canvas& canvas, double u, double v, double magnified) {
  const double x = kWidth / (2 * magnified), y = kHeight / (2 * magnified);
  canvas.stroke({{u - x, v - y, u + x, v - y},
                 {u + x, v - y, u + x, v + y},
                 {u + x, v + y, u - x, v + y},
                 {u - x, v + y, u - x, v - y}},
                1.5, kOther, 0.9f);
}

}  // namespace

CasePainter::CasePainter(const CloudView& cloud, const std::vector<std::uint32_t>& rgb, const Result& result)
    : cloud_(cloud), rgb_(rgb), result_(result), whole_(std::make_unique<Painter>(cloud, rgb, Size{kWidth, kHeight})) {}
CasePainter::~CasePainter() = default;

void CasePainter::write(const std::string& path, const CasePicture& picture) const {
  const std::vector<std::string> lines =
      wrapped(picture.caption, static_cast<std::size_t>((2 * kWidth - 2 * kPadding) / (kGlyphAdvance * kScale)));
  Canvas page(2 * kWidth, kHeight + 2 * kPadding + kLine * static_cast<int>(lines.size()), kInk);

  Painter whole = *whole_;
  draw(whole, result_, picture);
  page.paste(whole.canvas(), 0, 0);
  double u, v, z;
  if (whole.view() && whole.view()->project(picture.focus, u, v, z)) {
    // The same camera with a longer lens, turned to the focus by shifting the image.
    const double shown = norm(whole.view()->a_across()) * 2 * picture.extent / z;  // px
    const double magnified = std::clamp(kHeight / std::max(shown, 1.0), 1.0, kMostMagnified);
    Projection view = *whole.view();
    view.a = add(add({0, 0, 0}, add(view.a, view.c, -u), magnified), view.c, (kWidth - 1) / 2.0);
    view.b = add(add({0, 0, 0}, add(view.b, view.c, -v), magnified), view.c, (kHeight - 1) / 2.0);
    Painter place(cloud_, rgb_, Size{kWidth, kHeight}, view);
    draw(place, result_, picture);
    draw_frame(page, u, v, magnified);
    page.paste(place.canvas(), kWidth, 0);
  }
  page.fill(0, kHeight, page.width(), page.height(), kInk, 1);  // the frame may reach below the view
  for (std::size_t i = 0; i < lines.size(); ++i) {
    page.text(lines[i], kPadding, kHeight + kPadding + static_cast<int>(i) * kLine, kScale, kText, 0, kInk);
  }
  write_png(path, page);
}

}  // namespace handhold
