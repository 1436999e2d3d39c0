#include "plot.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace handhold {
namespace {

constexpr Color kPaper{1, 1, 1}, kInk{0.13f, 0.14f, 0.16f}, kGrid{0.87f, 0.88f, 0.90f};
constexpr int kScale = 2, kText = kGlyphHeight * kScale, kLine = kText + 8;  // px
constexpr int kLeft = 70, kRight = 24, kTop = 24 + 2 * kLine, kBottom = 20 + 2 * kLine;
constexpr int kMostTicks = 7;

class Panel {
 public:
  Panel(Canvas& canvas, const PlotPanel& panel, const std::array<int, 4>& area)
      : canvas_(canvas),
        panel_(panel),
        x0_(area[0] - kLeft),
        y0_(area[1] - kTop),
        left_(area[0]),
        top_(area[1]),
        right_(area[2]),
        bottom_(area[3]) {
    find_ranges();
  }

  void draw() {
    text(panel_.title, left_, y0_ + 10);
    draw_legend();
    draw_axes();
    if (panel_.groups.empty()) {
      draw_lines();
    } else {
      draw_bars();
    }
    canvas_.stroke({{1.0 * left_, 1.0 * top_, 1.0 * left_, 1.0 * bottom_},
                    {1.0 * left_, 1.0 * bottom_, 1.0 * right_, 1.0 * bottom_}},
                   1.6, kInk, 1);
  }

 private:
  bool bars() const { return !panel_.groups.empty(); }

  void text(const std::string& line, int x, int y) { canvas_.text(line, x, y, kScale, kInk, 0, kPaper); }
  void centred(const std::string& line, double x, int y) {
    text(line, static_cast<int>(std::lround(x)) - text_width(line, kScale) / 2, y);
  }

  void find_ranges() {
    double high = 0, low_x = HUGE_VAL, high_x = -HUGE_VAL;
    for (const PlotSeries& series : panel_.series) {
      for (std::size_t i = 0; i < series.y.size(); ++i) {
        if (!std::isfinite(series.y[i])) continue;
        high = std::max(high, series.y[i] + (i < series.error.size() ? series.error[i] : 0));
        if (i < series.x.size()) low_x = std::min(low_x, series.x[i]), high_x = std::max(high_x, series.x[i]);
      }
    }
    for (const double mark : panel_.marks) high = std::max(high, mark);
    if (!(high > 0)) high = 1;
    ticks_y_ = plot_ticks(0, panel_.highest.value_or(1.05 * high), kMostTicks);
    y_ = {0, panel_.highest.value_or(1.05 * high), 1.0 * bottom_, 1.0 * top_};
    if (bars()) {
      x_ = {0, static_cast<double>(panel_.groups.size()), 1.0 * left_, 1.0 * right_};
      return;
    }
    if (!(low_x <= high_x)) low_x = 0, high_x = 1;
    const double margin = high_x > low_x ? 0.06 * (high_x - low_x) : 0.5;
    x_ = {low_x - margin, high_x + margin, 1.0 * left_, 1.0 * right_};
  }

  void draw_axes() {
    const double step = ticks_y_.size() > 1 ? ticks_y_[1] - ticks_y_[0] : y_.high;
    for (const double tick : ticks_y_) {
      const double y = y_(tick);
      if (tick > 0) canvas_.stroke({{1.0 * left_, y, 1.0 * right_, y}}, 1, kGrid, 1);
      const std::string label = tick_label(tick, step);
      text(label, left_ - 8 - text_width(label, kScale), static_cast<int>(std::lround(y)) - kText / 2);
    }
    text(panel_.y_label, x0_ + 6, top_ - kLine - 8);
    centred(panel_.x_label, (left_ + right_) / 2.0, bottom_ + kLine + 4);
    if (bars()) {
      for (std::size_t i = 0; i < panel_.groups.size(); ++i) {
        centred(panel_.groups[i], x_(static_cast<double>(i) + 0.5), bottom_ + 8);
      }
      return;
    }
    for (const double tick : ticks_x()) {
      canvas_.stroke({{x_(tick), 1.0 * bottom_, x_(tick), bottom_ + 5.0}}, 1.6, kInk, 1);
      centred(tick_label(tick, 0), x_(tick), bottom_ + 8);
    }
  }

  /// Where something was measured.
  std::vector<double> ticks_x() const {
    std::vector<double> ticks;
    for (const PlotSeries& series : panel_.series) ticks.insert(ticks.end(), series.x.begin(), series.x.end());
    std::sort(ticks.begin(), ticks.end());
    ticks.erase(std::unique(ticks.begin(), ticks.end()), ticks.end());
    return ticks;
  }

  /// At the right end of the title's line, where the title leaves room, otherwise of the next one.
  void draw_legend() {
    struct Entry {
      std::string name;
      Color color;
      bool mark;
    };
    std::vector<Entry> entries;
    for (const PlotSeries& series : panel_.series) entries.push_back({series.name, series.color, false});
    if (!panel_.marks.empty()) entries.push_back({panel_.marks_name, kInk, true});
    constexpr int kSwatch = 26, kGap = 22;
    int width = -kGap;
    for (const Entry& entry : entries) width += kSwatch + text_width(entry.name, kScale) + kGap;
    int x = right_ - width;
    const int y = y0_ + 10 + (x < left_ + text_width(panel_.title, kScale) + kGap ? kLine : 0);
    for (const Entry& entry : entries) {
      const double middle = y + kText / 2.0 - 1;
      if (bars() && !entry.mark) {
        canvas_.fill(x, y, x + 16, y + kText - 2, entry.color, 1);
      } else {
        canvas_.stroke({{1.0 * x, middle, x + 18.0, middle}}, 3, entry.color, 1);
      }
      text(entry.name, x + kSwatch, y);
      x += kSwatch + text_width(entry.name, kScale) + kGap;
    }
  }

