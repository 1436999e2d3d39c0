// Pictures are judged by their pixels: what changes when a handle is added, and where.
#include "picture.h"

#include <gtest/gtest.h>
#include <png.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>

#include "font.h"

namespace handhold {
namespace {

namespace fs = std::filesystem;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

struct Image {
  int width = 0, height = 0;
  std::vector<std::uint8_t> rgb;

  bool differs(const Image& other, int x, int y) const {
    const auto i = 3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x));
    return rgb[i] != other.rgb[i] || rgb[i + 1] != other.rgb[i + 1] || rgb[i + 2] != other.rgb[i + 2];
  }
  // Whether a pixel within `reach` of (x, y) differs.
  bool differs_near(const Image& other, double x, double y, int reach) const {
    for (int v = std::max(0, int(y) - reach); v <= std::min(height - 1, int(y) + reach); ++v) {
      for (int u = std::max(0, int(x) - reach); u <= std::min(width - 1, int(x) + reach); ++u) {
        if (differs(other, u, v)) return true;
      }
    }
    return false;
  }
  int differences(const Image& other) const {
    int count = 0;
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) count += differs(other, x, y);
    }
    return count;
  }
};

Image decode(const std::string& path) {
  Image image;
  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  if (!png_image_begin_read_from_file(&png, path.c_str())) {
    ADD_FAILURE() << path << ": " << png.message;
    return image;
  }
  png.format = PNG_FORMAT_RGB;
  image.width = static_cast<int>(png.width);
  image.height = static_cast<int>(png.height);
  image.rgb.resize(PNG_IMAGE_SIZE(png));
  EXPECT_TRUE(png_image_finish_read(&png, nullptr, image.rgb.data(), 0, nullptr)) << png.message;
  return image;
}

// A camera of 160 x 120 pixels, in front of it a wall at 1 m and before that an upright cylinder.
constexpr int kWidth = 160, kHeight = 120;
constexpr double kFocal = 140, kCx = 79.5, kCy = 59.5;
const Vector3 kCenter{0.05, -0.02, 0.7};
constexpr double kRadius = 0.04, kLength = 0.2;

Cloud scene() {
  Cloud cloud;
  cloud.width = kWidth;
  cloud.height = kHeight;
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < kWidth; ++u) {
      const double dx = (u - kCx) / kFocal, dy = (v - kCy) / kFocal;
      double z = 1;  // of the ray (dx, dy, 1)
      const double a = dx * dx + 1, b = dx * kCenter[0] + kCenter[2];
      const double c = kCenter[0] * kCenter[0] + kCenter[2] * kCenter[2] - kRadius * kRadius;
      if (b * b - a * c > 0) {
        const double hit = (b - std::sqrt(b * b - a * c)) / a;
        if (std::abs(hit * dy - kCenter[1]) < kLength / 2) z = hit;
      }
      const bool missing = u < 3;
      for (double value : {dx * z, dy * z, z}) cloud.xyz.push_back(missing ? kNan : static_cast<float>(value));
    }
  }
  return cloud;
}

Handle handle() {
  Handle h;
  h.center = kCenter;
  h.axis = {0, 1, 0};
  h.radius = kRadius;
  h.length = kLength;
  h.confidence = 0.83;
  return h;
}

Result one_handle() {
  Result result;
  result.handles = {handle()};
  Affordance affordance;
  affordance.center = kCenter;
  affordance.axis = {0, 1, 0};
  affordance.radius = kRadius;
  result.affordances = {affordance};
  return result;
}

