// What tests of the C interface share: objects that free themselves, a cloud, and results compared with those of C++.
#pragma once

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <iterator>
#include <memory>
#include <vector>

#include "handhold/handhold.h"
#include "handhold/localizer.h"
#include "handhold/sensor.h"

namespace handhold::test {

using Options_ = std::unique_ptr<handhold_options, void (*)(handhold_options*)>;
using Localizer_ = std::unique_ptr<handhold_localizer, void (*)(handhold_localizer*)>;

inline Options_ make_options() {
  handhold_options* options = nullptr;
  EXPECT_EQ(handhold_options_create(&options), HANDHOLD_OK);
  return {options, handhold_options_destroy};
}
inline Localizer_ make_localizer(handhold_options* options = nullptr) {
  handhold_localizer* localizer = nullptr;
  EXPECT_EQ(handhold_localizer_create(options, &localizer), HANDHOLD_OK);
  return {localizer, handhold_localizer_destroy};
}

inline const Cloud& table_scene() {
  static const Cloud cloud = [] {
    const sensor::DepthCamera camera(sensor::table_scene_camera_options());
    return camera.capture(sensor::table_scene(), sensor::table_scene_camera()).cloud;
  }();
  return cloud;
}
inline handhold_cloud c_view(const Cloud& cloud) {
  handhold_cloud view = {};
  view.data = cloud.xyz.data();
  view.width = cloud.width;
  view.height = cloud.height;
  view.no_viewpoint = !cloud.viewpoint;
  for (std::size_t k = 0; k < 3 && cloud.viewpoint; ++k) view.viewpoint[k] = (*cloud.viewpoint)[k];
  return view;
}

inline handhold_frame frame_of(const handhold_localizer* localizer) {
  handhold_frame frame = {};
  EXPECT_EQ(handhold_get_frame(localizer, &frame, sizeof frame), HANDHOLD_OK);
  return frame;
}
template <class T, class Get>
std::vector<T> list(const handhold_localizer* localizer, std::size_t count, Get get) {
  std::vector<T> values(count);
  EXPECT_EQ(get(localizer, 0, count, values.data(), sizeof(T)), HANDHOLD_OK);
  return values;
}
inline std::vector<handhold_handle> handles_of(const handhold_localizer* localizer) {
  return list<handhold_handle>(localizer, frame_of(localizer).handles, handhold_get_handles);
}
inline std::vector<handhold_affordance> affordances_of(const handhold_localizer* localizer) {
  return list<handhold_affordance>(localizer, frame_of(localizer).affordances, handhold_get_affordances);
}

inline Vector3 vector(const double (&v)[3]) {
  return {v[0], v[1], v[2]};
}

inline void expect_same(const handhold_localizer* c, const Result& cpp) {
  const handhold_frame frame = frame_of(c);
  EXPECT_STREQ(handhold_status_text(frame.status), to_string(cpp.status).data());
  EXPECT_EQ(frame.points, cpp.points);
  EXPECT_EQ(frame.finite_points, cpp.finite_points);
  ASSERT_EQ(frame.handles, cpp.handles.size());
  ASSERT_EQ(frame.affordances, cpp.affordances.size());
  const std::vector<handhold_handle> handles = handles_of(c);
  for (std::size_t i = 0; i < handles.size(); ++i) {
    const handhold_handle& a = handles[i];
    const Handle& b = cpp.handles[i];
    EXPECT_EQ(vector(a.center), b.center);
    EXPECT_EQ(vector(a.axis), b.axis);
    EXPECT_EQ(vector(a.approach), b.approach);
    EXPECT_EQ(a.radius, b.radius);
    EXPECT_EQ(a.length, b.length);
    EXPECT_EQ(a.confidence, b.confidence);
    EXPECT_EQ(a.arc, b.arc);
    EXPECT_EQ(a.residual, b.residual);
    EXPECT_EQ(a.observed_free, b.observed_free);
    EXPECT_EQ(a.normal_error, b.normal_error);
    EXPECT_EQ(a.path == nullptr, b.path.empty());
    ASSERT_EQ(a.path_points, b.path.size());
    for (std::size_t k = 0; k < b.path.size(); ++k) {
      EXPECT_EQ((Vector3{a.path[3 * k], a.path[3 * k + 1], a.path[3 * k + 2]}), b.path[k]);
    }
    EXPECT_EQ(std::vector<std::uint32_t>(a.affordances, a.affordances + a.affordance_count), b.affordances);
  }
  const std::vector<handhold_affordance> affordances = affordances_of(c);
  for (std::size_t i = 0; i < affordances.size(); ++i) {
    const handhold_affordance& a = affordances[i];
    const Affordance& b = cpp.affordances[i];
    EXPECT_EQ(vector(a.center), b.center);
    EXPECT_EQ(vector(a.axis), b.axis);
    EXPECT_EQ(vector(a.normal), b.normal);
    EXPECT_EQ((std::vector<double>{a.radius, a.shell_radius, a.gap, a.curvature, a.observed_free, a.quality,
                                   a.neighbourhood}),
              (std::vector<double>{b.radius, b.shell_radius, b.gap, b.curvature, b.observed_free, b.quality,
                                   b.neighbourhood}));
    EXPECT_EQ(a.sample, b.sample);
    EXPECT_EQ(a.reserved, 0u);
  }
  handhold_funnel a;
  ASSERT_EQ(handhold_get_funnel(c, &a, sizeof a), HANDHOLD_OK);
  const Funnel& b = cpp.funnel;
  const std::int64_t counts_c[] = {
      a.samples,       a.too_few_points, a.flat,      a.curvature_low,  a.concave,     a.circle_wide,
      a.circle_narrow, a.poor_fit,       a.no_gap,    a.shell_empty,    a.affordances, a.cut,
      a.not_aligned,   a.unconfirmed,    a.too_short, a.low_confidence, a.in_handles};
  const std::int64_t counts_cpp[] = {
      b.samples,       b.too_few_points, b.flat,      b.curvature_low,  b.concave,     b.circle_wide,
      b.circle_narrow, b.poor_fit,       b.no_gap,    b.shell_empty,    b.affordances, b.cut,
      b.not_aligned,   b.unconfirmed,    b.too_short, b.low_confidence, b.in_handles};
  for (std::size_t i = 0; i < std::size(counts_c); ++i) EXPECT_EQ(counts_c[i], counts_cpp[i]) << "count " << i;
}

}  // namespace handhold::test
