// Figures: scales, ticks, and the pixels of bars and lines; and the statistics that they show.
#include "plot.h"

#include <gtest/gtest.h>

#include <cmath>

#include "statistics.h"

namespace handhold {
namespace {

using Values = std::vector<double>;

constexpr Color kRed{1, 0, 0}, kBlue{0, 0, 1};

bool is(const Color& a, const Color& b) {
  return std::abs(a.r - b.r) + std::abs(a.g - b.g) + std::abs(a.b - b.b) < 0.02f;
}

TEST(Statistics, MeanDeviationAndQuantile) {
  EXPECT_EQ(mean({}), 0);
  EXPECT_DOUBLE_EQ(mean({2, 4, 9}), 5);
  EXPECT_EQ(standard_deviation({}), 0);
  EXPECT_EQ(standard_deviation({3}), 0);
  EXPECT_DOUBLE_EQ(standard_deviation({2, 4, 4, 4, 5, 5, 7, 9}), std::sqrt(32.0 / 7)) << "n - 1";
  Values values;
  for (int i = 100; i >= 0; --i) values.push_back(i);
  EXPECT_EQ(quantile(values, 0.5), 50);
  EXPECT_EQ(quantile(values, 0.9), 90);
  EXPECT_EQ(quantile(values, 0), 0);
  EXPECT_EQ(quantile(values, 1), 100);
}

TEST(PlotTicks, AreRoundAndAsManyAsAllowed) {
  const auto expect_ticks = [](double low, double high, int most, const Values& expected) {
    const Values ticks = plot_ticks(low, high, most);
    ASSERT_EQ(ticks.size(), expected.size()) << low << " to " << high;
    for (std::size_t i = 0; i < ticks.size(); ++i) EXPECT_NEAR(ticks[i], expected[i], 1e-12 * high);
  };
  expect_ticks(0, 1, 6, {0, 0.2, 0.4, 0.6, 0.8, 1});
  expect_ticks(0, 1, 5, {0, 0.5, 1});
  expect_ticks(0, 11.5, 7, {0, 2, 4, 6, 8, 10});
  expect_ticks(0, 0.0037, 8, {0, 0.0005, 0.001, 0.0015, 0.002, 0.0025, 0.003, 0.0035});
  expect_ticks(0, 4200, 5, {0, 1000, 2000, 3000, 4000});
  expect_ticks(13, 27, 4, {15, 20, 25});
  for (double high = 1e-6; high < 1e6; high *= 1.37) {
    const Values ticks = plot_ticks(0, high, 7);
    EXPECT_LE(ticks.size(), 7u);
    EXPECT_GE(ticks.size(), 3u) << high;
    EXPECT_LE(ticks.back(), high * (1 + 1e-9));
    EXPECT_FALSE(std::signbit(ticks.front())) << "-0";
  }
}

TEST(PlotTicks, LabelsTellThemApart) {
  EXPECT_EQ(tick_label(0.2, 0.2), "0.2");
  EXPECT_EQ(tick_label(1, 0.2), "1.0");
  EXPECT_EQ(tick_label(20, 10), "20");
  EXPECT_EQ(tick_label(3, 1), "3");
  EXPECT_EQ(tick_label(0.25, 0.05), "0.25");
  EXPECT_EQ(tick_label(0.25, 0), "0.25") << "on its own";
}

TEST(PlotScale, IsLinear) {
  const PlotScale scale{10, 20, 100, 300};
  EXPECT_DOUBLE_EQ(scale(10), 100);
  EXPECT_DOUBLE_EQ(scale(20), 300);
  EXPECT_DOUBLE_EQ(scale(12.5), 150);
  const PlotScale up{0, 4, 400, 0};  // as pixels grow downwards
  EXPECT_DOUBLE_EQ(up(1), 300);
}

/// Two groups of two series on an axis up to 10.
PlotPanel bars() {
  PlotPanel panel;
  panel.title = "bars";
  panel.groups = {"a", "b"};
  panel.series = {{"red", kRed, {}, {5, 2}, {}}, {"blue", kBlue, {}, {10, std::nan("")}, {}}};
  panel.highest = 10;
  return panel;
}

TEST(Plot, BarsStandInTheirGroupsAndEndAtTheirValues) {
  Canvas canvas = draw_plot({bars()}, 1);
  EXPECT_EQ(canvas.width(), kPanelWidth);
  EXPECT_EQ(canvas.height(), kPanelHeight);
  const auto [left, top, right, bottom] = plot_area(0, 1);
  const int group = (right - left) / 2, height = bottom - top;
  // A bar's middle: the first of two takes 0.1 to 0.5 of the group.
  const auto x = [&, first = left](int g, int series) {
    return first + static_cast<int>(group * (g + 0.1 + 0.4 * series + 0.2));
  };
  const auto y = [&, floor = bottom](double share) { return floor - static_cast<int>(share * height); };
  EXPECT_TRUE(is(canvas.at(x(0, 0), y(0.49)), kRed));
  EXPECT_FALSE(is(canvas.at(x(0, 0), y(0.52)), kRed));
  EXPECT_TRUE(is(canvas.at(x(1, 0), y(0.19)), kRed));
  EXPECT_FALSE(is(canvas.at(x(1, 0), y(0.22)), kRed));
  EXPECT_TRUE(is(canvas.at(x(0, 1), y(0.98)), kBlue));
  for (double share = 0.05; share < 1; share += 0.1) EXPECT_FALSE(is(canvas.at(x(1, 1), y(share)), kBlue)) << "NaN";
}

TEST(Plot, ErrorBarsAndMarks) {
  const auto [left, top, right, bottom] = plot_area(0, 1);
  const int group = (right - left) / 2, height = bottom - top;
  PlotPanel panel = bars();
  Canvas plain = draw_plot({panel}, 1);
  panel.series[0].error = {2, 0};
  Canvas error = draw_plot({panel}, 1);
  const int x = left + static_cast<int>(group * 0.3);
  const auto changed = [&](Canvas& canvas, int px, int py) {
    for (int dx = -1; dx <= 1; ++dx) {
      if (!is(canvas.at(px + dx, py), plain.at(px + dx, py))) return true;
    }
    return false;
  };
  EXPECT_TRUE(changed(error, x, bottom - height * 4 / 10)) << "5 - 2 to 5 + 2";
  EXPECT_TRUE(changed(error, x, bottom - height * 65 / 100));
  EXPECT_FALSE(changed(error, x, bottom - height * 2 / 10));
  EXPECT_FALSE(changed(error, x, bottom - height * 8 / 10));
  EXPECT_FALSE(changed(error, x + group, bottom - height * 25 / 100)) << "no error, no bar";

  panel = bars();
  panel.marks = {7, 3};
  panel.marks_name = "there";
  Canvas marks = draw_plot({panel}, 1);
  EXPECT_TRUE(changed(marks, left + group / 5, bottom - height * 7 / 10));
  EXPECT_TRUE(changed(marks, left + group + group / 5, bottom - height * 3 / 10));
  EXPECT_FALSE(changed(marks, left + group + group / 5, bottom - height * 7 / 10));
}

TEST(Plot, LinesJoinTheirPoints) {
  PlotPanel panel;
  panel.series = {{"red", kRed, {0, 1, 2}, {0, 1, std::nan("")}, {}}};
  panel.highest = 1;
  Canvas canvas = draw_plot({panel, panel}, 2);
  EXPECT_EQ(canvas.width(), 2 * kPanelWidth);
  for (const std::size_t i : {std::size_t{0}, std::size_t{1}}) {
    const auto [left, top, right, bottom] = plot_area(i, 2);
    // x reaches from 0 to 1 as it is shown: NaN is nowhere. 6 % are left free at both ends.
    const PlotScale x{-0.06, 1.06, 1.0 * left, 1.0 * right}, y{0, 1, 1.0 * bottom, 1.0 * top};
    for (const double value : {0.1, 0.5, 0.9}) {
      const int px = static_cast<int>(std::lround(x(value))), py = static_cast<int>(std::lround(y(value)));
      EXPECT_GT(canvas.at(px, py).r, canvas.at(px, py).g + 0.3f) << value;
      EXPECT_FALSE(canvas.at(px, py - 30).r > canvas.at(px, py - 30).g + 0.3f) << value;
    }
  }
}

TEST(Plot, NothingToShowIsAnEmptyFigure) {
  PlotPanel panel;
  panel.series = {{"none", kRed, {}, {}, {}}};
  EXPECT_EQ(draw_plot({panel}, 1).height(), kPanelHeight);
  panel.groups = {"a"};
  panel.series[0].y = {std::nan("")};
  EXPECT_EQ(draw_plot({panel}, 1).bytes(), draw_plot({panel}, 1).bytes());
  EXPECT_EQ(draw_plot({}, 1).height(), kPanelHeight);
}

}  // namespace
}  // namespace handhold
