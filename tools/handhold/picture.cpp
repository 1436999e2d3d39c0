#include "picture.h"

#include <stdexcept>

#include "painter.h"
#include "png_file.h"

namespace handhold {
namespace {

constexpr int kLargest = 16384;  // px

Size picture_size(const CloudView& cloud, const PictureOptions& options) {
  if (options.width < 0 || options.height < 0 || options.width > kLargest || options.height > kLargest) {
    throw std::invalid_argument("picture size " + std::to_string(options.width) + " x " +
                                std::to_string(options.height) + ": 0 to " + std::to_string(kLargest) +
                                " pixels are possible");
  }
  double width = 1280, height = 960;
  if (cloud.organized() && cloud.width > 1 && cloud.width <= kLargest && cloud.height <= kLargest) {
    const double times = std::ceil(std::max({1.0, 640.0 / cloud.width, 480.0 / cloud.height}));
    width = std::min(times * cloud.width, double(kLargest));  // a very long and flat one is not magnified to the end
    height = std::min(times * cloud.height, double(kLargest));
  }
  if (options.width > 0 && options.height > 0) return {options.width, options.height};
  const auto rounded = [](double x) { return static_cast<int>(std::clamp(std::round(x), 1.0, double(kLargest))); };
  if (options.width > 0) return {options.width, rounded(options.width * height / width)};
  if (options.height > 0) return {rounded(options.height * width / height), options.height};
  return {rounded(width), rounded(height)};
}

}  // namespace

void write_picture(const std::string& path, const CloudView& cloud, const std::vector<std::uint32_t>& rgb,
                   const Result& result, const PictureOptions& options) {
  const Size size = picture_size(cloud, options);
  if (!rgb.empty() && rgb.size() != cloud.size()) {
    throw std::invalid_argument("write_picture: " + std::to_string(rgb.size()) + " colours for " +
                                std::to_string(cloud.size()) + " points: one for each point, or none, is needed");
  }
  Painter picture(cloud, rgb, size);
  if (options.labels) picture.plan_legend(result, options.samples);
  if (picture.finite_points() == 0) {
    picture.draw_message(cloud.size() == 0 ? "no points" : "no finite points");
  }
  picture.draw_samples(options.samples);
  if (options.affordances) {
    for (const Affordance& affordance : result.affordances) picture.draw_affordance(affordance);
  }
  // The best one last: it lies on top. Its number comes first: it has the choice of places.
  for (std::size_t i = result.handles.size(); i-- > 0;) picture.draw_handle(result.handles[i], handle_color(i));
  for (const PictureLine& line : options.lines) picture.draw_line(line.points, handle_color(line.handle));
  for (std::size_t i = 0; options.labels && i < result.handles.size(); ++i) {
    picture.draw_number(result.handles[i], std::to_string(i + 1), handle_color(i));
  }
  if (options.labels) picture.draw_legend();
  write_png(path, picture.canvas());
}

}  // namespace handhold
