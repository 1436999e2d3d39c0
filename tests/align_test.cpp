// The alignment kernel against the reference on all pairs, for every instruction set.
#include <gtest/gtest.h>

#include "reference/reference.h"
#include "test_tiles.h"

namespace handhold {
namespace {

using Eigen::Vector3d;
using kernels::AlignLimits;
using kernels::Kernels;
using reference::AxisCircle;
using test::Random;

/// Affordances as the kernel takes them. Padding has x = NaN, and whatever else would be aligned with anything.
class Arrays {
 public:
  explicit Arrays(const std::vector<AxisCircle>& affordances, int more_padding = 0) {
    padded_ = (static_cast<int>(affordances.size()) + 15) / 16 * 16 + 16 * more_padding;
    for (test::Lines& lines : lines_) lines.resize(static_cast<std::size_t>(padded_) / 16);
    for (int i = 0; i < padded_; ++i) {
      const bool real = i < static_cast<int>(affordances.size());
      const AxisCircle a = affordances[real ? i : 0];
      const double values[7] = {
          real ? a.center.x() : std::nan(""), a.center.y(), a.center.z(), a.axis.x(), a.axis.y(), a.axis.z(), a.radius};
      for (int k = 0; k < 7; ++k) lines_[k][static_cast<std::size_t>(i / 16)].v[i % 16] = static_cast<float>(values[k]);
    }
  }
  kernels::AffordanceArrays view() const {
    const auto p = [this](int k) { return test::floats(lines_[k]); };
    return {p(0), p(1), p(2), p(3), p(4), p(5), p(6), padded_};
  }
  int padded() const { return padded_; }