  void draw_error(double x, double y, double error, const Color& color) {
    if (!(error > 0)) return;
    const double low = y_(std::max(0.0, y - error)), high = std::max(1.0 * top_, y_(y + error)), cap = 4;
    canvas_.stroke({{x, low, x, high}, {x - cap, high, x + cap, high}, {x - cap, low, x + cap, low}}, 1.6, color, 1);
  }

  void draw_bars() {
    const double share = 0.8 / static_cast<double>(std::max<std::size_t>(1, panel_.series.size()));
    for (std::size_t s = 0; s < panel_.series.size(); ++s) {
      const PlotSeries& series = panel_.series[s];
      for (std::size_t i = 0; i < std::min(series.y.size(), panel_.groups.size()); ++i) {
        if (!std::isfinite(series.y[i])) continue;
        const double from = static_cast<double>(i) + 0.1 + share * static_cast<double>(s);
        const int left = static_cast<int>(std::lround(x_(from))) + 1;
        const int right = static_cast<int>(std::lround(x_(from + share))) - 1;
        canvas_.fill(left, static_cast<int>(std::lround(std::max(1.0 * top_, y_(series.y[i])))), right, bottom_,
                     series.color, 1);
        if (i < series.error.size()) draw_error((left + right - 1) / 2.0, series.y[i], series.error[i], kInk);
      }
    }
    for (std::size_t i = 0; i < std::min(panel_.marks.size(), panel_.groups.size()); ++i) {
      const double y = y_(panel_.marks[i]);
      canvas_.stroke({{x_(static_cast<double>(i) + 0.08), y, x_(static_cast<double>(i) + 0.92), y}}, 3, kInk, 1);
    }
  }

  void draw_lines() {
    for (const PlotSeries& series : panel_.series) {
      std::vector<Segment> line;
      const auto shown = [&](std::size_t i) { return std::isfinite(series.y[i]); };
      const auto height = [&](std::size_t i) { return std::max(1.0 * top_, y_(series.y[i])); };
      const std::size_t count = std::min(series.x.size(), series.y.size());
      for (std::size_t i = 0; i + 1 < count; ++i) {
        if (shown(i) && shown(i + 1)) line.push_back({x_(series.x[i]), height(i), x_(series.x[i + 1]), height(i + 1)});
      }
      canvas_.stroke(line, 2.4, series.color, 1);
      for (std::size_t i = 0; i < count; ++i) {
        if (!shown(i)) continue;
        const double x = x_(series.x[i]), y = height(i);
        canvas_.stroke({{x, y, x, y}}, 9, series.color, 1);
        if (i < series.error.size()) draw_error(x, series.y[i], series.error[i], series.color);
      }
    }
  }

  Canvas& canvas_;
  const PlotPanel& panel_;
  int x0_, y0_, left_, top_, right_, bottom_;
  PlotScale x_, y_;
  std::vector<double> ticks_y_;
};

}  // namespace

std::vector<double> plot_ticks(double low, double high, int most) {
  std::vector<double> ticks;
  for (double power = std::pow(10, std::floor(std::log10((high - low) / most)));; power *= 10) {
    for (const double factor : {1.0, 2.0, 5.0}) {
      const double step = factor * power, slack = 1e-9 * step;
      const double first = std::ceil((low - slack) / step), last = std::floor((high + slack) / step);
      if (last - first + 1 > most) continue;
      for (double k = first; k <= last; ++k) ticks.push_back(k * step + 0.0);  // no -0
      return ticks;
    }
  }
}

std::string tick_label(double value, double step) {
  char text[32];
  if (step > 0) {
    std::snprintf(text, sizeof text, "%.*f", std::max(0, static_cast<int>(-std::floor(std::log10(step) + 1e-9))),
                  value);
  } else {
    std::snprintf(text, sizeof text, "%.4g", value);
  }
  return text;
}

std::array<int, 4> plot_area(std::size_t panel, int columns) {
  const int x = static_cast<int>(panel % static_cast<std::size_t>(columns)) * kPanelWidth;
  const int y = static_cast<int>(panel / static_cast<std::size_t>(columns)) * kPanelHeight;
  return {x + kLeft, y + kTop, x + kPanelWidth - kRight, y + kPanelHeight - kBottom};
}

Canvas draw_plot(const std::vector<PlotPanel>& panels, int columns) {
  const int rows =
      static_cast<int>((panels.size() + static_cast<std::size_t>(columns) - 1) / static_cast<std::size_t>(columns));
  Canvas canvas(columns * kPanelWidth, std::max(1, rows) * kPanelHeight, kPaper);
  for (std::size_t i = 0; i < panels.size(); ++i) {
    Panel(canvas, panels[i], plot_area(i, columns)).draw();
  }
  return canvas;
}

}  // namespace handhold
