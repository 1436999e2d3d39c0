// Bars and lines with axes, ticks and a legend, as pixels: for figures that must not depend on other programs.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "canvas.h"

namespace handhold {

struct PlotSeries {
  std::string name;
  Color color;
  std::vector<double> x;      ///< of lines, ascending; bars have none: bar i stands in group i
  std::vector<double> y;      ///< NaN: nothing there
  std::vector<double> error;  ///< half the length of the error bar at each y; empty: none
};

/// A figure of its own in a plot. Texts are printable ASCII.
struct PlotPanel {
  std::string title, x_label, y_label;
  std::vector<PlotSeries> series;
  std::vector<std::string> groups;  ///< names under groups of bars; empty: lines with points
  std::vector<double> marks;        ///< of each group of bars, a line across it; empty: none
  std::string marks_name;
  std::optional<double> highest;  ///< upper end of the y axis, which begins at 0; otherwise what is shown decides
};

/// Values to pixels, linearly.
struct PlotScale {
  double low = 0, high = 1;  ///< values; low < high
  double from_px = 0, to_px = 1;

  double operator()(double value) const { return from_px + (value - low) / (high - low) * (to_px - from_px); }
};

/// Multiples of 1, 2 or 5 times a power of ten from `low` to `high` (low < high), as many as possible up to `most` > 1.
std::vector<double> plot_ticks(double low, double high, int most);

/// "0.25", "20": as few digits as tell ticks apart that are `step` from each other.
std::string tick_label(double value, double step);

/// Size of one panel (px).
constexpr int kPanelWidth = 860, kPanelHeight = 420;

/// Where the area inside the axes of panel i lies (px): left, top, right, bottom.
std::array<int, 4> plot_area(std::size_t panel, int columns);

/// The panels row by row, `columns` > 0 of them side by side. The same input gives the same pixels.
Canvas draw_plot(const std::vector<PlotPanel>& panels, int columns);

}  // namespace handhold
