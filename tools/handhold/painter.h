// The cloud and what was found in it, as pixels. Part of picture.cpp and case_picture.cpp.
#pragma once

#include <array>
#include <cstdio>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "canvas.h"
#include "colors.h"
#include "handhold/result.h"
#include "projection.h"
#include "surface.h"

namespace handhold {

constexpr double kPi = 3.14159265358979323846;
constexpr Color kInk{0.02f, 0.02f, 0.025f}, kText{0.9f, 0.91f, 0.92f};

struct Size {
  int width, height;
};

/// Draws a cloud as a shaded surface, and things in it as lines.
class Painter {
 public:
  /// The cloud as its sensor saw it, or as `view` has it.
  Painter(const CloudView& cloud, const std::vector<std::uint32_t>& rgb, Size size,
          std::optional<Projection> view = std::nullopt)
      : canvas_(size.width, size.height, kBackground),
        depth_(size.width, size.height),
        unit_(std::max(1.0, std::min(size.width / 640.0, size.height / 480.0))),
        view_(std::move(view)) {
    for (std::size_t i = 0; i < cloud.size(); ++i) finite_ += finite_point(cloud.point(i));
    if (finite_ > 0) draw_surface(cloud, rgb);
  }

  // Those that came furthest lie on top.
  void draw_samples(const std::vector<Sample>& samples) {
    for (std::size_t step = 0; step < kStepCount; ++step) {
      for (const Sample& sample : samples) {
        Segment dot{};
        if (sample.step != static_cast<Step>(step) || !project(sample.position, sample.position, dot)) continue;
        canvas_.stroke({dot}, 2.4 * unit_, step_color(sample.step), 0.85f);
      }
    }
  }

  void draw_affordance(const Affordance& affordance) {
    constexpr double kHalf = 0.005;  // m
    Segment axis{}, dot{};
    if (project(add(affordance.center, affordance.axis, -kHalf), add(affordance.center, affordance.axis, kHalf),
                axis)) {
      canvas_.stroke({axis}, 1.4 * unit_, kCyan, 0.5f);
    }
    if (project(affordance.center, affordance.center, dot)) canvas_.stroke({dot}, 2.6 * unit_, kCyan, 0.55f);
  }

  void draw_handle(const Handle& handle, const Color& color) {
    std::vector<Segment> seen, hidden;
    for (const Handle& piece : straight_pieces(handle)) {
      for (const Line& line : outline(piece)) split(line, seen, hidden);
    }
    canvas_.stroke(hidden, 1.6 * unit_, color, 0.4f);
    canvas_.stroke(seen, 4.2 * unit_, kInk, 0.55f);
    canvas_.stroke(seen, 2.2 * unit_, color, 1);
  }

  // Nothing hides it: what it shows is not in the cloud.
  void draw_line(const std::vector<Vector3>& points, const Color& color) {
    std::vector<Segment> segments;
    for (std::size_t i = 0; i + 1 < points.size(); ++i) {
      Segment s{};
      if (project(points[i], points[i + 1], s)) segments.push_back(s);
    }
    canvas_.stroke(segments, 3 * unit_, kInk, 0.5f);
    canvas_.stroke(segments, 1.5 * unit_, color, 1);
  }

  // A curved part: its centre line and its outline as seen from the eye.
  void draw_tube(const std::vector<Vector3>& centre_line, double radius, const Color& color) {
    if (!view_ || centre_line.size() < 2) return;
    std::vector<Segment> middle, outline;
    std::array<Vector3, 2> before;
    for (std::size_t i = 0; i < centre_line.size(); ++i) {
      const Vector3 &p = centre_line[i], &from = centre_line[i ? i - 1 : 0];
      const Vector3& to = centre_line[std::min(i + 1, centre_line.size() - 1)];
      const Vector3 side = cross(add(to, from, -1), add(view_->eye, p, -1));
      const double length = norm(side), offset = length > 1e-12 ? radius / length : 0;
      const std::array<Vector3, 2> sides = {add(p, side, offset), add(p, side, -offset)};
      Segment s{};
      if (i > 0 && project(centre_line[i - 1], p, s)) middle.push_back(s);
      for (std::size_t k = 0; i > 0 && k < 2; ++k) {
        if (project(before[k], sides[k], s)) outline.push_back(s);
      }
      if ((i == 0 || i + 1 == centre_line.size()) && project(sides[0], sides[1], s)) outline.push_back(s);
      before = sides;
    }
    canvas_.stroke(outline, 3.6 * unit_, kInk, 0.55f);
    canvas_.stroke(outline, 1.8 * unit_, color, 1);
    canvas_.stroke(middle, 1.2 * unit_, color, 0.8f);
  }

