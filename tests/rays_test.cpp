// Where a surface of a depth image ends, the outermost points about an axis, and the nearest point: the kernels against
// plain loops, for every instruction set.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>
#include <vector>

#include "kernels.h"
#include "normals.h"
#include "random.h"
#include "test_tiles.h"

namespace handhold {
namespace {

using kernels::Kernels;
using test::FloatPoints;
using test::Random;
using test::Vector3d;

// ---- ray_ends ------------------------------------------------------------------------------------------------------

struct Image {
  int width, height;
  std::vector<float> depth;
  float at(double u, double v) const {
    if (!(u >= 0 && v >= 0 && u < width && v < height)) return 0;
    return depth[static_cast<std::size_t>(v) * static_cast<std::size_t>(width) + static_cast<std::size_t>(u)];
  }
};

/// Patches of random depth, with blurred borders, missing pixels and some that look past everything.
Image random_image(Random& random) {
  Image image{70, 50, {}};
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      const int patch = (x / 9) * 7 + (y / 11) * 3;
      float z = 0.7f + 0.02f * static_cast<float>(patch % 5) + 0.0005f * static_cast<float>(x + y);
      if (x % 9 == 0) z -= 0.01f;
      const double kind = random.uniform(0, 60);
      image.depth.push_back(kind < 1 ? 0.0f : kind < 2 ? std::numeric_limits<float>::infinity() : z);
    }
  return image;
}

float plain_end(const Image& image, const kernels::RayQuery& q, int ray) {
  float last = image.at(q.column, q.row), before = last;
  if (!(last > 0)) return -1;
  for (int k = 1; k <= q.most; ++k) {
    const float z = image.at(std::fma(static_cast<float>(k), q.out_column[ray], q.column),
                             std::fma(static_cast<float>(k), q.out_row[ray], q.row));
    if (!(z > 0) || z < last - q.jump) return -1;
    if (z > last + q.jump) return static_cast<float>(k) - 0.5f;
    if (z > before + q.jump) return static_cast<float>(k) - 1;
    before = last, last = z;
  }
  return -1;
}

TEST(RayEnds, AgreeWithPlainLoops) {
  Random random(311);
  int found = 0, same = 0, all = 0;
  for (int trial = 0; trial < 400; ++trial) {
    const Image image = random_image(random);
    kernels::RayQuery q{};
    q.depth = image.depth.data(), q.width = image.width, q.height = image.height;
    q.column = static_cast<float>(random.uniform(-2, image.width + 2));
    q.row = static_cast<float>(random.uniform(-2, image.height + 2));
    for (int i = 0; i < 16; ++i) {
      const double angle = random.uniform(0, 6.3);
      q.out_column[i] = static_cast<float>(std::cos(angle)), q.out_row[i] = static_cast<float>(std::sin(angle));
    }
    q.jump = 0.006f, q.most = trial % 30;
    for (const Kernels* table : test::all_kernels()) {
      float ends[16];
      table->ray_ends(q, ends);
      for (int i = 0; i < 16; ++i) {
        const float plain = plain_end(image, q, i);
        found += plain >= 0, same += ends[i] == plain, ++all;
      }
    }
    for (const Kernels* table : test::bitwise_kernels()) {
      float first[16], other[16];
      test::bitwise_kernels().front()->ray_ends(q, first), table->ray_ends(q, other);
      EXPECT_TRUE(std::equal(first, first + 16, other)) << table->name;
    }
  }
  EXPECT_GT(found, 500);
  // Without a fused multiply-add a place at the border of two pixels may fall to the other one.
  EXPECT_GE(same, all - 5);
}

// ---- inverse_depths ------------------------------------------------------------------------------------------------

TEST(InverseDepths, AreMeansOverFivePixels) {
  Random random(315);
  int known = 0, unknown = 0;
  for (int trial = 0; trial < 300; ++trial) {
    const Image image = random_image(random);
    kernels::PlaceQuery q{image.depth.data(), image.width, image.height, {}, {}};
    for (int i = 0; i < 16; ++i) {
      q.column[i] = static_cast<float>(random.uniform(-3, image.width + 3));
      q.row[i] = static_cast<float>(random.uniform(-3, image.height + 3));
    }
    if (trial == 0) q.column[3] = std::numeric_limits<float>::quiet_NaN(), q.row[4] = 1e30f, q.column[5] = -1e30f;
    for (const Kernels* table : test::all_kernels()) {
      SCOPED_TRACE(table->name);
      float means[16], first[16];
      table->inverse_depths(q, means);
      for (int i = 0; i < 16; ++i) {
        double sum = 0;
        bool all = true;
        for (const auto& [du, dv] : {std::pair{0, 0}, {1, 0}, {-1, 0}, {0, 1}, {0, -1}}) {
          // As the kernel steps, in single precision.
          const float u = q.column[i] + static_cast<float>(du), v = q.row[i] + static_cast<float>(dv);
          const double z = static_cast<double>(image.at(static_cast<double>(u), static_cast<double>(v)));
          all = all && z > 0;
          sum += 1 / z;
        }
        EXPECT_NEAR(static_cast<double>(means[i]), all ? 0.2 * sum : 0.0, 1e-6);
        ++(all ? known : unknown);
      }
      test::bitwise_kernels().front()->inverse_depths(q, first);
      if (std::strcmp(table->name, "scalar") == 0) continue;
      EXPECT_TRUE(std::equal(first, first + 16, means));
    }
  }
  EXPECT_GT(known, 1000);
  EXPECT_GT(unknown, 1000);
}

// ---- outer_turns ---------------------------------------------------------------------------------------------------

TEST(OuterTurns, AreTheOutermostAngles) {
  Random random(312);
  for (int n : {1, 2, 3, 4, 5, 15, 16, 17, 40, 128}) {
    std::vector<float> p[3];
    for (auto& values : p) values.assign(static_cast<std::size_t>(n) + 15, std::numeric_limits<float>::quiet_NaN());
    const Vector3d point = 0.01 * random.direction(), axis = random.direction();
    const Vector3d ahead = axis.unitOrthogonal(), side = axis.cross(ahead);
    kernels::TurnQuery q{};
    for (int k = 0; k < 3; ++k) {
      q.point[k] = static_cast<float>(point[k]), q.ahead[k] = static_cast<float>(ahead[k]);
      q.side[k] = static_cast<float>(side[k]);
    }
    std::vector<double> angles;
    for (int i = 0; i < n; ++i) {
      const Vector3d x = random.normal3(0.03);
      for (int k = 0; k < 3; ++k) p[k][static_cast<std::size_t>(i)] = static_cast<float>(x[k]);
      angles.push_back(std::atan2((x - point).dot(side), (x - point).dot(ahead)));
    }
    std::sort(angles.begin(), angles.end());
    const auto angle = [](float turn) {
      const double c = 1 - std::fabs(static_cast<double>(turn));
      return std::atan2(std::copysign(1 - std::fabs(c), static_cast<double>(turn)), c);
    };
    for (const Kernels* table : test::all_kernels()) {
      SCOPED_TRACE(table->name);
      float least[kernels::kTurns], most[kernels::kTurns];
      table->outer_turns(p[0].data(), p[1].data(), p[2].data(), n, q, least, most);
      for (int k = 0; k < kernels::kTurns; ++k) {
        if (k >= n) {
          EXPECT_EQ(least[k], 3);
          EXPECT_EQ(most[k], -3);
          continue;
        }
        EXPECT_NEAR(angle(least[k]), angles[static_cast<std::size_t>(k)], 2e-5);
        EXPECT_NEAR(angle(most[k]), angles[static_cast<std::size_t>(n - 1 - k)], 2e-5);
      }
    }
  }
}

// ---- nearest, any_nearer -------------------------------------------------------------------------------------------

TEST(NearestPoint, IsThatOfAPlainLoop) {
  for (const Kernels* table : test::all_kernels()) {
    SCOPED_TRACE(table->name);
    Random random(313);
    int found = 0;
    for (int trial = 0; trial < 60; ++trial) {
      FloatPoints points;
      for (int i = 0; i < 900; ++i) points.push_back(random.normal3(0.05).cast<float>());
      const test::PackedCloud cloud(*table, points, {trial % 2 ? 16 : 11, trial % 3 == 0});
      const Eigen::Vector3f c = random.normal3(0.06).cast<float>();
      const float radius = trial % 4 == 0 ? 0.002f : 0.03f;
      float best2 = std::numeric_limits<float>::infinity();
      for (const auto& p : points) best2 = std::min(best2, (p - c).squaredNorm());
      float offset[3];
      const bool there = table->nearest(cloud.tiles(), cloud.candidates(), c.data(), radius, offset);
      EXPECT_EQ(there, best2 <= radius * radius);
      if (!there) continue;
      ++found;
      EXPECT_NEAR(Eigen::Vector3f(offset[0], offset[1], offset[2]).squaredNorm(), best2, 1e-6f * best2);
      // It is a point of the cloud.
      float least = 1;
      for (const auto& p : points) {
        least = std::min(least, (p - c - Eigen::Vector3f(offset[0], offset[1], offset[2])).norm());
      }
      EXPECT_LT(least, 1e-7f);
    }
    EXPECT_GT(found, 20);
  }
}

TEST(SecondMoments, AreThoseOfAPlainLoop) {
  Random random(314);
  for (int trial = 0; trial < 20; ++trial) {
    FloatPoints points;
    for (int i = 0; i < 700; ++i) points.push_back(random.normal3(0.05).cast<float>());
    const Eigen::Vector3f c = random.normal3(0.05).cast<float>();
    const float radius = 0.03f;
    double plain[10] = {};
    for (const auto& p : points) {
      const Vector3d d = (p - c).cast<double>();
      if (d.norm() > static_cast<double>(radius)) continue;
      const double terms[10] = {1,           d[0],        d[1],        d[2],        d[0] * d[0],
                                d[0] * d[1], d[0] * d[2], d[1] * d[1], d[1] * d[2], d[2] * d[2]};
      for (int k = 0; k < 10; ++k) plain[k] += terms[k];
    }
    float first[10];
    for (const Kernels* table : test::all_kernels()) {
      SCOPED_TRACE(table->name);
      const test::PackedCloud cloud(*table, points, {trial % 2 ? 16 : 11, trial % 3 == 0});
      float sums[10];
      table->second_moments(cloud.tiles(), cloud.candidates(), c.data(), radius, sums);
      for (int k = 0; k < 10; ++k) EXPECT_NEAR(sums[k], plain[k], 1e-5 * plain[0] * (k < 4 ? 0.03 : 0.0009) + 1e-9);
      if (table == test::bitwise_kernels().front()) std::copy(sums, sums + 10, first);
    }
    for (const Kernels* table : test::bitwise_kernels()) {
      const test::PackedCloud cloud(*table, points, {trial % 2 ? 16 : 11, trial % 3 == 0});
      float sums[10];
      table->second_moments(cloud.tiles(), cloud.candidates(), c.data(), radius, sums);
      EXPECT_TRUE(std::equal(sums, sums + 10, first)) << table->name;
    }
  }
}

TEST(AnyNearer, LooksAtAllPlaces) {
  for (const Kernels* table : test::all_kernels()) {
    std::vector<float> x(48, 1.0f), y(48, 2.0f), z(48, -1.0f);
    const float place[3] = {0.5f, 0, 0};
    for (std::size_t i = 1; i < 33; ++i) {  // from an odd address
      x[i] = 0.25f, y[i] = 0, z[i] = 0;
      EXPECT_TRUE(table->any_nearer(&x[1], &y[1], &z[1], 32, place, 0.0626f)) << table->name;
      EXPECT_FALSE(table->any_nearer(&x[1], &y[1], &z[1], 32, place, 0.0625f)) << table->name;
      for (std::int32_t n = 0; n <= 32; ++n) {
        EXPECT_EQ(table->any_nearer(&x[1], &y[1], &z[1], n, place, 0.0626f), static_cast<std::int32_t>(i) <= n);
      }
      x[i] = 1;
      y[i] = 2;
    }
  }
}

// ---- normal_pairs --------------------------------------------------------------------------------------------------

TEST(NormalPairs, AgreeWithTheLibrarysFunctions) {
  for (float x : {1e-30f, 5.96e-8f, 0.001f, 0.5f, 0.70710678f, 0.70710685f, 0.99999994f, 1.0f, 1.5f, 7.0f}) {
    EXPECT_NEAR(log_of(x), std::log(x), 2e-7f * std::max(1.0f, std::fabs(std::log(x)))) << x;
  }
  for (float x = -0.7854f; x <= 0.7854f; x += 0.01f) {
    EXPECT_NEAR(short_sine(x), std::sin(x), 1e-7f);
    EXPECT_NEAR(short_cosine(x), std::cos(x), 1e-7f);
  }
}

TEST(NormalPairs, AreNormal) {
  CounterRandom random(5, 1, 0);
  constexpr int kDraws = 40'000;
  double sum[2] = {}, square[2] = {}, fourth[2] = {}, both = 0, sizes = 0;
  std::vector<double> first;
  for (int i = 0; i < kDraws; i += static_cast<int>(kNormalWords)) {
    std::uint64_t words[kNormalWords];
    for (std::uint64_t& w : words) w = random.next();
    float pair[2][kNormalWords];
    normal_pairs(words, pair[0], pair[1]);
    for (std::size_t k = 0; k < kNormalWords; ++k) {
      for (int j = 0; j < 2; ++j) {
        const double x = static_cast<double>(pair[j][k]);
        sum[j] += x, square[j] += x * x, fourth[j] += x * x * x * x;
      }
      const double a = static_cast<double>(pair[0][k]), b = static_cast<double>(pair[1][k]);
      both += a * b, sizes += (a * a - 1) * (b * b - 1);
      first.push_back(a);
    }
  }
  const double root = std::sqrt(static_cast<double>(kDraws));  // 4 standard errors each
  for (int j = 0; j < 2; ++j) {
    EXPECT_NEAR(sum[j] / kDraws, 0, 4 / root);
    EXPECT_NEAR(square[j] / kDraws, 1, 4 * std::sqrt(2.0) / root);
    EXPECT_NEAR(fourth[j] / kDraws, 3, 4 * std::sqrt(96.0) / root);
  }
  EXPECT_NEAR(both / kDraws, 0, 4 / root);
  EXPECT_NEAR(sizes / kDraws, 0, 8 / root);
  // Kolmogorov and Smirnov's largest distance from the distribution.
  std::sort(first.begin(), first.end());
  double distance = 0;
  for (std::size_t i = 0; i < first.size(); ++i) {
    const double below = 0.5 * std::erfc(-first[i] / std::sqrt(2.0));
    distance = std::max(distance, std::fabs(below - (static_cast<double>(i) + 0.5) / kDraws));
  }
  EXPECT_LT(distance, 1.8 / root);
}

}  // namespace
}  // namespace handhold
