#include "chain.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

#include "vec3.h"

namespace handhold {
namespace {

constexpr double kThickest = 0.018;                    ///< m; radius: what is thicker is a body and no bow
constexpr double kRadiusShare = 0.3, kRadius = 0.002;  ///< m
constexpr double kMeet = 0.012;                        ///< m; ends as near as this meet
constexpr double kCosMost = 0.17364817766693041;       ///< 80 degrees: a sharper turn is another part
constexpr double kCosLeast = 0.97814760073380569;      ///< 12 degrees: straight on is no turn

using Chain = ChainSearch::Chain;

/// Distance of the ends at which two chains meet, infinity when they do not; `a_end`, `b_end` say which.
double meeting(const Chain& a, const Chain& b, int& a_end, int& b_end) {
  double best = std::numeric_limits<double>::infinity();
  const double large = std::max(a.radius, b.radius);
  if (std::fabs(a.radius - b.radius) > kRadiusShare * large + kRadius) return best;
  for (int i = 0; i < 2; ++i) {
    for (int k = 0; k < 2; ++k) {
      const double distance = norm(a.end(i) - b.end(k)), turn = -dot(a.out(i), b.out(k));
      if (distance > kMeet || turn < kCosMost || turn > kCosLeast || distance >= best) continue;
      best = distance, a_end = i, b_end = k;
    }
  }
  return best;
}

void join(Chain& a, Chain& b, int a_end, int b_end) {
  if (a_end == 0) std::reverse(a.path.begin(), a.path.end());
  if (b_end == 1) std::reverse(b.path.begin(), b.path.end());
  a.path.back() = 0.5 * (a.path.back() + b.path.front());
  a.path.insert(a.path.end(), b.path.begin() + 1, b.path.end());
  const double n = static_cast<double>(a.pieces.size()), m = static_cast<double>(b.pieces.size());
  a.radius = (n * a.radius + m * b.radius) / (n + m);
  a.pieces.insert(a.pieces.end(), b.pieces.begin(), b.pieces.end());
  b.taken = true;
}

}  // namespace

/// The best piece, as long as all of them.
void ChainSearch::make_one(const Chain& chain, std::vector<Handle>& handles) {
  Handle& h = handles[*std::min_element(chain.pieces.begin(), chain.pieces.end())];
  members_.clear();
  for (const std::size_t i : chain.pieces) {
    more_.clear();
    std::set_union(members_.begin(), members_.end(), handles[i].affordances.begin(), handles[i].affordances.end(),
                   std::back_inserter(more_));
    std::swap(members_, more_);
  }
  h.affordances = members_;
  h.path = chain.path;
  h.length = 0;
  for (std::size_t i = 0; i + 1 < h.path.size(); ++i) h.length += norm(h.path[i + 1] - h.path[i]);
  double left = 0.5 * h.length;
  for (std::size_t i = 0; i + 1 < h.path.size(); ++i) {
    const double step = norm(h.path[i + 1] - h.path[i]);
    if (left > step && i + 2 < h.path.size()) {
      left -= step;
      continue;
    }
    const Vector3 tangent = normalized(h.path[i + 1] - h.path[i]);
    h.center = h.path[i] + left * tangent;
    h.axis = canonical_axis(tangent);
    break;
  }
  h.radius = chain.radius;
  h.approach = normalized(h.approach - dot(h.approach, h.axis) * h.axis, any_perpendicular(h.axis));
}

void ChainSearch::join_curved(std::vector<Handle>& handles, Spares<Handle>& spares) {
  Recycled<Chain>& chains = chains_;
  chains.clear();
  for (std::size_t i = 0; i < handles.size(); ++i) {
    const Handle& h = handles[i];
    if (h.radius > kThickest || !(h.length > 0)) continue;
    Chain& chain = chains.next();
    chain.pieces.assign(1, i);
    chain.path = h.path;
    chain.radius = h.radius, chain.taken = false;
    if (h.path.size() >= 2) continue;
    chain.path.resize(2);
    chain.path[0] = h.center - 0.5 * h.length * h.axis, chain.path[1] = h.center + 0.5 * h.length * h.axis;
  }
  for (;;) {
    double least = std::numeric_limits<double>::infinity();
    std::size_t a = 0, b = 0;
    int a_end = 0, b_end = 0;
    for (std::size_t i = 0; i < chains.size(); ++i) {
      for (std::size_t k = i + 1; k < chains.size() && !chains[i].taken; ++k) {
        int i_end = 0, k_end = 0;
        if (chains[k].taken) continue;
        const double distance = meeting(chains[i], chains[k], i_end, k_end);
        if (distance < least) least = distance, a = i, b = k, a_end = i_end, b_end = k_end;
      }
    }
    if (!(least < std::numeric_limits<double>::infinity())) break;
    join(chains[a], chains[b], a_end, b_end);
  }
  std::vector<char>& gone = gone_;
  gone.assign(handles.size(), 0);
  for (const Chain& chain : chains) {
    if (chain.taken || chain.pieces.size() < 2) continue;
    make_one(chain, handles);
    for (const std::size_t i : chain.pieces) gone[i] = 1;
    gone[*std::min_element(chain.pieces.begin(), chain.pieces.end())] = 0;
  }
  std::size_t kept = 0;
  for (std::size_t i = 0; i < handles.size(); ++i) {
    if (gone[i]) continue;
    if (kept != i) std::swap(handles[kept], handles[i]);
    ++kept;
  }
  spares.take(handles, kept);
}

}  // namespace handhold
