// Pages from results that no command line gives, and what they hold of a cloud.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "html/page.h"
#include "html/page_cloud.h"
#include "html/start_view.h"

namespace handhold {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

Cloud cloud_of(const std::vector<Vector3>& points) {
  Cloud cloud;
  for (const Vector3& point : points) {
    for (const double x : point) cloud.xyz.push_back(static_cast<float>(x));
  }
  cloud.width = static_cast<std::uint32_t>(points.size());
  return cloud;
}

/// A square of 1 m, 2 m before a camera at the origin that looks along z and down by `pitch` (rad).
std::vector<Vector3> tilted_square(double pitch) {
  std::vector<Vector3> points;
  for (int i = -50; i <= 50; ++i) {
    for (int k = -50; k <= 50; ++k) {
      const double x = 0.01 * i, along = 0.01 * k;
      points.push_back({x, -along * std::sin(pitch), 2 + along * std::cos(pitch)});
    }
  }
  return points;
}

Vector3 decoded(const PageCloud& page, std::size_t i) {
  Vector3 point;
  for (std::size_t k = 0; k < 3; ++k) {
    const auto low = static_cast<unsigned char>(page.positions[6 * i + 2 * k]);
    const auto high = static_cast<unsigned char>(page.positions[6 * i + 2 * k + 1]);
    point[k] = page.lower[k] + page.size[k] * (low + 256 * high) / 65535;
  }
  return point;
}

TEST(PageCloud, RoundsToAShareOfTheBox) {
  std::vector<Vector3> points = tilted_square(0.6);
  points.insert(points.begin() + 5, {kNan, 0, 1});
  const Cloud cloud = cloud_of(points);
  const PageCloud page = page_cloud(cloud.view(), {});
  EXPECT_EQ(page.points, points.size() - 1);
  EXPECT_EQ(page.far, 0u);
  EXPECT_EQ(page.step, 1u);
  EXPECT_EQ(page.positions.size(), 6 * page.points);
  EXPECT_EQ(page.colors, "");
  for (std::size_t i = 0; i < page.points; ++i) {
    const Vector3 point = decoded(page, i), expected = points[i < 5 ? i : i + 1];
    for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(point[k], expected[k], page.size[k] / 65535 / 2 + 1e-6) << i;
  }
}

TEST(PageCloud, WhatStandsAloneFarAwayCostsNoPrecision) {
  std::vector<Vector3> points = tilted_square(0.6);
  points.push_back({0, 0, 1000});
  points.push_back({-1e5, 0, 0});
  const PageCloud page = page_cloud(cloud_of(points).view(), {});
  EXPECT_EQ(page.points, points.size() - 2);
  EXPECT_EQ(page.far, 2u);
  for (const double side : page.size) EXPECT_LT(side, 1.1);
}

TEST(PageCloud, OfVeryManyPointsAShareIsThere) {
  Cloud cloud;
  cloud.width = 2'500'000;
  for (std::uint32_t i = 0; i < cloud.width; ++i) {
    cloud.xyz.insert(cloud.xyz.end(), {static_cast<float>(i % 1000), static_cast<float>(i / 1000), 1.0f});
  }
  cloud.rgb.assign(cloud.width, 0x102030);
  cloud.rgb[3] = 0xfffefd;
  const PageCloud page = page_cloud(cloud.view(), cloud.rgb);
  EXPECT_EQ(page.step, 3u);
  EXPECT_EQ(page.points, (2'500'000u + 2) / 3);
  EXPECT_EQ(page.positions.size(), 6 * page.points);
  EXPECT_EQ(page.colors.size(), 3 * page.points);
  EXPECT_EQ(page.colors.substr(0, 6), std::string("\x10\x20\x30\xff\xfe\xfd"));
}

TEST(PageCloud, NoPointsAndOne) {
  EXPECT_EQ(page_cloud(cloud_of({}).view(), {}).points, 0u);
  EXPECT_EQ(page_cloud(cloud_of({{kNan, 0, 1}}).view(), {}).points, 0u);
  const PageCloud page = page_cloud(cloud_of({{1, 2, 3}}).view(), {0xff0000});
  EXPECT_EQ(page.points, 1u);
  EXPECT_EQ(decoded(page, 0), (Vector3{1, 2, 3}));
  EXPECT_EQ(page.colors, "") << "one colour for all is none";
}

TEST(PageCloud, Base64) {
  EXPECT_EQ(base64(""), "");
  EXPECT_EQ(base64("f"), "Zg==");
  EXPECT_EQ(base64("fo"), "Zm8=");
  EXPECT_EQ(base64("foo"), "Zm9v");
  EXPECT_EQ(base64("foob"), "Zm9vYg==");
  EXPECT_EQ(base64("\xfb\xff\xfe"), "+//+");
}

TEST(StartView, IsTheCameraOverItsTable) {
  constexpr double kPitch = 0.7;
  const StartView view = start_view(cloud_of(tilted_square(kPitch)).view());
  EXPECT_EQ(view.eye, (Vector3{0, 0, 0}));
  EXPECT_NEAR(view.target[0], 0, 0.02);
  EXPECT_NEAR(view.target[2], 2, 0.1);
  EXPECT_NEAR(view.down[1], 1, 0.02);
  // The square's normal, towards the camera.
  EXPECT_NEAR(view.up[0], 0, 1e-3);
  EXPECT_NEAR(view.up[1], -std::cos(kPitch), 1e-3);
  EXPECT_NEAR(view.up[2], -std::sin(kPitch), 1e-3);
}

TEST(StartView, AWallIsNotWhatThingsStandOn) {
  const StartView view = start_view(cloud_of(tilted_square(1.5)).view());
  EXPECT_NEAR(view.up[1], -1, 0.02);
}

TEST(StartView, OfNothingIsSomething) {
  const StartView view = start_view(cloud_of({{kNan, kNan, kNan}}).view());
  EXPECT_GT(view.angle, 0);
}

class PageText : public ::testing::Test {
 protected:
  PageText() {
    page_.name = "cloud.pcd";
    page_.cloud = &cloud_;
    page_.options = &options_;
    page_.result = &result_;
    result_.points = result_.finite_points = cloud_.size();
  }
  void SetUp() override {
    try {
      check_page_support();
    } catch (const std::runtime_error& error) {
      GTEST_SKIP() << error.what();
    }
  }

