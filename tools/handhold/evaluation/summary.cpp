#include "summary.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace handhold::evaluation {
namespace {

constexpr double kRadiusStep = 0.010;      // m
constexpr std::size_t kRadiusClasses = 4;  // and one for all above
constexpr double kRadiusRounding = 1e-9;   // m; 0.03 in a file is in the class from 30 mm, whatever its double is

std::size_t radius_class(double radius) {
  const double k = std::floor((radius + kRadiusRounding) / kRadiusStep);
  return static_cast<std::size_t>(std::clamp(k, 0.0, static_cast<double>(kRadiusClasses)));
}

std::string radius_name(std::size_t k) {
  const auto mm = [](std::size_t n) { return std::to_string(10 * n); };
  if (k == 0) return "below 10 mm";
  if (k == kRadiusClasses) return "40 mm and more";
  return mm(k) + " to " + mm(k + 1) + " mm";
}

std::optional<double> median(std::vector<double> values) {
  if (values.empty()) return std::nullopt;
  std::sort(values.begin(), values.end());
  const std::size_t n = values.size();
  return n % 2 ? values[n / 2] : (values[n / 2 - 1] + values[n / 2]) / 2;
}

/// Collects needed parts.
struct Tally {
  Share recall, precision;
  std::vector<double> center, axis, radius, length;

  void part(const HandleCase* found) {
    ++recall.of;
    if (!found) return;
    ++recall.count;
    center.push_back(found->offset.across);
    axis.push_back(found->offset.angle);
    radius.push_back(std::abs(found->offset.radius));
    length.push_back(std::abs(found->length_error));
  }
  Errors errors() const { return {median(center), median(axis), median(radius), median(length)}; }
  Group group(const std::string& name) const { return {name, recall, errors(), precision}; }
};

}  // namespace

Summary summarize(const std::vector<SceneScore>& scores, const std::vector<std::vector<LabelledPart>>& parts,
                  const std::vector<std::vector<Handle>>& handles) {
  Summary summary;
  Tally all;
  std::map<std::string, Tally> by_what, by_support;
  std::map<std::string, FamilyFalse> false_by_family;
  std::array<Tally, kRadiusClasses + 1> by_radius;
  for (std::size_t b = 0; b < summary.reliability.size(); ++b) {
    summary.reliability[b].from = 0.1 * static_cast<double>(b);
    summary.reliability[b].to = 0.1 * static_cast<double>(b + 1);
  }
  for (std::size_t s = 0; s < scores.size(); ++s) {
    const SceneScore& score = scores[s];
    ++summary.scenes;
    std::size_t counted = 0, wrong = 0, needed_parts = 0;
    std::vector<char> quiet(score.objects.size(), 1);
    for (std::size_t i = 0; i < score.handles.size(); ++i) {
      const HandleCase& handle = score.handles[i];
      if (handle.verdict == Verdict::kLeftOut) continue;
      const bool right = handle.verdict == Verdict::kRight;
      ++counted;
      wrong += handle.verdict == Verdict::kFalse;
      all.precision.count += right;
      ++all.precision.of;
      summary.duplicates.count += handle.verdict == Verdict::kDuplicate;
      Share& same_radius = by_radius[radius_class(handles[s][i].radius)].precision;
      same_radius.count += right;
      ++same_radius.of;
      const double confidence = std::clamp(handles[s][i].confidence, 0.0, 1.0);
      ConfidenceBin& bin = summary.reliability[std::min<std::size_t>(9, static_cast<std::size_t>(10 * confidence))];
      bin.right.count += right;
      ++bin.right.of;
      bin.mean_confidence += confidence;  // divided below
      if (handle.verdict == Verdict::kFalse && handle.object >= 0) {
        const auto object = static_cast<std::size_t>(handle.object);
        Share& sound = false_by_family[score.objects[object].family].sound;
        sound.count += handle.sound.value_or(false);
        ++sound.of;
        quiet[object] = 0;
      }
      if (!handle.sound) continue;
      summary.sound_handles.count += *handle.sound;
      ++summary.sound_handles.of;
      if (handle.verdict != Verdict::kFalse) continue;
      summary.sound_false_handles.count += *handle.sound;
      ++summary.sound_false_handles.of;
    }
    for (std::size_t k = 0; k < score.parts.size(); ++k) {
      if (!score.parts[k].needed) continue;
      ++needed_parts;
      const LabelledPart& part = parts[s][k];
      const int finder = score.parts[k].handle;
      const HandleCase* found = finder < 0 ? nullptr : &score.handles[static_cast<std::size_t>(finder)];
      all.part(found);
      by_what[part.family.empty() ? part.what : part.family].part(found);
      by_radius[radius_class(part.radius)].part(found);
      if (part.raised) by_support[*part.raised ? "raised" : "lying"].part(found);
    }
    for (std::size_t k = 0; k < quiet.size(); ++k) {
      Share& objects = false_by_family[score.objects[k].family].quiet;
      objects.count += static_cast<std::size_t>(quiet[k]);
      ++objects.of;
    }
    if (score.parts.empty()) {
      summary.quiet.count += counted == 0;
      ++summary.quiet.of;
    }
    if (needed_parts == 0) {
      summary.unneeding_quiet.count += wrong == 0;
      ++summary.unneeding_quiet.of;
    }
    summary.sound_affordances.count += score.sound_affordances;
    summary.sound_affordances.of += score.affordances;
  }
  summary.recall = all.recall;
  summary.precision = all.precision;
  summary.duplicates.of = all.precision.of;
  summary.errors = all.errors();
  for (const auto& [name, tally] : by_what) summary.by_what.push_back(tally.group(name));
  for (auto& [name, family] : false_by_family) {
    family.family = name;
    summary.false_by_family.push_back(family);
  }
  std::stable_sort(summary.false_by_family.begin(), summary.false_by_family.end(),
                   [](const FamilyFalse& a, const FamilyFalse& b) { return a.sound.of > b.sound.of; });
  for (std::size_t k = 0; k < by_radius.size(); ++k) {
    if (k == kRadiusClasses && by_radius[k].recall.of + by_radius[k].precision.of == 0) continue;
    summary.by_radius.push_back(by_radius[k].group(radius_name(k)));
  }
  for (const char* name : {"raised", "lying"}) {
    const auto found = by_support.find(name);
    if (found != by_support.end()) summary.by_support.push_back(found->second.group(name));
  }
  for (ConfidenceBin& bin : summary.reliability) {
    if (bin.right.of == 0) continue;
    bin.mean_confidence /= static_cast<double>(bin.right.of);
    summary.calibration_error += std::abs(bin.mean_confidence - bin.right.value()) * static_cast<double>(bin.right.of) /
                                 static_cast<double>(all.precision.of);
  }
  return summary;
}

}  // namespace handhold::evaluation
