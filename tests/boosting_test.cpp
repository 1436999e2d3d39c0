// The trees that the confidence is made of, fitted to examples whose truth is known.
#include "boosting.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace handhold::boosting {
namespace {

/// Right with the probability of a rule that no sum of single features has; `free` (kUnfreeFeature) speaks the wrong
/// way.
std::vector<Example> examples(std::size_t n, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(-1, 1);
  std::vector<Example> all(n);
  for (Example& e : all) {
    for (double& x : e.x) x = uniform(random);
    const double p = (e.x[0] > 0) == (e.x[1] > 0.2) ? 0.9 : 0.1;
    const double shifted = std::min(1.0, std::max(0.0, p + 0.05 * e.x[kUnfreeFeature]));
    e.right = 0.5 * (uniform(random) + 1) < shifted ? 1 : 0;
  }
  return all;
}

TEST(Boosting, LearnsWhatNoSingleFeatureTells) {
  const Model model = fit(examples(4000, 1), {});
  double right = 0, mean = 0, truth = 0;
  const std::vector<Example> others = examples(2000, 2);
  for (const Example& e : others) {
    const double p = model.probability(e.x);
    right += (p > 0.5) == (e.right > 0), mean += p / 2000, truth += e.right / 2000;
  }
  EXPECT_GT(right / 2000, 0.85) << "0.9 is the best there is";
  EXPECT_NEAR(mean, truth, 0.03) << "a probability";
}

TEST(Boosting, TheFallingFeatureNeverRaisesTheProbability) {
  Settings settings;
  settings.falling_feature = kUnfreeFeature;
  const std::vector<Example> some = examples(3000, 3);
  const Model free = fit(some, {}), bound = fit(some, settings);
  int raised = 0;
  for (std::size_t i = 0; i < 50; ++i) {
    Example e = some[i];
    double last = 1, last_free = 1;
    for (double x = -1; x <= 1; x += 0.02) {
      e.x[kUnfreeFeature] = x;
      const double p = bound.probability(e.x), q = free.probability(e.x);
      EXPECT_LE(p, last + 1e-12);
      raised += q > last_free + 1e-12;
      last = p, last_free = q;
    }
  }
  EXPECT_GT(raised, 0) << "without the bound it does";
}

TEST(Boosting, StandsExamplesThatSayNothing) {
  EXPECT_TRUE(fit({}, {}).trees.empty());
  std::vector<Example> same(100);
  for (Example& e : same) e.x.fill(1), e.right = 1;
  EXPECT_TRUE(fit(same, {}).trees.empty()) << "all are right";
  for (std::size_t i = 0; i < 30; ++i) same[i].right = 0;
  const Model model = fit(same, {});
  EXPECT_NEAR(model.probability(same[0].x), 0.7, 1e-6) << "nothing tells them apart";
}

}  // namespace
}  // namespace handhold::boosting
