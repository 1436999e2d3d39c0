// Fits the confidence of the default method's handles to simulated scenes with their truth, and says how well it holds.
#include <tbb/parallel_for.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>
#include <exception>
#include <map>
#include <string>
#include <vector>

#include "atomic_file.h"
#include "boosting.h"
#include "confidence.h"
#include "files.h"
#include "handhold/io.h"
#include "handhold/localizer.h"
#include "localizer_detail.h"
#include "matching.h"

namespace handhold {
namespace {

struct Example : boosting::Example {
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
    const Recycled<PartCandidate>& candidates = LocalizerInside::candidates(localizer);
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

boosting::Model fit(const std::vector<Example>& examples, const boosting::Settings& settings) {
  return boosting::fit({examples.begin(), examples.end()}, settings);
}

/// As a piece of C++ that confidence.cpp includes.
void write_model(const boosting::Model& model, const std::string& path) {
  AtomicFile file(path);
  char number[32];
  const auto put = [&](const auto& values, const char* format) {
    file.write("{");
    for (std::size_t i = 0; i < values.size(); ++i) {
      std::snprintf(number, sizeof number, format, static_cast<double>(values[i]));
      file.write(std::string(i ? ", " : "") + number);
    }
    file.write("}");
  };
  std::snprintf(number, sizeof number, "%.9g", model.start);
  file.write("// Log odds, and what each tree adds.\nconstexpr double kStart = " + std::string(number) +
             ";\nconstexpr ConfidenceTree kTrees[] = {\n");
  for (const ConfidenceTree& tree : model.trees) {
    file.write("    {");
    put(tree.feature, "%g"), file.write(", ");
    put(tree.threshold, "%.6ef"), file.write(", ");
    put(tree.value, "%.3ef"), file.write("},\n");
  }
  file.write("};\n");
  file.commit();
}

double log_loss(const boosting::Model& model, const std::vector<Example>& examples) {
  double sum = 0;
  for (const Example& e : examples) {
    const double p = std::min(1 - 1e-9, std::max(1e-9, model.probability(e.x)));
    sum -= e.right > 0 ? std::log(p) : std::log(1 - p);
  }
  return sum / static_cast<double>(std::max<std::size_t>(1, examples.size()));
}

void print_quality(const char* what, const boosting::Model& model, const std::vector<Example>& examples) {
  double above = 0, right = 0, all_right = 0;
  for (const Example& e : examples) {
    all_right += e.right;
    if (model.probability(e.x) < 0.5) continue;
    above += 1, right += e.right;
  }
  std::printf("%s: %zu candidates, %.0f right; with confidence >= 0.5: %.0f, %.0f right (%.3f); log loss %.4f\n", what,
              examples.size(), all_right, above, right, above > 0 ? right / above : 0, log_loss(model, examples));
}

int run(int argc, char** argv) {
  CLI::App app{"Fits the confidence of handles to scenes that 'handhold simulate' made"};
  std::vector<std::string> folders;
  std::string check, csv, write;
  int seeds = 1;
  boosting::Settings settings;
  settings.falling_feature = kUnfreeFeature;
  app.add_option("FOLDER", folders, "Folders with NAME.pcd and truth.json")->required();
  app.add_option("--check", check, "Another folder, to judge the fit on");
  app.add_option("--seeds", seeds, "Searches of each scene, with seeds from 1 on")->check(CLI::PositiveNumber);
  app.add_option("--trees", settings.trees, "How many trees")->check(CLI::PositiveNumber);
  app.add_option("--rate", settings.rate, "Share of each tree's step that is taken, 0 to 1")
      ->check(CLI::Range(1e-3, 1.0));
  app.add_option("--least-leaf", settings.least_leaf, "Examples that a leaf has at least")->check(CLI::PositiveNumber);
  app.add_option("--csv", csv, "Write the examples");
  app.add_option("--write", write, "Write the model: engine/src/confidence_model.inc");
  CLI11_PARSE(app, argc, argv);
  Options options;
  options.min_confidence = 0;
  std::vector<Example> examples;
  for (int seed = 1; seed <= seeds; ++seed) {
    options.seed = static_cast<std::uint64_t>(seed);
    for (const std::string& folder : folders) {
      const std::vector<Example> more = examples_of(folder, options);
      examples.insert(examples.end(), more.begin(), more.end());
    }
  }
  options.seed = 1;
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
  const boosting::Model model = fit(examples, settings);
  print_quality("fitted on", model, examples);
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
    loss += log_loss(fit(part[0], settings), part[1]) / 5;
  }
  std::printf("left out by fifths: log loss %.4f\n", loss);
  if (!check.empty()) print_quality("checked on", model, examples_of(check, options));
  if (!write.empty()) write_model(model, write);
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