  Cloud cloud_ = cloud_of(tilted_square(0.6));
  Options options_;
  Result result_;
  Page page_;
};

std::size_t count(const std::string& text, const std::string& what) {
  std::size_t found = 0;
  for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + 1)) ++found;
  return found;
}

// Names come from file systems and URDFs.
TEST_F(PageText, NamesCannotEndAScript) {
  const std::string plain = page_text(page_);
  const std::string bad = "</script><b>&\"'<!--\n\xff@VIEW@";
  page_.name = bad;
  page_.plan = PagePlan();
  page_.plan->arm = page_.plan->base = page_.plan->tip = bad;
  page_.plan->rejected.push_back({0, bad});
  const std::string text = page_text(page_);
  EXPECT_EQ(count(text, "</script"), count(plain, "</script"));
  EXPECT_EQ(count(text, "<b>"), count(plain, "<b>"));
  EXPECT_EQ(count(text, "<!--"), count(plain, "<!--"));
  EXPECT_NE(text.find("<title>&lt;/script&gt;&lt;b&gt;&amp;"), std::string::npos);
  EXPECT_NE(text.find("\"reason\":\"\\u003c/script>\\u003cb>&\\\"'\\u003c!--\\n\xEF\xBF\xBD@VIEW@\""),
            std::string::npos);
}

TEST_F(PageText, HasNoMarkLeft) {
  const std::string text = page_text(page_);
  for (const char* mark : {"@TITLE@", "@STYLE@", "@RESULT@", "@VIEW@", "@POSITIONS@", "@COLORS@", "@SAMPLES@",
                           "@STEPS@", "@FAILURE@", "@LICENSE@", "@THREE@", "@PROGRAM@"}) {
    EXPECT_EQ(text.find(mark), std::string::npos) << mark;
  }
  EXPECT_NE(text.find("three.js authors"), std::string::npos) << "their licence asks for it";
  EXPECT_EQ(page_text(page_), text);
}

}  // namespace
}  // namespace handhold
