// The paper's verdict on a neighbourhood: a cylindrical shell with an empty gap around it.
#include <algorithm>
#include <cmath>

#include "search.h"

namespace handhold {
namespace {

/// Centres of shells that one index query serves lie in a box of at most this diagonal (m).
constexpr float kShellGroup = 0.12f;

}  // namespace

kernels::ShellLimits shell_limits(const Options& o) {
  return {o.hand_aperture, o.finger_width / 2, o.finger_thickness, o.shell_gap_area_mm2, o.shell_inner_area_mm2};
}

/// Shells of the chunk's candidates, group by group of near centres.
bool Search::find_shells(Scratch& s) const {
  const auto [tiles, index] = (*layers_)[0];
  const kernels::Kernels& k = kernels::kernels();
  const kernels::ShellLimits limits = shell_limits(*options_);
  s.queries.clear();
  for (const Candidate& c : s.candidates) {
    const Affordance& a = c.affordance;
    kernels::Place place;
    std::copy_n(a.center.data(), 3, place.center), std::copy_n(a.axis.data(), 3, place.axis);
    s.queries.push_back(kernels::shell_query(limits, fit_limits(*options_, c.scale, false, viewpoint_),
                                             c.position.data(), place, a.radius, c.density));
  }
  for (std::size_t first = 0; first < s.candidates.size();) {
    float low[3], high[3];
    float farthest = 0;
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
      const kernels::ShellQuery& q = s.queries[last];
      farthest = std::max(farthest, std::hypot(q.max_radius + q.gap, q.half_width));
    }
    s.shells.fill(*tiles, *index, low, high, 1.00001f * farthest);
    for (; first < last; ++first) {
      Candidate& c = s.candidates[first];
      Affordance& a = c.affordance;
      kernels::ShellResult r;
      k.shell(tiles->view(), s.shells.view(), s.queries[first], s.kernel.data(), r);
      Step& step = s.reached[c.entry];
      if (r.status != kernels::kShellFound) {
        step = static_cast<Step>(kernels::end_of_shell(r));
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
