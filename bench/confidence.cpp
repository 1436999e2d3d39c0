// Fits the confidence of the default method's handles to simulated scenes with their truth, and says how well it holds.
#include <tbb/parallel_for.h>

#include <CLI/CLI.hpp>
#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <cmath>
#include <cstdio>
#include <exception>
#include <map>
#include <string>
#include <vector>

#include "atomic_file.h"
#include "confidence.h"
#include "files.h"
#include "handhold/io.h"
#include "handhold/localizer.h"
#include "localizer_detail.h"
#include "matching.h"

namespace handhold {
namespace {

struct Example {
  std::array<double, kFeatures> x;
  double right = 0;
  double before = 0;  ///< the confidence that the program gives now
  std::string scene, family;
};

/// Handles and what they are, of the scenes of a folder that `handhold simulate` made.
std::vector<Example> examples_of(const std::string& folder, const Options& options) {
  const auto truth = evaluation::read_truth(folder + "/truth.json");
  std::vector<const std::pair<const std::string, std::vector<evaluation::LabelledPart>>*> scenes;
  for (const auto& scene : truth) scenes.push_back(&scene);
  std::vector<std::vector<Example>> found(scenes.size());
  tbb::parallel_for(std::size_t{0}, scenes.size(), [&](std::size_t s) {
    const auto& [name, parts] = *scenes[s];
    const Cloud cloud = read_cloud(folder + "/" + name + ".pcd");
    Localizer localizer(options);
    localizer.localize(cloud.view());
    // Each straight piece for itself, before they become curved handles.
    const std::vector<PartCandidate>& candidates = LocalizerInside::candidates(localizer);
    std::vector<Handle> handles;
    for (const PartCandidate& candidate : candidates) handles.push_back(candidate.handle);
    const evaluation::SceneScore score = evaluation::score_scene(name, parts, handles);
    for (std::size_t i = 0; i < handles.size(); ++i) {
      const evaluation::HandleCase& handle = score.handles[i];
      if (handle.verdict == evaluation::Verdict::kDuplicate) continue;
      Example e;
      e.x = features(candidates[i].evidence);
      e.right = handle.verdict == evaluation::Verdict::kRight ? 1 : 0;
      e.before = handles[i].confidence;
      e.scene = name;
      if (handle.part >= 0) e.family = parts[static_cast<std::size_t>(handle.part)].family;
      found[s].push_back(e);
    }
  });
  std::vector<Example> all;
  for (const auto& scene : found) all.insert(all.end(), scene.begin(), scene.end());
  return all;
}

using Weights = Eigen::Matrix<double, kFeatures, 1>;

double probability(const Weights& w, const std::array<double, kFeatures>& x) {
  double sum = 0;
  for (std::size_t i = 0; i < kFeatures; ++i) sum += w[static_cast<Eigen::Index>(i)] * x[i];
  return 1 / (1 + std::exp(-sum));
}

/// Logistic regression by Newton's method; a ridge keeps weights small that the examples do not ask for. The feature
/// `without` (an index; negative: none) gets no weight.
Weights fit_without(const std::vector<Example>& examples, double ridge, int without) {
  Weights w = Weights::Zero();
  for (int step = 0; step < 50; ++step) {
    Eigen::Matrix<double, kFeatures, kFeatures> H = ridge * Eigen::Matrix<double, kFeatures, kFeatures>::Identity();
    H(0, 0) = 1e-6;
    Weights g = -ridge * w;
    g[0] = 0;
    for (const Example& e : examples) {
      const Eigen::Map<const Weights> x(e.x.data());
      const double p = probability(w, e.x);
      g += (e.right - p) * x;
      H += p * (1 - p) * x * x.transpose();
    }
    if (without >= 0) g[without] = 0, H.row(without).setZero(), H.col(without).setZero(), H(without, without) = 1;
    const Weights d = H.ldlt().solve(g);
    w += d;
    if (d.norm() < 1e-8) break;
  }
  return w;
}

/// A finger with less free space never speaks for a handle: where the examples have it so by chance, it says nothing.
Weights fit(const std::vector<Example>& examples, double ridge) {
  const Weights w = fit_without(examples, ridge, -1);
  return w[kUnfreeFeature] > 0 ? fit_without(examples, ridge, kUnfreeFeature) : w;
}

double log_loss(const Weights& w, const std::vector<Example>& examples) {
  double sum = 0;
  for (const Example& e : examples) {
    const double p = std::min(1 - 1e-9, std::max(1e-9, probability(w, e.x)));
    sum -= e.right > 0 ? std::log(p) : std::log(1 - p);
  }
  return sum / static_cast<double>(std::max<std::size_t>(1, examples.size()));
}

void print_quality(const char* what, const Weights& w, const std::vector<Example>& examples) {
  double above = 0, right = 0, all_right = 0;
  for (const Example& e : examples) {
    all_right += e.right;
    if (probability(w, e.x) < 0.5) continue;
    above += 1, right += e.right;
  }
  std::printf("%s: %zu candidates, %.0f right; with confidence >= 0.5: %.0f, %.0f right (%.3f); log loss %.4f\n", what,
              examples.size(), all_right, above, right, above > 0 ? right / above : 0, log_loss(w, examples));
}

int run(int argc, char** argv) {
  CLI::App app{"Fits the confidence of handles to scenes that 'handhold simulate' made"};
  std::vector<std::string> folders;
  std::string check, csv;
  double ridge = 1;
  app.add_option("FOLDER", folders, "Folders with NAME.pcd and truth.json")->required();
  app.add_option("--check", check, "Another folder, to judge the fit on");
  app.add_option("--ridge", ridge, "Weight of the sum of squared weights (no unit)")->check(CLI::PositiveNumber);
  app.add_option("--csv", csv, "Write the examples");
  CLI11_PARSE(app, argc, argv);
  Options options;
  options.min_confidence = 0;
  std::vector<Example> examples;
  for (const std::string& folder : folders) {
    const std::vector<Example> more = examples_of(folder, options);
    examples.insert(examples.end(), more.begin(), more.end());
  }
  if (!csv.empty()) {
    AtomicFile file(csv);
    char number[32];
    for (const Example& e : examples) {
      std::snprintf(number, sizeof number, ",%g,%.4f", e.right, e.before);
      file.write(e.scene + "," + e.family + number);
      for (const double v : e.x) {
        std::snprintf(number, sizeof number, ",%.6g", v);
        file.write(number);
      }
      file.write("\n");
    }
    file.commit();
  }
  const Weights w = fit(examples, ridge);
  print_quality("fitted on", w, examples);
  // How it does on scenes that it has not seen: five fits, each judged on the fifth that it left out.
  std::vector<Example> part[2];
  double loss = 0;
  for (std::size_t fold = 0; fold < 5; ++fold) {
    part[0].clear(), part[1].clear();
    std::map<std::string, std::size_t> number;
    for (const Example& e : examples) {
      const std::size_t scene = number.try_emplace(e.scene, number.size()).first->second;
      part[scene % 5 == fold].push_back(e);
    }
    loss += log_loss(fit(part[0], ridge), part[1]) / 5;
  }
  std::printf("left out by fifths: log loss %.4f\n", loss);
  if (!check.empty()) print_quality("checked on", w, examples_of(check, options));
  std::printf("constexpr double kWeights[kFeatures] = {");
  for (std::size_t i = 0; i < kFeatures; ++i) {
    std::printf("%s%.4f", i ? ", " : "", w[static_cast<Eigen::Index>(i)]);
  }
  std::printf("};\n");
  return 0;
}

}  // namespace
}  // namespace handhold

int main(int argc, char** argv) {
  try {
    return handhold::run(argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "handhold_confidence: %s\n", error.what());
    return 1;
  }
}
