#include "bow_groups.h"

#include <algorithm>
#include <cmath>

namespace handhold {
namespace {

constexpr double kThickestBow = 0.017;                          ///< m; radius
constexpr double kLeastTurn = 0.6, kLeastBow = 0.035;           ///< rad and m; what turns less or is shorter is no bow
constexpr double kLeastWidths = 3;                              ///< widths that a bow is long; shorter ones are bumps
constexpr double kSag = 0.002, kSagShare = 0.3;                 ///< m, and of the radius; of the piece about its middle
constexpr double kShortestPiece = 0.025, kLongestPiece = 0.06;  ///< m
constexpr double kAlikeShare = 0.25, kAlike = 0.002;            ///< m; radii of one bow's pieces
constexpr double kOnBow = 0.006;                                ///< m beside the radius: as near as this to its path
constexpr double kCosAlong = 0.766;                             ///< 40 degrees: as far from its path's direction
constexpr int kPlaces = 10, kCovered = 8;                       ///< of places along a piece, those on the path
constexpr double kCosMember = 0.9397;                           ///< 20 degrees: from the middle's

/// Whether something at `center` along `axis` is of the curved part with that path.
bool on_path(const std::vector<Vector3>& path, double radius, const Vector3& center, const Vector3& axis) {
  const std::size_t i = nearest_place(path, center), n = path.size();
  if (norm(path[i] - center) > radius + kOnBow) return false;
  const Vector3 tangent = normalized(path[std::min(n - 1, i + 2)] - path[i < 2 ? 0 : i - 2]);
  return std::fabs(dot(tangent, axis)) > kCosAlong;
}

}  // namespace

bool of_bow(const Handle& bow, const Handle& piece) {
  if (std::fabs(bow.radius - piece.radius) > kAlikeShare * std::min(bow.radius, piece.radius) + kAlike) return false;
  if (!on_path(bow.path, bow.radius, piece.center, piece.axis)) return false;
  int on = 0;
  for (int k = 0; k < kPlaces; ++k) {
    const double at = ((k + 0.5) / kPlaces - 0.5) * piece.length;
    on += on_path(bow.path, bow.radius, piece.center + at * piece.axis, piece.axis);
  }
  return on >= kCovered;
}

/// Thin parts that bend, from the best affordances on; each becomes a group about its middle.
void BowSearch::run(const std::vector<Affordance>& affordances, const DepthImage& image, Recycled<PartGroup>& groups,
                    Recycled<Bow>& bows, const Budget& budget) {
  groups.clear(), bows.clear();
  std::vector<std::uint32_t>& thin = thin_;
  thin.clear();
  for (std::uint32_t i = 0; i < affordances.size(); ++i) {
    if (affordances[i].radius <= kThickestBow) thin.push_back(i);
  }
  std::sort(thin.begin(), thin.end(), [&](std::uint32_t a, std::uint32_t b) {
    return affordances[a].quality != affordances[b].quality ? affordances[a].quality > affordances[b].quality : a < b;
  });
  std::vector<char>& taken = taken_;
  taken.assign(affordances.size(), 0);
  Bow& bow = bow_;
  for (const std::uint32_t seed : thin) {
    if (taken[seed]) continue;
    if (budget.spent()) break;
    taken[seed] = 1;
    const Affordance& s = affordances[seed];
    if (!trace_bow(image, {s.center, s.axis, s.radius}, depth_noise(norm(image.viewpoint() - s.center)), scratch_, bow))
      continue;
    std::vector<double>& widths = widths_;
    widths = bow.widths;
    const auto middle = widths.begin() + static_cast<std::ptrdiff_t>(widths.size() / 2);
    std::nth_element(widths.begin(), middle, widths.end());
    const double radius = 0.5 * *middle;
    for (const std::uint32_t i : thin) {
      if (!taken[i] && on_path(bow.path, 2 * radius, affordances[i].center, affordances[i].axis)) taken[i] = 1;
    }
    if (bow.closed || bow.turn < kLeastTurn || bow.length < std::max(kLeastBow, kLeastWidths * 2 * radius)) continue;
    if (!bow.curved() || bow.tangled(2 * radius)) continue;
    const std::size_t at = bow.path.size() / 2;
    const Vector3 axis = bow.tangent(at), to_sensor = image.viewpoint() - bow.path[at];
    const Vector3 ahead = normalized(to_sensor - dot(to_sensor, axis) * axis, any_perpendicular(axis));
    PartGroup& group = groups.next();
    group.clear();
    group.mean = {bow.path[at] - radius * ahead, axis, radius};
    const double sag = std::max(kSag, kSagShare * radius);
    const double piece = std::clamp(2 * std::sqrt(2 * sag * bow.length / bow.turn), kShortestPiece, kLongestPiece);
    group.low = -0.5 * std::min(piece, bow.length), group.high = -group.low;
    for (std::uint32_t i = 0; i < affordances.size(); ++i) {
      const Affordance& a = affordances[i];
      const double along = dot(a.center - group.mean.point, axis);
      if (along < group.low || along > group.high || std::fabs(dot(a.axis, axis)) < kCosMember) continue;
      if (norm(a.center - group.mean.point - along * axis) > radius + kOnBow) continue;
      group.members.push_back(i);
    }
    if (group.members.empty()) {
      groups.drop_last();
      continue;
    }
    group.straps = group.members.size();
    bows.next() = bow;
  }
  for (std::size_t i = 0; i < bows.size(); ++i) groups[i].bow = &bows[i];
}

}  // namespace handhold