 private:
  test::Lines lines_[7];
  int padded_ = 0;
};

/// The row as bits; checks that nothing behind it was touched.
std::vector<bool> row_of(const Kernels& table, const Arrays& arrays, int i, const AlignLimits& limits) {
  const std::size_t words = static_cast<std::size_t>(arrays.padded() + 31) / 32;
  constexpr std::uint32_t kMark = 0xdeadbeef;
  std::vector<std::uint32_t> row(words + 2, kMark);
  table.align(arrays.view(), i, limits, row.data());
  EXPECT_EQ(row[words], kMark);
  EXPECT_EQ(row[words + 1], kMark);
  std::vector<bool> bits(words * 32);
  for (std::size_t j = 0; j < bits.size(); ++j) bits[j] = row[j / 32] >> (j % 32) & 1;
  return bits;
}

/// Affordances along a few handles, with spreads about the limits, so that many pairs are aligned and many are not. All
/// values are floats.
std::vector<AxisCircle> affordances(Random& random, int n) {
  std::vector<AxisCircle> handles;
  for (int i = 0; i < 1 + n / 20; ++i)
    handles.push_back({random.normal3(0.3), random.direction(), random.uniform(0.005, 0.04)});
  std::vector<AxisCircle> list;
  for (int i = 0; i < n; ++i) {
    const AxisCircle& handle = handles[random.index(handles.size())];
    AxisCircle a;
    a.center = handle.center + random.normal(0.04) * handle.axis + random.normal3(0.003);
    a.axis = (handle.axis + random.normal3(0.1)).normalized() * (random.index(2) ? 1 : -1);
    a.radius = handle.radius + random.normal(0.003);
    a.center = a.center.cast<float>().cast<double>();
    a.axis = a.axis.cast<float>().cast<double>();
    a.radius = static_cast<float>(a.radius);
    list.push_back(a);
  }
  return list;
}

constexpr AlignLimits kLimits = {0.342898f, 0.01f, 0.005f};  // sin(0.35 rad), 10 mm, 5 mm

TEST(Align, AgreesWithTheReferenceOnAllPairs) {
  for (const Kernels* table : test::all_kernels()) {
    SCOPED_TRACE(table->name);
    Random random(61);
    int aligned = 0, apart = 0, borderline = 0;
    for (int n : {1, 2, 15, 16, 17, 31, 32, 33, 47, 48, 49, 64, 100, 257}) {
      SCOPED_TRACE(n);
      const auto list = affordances(random, n);
      const Arrays arrays(list, n % 3);
      for (int i = 0; i < n; ++i) {
        const auto row = row_of(*table, arrays, i, kLimits);
        for (int j = 0; j < static_cast<int>(row.size()); ++j) {
          if (j >= n) {
            ASSERT_FALSE(row[j]) << "padding " << j << " is aligned with " << i;
            continue;
          }
          const auto d = reference::align_distances(list[i], list[j]);
          // Rounding of float: 2^-24 of a difference of up to 1 m for the offset, and of 1 for the sine.
          const double clearance[3] = {(d.sin - kLimits.max_sin) / 1e-6, (d.offset - kLimits.max_offset) / 1e-6,
                                       (d.radius - kLimits.max_radius) / 1e-8};
          const double worst = std::max({clearance[0], clearance[1], clearance[2]});
          if (std::abs(worst) <= 1) {
            ++borderline;
            continue;
          }
          ASSERT_EQ(row[j], worst < 0) << i << " and " << j << ": sin " << d.sin << " offset " << d.offset << " radius "
                                       << d.radius;
          ++(worst < 0 ? aligned : apart);
        }
        ASSERT_TRUE(row[i]);
      }
    }
    EXPECT_GT(aligned, 1000);
    EXPECT_GT(apart, 10000);
    EXPECT_LT(borderline, 100);
  }
}

TEST(Align, EachLimitIsClosedAndCounts) {
  // Everything here is exact in float.
  const AlignLimits limits = {0.5f, 0.25f, 0.125f};
  const auto at = [](double x, double z, const Vector3d& axis, double radius) {
    return AxisCircle{{x, 0, z}, axis, radius};
  };
  const Vector3d z(0, 0, 1), tilted(0.5, 0, 0.75), more(0.5000001, 0, 0.75);  // |z x a| is what counts
  const std::vector<AxisCircle> list = {
      at(0, 0, z, 1),          // 0: the one to compare with
      at(0.25, 7, z, 1),       // 1: offset on the limit, far along the axis
      at(0.2500001, 0, z, 1),  // 2: beyond it
      at(0, 0, -z, 1.125),     // 3: radius on the limit, axis the other way round
      at(0, 0, z, 1.1250001),  // 4: beyond
      at(0, 0, tilted, 1),     // 5: angle on the limit
      at(0, 0, more, 1),       // 6: beyond
      at(0, 0, z, 0.875),      // 7: radius on the limit, smaller
      at(-0.25, -7, -z, 1),    // 8
  };
  const std::vector<bool> expected = {true, true, false, true, false, true, false, true, true};
  for (const Kernels* table : test::all_kernels()) {
    SCOPED_TRACE(table->name);
    auto row = row_of(*table, Arrays(list), 0, limits);
    row.resize(list.size());
    EXPECT_EQ(row, expected);
  }
}

TEST(Align, OffsetCountsBothWays) {
  // j lies on i's axis, 0.1 m ahead, but leans by 0.3 rad: i is 3 cm beside j's axis.
  const std::vector<AxisCircle> list = {{{0, 0, 0}, {0, 0, 1}, 0.02},
                                        {{0, 0, 0.1}, {std::sin(0.3), 0, std::cos(0.3)}, 0.02}};
  for (const Kernels* table : test::all_kernels()) {
    SCOPED_TRACE(table->name);
    EXPECT_FALSE(row_of(*table, Arrays(list), 0, kLimits)[1]);
    EXPECT_FALSE(row_of(*table, Arrays(list), 1, kLimits)[0]);
  }
}

TEST(Align, NotANumberIsAlignedWithNothing) {
  Random random(62);
  for (const Kernels* table : test::all_kernels()) {
    SCOPED_TRACE(table->name);
    for (int field = 0; field < 3; ++field) {
      std::vector<AxisCircle> list(20, AxisCircle{{0.1, 0.2, 0.3}, {0, 0, 1}, 0.02});
      const double nan = std::nan("");
      if (field == 0) list[7].center.y() = nan;
      if (field == 1) list[7].axis.z() = nan;
      if (field == 2) list[7].radius = nan;
      for (int i = 0; i < 20; ++i) {
        const auto row = row_of(*table, Arrays(list), i, kLimits);
        for (int j = 0; j < 20; ++j) {
          if (i == 7 || j == 7) {
            EXPECT_FALSE(row[j] && i != j);
          } else {
            EXPECT_TRUE(row[j]);
          }
        }
      }
    }
  }
}

TEST(Align, VectorTablesAgreeToTheBit) {
  const auto tables = test::bitwise_kernels();
  Random random(63);
  const auto list = affordances(random, 300);
  const Arrays arrays(list);
  for (int i = 0; i < 300; ++i) {
    const auto first = row_of(*tables[0], arrays, i, kLimits);
    for (const Kernels* table : tables) EXPECT_EQ(row_of(*table, arrays, i, kLimits), first) << table->name;
  }
}

}  // namespace
}  // namespace handhold