  // The number stands at an end of the cylinder, or beside it, where no other number is.
  void draw_number(const Handle& handle, const std::string& number, const Color& color) {
    const int scale = static_cast<int>(std::lround(2 * unit_)), halo = static_cast<int>(std::lround(2 * unit_));
    const int width = text_width(number, scale), height = (kGlyphHeight - 1) * scale;
    double u, v, z;
    if (!view_ || !view_->project(handle.center, u, v, z)) return;
    std::vector<std::pair<double, double>> places;
    for (double sign : {1.0, -1.0}) {
      double ue, ve, ze;
      if (!view_->project(add(handle.center, handle.axis, sign * handle.length / 2), ue, ve, ze)) continue;
      const double length = std::hypot(ue - u, ve - v);
      const double radius = handle.radius * norm(view_->a_across()) / ze;
      const double away = (length < 1 ? 1 : (length + 0.5 * radius + 0.8 * (width + height) / 2 + 5 * unit_) / length);
      places.emplace_back(u + away * (ue - u), v + away * (ve - v));
      // Across the axis, at the middle.
      const double across = radius + width / 2.0 + 8 * unit_;
      if (length >= 1)
        places.emplace_back(u - sign * across * (ve - v) / length, v + across * (ue - u) / length * sign);
    }
    // Upper ones first: there is less in front of them.
    std::stable_sort(places.begin(), places.end(), [](const auto& a, const auto& b) { return a.second < b.second; });
    places.emplace_back(u, v);
    for (std::size_t i = 0; i < places.size(); ++i) {
      if (!(std::abs(places[i].first) < 1e6 && std::abs(places[i].second) < 1e6)) continue;  // no pixel, and no int
      const int x = static_cast<int>(std::lround(places[i].first - width / 2.0));
      const int y = static_cast<int>(std::lround(places[i].second - height / 2.0));
      const Box box{x - halo, y - halo, x + width + halo, y + height + halo};
      const bool inside =
          box.x0 >= 0 && box.y0 >= 0 && box.x1 <= canvas_.width() && box.y1 <= canvas_.height() - legend_;
      if (i + 1 < places.size() && (!inside || overlaps(box))) continue;
      taken_.push_back(box);
      canvas_.text(number, x, y, scale, color, halo, kInk);
      return;
    }
  }

  // The height of the legend has to be known before the numbers are placed; it is drawn over all else.
  void plan_legend(const Result& result, const std::vector<Sample>& samples = {}) {
    const auto plural = [](std::size_t n, const char* one) {
      return std::to_string(n) + " " + one + (n == 1 ? "" : "s");
    };
    const std::string summary = plural(finite_, "point") + "  " + plural(result.affordances.size(), "affordance") +
                                "  " + plural(result.handles.size(), "handle");
    std::array<std::size_t, kStepCount> ended{};
    for (const Sample& sample : samples) ++ended[static_cast<std::size_t>(sample.step)];
    std::vector<Entry> steps;
    for (std::size_t i = 0; i < kStepCount; ++i) {
      if (ended[i] == 0) continue;
      std::string text = std::to_string(ended[i]) + " " + std::string(to_string(static_cast<Step>(i)));
      std::replace(text.begin(), text.end(), '_', ' ');
      steps.push_back({text, step_color(static_cast<Step>(i))});
    }
    const auto arrange = [&](std::size_t shown) {
      entries_ = {{summary, kText}};
      entries_.insert(entries_.end(), steps.begin(), steps.end());
      for (std::size_t i = 0; i < shown; ++i) {
        const Handle& h = result.handles[i];
        char text[96];
        std::snprintf(text, sizeof text, "%zu r %.0f mm l %.0f mm c %.2f", i + 1, 1000 * h.radius, 1000 * h.length,
                      h.confidence);
        entries_.push_back({text, handle_color(i)});
      }
      if (shown < result.handles.size()) {
        entries_.push_back({"+" + std::to_string(result.handles.size() - shown), kText});
      }
      return arrange_legend();
    };
    // As large as two lines allow; with many handles small, and cut after four lines.
    std::size_t shown = result.handles.size();
    legend_scale_ = std::max(1, static_cast<int>(2 * unit_));
    while (legend_scale_ > static_cast<int>(unit_) && arrange(shown) > 2) --legend_scale_;
    while (arrange(shown) > 4 && shown > 0) --shown;
    legend_ = 2 * padding() + arrange_legend() * line_height();
  }

