// The paper's verdict on a neighbourhood: a cylindrical shell with an empty gap around it.
#include <algorithm>
#include <cmath>

#include "search.h"

namespace handhold {
namespace {

/// Centres of shells that one index query serves lie in a box of at most this diagonal (m).
constexpr float kShellGroup = 0.12f;

}  // namespace

/// Shells of the chunk's candidates, group by group of near centres.
bool Search::find_shells(Scratch& s) const {
  const auto [tiles, index] = (*layers_)[0];
  const kernels::Kernels& k = kernels::kernels();
  const double half_width = options_->finger_width / 2, gap = options_->finger_thickness;
  const auto largest_radius = [&](const Candidate& c) {
    const double z = viewpoint_ ? norm(c.position - *viewpoint_) : 0.0;
    // Noise may carry single points of the part beyond its own radius.
    // Far away the noise of such a camera would swallow what stands beside the part: it counts up to a tenth of the
    // hand.
    return options_->hand_aperture / 2 + std::min(2 * depth_noise(z), 0.1 * options_->hand_aperture) + 0.002;
  };
  for (std::size_t first = 0; first < s.candidates.size();) {
    float low[3], high[3];
    double farthest = 0;
    std::size_t last = first;
    if (budget_.spent()) return false;
    for (; last < s.candidates.size(); ++last) {
      const Candidate& c = s.candidates[last];
      float l[3], h[3], d2 = 0;
      for (std::size_t j = 0; j < 3; ++j) {
        const auto x = static_cast<float>(c.affordance.center[j]);
        l[j] = last == first ? x : std::min(low[j], x), h[j] = last == first ? x : std::max(high[j], x);
        d2 += (h[j] - l[j]) * (h[j] - l[j]);
      }
      if (d2 > kShellGroup * kShellGroup) break;
      std::copy(l, l + 3, low), std::copy(h, h + 3, high);
      farthest = std::max(farthest, std::hypot(largest_radius(c) + gap, half_width));
    }
    s.shells.fill(*tiles, *index, low, high, static_cast<float>(farthest));
    for (; first < last; ++first) {
      Candidate& c = s.candidates[first];
      Affordance& a = c.affordance;
      kernels::ShellQuery q{};
      for (std::size_t j = 0; j < 3; ++j) {
        q.centre[j] = static_cast<float>(a.center[j]);
        q.axis[j] = static_cast<float>(a.axis[j]);
      }
      q.half_width = static_cast<float>(half_width);
      q.start_radius = static_cast<float>(0.7 * a.radius);
      q.max_radius = static_cast<float>(largest_radius(c));
      q.gap = static_cast<float>(gap);
      q.max_gap_points =
          static_cast<std::int32_t>(std::min(1e9, std::floor(options_->shell_gap_area_mm2 * 1e-6 * c.density)));
      q.min_inner_points = std::max(
          1, static_cast<std::int32_t>(std::min(1e9, std::ceil(options_->shell_inner_area_mm2 * 1e-6 * c.density))));
      kernels::ShellResult r;
      k.shell(tiles->view(), s.shells.view(), q, s.kernel.data(), r);
      Step& step = s.reached[c.entry];
      if (r.status != kernels::kShellFound) {
        step = r.status == kernels::kShellEmpty ? Step::kShellEmpty : Step::kNoGap;
        continue;
      }
      step = Step::kAffordance;
      a.shell_radius = static_cast<double>(r.radius);
      a.gap = static_cast<double>(r.free_to) - static_cast<double>(r.radius);
      s.found.push_back({a, c.residual, c.scale});
    }
  }
  return true;
}

}  // namespace handhold
