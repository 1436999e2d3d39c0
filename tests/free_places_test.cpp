// Places that a depth image shows to be empty: the kernel against a plain loop, for every instruction set.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>

#include "kernels.h"
#include "reference/reference.h"
#include "test_tiles.h"

namespace handhold {
namespace {

using Eigen::Vector3d;
using kernels::FreeQuery;
using kernels::Kernels;
using reference::Depths;
using test::Random;

/// Depths about 1 m; of eight pixels one is unknown and one looks past everything.
Depths random_image(Random& random, int width, int height) {
  Depths image{width, height, {}};
  for (int i = 0; i < width * height; ++i) {
    const double kind = random.uniform(0, 8);
    image.value.push_back(kind < 1   ? 0.0f
                          : kind < 2 ? std::numeric_limits<float>::infinity()
                                     : static_cast<float>(random.uniform(0.8, 1.2)));
  }
  return image;
}

void set(float* to, const Vector3d& v) {
  for (int k = 0; k < 3; ++k) to[k] = static_cast<float>(v[k]);
}
Vector3d get(const float* v) {
  return Eigen::Vector3f(v[0], v[1], v[2]).cast<double>();
}

FreeQuery query_of(const Depths& image, int columns, int rows, int layers) {
  FreeQuery q{};
  q.depth = image.value.data(), q.width = image.width, q.height = image.height;
  q.columns = columns, q.rows = rows, q.layers = layers;
  q.tolerance = 0.003f;
  return q;
}

std::vector<float> run(const Kernels& table, const FreeQuery& q) {
  std::vector<float> free(static_cast<std::size_t>((q.columns + 15) / 16 * 16) + 1, -1.0f);
  table.free_places(q, free.data());
  EXPECT_EQ(free.back(), -1.0f) << "written behind the end";
  free.resize(static_cast<std::size_t>(q.columns));
  return free;
}

/// Returns how many places were certain.
int expect_plain(const Depths& image, const FreeQuery& q) {
  int certain = 0;
  const std::vector<float> first = run(*test::bitwise_kernels().front(), q);
  for (const Kernels* table : test::bitwise_kernels()) EXPECT_EQ(run(*table, q), first) << table->name;
  for (const Kernels* table : test::all_kernels()) {
    SCOPED_TRACE(table->name);
    const std::vector<float> free = run(*table, q);
    for (int c = 0; c < q.columns; ++c) {
      int sure = 0, perhaps = 0;
      for (int r = 0; r < q.rows; ++r)
        for (int l = 0; l < q.layers; ++l) {
          const Vector3d place = get(q.corner) + c * get(q.out) + r * get(q.up) + l * get(q.along);
          const reference::Place seen = reference::look(image, place, static_cast<double>(q.tolerance), 1e-4);
          sure += seen == reference::Place::kFree;
          perhaps += seen == reference::Place::kBorder;
          certain += seen != reference::Place::kBorder;
        }
      EXPECT_GE(free[static_cast<std::size_t>(c)], static_cast<float>(sure)) << "column " << c;
      EXPECT_LE(free[static_cast<std::size_t>(c)], static_cast<float>(sure + perhaps)) << "column " << c;
    }
  }
  return certain;
}

TEST(FreePlaces, AreThoseOfAPlainLoop) {
  Random random(501);
  int certain = 0, all = 0;
  for (int i = 0; i < 60; ++i) {
    const Depths image = random_image(random, 20 + i, 70 - i);
    FreeQuery q = query_of(image, 1 + i * 7 % 40, 1 + i % 6, 1 + i % 3);
    const double depth = random.uniform(0.9, 1.1);
    // Some begin outside, or leave the image on the way.
    set(q.corner, depth * Vector3d(random.uniform(-5, image.width + 5), random.uniform(-5, image.height + 5), 1));
    set(q.out, {random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-0.005, 0.005)});
    set(q.up, {random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-0.01, 0.01)});
    set(q.along, {random.uniform(-3, 3), random.uniform(-3, 3), random.uniform(-0.01, 0.01)});
    SCOPED_TRACE("query " + std::to_string(i));
    certain += expect_plain(image, q);
    all += q.columns * q.rows * q.layers * static_cast<int>(test::all_kernels().size());
  }
  EXPECT_GT(certain, all * 9 / 10) << "nearly every place was checked";
}

TEST(FreePlaces, OfOnePixel) {
  const Depths image{1, 1, {1.0f}};
  FreeQuery q = query_of(image, 3, 1, 1);
  set(q.corner, {0, 0, 0.9});
  set(q.out, {0, 0, 0.06});  // 0.9, 0.96 and 1.02 m
  for (const Kernels* table : test::all_kernels())
    EXPECT_EQ(run(*table, q), (std::vector<float>{1, 1, 0})) << table->name;
}

TEST(FreePlaces, NothingIsKnownOutsideOrBehindTheSensor) {
  Random random(502);
  const Depths image{8, 8, std::vector<float>(64, std::numeric_limits<float>::infinity())};
  const double nan = std::nan(""), huge = 1e30;
  for (const Vector3d& corner : {Vector3d(4, 4, -1), Vector3d(0, 0, 0), Vector3d(-1, 4, 1), Vector3d(4, 8, 1),
                                 Vector3d(nan, 4, 1), Vector3d(4, 4, nan), Vector3d(huge, 4, 1), Vector3d(4, -huge, 1),
                                 Vector3d(huge, huge, 1e-30), Vector3d(0.04, 0.04, 0.01)}) {
    FreeQuery q = query_of(image, 17, 2, 2);
    set(q.corner, corner);
    for (const Kernels* table : test::all_kernels())
      EXPECT_EQ(run(*table, q), std::vector<float>(17, 0.0f)) << table->name << ' ' << corner.transpose();
  }
  FreeQuery q = query_of(image, 17, 2, 2);
  set(q.corner, {4, 4, 1});
  for (const Kernels* table : test::all_kernels()) EXPECT_EQ(run(*table, q), std::vector<float>(17, 4.0f));
  q.columns = 0;
  for (const Kernels* table : test::all_kernels()) EXPECT_TRUE(run(*table, q).empty()) << "and nothing is written";
}

TEST(FreePlaces, UnknownAndInvalidDepthsAreNotFree) {
  const float nan = std::nanf("");
  const Depths image{4, 1, {0.0f, nan, 0.5f, 2.0f}};
  FreeQuery q = query_of(image, 4, 1, 1);
  set(q.corner, {0, 0, 1});
  set(q.out, {1, 0, 0});
  for (const Kernels* table : test::all_kernels())
    EXPECT_EQ(run(*table, q), (std::vector<float>{0, 0, 0, 1})) << table->name;
}

}  // namespace
}  // namespace handhold