  void draw_legend() {
    arrange_legend();
    const int top = canvas_.height() - legend_;
    canvas_.fill(0, top, canvas_.width(), canvas_.height(), kInk, 0.72f);
    for (const Entry& entry : entries_) {
      canvas_.text(entry.text, entry.x, top + padding() + entry.line * line_height(), legend_scale_, entry.color, 0,
                   kInk);
    }
  }

  void draw_message(const std::string& text) {
    const int scale = std::max(1, std::min(static_cast<int>(2 * unit_), (canvas_.width() - 8) / text_width(text, 1)));
    canvas_.text(text, (canvas_.width() - text_width(text, scale)) / 2, (canvas_.height() - kGlyphHeight * scale) / 2,
                 scale, kText, 0, kInk);
  }

  std::size_t finite_points() const { return finite_; }
  const Canvas& canvas() const { return canvas_; }
  /// What maps points to pixels; none when there is no finite point.
  const std::optional<Projection>& view() const { return view_; }

 private:
  struct Box {
    int x0, y0, x1, y1;
  };
  struct Line {
    std::vector<Vector3> points;
    double margin;  ///< m; how far the surface may lie in front of what it does not hide
    bool closed;
  };
  struct Entry {
    std::string text;
    Color color;
    int x = 0, line = 0;
  };

