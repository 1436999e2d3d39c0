#include "page_cloud.h"

#include <algorithm>
#include <cmath>

#include "projection.h"

namespace handhold {
namespace {

constexpr std::size_t kMostPoints = 1'000'000;
constexpr double kSteps = 65535;

struct Box {
  Vector3 lower = {INFINITY, INFINITY, INFINITY}, upper = {-INFINITY, -INFINITY, -INFINITY};

  void add(const float* p) {
    for (std::size_t k = 0; k < 3; ++k) {
      lower[k] = std::min(lower[k], static_cast<double>(p[k]));
      upper[k] = std::max(upper[k], static_cast<double>(p[k]));
    }
  }
  bool contains(const float* p) const {
    for (std::size_t k = 0; k < 3; ++k) {
      if (!(p[k] >= lower[k] && p[k] <= upper[k])) return false;
    }
    return true;
  }
};

/// What a thousandth of the points on either side leave, and three times as much room around it: a single point a
/// kilometre away would take all others their precision.
Box generous_box(const CloudView& cloud, const std::vector<std::size_t>& finite) {
  Box box;
  double room = 0;
  std::vector<double> values;
  const std::size_t step = std::max<std::size_t>(1, finite.size() / 50'000);
  for (std::size_t k = 0; k < 3; ++k) {
    values.clear();
    for (std::size_t i = 0; i < finite.size(); i += step) values.push_back(cloud.point(finite[i])[k]);
    box.lower[k] = quantile(values, 0.001);
    box.upper[k] = quantile(values, 0.999);
    room = std::max(room, 3 * (box.upper[k] - box.lower[k]));
  }
  for (std::size_t k = 0; k < 3; ++k) {
    box.lower[k] -= room;
    box.upper[k] += room;
  }
  return box;
}

}  // namespace

void PageCloud::append(const Vector3& point, std::string& numbers) const {
  for (std::size_t k = 0; k < 3; ++k) {
    const double share = size[k] > 0 ? (point[k] - lower[k]) / size[k] : 0;
    const auto q = static_cast<unsigned>(std::lround(kSteps * std::clamp(share, 0.0, 1.0)));
    numbers += static_cast<char>(q & 255);
    numbers += static_cast<char>(q >> 8);
  }
}

PageCloud page_cloud(const CloudView& cloud, const std::vector<std::uint32_t>& rgb) {
  PageCloud page;
  std::vector<std::size_t> shown;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (finite_point(cloud.point(i))) shown.push_back(i);
  }
  if (shown.empty()) return page;
  const Box generous = generous_box(cloud, shown);
  const std::size_t finite = shown.size();
  shown.erase(
      std::remove_if(shown.begin(), shown.end(), [&](std::size_t i) { return !generous.contains(cloud.point(i)); }),
      shown.end());
  page.far = finite - shown.size();
  page.step = (shown.size() + kMostPoints - 1) / kMostPoints;
  if (page.step > 1) {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < shown.size(); i += page.step) shown[kept++] = shown[i];
    shown.resize(kept);
  }
  page.points = shown.size();

  Box box;
  for (const std::size_t i : shown) box.add(cloud.point(i));
  page.lower = box.lower;
  page.size = add(box.upper, box.lower, -1);
  page.positions.reserve(6 * shown.size());
  for (const std::size_t i : shown) page.append(to_vector(cloud.point(i)), page.positions);

  // One colour for all is no colour: fields that nobody filled.
  if (std::any_of(rgb.begin(), rgb.end(), [&](std::uint32_t c) { return c != rgb.front(); })) {
    page.colors.reserve(3 * shown.size());
    for (const std::size_t i : shown) {
      for (const int shift : {16, 8, 0}) page.colors += static_cast<char>(rgb[i] >> shift & 255);
    }
  }
  return page;
}

std::string base64(std::string_view bytes) {
  static constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t count = std::min<std::size_t>(3, bytes.size() - i);
    unsigned group = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      group = group << 8 | (k < count ? static_cast<unsigned char>(bytes[i + k]) : 0u);
    }
    for (std::size_t k = 0; k < 4; ++k) text += k <= count ? kDigits[group >> (18 - 6 * k) & 63] : '=';
  }
  return text;
}

}  // namespace handhold
