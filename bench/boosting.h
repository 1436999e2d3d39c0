// Gradient boosting of shallow trees for a probability: each tree is one Newton step of the logistic loss (Friedman
// 2001; with the regularized leaf values of Chen & Guestrin 2016).
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "confidence.h"

namespace handhold::boosting {

struct Example {
  std::array<double, kFeatures> x;
  double right = 0;  ///< 0 or 1
};

struct Settings {
  int trees = 480;
  double rate = 0.1;         ///< share of each step that is taken
  double least_leaf = 60;    ///< examples in a leaf
  double ridge = 1;          ///< in units of the loss's second derivative
  int falling_feature = -1;  ///< the probability may not rise with it; negative: there is none
};

struct Model {
  double start = 0;  ///< log odds before the first tree
  std::vector<ConfidenceTree> trees;

  double probability(const std::array<double, kFeatures>& x) const;
};

/// The same examples give the same model.
Model fit(const std::vector<Example>& examples, const Settings& settings);

}  // namespace handhold::boosting
