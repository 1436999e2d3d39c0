// The localizer as a whole: the same result always, the right status for every cloud, and every sample as the
// reference.
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "handhold/device.h"
#include "handhold/localizer.h"
#include "host_frame.h"
#include "localizer_detail.h"
#include "paper_options.h"
#include "reference/pipeline.h"
#include "same_result.h"
#include "test_clouds.h"

namespace handhold {
namespace {

using test::expect_same;
using test::FloatPoints;
using test::kNan;
using test::Random;
using test::Vector3d;
using test::Vector3f;

CloudView view_of(const FloatPoints& points, std::uint32_t height = 1) {
  CloudView view;
  view.data = points.empty() ? nullptr : points.front().data();
  view.width = static_cast<std::uint32_t>(points.size()) / height;
  view.height = height;
  return view;
}

Vector3d eigen(const Vector3& v) {
  return {v[0], v[1], v[2]};
}

/// A rod, a jug's body and a ball over a table, seen from everywhere: not organized.
FloatPoints table_scene(std::uint64_t seed) {
  Random random(seed);
  const auto at = [&](const FloatPoints& points, const Vector3d& t) {
    return test::transformed(points, random.rotation(), t);
  };
  FloatPoints all = test::transformed(test::plane(random, 12'000, 0.5, 5e-4), Eigen::Matrix3d::Identity(), {0, 0, 0.8});
  all = test::joined(all, at(test::cylinder(random, 2500, 0.012, 0.14, 3e-4), {0.1, 0.05, 0.68}));
  all = test::joined(all, at(test::cylinder(random, 5000, 0.055, 0.12, 3e-4), {-0.12, 0.1, 0.65}));
  return test::joined(all, at(test::sphere(random, 2500, 0.03, 3e-4), {0, -0.15, 0.7}));
}

const FloatPoints& image() {  // 160 x 120
  static const FloatPoints points = [] {
    Random random(51);
    return test::depth_image(random, 160, 120);
  }();
  return points;
}

Options few_samples() {
  Options options = test::paper_options();
  options.samples = 1500;
  return options;
}

/// What holds for every result of a cloud that was searched.
void expect_sound(const Result& r, const Options& options) {
  EXPECT_EQ(r.status, Status::kOk);
  const Funnel& f = r.funnel;
  EXPECT_EQ(f.samples, options.samples);
  EXPECT_EQ(f.too_few_points + f.flat + f.curvature_low + f.concave + f.circle_wide + f.circle_narrow + f.poor_fit +
                f.no_gap + f.shell_empty + f.affordances,
            f.samples);
  EXPECT_EQ(f.affordances, static_cast<std::int64_t>(r.affordances.size()));
  EXPECT_EQ(f.not_aligned + f.unconfirmed + f.too_short + f.low_confidence + f.in_handles, f.affordances);
  std::int64_t in_handles = 0;
  for (const Handle& h : r.handles) {
    in_handles += static_cast<std::int64_t>(h.affordances.size());
    for (const std::uint32_t i : h.affordances) EXPECT_LT(i, r.affordances.size());
    EXPECT_NEAR(eigen(h.axis).norm(), 1, 1e-9);
    EXPECT_NEAR(eigen(h.approach).norm(), 1, 1e-9);
    EXPECT_TRUE(std::isfinite(h.length) && std::isfinite(h.radius) && eigen(h.center).allFinite());
  }
  EXPECT_GE(f.in_handles, in_handles);  // what lies askew on a handle's part is counted, but no evidence for it
  std::int64_t last = -1;
  for (const Affordance& a : r.affordances) {
    EXPECT_GT(static_cast<std::int64_t>(a.sample), last) << "in the order of the samples, one each";
    last = a.sample;
    EXPECT_LT(last, f.samples);
    EXPECT_NEAR(eigen(a.axis).norm(), 1, 1e-9);
    EXPECT_NEAR(eigen(a.normal).norm(), 1, 1e-9);
    EXPECT_GT(*std::max_element(a.axis.begin(), a.axis.end()), 0.577);
    EXPECT_TRUE(eigen(a.center).allFinite());
    EXPECT_LE(2 * a.radius, options.hand_aperture);
    EXPECT_GE(2 * a.radius, options.hand_minimum);
    EXPECT_GE(a.gap, options.finger_thickness - 1e-7);
    EXPECT_GE(a.curvature, 1 / ((options.method == Method::kPaper ? 1 : 1.5) * options.effective_reach()));
  }
}

// ---- The same result always ----------------------------------------------------------------------------------------

TEST(Localizer, GivesTheSameForAnyNumberOfThreadsAndAnyIndex) {
  const tbb::global_control allow(tbb::global_control::max_allowed_parallelism, 8);
  const FloatPoints table = table_scene(52);
  for (const CloudView& cloud : {view_of(image(), 120), view_of(table)}) {
    Options options = few_samples();
    const Result first = Localizer(options).localize(cloud);
    expect_sound(first, options);
    EXPECT_GE(first.handles.size(), 1u);
    EXPECT_GT(first.funnel.affordances, 30);
    for (const IndexKind index : {IndexKind::kEmbree, IndexKind::kGrid}) {
      for (const int threads : {1, 2, 7}) {
        SCOPED_TRACE(std::string(to_string(index)) + ", " + std::to_string(threads) + " threads");
        options.index = index, options.threads = threads;
        expect_same(Localizer(options).localize(cloud), first);
      }
    }
    options.seed = 2;
    EXPECT_NE(Localizer(options).localize(cloud).affordances.size(), 0u);
  }
}

TEST(Localizer, RemembersNothing) {
  const FloatPoints table = table_scene(53);
  const Options options = few_samples();
  const Result on_image = Localizer(options).localize(view_of(image(), 120));
  const Result on_table = Localizer(options).localize(view_of(table));
  Localizer reused(options);
  Result result;
  for (int i = 0; i < 2; ++i) {
    reused.localize(view_of(image(), 120), result);
    expect_same(result, on_image);
    reused.localize(view_of(image(), 120), result);
    expect_same(result, on_image);
    reused.localize(CloudView(), result);
    EXPECT_EQ(result.status, Status::kEmpty);
    reused.localize(view_of(table), result);
    expect_same(result, on_table);
  }
  Localizer moved = std::move(reused);
  expect_same(moved.localize(view_of(image(), 120)), on_image);
}

TEST(Localizer, TellsWhereEverySampleWasAndWhereItEnded) {
  for (const Strategy strategy : {Strategy::kUniform, Strategy::kMax}) {
    Options options = few_samples();
    options.strategy = strategy;
    Localizer localizer(options);
    EXPECT_TRUE(localizer.samples().empty());
    const Result result = localizer.localize(view_of(image(), 120));
    const std::vector<Sample> samples = localizer.samples();
    ASSERT_EQ(samples.size(), static_cast<std::size_t>(options.samples));
    const auto ended = [&](Step step) {
      return std::count_if(samples.begin(), samples.end(), [&](const Sample& s) { return s.step == step; });
    };
    EXPECT_EQ(ended(Step::kTooFewPoints), result.funnel.too_few_points);
    EXPECT_EQ(ended(Step::kCurvatureLow), result.funnel.curvature_low);
    EXPECT_EQ(ended(Step::kNoGap), result.funnel.no_gap);
    EXPECT_EQ(ended(Step::kAffordance), result.funnel.affordances);
    ASSERT_FALSE(result.affordances.empty());
    for (const Affordance& a : result.affordances) {
      const Sample& sample = samples[a.sample];
      EXPECT_EQ(sample.step, Step::kAffordance);
      // The center lies at the sample's height on the axis.
      EXPECT_NEAR((eigen(a.center) - eigen(sample.position)).dot(eigen(a.axis)), 0, 1e-4);
    }
    localizer.localize(CloudView());
    EXPECT_TRUE(localizer.samples().empty()) << "of the last frame only";
  }
}

TEST(Localizer, ReadsPointsOfAnyStep) {
  const FloatPoints table = table_scene(54);
  for (const auto& [points, height] : {std::pair(image(), 120u), std::pair(table, 1u)}) {
    const CloudView packed = view_of(points, height);
    const Result first = Localizer(few_samples()).localize(packed);
    for (const std::size_t floats : {4u, 5u, 8u}) {
      std::vector<float> wide;
      for (const Vector3f& p : points) {
        wide.insert(wide.end(), p.data(), p.data() + 3);
        wide.resize(wide.size() + floats - 3, kNan);  // what stands between points is none of our business
      }
      CloudView view = packed;
      view.data = wide.data(), view.point_step = 4 * floats;
      expect_same(Localizer(few_samples()).localize(view), first);
    }
  }
}

// ---- Clouds in which nothing can be found --------------------------------------------------------------------------

TEST(Localizer, SaysWhyACloudWasNotSearched) {
  Random random(55);
  const FloatPoints rod = test::transformed(test::cylinder(random, 3000, 0.015, 0.2), random.rotation(), {0, 0, 0.6});
  FloatPoints millimetres;
  for (const Vector3f& p : rod) millimetres.push_back(1000 * p);
  const FloatPoints missing(640, Vector3f(kNan, kNan, kNan)), infinite(640, Vector3f(0, 0, test::kInfinity)),
      nine(rod.begin(), rod.begin() + 9);
  struct Case {
    CloudView cloud;
    Status status;
    std::size_t finite;
  };
  for (const Case& c :
       {Case{CloudView(), Status::kEmpty, 0}, Case{view_of(missing), Status::kNoFinitePoints, 0},
        Case{view_of(missing, 20), Status::kNoFinitePoints, 0}, Case{view_of(infinite, 20), Status::kNoFinitePoints, 0},
        Case{view_of(nine), Status::kTooFewPoints, 9}, Case{view_of(millimetres), Status::kSuspiciousUnits, 3000}}) {
    SCOPED_TRACE(to_string(c.status));
    const Result r = Localizer(few_samples()).localize(c.cloud);
    EXPECT_EQ(to_string(r.status), to_string(c.status));
    EXPECT_EQ(r.points, c.cloud.size());
    EXPECT_EQ(r.finite_points, c.finite);
    EXPECT_TRUE(r.handles.empty() && r.affordances.empty());
    EXPECT_EQ(r.funnel.samples, 0);
  }
  EXPECT_EQ(Localizer(few_samples()).localize(view_of(rod)).status, Status::kOk);
}

TEST(Localizer, EndsPlacesWithoutShapeAsFlat) {
  Random random(56);
  const FloatPoints ten(10, Vector3f(0.1f, 0.2f, 0.5f));
  const FloatPoints line = test::transformed(test::line(random, 500, 0.1), random.rotation(), {0, 0, 0.5});
  const FloatPoints plane = test::transformed(test::plane(random, 900, 0.1), random.rotation(), {0, 0, 0.5});
  for (const FloatPoints* points : {&ten, &line, &plane}) {
    const Options options = few_samples();
    const Result r = Localizer(options).localize(view_of(*points));
    expect_sound(r, options);
    EXPECT_TRUE(r.handles.empty());
    // Flat places end before their points are summed, as too little curved; only what is left is found flat by the fit.
    EXPECT_EQ(r.funnel.flat + r.funnel.curvature_low + r.funnel.too_few_points, options.samples);
    EXPECT_GT(r.funnel.flat + r.funnel.curvature_low, options.samples / 2);
  }
}

TEST(Localizer, IgnoresPointsThatWereNotMeasured) {
  const Result clean = Localizer(few_samples()).localize(view_of(image(), 120));
  ASSERT_LT(clean.finite_points, clean.points);
  FloatPoints spoilt = image();
  int n = 0;
  for (Vector3f& p : spoilt) {
    if (reference::is_measured(p.cast<double>())) continue;
    const float bad[] = {test::kInfinity, -test::kInfinity, kNan, 1e30f, -2e6f};
    p = Vector3f(0.01f, 0.02f, 0.7f);
    p[n % 3] = bad[n % 5];
    ++n;
  }
  ASSERT_GT(n, 100);
  expect_same(Localizer(few_samples()).localize(view_of(spoilt, 120)), clean);
}

TEST(Localizer, RefusesViewsThatContradictThemselves) {
  Localizer localizer(few_samples());
  const auto message = [&](const CloudView& cloud) -> std::string {
    try {
      localizer.localize(cloud);
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "nothing was thrown";
  };
  const CloudView good = view_of(image(), 120);
  CloudView bad = good;
  bad.data = nullptr;
  EXPECT_NE(message(bad).find("data is null"), std::string::npos) << message(bad);
  for (const std::size_t step : {0u, 8u, 14u, 18u}) {
    bad = good;
    bad.point_step = step;
    EXPECT_NE(message(bad).find("point_step = " + std::to_string(step)), std::string::npos) << message(bad);
  }
  bad = good;
  bad.viewpoint = Vector3{0, std::nan(""), 0};
  EXPECT_NE(message(bad).find("viewpoint"), std::string::npos) << message(bad);
  bad = good;
  bad.width = bad.height = 1u << 16;
  EXPECT_NE(message(bad).find("2^31"), std::string::npos) << message(bad);
  EXPECT_EQ(localizer.localize(good).status, Status::kOk);

  Options options = test::paper_options();
  options.samples = 0;
  EXPECT_THROW(Localizer{options}, OptionError);
}

TEST(Localizer, SearchesTheWorkspaceOnly) {
  Options options = few_samples();
  options.workspace = {{-1, 1, -1, 1, 0.8, 2}};  // the wall behind the cylinder
  const Result r = Localizer(options).localize(view_of(image(), 120));
  expect_sound(r, options);
  EXPECT_TRUE(r.handles.empty());
  options.workspace = {{5, 6, 5, 6, 5, 6}};
  const Result nothing = Localizer(options).localize(view_of(image(), 120));
  EXPECT_TRUE(nothing.handles.empty());
  EXPECT_EQ(nothing.funnel.samples, 0);
}

// ---- Sample by sample ----------------------------------------------------------------------------------------------

const char* const kSteps[] = {"too few points", "flat",   "curvature low", "circle wide",
                              "circle narrow",  "no gap", "shell empty",   "affordance"};

/// Root mean square distance of the neighbours from their plane (m).
double distance_from_plane(const reference::Points& points, const Vector3d& sample, double radius) {
  const reference::Points near = reference::scaled_neighbourhood(points, sample, radius);
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(reference::scatter(near));
  return radius * std::sqrt(std::max(0.0, solver.eigenvalues()[0]));
}

struct Samples {
  std::string name;
  FloatPoints points;
  std::uint32_t height = 1;
  std::vector<std::array<float, 3>> places;
};

std::vector<Samples> scenes() {
  std::vector<Samples> all = {{"depth image", image(), 120, {}}, {"table", table_scene(57), 1, {}}};
  for (const test::NamedCloud& c : test::ordinary_clouds(58, 2000)) all.push_back({c.name, c.points, 1, {}});
  Random random(59);
  for (Samples& s : all) {
    while (s.places.size() < (s.points.size() > 15'000 ? 500 : 100)) {
      const Vector3f p = s.points[random.index(s.points.size())] + random.normal3(1e-3).cast<float>();
      if (reference::is_measured(p.cast<double>())) s.places.push_back({p[0], p[1], p[2]});
    }
  }
  return all;
}

/// Where samples are looked at: on the CPU, through the stages of a GPU's frame on the CPU, or on a GPU.
class Reference : public testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    const CudaDevice gpu = cuda_device();
    if (where() == "cuda" && !gpu.available) GTEST_SKIP() << gpu.reason;
    if (where() == "host" && !test::HostFrame::same_rounding())
      GTEST_SKIP() << "the stages are built for packs that fuse, which this machine has not";
  }
  static std::string where() { return GetParam(); }
  static std::unique_ptr<DeviceFrame> device() {
    if (where() == "cuda") return make_cuda_frame();
    if (where() == "host") return std::make_unique<test::HostFrame>();
    return nullptr;
  }
};

TEST_P(Reference, AgreesOnEverySample) {
  const Options options = test::paper_options();
  int samples = 0, affordances = 0;
  std::map<std::string, int> rest;
  for (const Samples& scene : scenes()) {
    SCOPED_TRACE(scene.name);
    const reference::Cloud cloud{test::to_double(scene.points)};
    Result result;
    std::vector<Step> steps;
    localize_samples(options, view_of(scene.points, scene.height), scene.places, result, steps, device());
    ASSERT_EQ(steps.size(), scene.places.size());
    std::map<std::uint32_t, const Affordance*> found;
    for (const Affordance& a : result.affordances) found[a.sample] = &a;
    for (std::uint32_t i = 0; i < steps.size(); ++i) {
      const auto& p = scene.places[i];
      const Vector3d sample = Vector3f(p[0], p[1], p[2]).cast<double>();
      const reference::SampleResult expected = reference::localize_sample(cloud, sample, options);
      ++samples;
      EXPECT_EQ(found.count(i), steps[i] == Step::kAffordance ? 1u : 0u);
      // The reference knows the paper's steps only.
      constexpr int kReferenceStep[] = {0, 1, 2, -1, 3, 4, -1, 5, 6, 7};
      const auto got = kReferenceStep[static_cast<int>(steps[i])], wanted = static_cast<int>(expected.step);
      if (got != wanted) {
        // Neighbourhoods flatter than any cylinder that the hand can hold end before their points are summed; the
        // reference lets them go on to a later refusal.
        // A cylinder of diameter D = aperture that a ball of radius R cuts leaves R^2 / (4 D) about its plane.
        const double radius = options.effective_radius().front();
        const bool flat =
            distance_from_plane(cloud.points, sample, radius) < radius * radius / (4 * options.hand_aperture);
        if (steps[i] == Step::kCurvatureLow && flat && expected.step != reference::Step::kAffordance) continue;
        ++rest[std::string(kSteps[got]) + " instead of " + kSteps[wanted]];
        continue;
      }
      if (steps[i] != Step::kAffordance) continue;
      ASSERT_EQ(found.count(i), 1u);
      const Affordance& a = *found[i];
      const reference::Affordance& b = expected.affordance;
      // A sphere has no axis: where the two curvatures are all but equal, noise in their last digits chooses it.
      const auto& k = expected.curvature.at_foot;
      if (std::abs(k.major - k.minor) < 0.005 * std::abs(k.major)) continue;
      const bool close = (eigen(a.center) - b.center).norm() < 2e-5 && eigen(a.axis).cross(b.axis).norm() < 1e-3 &&
                         (eigen(a.normal) - b.normal).norm() < 1e-3 && std::abs(a.radius - b.radius) < 1e-5 &&
                         std::abs(a.shell_radius - b.shell_radius) < 2e-5 && std::abs(a.gap - b.gap) < 5e-5 &&
                         std::abs(a.curvature / b.curvature - 1) < 1e-3;
      ++affordances;
      if (!close) ++rest["affordance with other numbers"];
    }
  }
  int differ = 0;
  std::string list;
  for (const auto& [what, n] : rest) differ += n, list += "\n  " + std::to_string(n) + " " + what;
  EXPECT_LE(differ, samples / 100) << list;
  EXPECT_GT(affordances, 100) << "hardly any affordance was compared";
  RecordProperty("differ", std::to_string(differ) + " of " + std::to_string(samples) + list);
}

INSTANTIATE_TEST_SUITE_P(, Reference, testing::Values("cpu", "host", "cuda"),
                         [](const auto& where) { return std::string(where.param); });

TEST(LocalizeSamples, SeveralRadiiFindWhatEachFinds) {
  const auto all = scenes();
  for (const Samples& scene : {all[0], all[1]}) {
    std::set<std::uint32_t> of_each, of_both;
    std::vector<Step> furthest(scene.places.size(), Step::kTooFewPoints), steps;
    Result result;
    Options options;  // the paper's method takes one radius
    for (const double radius : {0.018, 0.03}) {
      options.radius = {radius};
      localize_samples(options, view_of(scene.points, scene.height), scene.places, result, steps);
      for (const Affordance& a : result.affordances) of_each.insert(a.sample);
      for (std::size_t i = 0; i < steps.size(); ++i) furthest[i] = std::max(furthest[i], steps[i]);
    }
    options.radius = {0.018, 0.03};
    localize_samples(options, view_of(scene.points, scene.height), scene.places, result, steps);
    for (const Affordance& a : result.affordances) {
      EXPECT_TRUE(of_both.insert(a.sample).second) << "two affordances from sample " << a.sample;
    }
    EXPECT_EQ(of_both, of_each);
    EXPECT_FALSE(of_both.empty());
    EXPECT_EQ(steps, furthest);
  }
}

TEST(Localizer, SearchesWithSeveralRadii) {
  Options options = few_samples();
  options.method = Method::kDefault;
  options.radius = {0.025, 0.015, 0.035};
  const Result r = Localizer(options).localize(view_of(image(), 120));
  expect_sound(r, options);
  EXPECT_GE(r.handles.size(), 1u);
}

TEST(Localizer, EveryEstimatorFindsTheAxisOfACylinder) {
  Random random(60);
  const Eigen::Matrix3d R = random.rotation();
  const FloatPoints rod = test::transformed(test::cylinder(random, 6000, 0.01, 0.2), R, {0.1, -0.1, 0.7});
  for (const AxisEstimator axis : {AxisEstimator::kTaubin, AxisEstimator::kNormals, AxisEstimator::kPca}) {
    SCOPED_TRACE(to_string(axis));
    Options options = test::paper_options();
    options.axis = axis;
    std::vector<std::array<float, 3>> places;
    for (const Vector3f& p : rod) {
      const Vector3d local = R.transpose() * (p.cast<double>() - Vector3d(0.1, -0.1, 0.7));
      if (std::abs(local.z()) < 0.07 && places.size() < 500) places.push_back({p[0], p[1], p[2]});
    }
    Result result;
    std::vector<Step> steps;
    localize_samples(options, view_of(rod), places, result, steps);
    EXPECT_EQ(result.affordances.size(), places.size());
    double worst = 0;
    for (const Affordance& a : result.affordances) worst = std::max(worst, eigen(a.axis).cross(R.col(2)).norm());
    EXPECT_LT(worst, axis == AxisEstimator::kTaubin ? 0.01 : 0.2);
    ASSERT_EQ(result.handles.size(), 1u);
    EXPECT_LT(eigen(result.handles[0].axis).cross(R.col(2)).norm(), 0.01);
    EXPECT_NEAR(result.handles[0].radius, 0.01, 0.0005);
  }
}

}  // namespace
}  // namespace handhold
