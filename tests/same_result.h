// Whether two results are the same to the bit.
#pragma once

#include <gtest/gtest.h>

#include <vector>

#include "handhold/result.h"

namespace handhold::test {

/// Everything but the times, bit by bit.
inline void expect_same(const Result& a, const Result& b) {
  EXPECT_EQ(a.status, b.status);
  EXPECT_EQ(a.points, b.points);
  EXPECT_EQ(a.finite_points, b.finite_points);
  const auto counts = [](const Funnel& f) {
    return std::vector<std::int64_t>{f.samples,     f.too_few_points, f.flat,           f.curvature_low,
                                     f.concave,     f.circle_wide,    f.circle_narrow,  f.poor_fit,
                                     f.no_gap,      f.shell_empty,    f.affordances,    f.not_aligned,
                                     f.unconfirmed, f.too_short,      f.low_confidence, f.in_handles};
  };
  EXPECT_EQ(counts(a.funnel), counts(b.funnel));
  ASSERT_EQ(a.affordances.size(), b.affordances.size());
  const auto numbers = [](const Affordance& x) {
    return std::vector<double>{x.center[0],    x.center[1], x.center[2], x.axis[0],       x.axis[1],
                               x.axis[2],      x.normal[0], x.normal[1], x.normal[2],     x.radius,
                               x.shell_radius, x.gap,       x.curvature, x.observed_free, x.quality};
  };
  for (std::size_t i = 0; i < a.affordances.size(); ++i) {
    EXPECT_EQ(numbers(a.affordances[i]), numbers(b.affordances[i])) << "affordance " << i;
    EXPECT_EQ(a.affordances[i].sample, b.affordances[i].sample);
  }
  ASSERT_EQ(a.handles.size(), b.handles.size());
  for (std::size_t i = 0; i < a.handles.size(); ++i) {
    const Handle &x = a.handles[i], &y = b.handles[i];
    EXPECT_EQ(x.center, y.center);
    EXPECT_EQ(x.axis, y.axis);
    EXPECT_EQ(x.approach, y.approach);
    EXPECT_EQ(x.radius, y.radius);
    EXPECT_EQ(x.length, y.length);
    EXPECT_EQ(x.confidence, y.confidence);
    EXPECT_EQ(x.affordances, y.affordances);
  }
}

}  // namespace handhold::test