class Picture : public ::testing::Test {
 protected:
  void SetUp() override {
    const ::testing::TestInfo* info = ::testing::UnitTest::GetInstance()->current_test_info();
    folder_ = fs::path(::testing::TempDir()) / ("handhold_picture_" + std::string(info->name()));
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  std::string path(const std::string& name) const { return (folder_ / name).string(); }
  std::string bytes(const std::string& name) const {
    std::ifstream file(path(name), std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }
  Image draw(const Cloud& cloud, const Result& result, const PictureOptions& options = {}) const {
    write_picture(path("picture.png"), cloud.view(), cloud.rgb, result, options);
    return decode(path("picture.png"));
  }
  static PictureOptions sized(int width, int height, bool affordances = true, bool labels = true) {
    PictureOptions options;
    options.width = width;
    options.height = height;
    options.affordances = affordances;
    options.labels = labels;
    return options;
  }

  fs::path folder_;
};

// The outline's extremes: where the side lines pass the middle, and the near points of the end circles.
void expect_handle_drawn(const Image& with, const Image& without, double scale) {
  const auto pixel = [&](const Vector3& p) {
    return std::pair<double, double>{(kFocal * p[0] / p[2] + kCx + 0.5) * scale - 0.5,
                                     (kFocal * p[1] / p[2] + kCy + 0.5) * scale - 0.5};
  };
  const double d = std::hypot(kCenter[0], kCenter[2]), touch = std::acos(kRadius / d);
  const double to_eye = std::atan2(-kCenter[2], -kCenter[0]);
  for (double angle : {to_eye - touch, to_eye + touch}) {
    const auto [u, v] =
        pixel({kCenter[0] + kRadius * std::cos(angle), kCenter[1] + 0.03, kCenter[2] + kRadius * std::sin(angle)});
    EXPECT_TRUE(with.differs_near(without, u, v, 1)) << u << ' ' << v;
  }
  for (double y : {-kLength / 2, kLength / 2}) {
    const auto [u, v] =
        pixel({kCenter[0] + kRadius * std::cos(to_eye), kCenter[1] + y, kCenter[2] + kRadius * std::sin(to_eye)});
    EXPECT_TRUE(with.differs_near(without, u, v, 1)) << u << ' ' << v;
  }
  const auto [u, v] = pixel(kCenter);
  EXPECT_FALSE(with.differs_near(without, u, v, 4));  // only an outline
  EXPECT_FALSE(with.differs_near(without, 0.1 * with.width, 0.1 * with.height, 20));
}

TEST_F(Picture, HasTheSizeAskedFor) {
  const Cloud cloud = scene();
  const Result result = one_handle();
  const auto size = [&](const Cloud& c, int width, int height) {
    const Image image = draw(c, result, sized(width, height));
    return std::pair<int, int>{image.width, image.height};
  };
  EXPECT_EQ(size(cloud, 0, 0), std::pair(640, 480));  // 160 x 120, four times
  EXPECT_EQ(size(cloud, 320, 0), std::pair(320, 240));
  EXPECT_EQ(size(cloud, 0, 60), std::pair(80, 60));
  EXPECT_EQ(size(cloud, 300, 200), std::pair(300, 200));
  EXPECT_EQ(size(cloud, 1, 1), std::pair(1, 1));

  Cloud list = cloud;
  list.width = kWidth * kHeight;
  list.height = 1;
  EXPECT_EQ(size(list, 0, 0), std::pair(1280, 960));
  Cloud large = cloud;
  large.width = 700;
  large.height = 500;
  large.xyz.assign(3 * large.size(), kNan);
  EXPECT_EQ(size(large, 0, 0), std::pair(700, 500));
}

TEST_F(Picture, OutlinesAHandleWhereItIs) {
  const Cloud cloud = scene();
  for (const int width : {160, 640}) {
    const PictureOptions options = sized(width, 0, false, false);
    expect_handle_drawn(draw(cloud, one_handle(), options), draw(cloud, Result(), options), width / 160.0);
  }
}

TEST_F(Picture, OutlinesACurvedHandlePieceByPiece) {
  const Cloud cloud = scene();
  const PictureOptions options = sized(640, 0, false, false);
  Result result;
  result.handles = {handle()};
  Handle& h = result.handles[0];
  const Vector3 corner = {kCenter[0], kCenter[1] + 0.5 * kLength, kCenter[2]};
  const Vector3 end = {kCenter[0] - kLength, corner[1], kCenter[2]};
  h.path = {{kCenter[0], kCenter[1] - 0.5 * kLength, kCenter[2]}, corner, end};
  const Image curved = draw(cloud, result, options), straight = draw(cloud, one_handle(), options);
  // The first piece is the straight handle; the second one's far circle is where only the path leads.
  const double scale = 640 / 160.0;
  expect_handle_drawn(curved, draw(cloud, Result(), options), scale);
  const double u = (kFocal * end[0] / end[2] + kCx + 0.5) * scale - 0.5;
  const double v = (kFocal * (end[1] + kRadius) / end[2] + kCy + 0.5) * scale - 0.5;
  EXPECT_TRUE(curved.differs_near(straight, u, v, 4));
}

// The projection is fitted in the cloud's own frame.
TEST_F(Picture, FollowsACloudThatWasMoved) {
  const auto move = [](const Vector3& p) {  // a turn about z, then one about x, and a shift
    const double c = std::cos(0.7), s = std::sin(0.7), C = std::cos(2.1), S = std::sin(2.1);
    const Vector3 q{c * p[0] - s * p[1], s * p[0] + c * p[1], p[2]};
    return Vector3{q[0] + 0.3, C * q[1] - S * q[2] - 0.2, S * q[1] + C * q[2] + 1.4};
  };
  Cloud cloud = scene();
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Vector3 p = move({cloud.xyz[3 * i], cloud.xyz[3 * i + 1], cloud.xyz[3 * i + 2]});
    for (std::size_t k = 0; k < 3; ++k) cloud.xyz[3 * i + k] = static_cast<float>(p[k]);
  }
  cloud.viewpoint = move({0, 0, 0});
  Result result = one_handle();
  const Vector3 zero = move({0, 0, 0}), along = move({0, 1, 0});
  result.handles[0].center = move(kCenter);
  for (std::size_t k = 0; k < 3; ++k) result.handles[0].axis[k] = along[k] - zero[k];
  const PictureOptions options = sized(640, 0, false, false);
  expect_handle_drawn(draw(cloud, result, options), draw(cloud, Result(), options), 4);
}

TEST_F(Picture, ShowsTheSurfaceAndItsHoles) {
  const Image image = draw(scene(), Result(), sized(160, 120, false, false));
  const auto brightness = [&](int x, int y) { return int(image.rgb[3 * static_cast<std::size_t>(y * 160 + x) + 1]); };
  EXPECT_LT(brightness(0, 60), 40);  // nothing was measured there
  EXPECT_GT(brightness(20, 60), 60);
  const int u = static_cast<int>(kFocal * kCenter[0] / kCenter[2] + kCx);
  EXPECT_GT(brightness(u - 3, 56), brightness(20, 56));  // nearer is brighter
}

TEST_F(Picture, UsesColours) {
  Cloud cloud = scene();
  cloud.rgb.assign(cloud.size(), 0x10c020);
  const PictureOptions options = sized(160, 120, false, false);
  const Image plain = draw(scene(), Result(), options);
  EXPECT_EQ(draw(cloud, Result(), options).rgb, plain.rgb);  // the same everywhere: a field that nobody filled
  for (std::size_t i = 0; i < cloud.size() / 2; ++i) cloud.rgb[i] = 0xc02010;
  const Image image = draw(cloud, Result(), options);
  const auto pixel = [&](int x, int y) { return &image.rgb[3 * static_cast<std::size_t>(y * 160 + x)]; };
  EXPECT_GT(pixel(20, 20)[0], 2 * pixel(20, 20)[1]);
  EXPECT_GT(pixel(20, 100)[1], 2 * pixel(20, 100)[0]);
}

TEST_F(Picture, AffordancesAndLabelsCanBeLeftOut) {
  const Cloud cloud = scene();
  const Result result = one_handle();
  const Image bare = draw(cloud, result, sized(640, 480, false, false));
  const Image affordances = draw(cloud, result, sized(640, 480, true, false));
  const Image labels = draw(cloud, result, sized(640, 480, false, true));
  const double u = (kFocal * kCenter[0] / kCenter[2] + kCx + 0.5) * 4 - 0.5;
  const double v = (kFocal * kCenter[1] / kCenter[2] + kCy + 0.5) * 4 - 0.5;
  EXPECT_TRUE(affordances.differs_near(bare, u, v, 1));
  EXPECT_LT(affordances.differences(bare), 200);
  EXPECT_FALSE(labels.differs_near(bare, u, v, 1));
  EXPECT_TRUE(labels.differs_near(bare, 320, 477, 2));  // the legend
  EXPECT_GT(labels.differences(bare), 640 * 10);
}

TEST_F(Picture, SamplesAreDotsInTheColourOfTheirStep) {
  const Cloud cloud = scene();
  PictureOptions options = sized(640, 480, false, false);
  const Image bare = draw(cloud, Result(), options);
  const auto pixel_of = [](const Vector3& p) {
    return std::array<double, 2>{(kFocal * p[0] / p[2] + kCx + 0.5) * 4 - 0.5,
                                 (kFocal * p[1] / p[2] + kCy + 0.5) * 4 - 0.5};
  };
  const Vector3 flat{-0.1, 0.05, 1}, shut{-0.2, -0.1, 1};
  options.samples = {{flat, Step::kCurvatureLow}, {shut, Step::kNoGap}};
  const Image dots = draw(cloud, Result(), options);
  EXPECT_LT(dots.differences(bare), 60);
  const auto [xf, yf] = pixel_of(flat);
  const auto [xs, ys] = pixel_of(shut);
  EXPECT_TRUE(dots.differs_near(bare, xf, yf, 1));
  EXPECT_TRUE(dots.differs_near(bare, xs, ys, 1));
  const auto channel = [&](double x, double y, std::size_t c) {
    return int(dots.rgb[3 * static_cast<std::size_t>(std::lround(y) * 640 + std::lround(x)) + c]);
  };
  EXPECT_GT(channel(xf, yf, 2), channel(xf, yf, 0) + 40) << "blue";
  EXPECT_GT(channel(xs, ys, 0), channel(xs, ys, 2) + 40) << "red";
  // The legend names the steps.
  options.labels = true;
  PictureOptions without = options;
  without.samples.clear();
  EXPECT_GT(draw(cloud, Result(), options).differences(draw(cloud, Result(), without)), 300);
}

TEST_F(Picture, HiddenPartsAreFainter) {
  const Cloud cloud = scene();
  Result result = one_handle();
  const PictureOptions options = sized(640, 480, false, false);
  const Image without = draw(cloud, Result(), options);
  const auto change = [&](double z) {
    result.handles[0].center = {-0.1 * z, 0, z};
    result.handles[0].radius = 0.02 * z;  // the same pixels at each distance
    result.handles[0].length = 0.1 * z;
    const Image image = draw(cloud, result, options);
    long sum = 0;
    for (std::size_t i = 0; i < image.rgb.size(); ++i) sum += std::abs(int(image.rgb[i]) - int(without.rgb[i]));
    return sum;
  };
  EXPECT_LT(2 * change(1.5), change(0.8));  // behind the wall, before it
}

TEST_F(Picture, UnorganizedCloudsAreSeenFromTheirViewpoint) {
  Cloud cloud = scene();
  cloud.width = kWidth * kHeight;
  cloud.height = 1;
  const PictureOptions options = sized(640, 480, false, false);
  const Image with = draw(cloud, one_handle(), options), without = draw(cloud, Result(), options);
  int covered = 0;
  for (std::size_t i = 0; i < without.rgb.size(); i += 3) covered += without.rgb[i] > 60;
  EXPECT_GT(covered, 640 * 480 / 2);
  EXPECT_GT(with.differences(without), 500);
  // No holes within the wall: points are wider than the distance between them.
  for (int x = 100; x < 200; ++x) {
    EXPECT_GT(without.rgb[3 * static_cast<std::size_t>(300 * 640 + x)], 60) << x;
  }

  cloud.viewpoint.reset();
  const Image outside = draw(cloud, one_handle(), options);
  EXPECT_GT(outside.differences(with), 10000);
  EXPECT_GT(outside.differences(draw(cloud, Result(), options)), 300);
}

TEST_F(Picture, TheSameInputGivesTheSameBytes) {
  Cloud cloud = scene();
  for (int round = 0; round < 2; ++round) {
    write_picture(path("a.png"), cloud.view(), {}, one_handle());
    write_picture(path("b.png"), cloud.view(), {}, one_handle());
    EXPECT_EQ(bytes("a.png"), bytes("b.png"));
    cloud.width *= cloud.height;
    cloud.height = 1;
  }
}

TEST_F(Picture, CloudsWithNothingToSee) {
  const Image empty = draw(Cloud(), one_handle());
  EXPECT_EQ(empty.width, 1280);
  EXPECT_EQ(empty.height, 960);

  Cloud cloud = scene();
  cloud.xyz.assign(cloud.xyz.size(), kNan);
  const Image nothing = draw(cloud, Result(), sized(640, 480, true, false));
  Image background = nothing;
  for (std::size_t i = 3; i < background.rgb.size(); ++i) background.rgb[i] = background.rgb[i % 3];
  EXPECT_GT(nothing.differences(background), 100);              // a message ...
  EXPECT_TRUE(nothing.differs_near(background, 320, 240, 20));  // ... in the middle
  EXPECT_FALSE(nothing.differs_near(background, 320, 100, 50));
}

TEST_F(Picture, CloudsWithoutAShape) {
  const auto cloud = [](std::uint32_t width, std::uint32_t height, auto point) {
    Cloud c;
    c.width = width;
    c.height = height;
    for (std::size_t i = 0; i < c.size(); ++i) {
      const Vector3 p = point(static_cast<double>(i));
      for (double value : p) c.xyz.push_back(static_cast<float>(value));
    }
    return c;
  };
  const auto draw_all = [&](const Cloud& c) {
    Cloud copy = c;
    for (const std::optional<Vector3>& eye : {std::optional<Vector3>(), std::optional<Vector3>({0, 0, 0}),
                                              std::optional<Vector3>({5, 0, -3}), std::optional<Vector3>({1, 1, 1})}) {
      copy.viewpoint = eye;
      EXPECT_EQ(draw(copy, one_handle(), sized(320, 240)).width, 320);
    }
  };
  draw_all(cloud(1, 1, [](double) { return Vector3{1, 1, 1}; }));
  draw_all(cloud(10, 10, [](double) { return Vector3{1, 1, 1}; }));
  draw_all(cloud(100, 1, [](double i) { return Vector3{0, i, 0}; }));
  draw_all(cloud(50, 2, [](double i) { return Vector3{i, 0, 1}; }));
  draw_all(cloud(40, 40, [](double i) { return Vector3{std::sin(i), std::cos(3 * i), std::sin(7 * i)}; }));
  draw_all(cloud(30, 30, [](double i) { return Vector3{1e30 * i, -1e30, 1e30}; }));
  draw_all(cloud(30, 1, [](double i) { return Vector3{1e-30 * i, 0, 0}; }));
}

TEST_F(Picture, HandlesThatCannotBeDrawnAreNot) {
  const Cloud cloud = scene();
  const PictureOptions options = sized(640, 480, true, false);
  const Image without = draw(cloud, Result(), options);
  Result result = one_handle();
  result.handles[0].center = {0, 0, -1};  // behind the camera
  result.affordances[0].center = {0, 0, -1};
  result.handles.push_back(handle());
  result.handles[1].center = {kNan, 0, 1};
  result.handles.push_back(handle());
  result.handles[2].axis = {0, 0, 0};
  result.handles.push_back(handle());
  result.handles[3].center = {1e9, 0, 1};  // far beside the picture
  result.handles.push_back(handle());
  result.handles[4].path = {{kNan, 0, 1}, {0, 0, -1}, {0, 0, -1}, {0, 0, -2}};
  EXPECT_EQ(draw(cloud, result, options).differences(without), 0);
  draw(cloud, result);  // with their numbers
  result.handles.assign(300, handle());
  result.affordances.assign(5000, one_handle().affordances[0]);
  const Image many = draw(cloud, result);
  EXPECT_FALSE(many.differs_near(draw(cloud, Result()), 40, 300, 20));  // the legend stays at the bottom
}

TEST_F(Picture, WrongUseAndFailure) {
  const Cloud cloud = scene();
  const auto write = [&](const std::string& name, const std::vector<std::uint32_t>& rgb,
                         const PictureOptions& options) {
    write_picture(path(name), cloud.view(), rgb, Result(), options);
  };
  EXPECT_THROW(write("a.png", {1, 2, 3}, {}), std::invalid_argument);
  EXPECT_THROW(write("a.png", {}, sized(-1, 0)), std::invalid_argument);
  EXPECT_THROW(write("a.png", {}, sized(0, 20000)), std::invalid_argument);
  EXPECT_THROW(write("no/such/folder.png", {}, sized(16, 16)), std::runtime_error);
  EXPECT_TRUE(fs::is_empty(folder_));
}

TEST(Font, GlyphsAreThereAndDiffer) {
  for (char a = '!'; a <= '~'; ++a) {
    EXPECT_NE(glyph(a), glyph(' ')) << a;
    for (char b = '!'; b < a; ++b) EXPECT_NE(glyph(a), glyph(b)) << a << b;
    for (const std::uint8_t row : glyph(a)) EXPECT_LT(row, 32) << a;
  }
  EXPECT_EQ(glyph('\n'), glyph('\x80'));
}

TEST(Font, TextIsMagnifiedByWholeNumbers) {
  EXPECT_EQ(text_width("", 3), 0);
  EXPECT_EQ(text_width("ab", 2), 22);
  for (int y = -3; y < 30; ++y) {
    for (int x = -3; x < 60; ++x) {
      const bool inside = x >= 0 && y >= 0;
      EXPECT_EQ(text_covers("Ag1", 3, x, y), inside && text_covers("Ag1", 1, x / 3, y / 3)) << x << ' ' << y;
    }
  }
  EXPECT_TRUE(text_covers("L", 1, 0, 0));
  EXPECT_FALSE(text_covers("L", 1, 4, 0));
  EXPECT_TRUE(text_covers("L", 1, 4, 6));
}

}  // namespace
}  // namespace handhold
