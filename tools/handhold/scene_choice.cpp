#include "scene_choice.h"

#include <algorithm>
#include <stdexcept>

#include "usage_error.h"

namespace handhold {

using sensor::FamilyGroup;
using sensor::FamilyHalf;
using sensor::RandomSceneOptions;

RandomSceneOptions families_named(const std::string& text, bool negatives) {
  const auto of_half = [&](FamilyHalf half) {
    return negatives ? RandomSceneOptions::negatives(half) : RandomSceneOptions::of_half(half);
  };
  if (text.empty() || text == "all") return of_half(FamilyHalf::kBoth);
  if (text == "tuning") return of_half(FamilyHalf::kTuning);
  if (text == "report") return of_half(FamilyHalf::kReport);
  RandomSceneOptions options;
  for (std::size_t from = 0; from <= text.size();) {
    const std::size_t comma = std::min(text.find(',', from), text.size());
    const std::string name = text.substr(from, comma - from);
    from = comma + 1;
    try {
      const bool graspable = sensor::family(name).group == FamilyGroup::kGraspable;
      if (graspable && negatives) {
        throw UsageError("--families: '" + name + "' has graspable parts; --set negatives takes families without");
      }
      if (graspable || negatives) options.targets.push_back(name);
      options.clutter.push_back(name);
      options.validate();
    } catch (const std::invalid_argument& error) {
      throw UsageError(std::string("--families: ") + error.what() + "; or all, tuning, report");
    }
  }
  return options;
}

}  // namespace handhold