  void draw_surface(const CloudView& cloud, const std::vector<std::uint32_t>& rgb) {
    const int width = canvas_.width(), height = canvas_.height();
    double scale = unit_;
    const bool given = view_.has_value();
    if (!given && cloud.organized()) view_ = fit_projection(cloud, cloud.viewpoint.value_or(Vector3{0, 0, 0}));
    if (view_ && !given) {
      scale = std::min(width / static_cast<double>(cloud.width), height / static_cast<double>(cloud.height));
      view_->resize(scale);
      depth_ = depth_of_grid(cloud, *view_, scale, width, height);
      close_holes(depth_, 1);
    } else {
      if (!given) view_ = look_at_cloud(cloud, width, height);
      depth_ = depth_of_points(cloud, *view_, width, height);
      close_holes(depth_, static_cast<int>(std::lround(3 * unit_)));
    }
    // One colour for all is no colour: fields that nobody filled.
    const bool colored = std::any_of(rgb.begin(), rgb.end(), [&](std::uint32_t c) { return c != rgb.front(); });
    const Shader shade(*view_, depth_, scale);
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        if (depth_.at(x, y) <= 0) continue;
        if (!colored) {
          canvas_.at(x, y) = shade(x, y, nullptr);
          continue;
        }
        const std::uint32_t c = rgb[depth_.point[depth_.index(x, y)]];
        const Color own{static_cast<float>(c >> 16 & 255) / 255, static_cast<float>(c >> 8 & 255) / 255,
                        static_cast<float>(c & 255) / 255};
        canvas_.at(x, y) = shade(x, y, &own);
      }
    }
  }

  bool project(const Vector3& from, const Vector3& to, Segment& s) const {
    double z;
    return view_ && view_->project(from, s.x0, s.y0, z) && view_->project(to, s.x1, s.y1, z);
  }

  // Divides a line into what the surface leaves free and what it hides.
  void split(const Line& line, std::vector<Segment>& seen, std::vector<Segment>& hidden) const {
    std::vector<Segment> segments;
    std::vector<int> free;
    for (std::size_t i = 0; i + 1 < line.points.size(); ++i) {
      Segment s{};
      if (!project(line.points[i], line.points[i + 1], s)) continue;
      const double x = (s.x0 + s.x1) / 2, y = (s.y0 + s.y1) / 2;
      const bool inside = x > -0.5 && y > -0.5 && x < depth_.width - 0.5 && y < depth_.height - 0.5;
      const float surface = inside ? depth_.at(static_cast<int>(std::lround(x)), static_cast<int>(std::lround(y))) : 0;
      const double z = (view_->depth(line.points[i]) + view_->depth(line.points[i + 1])) / 2;
      segments.push_back(s);
      free.push_back(surface <= 0 || z < surface + line.margin);
    }
    // Noise along an edge would tear the line to shreds: each piece does as most of its neighbours.
    constexpr int kReach = 4;
    const int count = static_cast<int>(segments.size());
    for (int i = 0; i < count; ++i) {
      int votes = 0, voters = 0;
      for (int k = i - kReach; k <= i + kReach; ++k) {
        if (!line.closed && (k < 0 || k >= count)) continue;
        votes += free[static_cast<std::size_t>(((k % count) + count) % count)];
        ++voters;
      }
      (2 * votes > voters ? seen : hidden).push_back(segments[static_cast<std::size_t>(i)]);
    }
  }

  // A curved handle piece by piece; a straight one is its own.
  static std::vector<Handle> straight_pieces(const Handle& handle) {
    if (handle.path.size() < 2) return {handle};
    std::vector<Handle> pieces;
    for (std::size_t i = 0; i + 1 < handle.path.size(); ++i) {
      const Vector3 step = add(handle.path[i + 1], handle.path[i], -1);
      Handle piece{};
      piece.center = add(handle.path[i], step, 0.5);
      piece.length = norm(step);
      piece.axis = unit(step);
      piece.radius = handle.radius;
      if (piece.length > 0) pieces.push_back(std::move(piece));
    }
    return pieces;
  }

  // Both end circles, and the two lines where the eye's rays touch the cylinder.
  std::vector<Line> outline(const Handle& handle) const {
    constexpr int kSteps = 64;
    const Vector3 axis = unit(handle.axis);
    Vector3 toward = add(view_ ? view_->eye : Vector3{0, 0, 0}, handle.center, -1);
    toward = add(toward, axis, -dot(toward, axis));
    const double distance = norm(toward);
    const Vector3 other = std::abs(axis[0]) < 0.8 ? Vector3{1, 0, 0} : Vector3{0, 1, 0};
    const Vector3 u = unit(distance > 1e-9 ? toward : cross(axis, other)), v = cross(axis, u);
    const auto on_circle = [&](double angle, double along) {
      const Vector3 foot = add(handle.center, axis, along);
      return add(add(foot, u, handle.radius * std::cos(angle)), v, handle.radius * std::sin(angle));
    };
    std::vector<Line> lines;
    for (double along : {-handle.length / 2, handle.length / 2}) {
      lines.push_back({{}, 0.004 + 0.1 * handle.radius, true});
      for (int k = 0; k <= kSteps; ++k) lines.back().points.push_back(on_circle(2 * kPi * k / kSteps, along));
    }
    if (distance <= handle.radius) return lines;
    // The part's own surface rises beside these lines by up to a radius; only something else can hide them.
    const double touch = std::acos(handle.radius / distance);
    for (double angle : {-touch, touch}) {
      lines.push_back({{}, 0.006 + handle.radius, false});
      for (int k = 0; k <= kSteps; ++k) {
        lines.back().points.push_back(on_circle(angle, handle.length * (static_cast<double>(k) / kSteps - 0.5)));
      }
    }
    return lines;
  }

  bool overlaps(const Box& box) const {
    return std::any_of(taken_.begin(), taken_.end(), [&](const Box& other) {
      return box.x0 < other.x1 && other.x0 < box.x1 && box.y0 < other.y1 && other.y0 < box.y1;
    });
  }

  int padding() const { return 3 * legend_scale_; }
  int line_height() const { return (kGlyphHeight + 3) * legend_scale_; }

  // Sets the entries one after the other; returns the number of lines.
  int arrange_legend() {
    const int margin = 5 * legend_scale_, gap = 3 * kGlyphAdvance * legend_scale_;
    int x = margin, line = 0;
    for (Entry& entry : entries_) {
      const int width = text_width(entry.text, legend_scale_);
      if (x > margin && x + width + margin > canvas_.width()) x = margin, ++line;
      entry.x = x;
      entry.line = line;
      x += width + gap;
    }
    return line + 1;
  }

  Canvas canvas_;
  DepthMap depth_;
  double unit_;  // lines and letters grow with the picture: 1 for 640 x 480
  std::optional<Projection> view_;
  std::size_t finite_ = 0;
  std::vector<Entry> entries_;
  int legend_ = 0, legend_scale_ = 1;
  std::vector<Box> taken_;
};

}  // namespace handhold
