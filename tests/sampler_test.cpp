// Where samples come from: rounds, the two proposal distributions, and how a draw is brought to the cloud.
#include "sampler.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <memory>
#include <numeric>
#include <optional>
#include <vector>

#include "paper_options.h"
#include "reference/neighbours.h"
#include "test_clouds.h"
#include "vec3.h"

namespace handhold {
namespace {

using test::FloatPoints;
using test::Random;
using test::Vector3d;
using test::Vector3f;
using Sample = std::array<float, 3>;

/// What a sampler needs besides its options.
struct Scene {
  explicit Scene(const FloatPoints& points, std::uint32_t height = 1) {
    CloudView view;
    view.data = points.front().data();
    view.width = static_cast<std::uint32_t>(points.size()) / height, view.height = height;
    tiles.build(view);
    index->build(tiles);
    for (const Vector3f& p : points)
      if (reference::is_measured(p.cast<double>())) measured.push_back(p);
  }
  TileStore tiles;
  std::unique_ptr<NeighbourIndex> index = make_index(IndexKind::kEmbree);
  FloatPoints measured;
};

std::vector<Sample> uniform(const Sampler& sampler, int round, int n) {
  std::vector<Sample> samples(static_cast<std::size_t>(n));
  sampler.uniform(round, n, samples.front().data());
  return samples;
}
std::vector<Sample> proposals(Sampler& sampler, int round, int n) {
  std::vector<Sample> samples(static_cast<std::size_t>(n));
  sampler.propose(round, n, samples.front().data());
  return samples;
}

/// Chi-square statistic of counts that should all be equal, in standard deviations from its mean.
double excess_chi_square(const std::vector<int>& counts) {
  const double mean = std::accumulate(counts.begin(), counts.end(), 0.0) / static_cast<double>(counts.size());
  double chi2 = 0;
  for (const int c : counts) chi2 += (c - mean) * (c - mean) / mean;
  const double degrees = static_cast<double>(counts.size()) - 1;
  return (chi2 - degrees) / std::sqrt(2 * degrees);
}

// ---- Rounds --------------------------------------------------------------------------------------------------------

std::vector<int> rounds(int samples, Strategy strategy, Method method = Method::kPaper) {
  Options options;
  options.method = method;
  options.samples = samples, options.strategy = strategy;
  return Sampler::rounds(options);
}
std::vector<int> rounds_of(int first, int others, int last) {
  std::vector<int> sizes(11, others);
  sizes.front() = first, sizes.back() = last;
  return sizes;
}

TEST(SamplerRounds, HaveThePapersSizes) {
  for (const Strategy strategy : {Strategy::kSum, Strategy::kMax}) {
    EXPECT_EQ(rounds(2000, strategy), rounds_of(1000, 100, 100));
    EXPECT_EQ(rounds(5000, strategy), rounds_of(2000, 300, 300));
    EXPECT_EQ(rounds(2001, strategy), rounds_of(800, 120, 121));
    EXPECT_EQ(rounds(1999, strategy), rounds_of(999, 100, 100));
    EXPECT_EQ(rounds(25, strategy), rounds_of(12, 1, 4));
    EXPECT_EQ(rounds(3, strategy), (std::vector<int>{1, 2}));
    EXPECT_EQ(rounds(1, strategy), (std::vector<int>{1}));
  }
  EXPECT_EQ(rounds(5000, Strategy::kUniform), (std::vector<int>{5000}));
}

TEST(SamplerRounds, AreFewerByTheDefaultMethod) {
  EXPECT_EQ(rounds(5000, Strategy::kMax, Method::kDefault),
            (std::vector<int>{2000, 428, 428, 428, 428, 428, 428, 432}));
}

TEST(SamplerRounds, AddUpToTheSamples) {
  for (const Strategy strategy : {Strategy::kUniform, Strategy::kSum, Strategy::kMax}) {
    for (int n : {1, 2, 3, 4, 5, 7, 10, 19, 20, 21, 199, 1999, 2000, 2001, 2002, 4999, 5003, 123'457, 10'000'000}) {
      for (const Method method : {Method::kPaper, Method::kDefault}) {
        const std::vector<int> sizes = rounds(n, strategy, method);
        EXPECT_EQ(std::accumulate(sizes.begin(), sizes.end(), 0), n);
        EXPECT_GT(*std::min_element(sizes.begin(), sizes.end()), 0) << n;
      }
    }
  }
}

// ---- Uniform draws -------------------------------------------------------------------------------------------------

TEST(SamplerUniform, DrawsEveryPointEquallyOften) {
  Random random(41);
  const FloatPoints image = test::depth_image(random, 30, 22);  // with missing pixels, and blocks cut by the border
  for (const std::uint32_t height : {22u, 1u}) {
    SCOPED_TRACE(height);
    const Scene scene(image, height);
    Options options = test::paper_options();
    Sampler sampler(options);
    sampler.begin(scene.tiles, *scene.index);
    ASSERT_EQ(sampler.points(), scene.measured.size());
    std::map<Sample, int> counts;
    for (const Vector3f& p : scene.measured) counts[{p[0], p[1], p[2]}] = 0;
    ASSERT_EQ(counts.size(), scene.measured.size());
    for (const Sample& s : uniform(sampler, 0, 60'000)) {
      const auto at = counts.find(s);
      ASSERT_NE(at, counts.end()) << "not a point of the cloud";
      ++at->second;
    }
    std::vector<int> values;
    for (const auto& [point, n] : counts) values.push_back(n);
    EXPECT_LT(std::abs(excess_chi_square(values)), 4);
  }
}

TEST(SamplerUniform, DependsOnSeedAndRoundAlone) {
  Random random(42);
  const Scene scene(test::cube(random, 3000, 0.3));
  Options options = test::paper_options(), other = options;
  other.seed = 2;
  Sampler a(options), b(options), c(other);
  for (Sampler* s : {&a, &b, &c}) s->begin(scene.tiles, *scene.index);
  EXPECT_EQ(uniform(a, 0, 500), uniform(b, 0, 500));
  EXPECT_NE(uniform(a, 0, 500), uniform(a, 1, 500));
  EXPECT_NE(uniform(a, 0, 500), uniform(c, 0, 500));
  const auto few = uniform(a, 0, 100), many = uniform(a, 0, 5000);
  EXPECT_TRUE(std::equal(few.begin(), few.end(), many.begin()));
}

// ---- Draws of the proposal distributions ---------------------------------------------------------------------------

std::vector<Vector3> line_of_centres(int n, const Vector3& from, const Vector3& to) {
  std::vector<Vector3> centres;
  for (int i = 0; i < n; ++i) centres.push_back(from + (i / (n - 1.0)) * (to - from));
  return centres;
}

TEST(SamplerDraws, SumIsAMixtureOfGaussians) {
  Options options = test::paper_options();
  options.strategy = Strategy::kSum;
  options.proposal_sigma = 0.02;
  Sampler sampler(options);
  const auto centres = line_of_centres(50, {0.1, 0.2, 0.5}, {-0.3, 0.1, 0.9});
  sampler.set_centres(centres);
  constexpr int kDraws = 40'000;
  std::vector<int> counts(centres.size());
  double sum[3] = {}, products[3][3] = {}, lagged = 0, last = 0;
  for (int i = 0; i < kDraws; ++i) {
    const Sampler::Draw d = sampler.draw(1 + i % 3, i / 4, i % 4);
    ASSERT_TRUE(d.accepted) << "g_sum refuses nothing";
    ++counts.at(d.centre);
    const Vector3 offset = (1 / *options.proposal_sigma) * (d.position - centres[d.centre]);
    for (std::size_t j = 0; j < 3; ++j) {
      sum[j] += offset[j];
      for (std::size_t k = 0; k < 3; ++k) products[j][k] += offset[j] * offset[k];
    }
    lagged += offset[0] * last;
    last = offset[0];
  }
  EXPECT_LT(std::abs(excess_chi_square(counts)), 4);
  // 4 standard errors each
  const double root = std::sqrt(static_cast<double>(kDraws));
  for (std::size_t j = 0; j < 3; ++j) {
    EXPECT_LT(std::abs(sum[j] / kDraws), 4 / root);
    for (std::size_t k = 0; k < 3; ++k) {
      EXPECT_NEAR(products[j][k] / kDraws, j == k ? 1 : 0, 4 * (j == k ? std::sqrt(2.0) : 1) / root);
    }
  }
  EXPECT_LT(std::abs(lagged / kDraws), 4 / root) << "successive draws depend on each other";
}

TEST(SamplerDraws, DefaultSigmaIsHalfTheRadius) {
  Options options = test::paper_options();
  options.strategy = Strategy::kSum;
  options.radius = {0.04};
  Sampler sampler(options);
  sampler.set_centres({{0, 0, 0}});
  double sum2 = 0;
  for (int i = 0; i < 5000; ++i) {
    const Vector3 p = sampler.draw(1, i, 0).position;
    sum2 += dot(p, p);
  }
  EXPECT_NEAR(std::sqrt(sum2 / 15'000), 0.02, 4 * 0.02 / std::sqrt(2 * 15'000.0));
}

std::vector<std::vector<Vector3>> sets_of_centres() {
  Random random(43);
  const auto vector = [](const Vector3d& v) { return Vector3{v.x(), v.y(), v.z()}; };
  std::vector<std::vector<Vector3>> sets;
  sets.push_back({{0.1, 0.2, 0.3}});
  sets.emplace_back();  // sparse and dense
  for (int i = 0; i < 400; ++i) sets.back().push_back(vector(random.uniform(0, 0.5) * random.direction()));
  sets.emplace_back();  // clusters, one of them far away
  for (int i = 0; i < 600; ++i) {
    const Vector3d at = i % 3 == 0 ? Vector3d(0, 0, 0.5) : i % 3 == 1 ? Vector3d(0.1, 0, 0.5) : Vector3d(40, 0, 3);
    sets.back().push_back(vector(at + random.normal3(0.004)));
  }
  sets.emplace_back();  // every centre three times, far apart in the list
  for (int i = 0; i < 300; ++i)
    sets.back().push_back(i < 100 ? vector(random.normal3(0.05)) : sets.back()[static_cast<std::size_t>(i - 100)]);
  sets.emplace_back(40, Vector3{0.1, 0.2, 0.3});  // all in one place
  sets.emplace_back();                            // cells' borders; the origin, where signs change
  for (int i = 0; i < 512; ++i)
    sets.back().push_back({0.03125 * (i % 8 - 4), 0.03125 * (i / 8 % 8 - 4), 0.03125 * (i / 64 - 4)});
  return sets;
}

TEST(SamplerDraws, MaxAcceptsTheNearestCentreOnly) {
  const auto sets = sets_of_centres();
  for (std::size_t set = 0; set < sets.size(); ++set) {
    SCOPED_TRACE("set " + std::to_string(set));
    const std::vector<Vector3>& centres = sets[set];
    for (const double sigma : {0.0125, 0.2}) {
      Options options = test::paper_options();
      options.proposal_sigma = sigma;
      Sampler sampler(options);
      sampler.set_centres(sets[(set + 1) % sets.size()]);  // of another round
      sampler.set_centres(centres);
      int accepted = 0;
      for (int i = 0; i < 3000; ++i) {
        const Sampler::Draw d = sampler.draw(2, i, i % 100);
        std::size_t nearest = 0;
        double best2 = std::numeric_limits<double>::infinity();
        for (std::size_t j = 0; j < centres.size(); ++j) {
          const Vector3 to = d.position - centres[j];
          if (dot(to, to) < best2) best2 = dot(to, to), nearest = j;
        }
        ASSERT_EQ(d.accepted, nearest == d.centre) << "draw " << i << " about " << d.centre << ", nearest " << nearest;
        accepted += d.accepted;
      }
      EXPECT_GT(accepted, 0);
    }
  }
}

/// Share of the accepted draws that lie about the second of two handles.
double share_of_second(Strategy strategy, int first, int second) {
  Options options = test::paper_options();
  options.strategy = strategy;
  Sampler sampler(options);
  auto centres = line_of_centres(first, {0, 0, 0.6}, {0.1, 0, 0.6});
  for (const Vector3& c : line_of_centres(second, {0, 0.5, 0.6}, {0.1, 0.5, 0.6})) centres.push_back(c);
  sampler.set_centres(centres);
  int accepted = 0, near_second = 0;
  for (int i = 0; i < 400'000; ++i) {
    const Sampler::Draw d = sampler.draw(1, i, 0);
    accepted += d.accepted;
    near_second += d.accepted && d.position[1] > 0.25;
  }
  return static_cast<double>(near_second) / accepted;
}

TEST(SamplerDraws, MaxCoversHandlesMoreEvenlyThanSum) {
  // Two equal handles, one with ten times the other's affordances (paper, figure 5).
  const double sum = share_of_second(Strategy::kSum, 200, 20), max = share_of_second(Strategy::kMax, 200, 20);
  EXPECT_NEAR(sum, 1.0 / 11, 0.006);
  // Each cell of a line's centres holds the part of its Gaussian within half a spacing, the two at the ends half of it
  // in addition. About 15,000 draws are accepted: 4 standard errors.
  const auto mass = [](int n) { return 1 + (n - 1) * std::erf(0.05 / (n - 1) / 0.0125 / std::sqrt(2.0)); };
  EXPECT_NEAR(max, mass(20) / (mass(200) + mass(20)), 4 * 0.5 / std::sqrt(15'000.0));
}

// ---- Proposals on the cloud ----------------------------------------------------------------------------------------

bool inside(const std::optional<std::array<double, 6>>& box, const Vector3f& p) {
  for (std::size_t k = 0; box && k < 3; ++k) {
    const auto x = static_cast<double>(p[static_cast<Eigen::Index>(k)]);
    if (!(x >= (*box)[2 * k] && x <= (*box)[2 * k + 1])) return false;
  }
  return true;
}

/// The point that a sample must be brought to by the plain rule: the point nearest to the first accepted draw that has
/// one within the radius; a uniform draw when there is none in 100.
Sample expected_proposal(const Scene& scene, const Options& options, const Sampler& sampler, int round, int i,
                         const Sample& fallback, bool& fell_back) {
  fell_back = false;
  for (int attempt = 0; attempt < 100; ++attempt) {
    const Sampler::Draw d = sampler.draw(round, i, attempt);
    if (!d.accepted) continue;
    const Vector3d at(d.position[0], d.position[1], d.position[2]);
    double best = options.effective_radius().back();
    const Vector3f* nearest = nullptr;
    for (const Vector3f& p : scene.measured) {
      const double distance = (p.cast<double>() - at).norm();
      if (distance <= best && inside(options.workspace, p)) best = distance, nearest = &p;
    }
    if (nearest) return {nearest->x(), nearest->y(), nearest->z()};
  }
  fell_back = true;
  return fallback;
}

double distance(const Sample& a, const Sample& b) {
  return static_cast<double>(std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]));
}

TEST(SamplerProposals, AreTheNearestPointsOfTheCloud) {
  Random random(44);
  const Scene scene(test::depth_image(random, 100, 75), 75);
  Options with_workspace = test::paper_options(), sum = test::paper_options();
  with_workspace.workspace = {{-0.02, 0.3, -1, 0.01, 0, 2}};
  sum.strategy = Strategy::kSum;
  for (const Options& options : {test::paper_options(), with_workspace, sum}) {
    Sampler sampler(options);
    sampler.begin(scene.tiles, *scene.index);
    // Some centres on the cylinder, some in the air beside it, one where nothing is.
    auto centres = line_of_centres(12, {0, -0.1, 0.7}, {0, 0.1, 0.7});
    centres.push_back({0.1, 0, 0.78});
    centres.push_back({2, 2, -3});
    sampler.set_centres(centres);
    const auto samples = proposals(sampler, 3, 400), fallbacks = uniform(sampler, 3, 400);
    int fell = 0;
    for (int i = 0; i < 400; ++i) {
      const auto k = static_cast<std::size_t>(i);
      bool fell_back;
      const Sample expected = expected_proposal(scene, options, sampler, 3, i, fallbacks[k], fell_back);
      EXPECT_LT(distance(samples[k], expected), 1e-6) << "sample " << i;
      fell += fell_back;
    }
    EXPECT_LT(fell, 4);
  }
}

TEST(SamplerProposals, FarFromTheCloudAreDrawnUniformly) {
  Random random(45);
  const Scene scene(test::cube(random, 2000, 0.2));
  Options options = test::paper_options();
  Sampler sampler(options);
  sampler.begin(scene.tiles, *scene.index);
  sampler.set_centres({{5, 5, 5}, {-3, 0, 1}});
  EXPECT_EQ(proposals(sampler, 4, 300), uniform(sampler, 4, 300));
  sampler.set_centres({});
  EXPECT_EQ(proposals(sampler, 5, 300), uniform(sampler, 5, 300));
}

TEST(SamplerProposals, DoNotDependOnTheNumberOfThreads) {
  // More threads than cores, so that their order changes.
  const tbb::global_control allow(tbb::global_control::max_allowed_parallelism, 8);
  Random random(46);
  const Scene scene(test::depth_image(random, 100, 75), 75);
  const auto centres = line_of_centres(300, {0, -0.1, 0.7}, {0.02, 0.1, 0.8});
  for (const Strategy strategy : {Strategy::kSum, Strategy::kMax}) {
    Options options = test::paper_options();
    options.strategy = strategy;
    std::vector<std::vector<Sample>> results;
    for (const int threads : {1, 2, 7}) {
      tbb::task_arena arena(threads);
      arena.execute([&] {
        Sampler sampler(options);
        sampler.begin(scene.tiles, *scene.index);
        sampler.set_centres(centres);
        results.push_back(uniform(sampler, 0, 3000));
        const auto more = proposals(sampler, 1, 3000);
        results.back().insert(results.back().end(), more.begin(), more.end());
      });
    }
    for (const auto& r : results)
      EXPECT_EQ(std::memcmp(r.data(), results[0].data(), r.size() * sizeof(Sample)), 0) << "bytes differ";
  }
}

TEST(SamplerWorkspace, HoldsEverySample) {
  Random random(47);
  const Scene scene(test::cube(random, 4000, 0.4));
  Options options = test::paper_options();
  options.workspace = {{-0.05, 0.1, -0.2, 0.02, 0, 0.15}};
  Sampler sampler(options);
  sampler.begin(scene.tiles, *scene.index);
  const auto count = std::count_if(scene.measured.begin(), scene.measured.end(),
                                   [&](const Vector3f& p) { return inside(options.workspace, p); });
  EXPECT_EQ(sampler.points(), static_cast<std::size_t>(count));
  sampler.set_centres({{0.1, 0, 0.1}, {0.1, 0.02, 0}, {-0.15, 0, 0.1}});  // on its border, and outside
  for (const auto& samples : {uniform(sampler, 0, 1000), proposals(sampler, 1, 1000)})
    for (const Sample& s : samples) EXPECT_TRUE(inside(options.workspace, Vector3f(s[0], s[1], s[2])));

  Options nowhere = test::paper_options();
  nowhere.workspace = {{1, 2, 1, 2, 1, 2}};
  Sampler none(nowhere);
  none.begin(scene.tiles, *scene.index);
  EXPECT_EQ(none.points(), 0u);
}

}  // namespace
}  // namespace handhold
