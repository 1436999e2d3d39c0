#include "boosting.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

namespace handhold::boosting {
namespace {

constexpr std::size_t kBins = 64;
constexpr float kNever = std::numeric_limits<float>::max();  ///< a threshold that nothing exceeds

/// Thresholds of each feature at the quantiles of the examples: bin b holds what is above threshold b - 1 and not above
/// threshold b.
struct Bins {
  std::array<std::vector<float>, kFeatures> thresholds;
  std::vector<std::array<std::uint8_t, kFeatures>> of;  ///< bin of each example's features

  explicit Bins(const std::vector<Example>& examples) : of(examples.size()) {
    std::vector<float> values(examples.size());
    for (std::size_t f = 0; f < kFeatures; ++f) {
      for (std::size_t i = 0; i < examples.size(); ++i) values[i] = static_cast<float>(examples[i].x[f]);
      std::sort(values.begin(), values.end());
      std::vector<float>& t = thresholds[f];
      for (std::size_t b = 1; b < kBins && !values.empty(); ++b) {
        const std::size_t at = b * values.size() / kBins;
        if (at == 0 || !(values[at] > values.front())) continue;
        const float below = *(std::lower_bound(values.begin(), values.end(), values[at]) - 1);
        const float middle = 0.5f * (below + values[at]);
        if (middle < values[at] && (t.empty() || middle > t.back())) t.push_back(middle);
      }
      for (std::size_t i = 0; i < examples.size(); ++i) {
        const double x = examples[i].x[f];
        std::size_t b = 0;
        while (b < t.size() && x > static_cast<double>(t[b])) ++b;
        of[i][f] = static_cast<std::uint8_t>(b);
      }
    }
  }
};

/// Sums of the first and second derivative of the loss, and how many examples there are.
struct Sums {
  double g = 0, h = 0, n = 0;
  Sums operator-(const Sums& o) const { return {g - o.g, h - o.h, n - o.n}; }
};

/// What a leaf's value may be.
struct Bounds {
  double low = -1e9, high = 1e9;
};

class Grower {
 public:
  Grower(const Bins& bins, const Settings& settings) : bins_(bins), settings_(settings) {}

  ConfidenceTree grow(const std::vector<double>& g, const std::vector<double>& h) {
    constexpr std::size_t kInner = kConfidenceSplits, kAll = 2 * kInner + 1;
    ConfidenceTree tree;
    tree.feature.fill(0), tree.threshold.fill(kNever), tree.value.fill(0);
    std::array<Sums, kAll> sums{};
    std::array<Bounds, kAll> bounds;
    std::vector<std::uint8_t> node(g.size(), 0);
    for (std::size_t i = 0; i < g.size(); ++i) sums[0].g += g[i], sums[0].h += h[i], sums[0].n += 1;
    for (std::size_t first = 0; first < kInner; first = 2 * first + 1) {
      const std::size_t level = first + 1;  // how many nodes it has
      histogram_.assign(level * kFeatures * kBins, {});
      for (std::size_t i = 0; i < g.size(); ++i) {
        Sums* of = &histogram_[(node[i] - first) * kFeatures * kBins];
        for (std::size_t f = 0; f < kFeatures; ++f) {
          Sums& s = of[f * kBins + bins_.of[i][f]];
          s.g += g[i], s.h += h[i], s.n += 1;
        }
      }
      std::array<std::uint8_t, kInner> bin{};
      for (std::size_t k = first; k < first + level; ++k) {
        split(k, &histogram_[(k - first) * kFeatures * kBins], sums, bounds, tree, bin);
      }
      for (std::size_t i = 0; i < g.size(); ++i) {
        const std::size_t k = node[i];
        node[i] = static_cast<std::uint8_t>(2 * k + 1 + (bins_.of[i][tree.feature[k]] > bin[k]));
      }
    }
    for (std::size_t leaf = 0; leaf <= kInner; ++leaf) {
      const std::size_t k = kInner + leaf;
      tree.value[leaf] = static_cast<float>(settings_.rate * value(sums[k], bounds[k]));
    }
    return tree;
  }

 private:
  double value(const Sums& s, const Bounds& b) const {
    return std::clamp(s.h > 0 ? s.g / (s.h + settings_.ridge) : 0.0, b.low, b.high);
  }
  /// By how much the loss falls, to second order.
  double gain(const Sums& s, double v) const { return s.g * v - 0.5 * (s.h + settings_.ridge) * v * v; }

  /// The best split of a node; none: all examples go to the lower child.
  void split(std::size_t k, const Sums* histogram, std::array<Sums, 2 * kConfidenceSplits + 1>& sums,
             std::array<Bounds, 2 * kConfidenceSplits + 1>& bounds, ConfidenceTree& tree,
             std::array<std::uint8_t, kConfidenceSplits>& bin) const {
    const Sums all = sums[k];
    double best = gain(all, value(all, bounds[k])) + 1e-9;
    const std::size_t low = 2 * k + 1, high = 2 * k + 2;
    sums[low] = all, sums[high] = {};
    bounds[low] = bounds[high] = bounds[k];
    bin[k] = 255;
    for (std::size_t f = 0; f < kFeatures; ++f) {
      Sums below;
      for (std::size_t b = 0; b < bins_.thresholds[f].size(); ++b) {
        const Sums& s = histogram[f * kBins + b];
        below.g += s.g, below.h += s.h, below.n += s.n;
        const Sums above = all - below;
        if (below.n < settings_.least_leaf || above.n < settings_.least_leaf) continue;
        const double v = value(below, bounds[k]), w = value(above, bounds[k]);
        const bool falls = static_cast<int>(f) == settings_.falling_feature;
        if (falls && w > v) continue;
        const double sum = gain(below, v) + gain(above, w);
        if (sum <= best) continue;
        best = sum;
        tree.feature[k] = static_cast<std::uint8_t>(f), tree.threshold[k] = bins_.thresholds[f][b];
        bin[k] = static_cast<std::uint8_t>(b);
        sums[low] = below, sums[high] = above;
        bounds[low] = bounds[high] = bounds[k];
        if (falls) bounds[low].low = bounds[high].high = 0.5 * (v + w);
      }
    }
  }

  const Bins& bins_;
  const Settings& settings_;
  std::vector<Sums> histogram_;
};

double probability_of(double log_odds) {
  return 1 / (1 + std::exp(-log_odds));
}

}  // namespace

double Model::probability(const std::array<double, kFeatures>& x) const {
  double sum = start;
  for (const ConfidenceTree& tree : trees) sum += tree(x);
  return probability_of(sum);
}

Model fit(const std::vector<Example>& examples, const Settings& settings) {
  Model model;
  double right = 0;
  for (const Example& e : examples) right += e.right;
  const auto all = static_cast<double>(examples.size());
  if (!(right > 0) || !(right < all)) return model;
  model.start = std::log(right / (all - right));
  const Bins bins(examples);
  Grower grower(bins, settings);
  std::vector<double> sum(examples.size(), model.start), g(examples.size()), h(examples.size());
  for (int t = 0; t < settings.trees; ++t) {
    for (std::size_t i = 0; i < examples.size(); ++i) {
      const double p = probability_of(sum[i]);
      g[i] = examples[i].right - p, h[i] = p * (1 - p);
    }
    model.trees.push_back(grower.grow(g, h));
    for (std::size_t i = 0; i < examples.size(); ++i) sum[i] += model.trees.back()(examples[i].x);
  }
  return model;
}

}  // namespace handhold::boosting
