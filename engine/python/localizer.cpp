#include "localizer.h"

#include <pybind11/stl.h>

#include <stdexcept>
#include <string>
#include <utility>

#include "handhold/device.h"
#include "keywords.h"
#include "numpy_views.h"
#include "points.h"

namespace handhold::python {
namespace {

/// Results that a localizer remembers: the one that Python still holds, the next one, and one in between.
constexpr std::size_t kResults = 3;

constexpr const char* kViewpoint = "viewpoint";

py::tuple samples_of(const PyLocalizer& localizer) {
  const auto samples = std::make_shared<const std::vector<Sample>>(localizer.samples());
  const auto n = static_cast<py::ssize_t>(samples->size());
  const Sample* first = samples->data();
  static_assert(sizeof(Step) == sizeof(std::uint8_t));
  return py::make_tuple(
      view(samples, first ? first->position.data() : nullptr, {n, 3}, {sizeof(Sample), sizeof(double)}),
      view(samples, first ? reinterpret_cast<const std::uint8_t*>(&first->step) : nullptr, {n}, {sizeof(Sample)}));
}

py::tuple step_names() {
  constexpr int kSteps = static_cast<int>(Step::kCut) + 1;
  py::tuple names(kSteps);
  for (int i = 0; i < kSteps; ++i) names[i] = std::string(to_string(static_cast<Step>(i)));
  return names;
}

const char* const kPointsHelp =
    "points: float32 or float64, (N, 3), or (H, W, 3) as a depth camera delivers them; metres, in any frame; NaN "
    "where\n"
    "nothing was measured. float32 is read where it lies when x, y, z stand together and the points are evenly spaced\n"
    "(also a slice such as cloud[..., :3]); everything else is copied first.\n"
    "viewpoint: where the sensor stood, three numbers (m, in that frame); None: no single viewpoint, as of merged "
    "views.\n";

}  // namespace

/// The localizer, for one thread.
class PyLocalizer::Turn {
 public:
  explicit Turn(const PyLocalizer& localizer) : busy_(localizer.busy_) {
    if (busy_.exchange(true)) {
      throw std::runtime_error("this localizer is busy with another thread's frame; make one for each thread");
    }
    if (localizer.failed_) {
      busy_ = false;
      throw std::runtime_error("this localizer failed in an earlier frame; make a new one");
    }
  }
  ~Turn() { busy_ = false; }
  Turn(const Turn&) = delete;
  Turn& operator=(const Turn&) = delete;

 private:
  std::atomic<bool>& busy_;
};

/// Called with the GIL: nobody else takes or lets go of a result meanwhile.
std::shared_ptr<Result> PyLocalizer::spare_result() {
  for (const std::shared_ptr<Result>& result : results_) {
    if (result.use_count() == 1) return result;
  }
  // Python keeps them all: let it have the oldest.
  if (results_.size() == kResults) results_.erase(results_.begin());
  return results_.emplace_back(std::make_shared<Result>());
}

PyResult PyLocalizer::localize(const py::object& points, const py::object& viewpoint, const py::object& guesses) {
  const Points cloud(points, viewpoint);
  const std::vector<Vector3> places = guesses.is_none() ? std::vector<Vector3>() : to_vectors3("guesses", guesses);
  const Turn turn(*this);
  const std::shared_ptr<Result> result = spare_result();
  try {
    const py::gil_scoped_release released;
    localizer_.localize(cloud.view(copied_points_), *result, places);
  } catch (const std::invalid_argument&) {
    throw;  // a cloud that was refused: nothing has happened
  } catch (...) {
    failed_ = true;
    throw;
  }
  return {result};
}

void PyLocalizer::set_seed(std::uint64_t seed) {
  const Turn turn(*this);
  localizer_.set_seed(seed);
}

std::vector<Sample> PyLocalizer::samples() const {
  const Turn turn(*this);
  return localizer_.samples();
}

void bind_localizer(py::module_& m) {
  const std::string options = keyword_signature();
  const std::string help =
      "hand: 'baxter', options of a known hand. config: path of a TOML file with options. Options given here win over\n"
      "the file, which wins over the hand:\n\n" +
      keyword_help();
  const std::string errors =
      "\nRaises ValueError for an option that is unknown or out of range, naming it and what would be right";

  const std::string localizer_doc =
      "Finds the graspable parts of clouds, frame after frame, and reuses its memory.\n\n" + help + errors + ".\n";
  py::class_<PyLocalizer>(m, "Localizer", localizer_doc.c_str())
      .def(py::init([](const py::kwargs& keywords) { return std::make_unique<PyLocalizer>(to_options(keywords)); }),
           ("__init__(self, *, " + options + ")\n--\n\n").c_str())
      .def("localize", &PyLocalizer::localize, py::arg("points"), py::kw_only(),
           py::arg(kViewpoint) = py::make_tuple(0.0, 0.0, 0.0), py::arg("guesses") = py::none(),
           (std::string("localize(self, points, *, viewpoint=(0.0, 0.0, 0.0), guesses=None)\n--\n\n"
                        "Searches a cloud and returns a Result. Other Python threads run meanwhile.\n\n") +
            kPointsHelp +
            "guesses: where handles are expected, (G, 3) (m; Tracker.guesses()): samples are drawn there, too.\n\n"
            "A cloud in which nothing can be found is no error: Result.status says why.\n"
            "Raises ValueError for points of another shape or dtype, RuntimeError while the localizer is busy with\n"
            "another thread's frame.")
               .c_str())
      .def(
          "set_seed",
          [](PyLocalizer& localizer, const py::object& seed) {
            // By the option's own rules.
            localizer.set_seed(to_options(py::kwargs(py::dict(py::arg("seed") = seed))).seed);
          },
          py::arg("seed"),
          "set_seed(self, seed)\n--\n\n"
          "Seed of the frames from the next one on: in a stream each frame may draw other samples.")
      .def("cancel", &PyLocalizer::cancel,
           "cancel(self)\n--\n\n"
           "Ends the frame in progress, from another thread: it returns soon, with status 'cancelled' and nothing\n"
           "found. Does nothing when none is in progress.")
      .def("samples", &samples_of,
           "samples(self)\n--\n\n"
           "The samples of the last frame, in the order in which they were drawn, and where each ended: positions\n"
           "(N, 3), m, and indices into handhold.STEPS (N,). Affordance.sample is an index into them.")
      .def_property_readonly(
          "options", [](const PyLocalizer& localizer) { return to_dict(localizer.options()); },
          "The options in use by name, as a dictionary; None where the method decides.")
      .def_property_readonly(
          "backend", [](const PyLocalizer& localizer) { return std::string(to_string(localizer.backend())); },
          "What frames run on: 'cpu' or 'cuda'. backend='auto' becomes one of them when the localizer is made.")
      .def_property_readonly("backend_reason", &PyLocalizer::backend_reason,
                             "With backend='auto', why frames run on the CPU, in one line; otherwise ''.");

  m.def(
      "localize",
      [](const py::object& points, const py::kwargs& keywords) {
        const bool has_viewpoint = keywords.contains(kViewpoint);
        const py::object viewpoint =
            has_viewpoint ? keywords.attr("pop")(kViewpoint) : py::object(py::make_tuple(0.0, 0.0, 0.0));
        return PyLocalizer(to_options(keywords, {kViewpoint})).localize(points, viewpoint, py::none());
      },
      py::arg("points"),
      ("localize(points, *, viewpoint=(0.0, 0.0, 0.0), " + options +
       ")\n--\n\n"
       "Searches one cloud and returns a Result. For many, a Localizer reuses its memory and is faster.\n\n" +
       kPointsHelp + help + errors + ", and for points of another shape or dtype.\n")
          .c_str());
  m.def(
      "options", [](const py::kwargs& keywords) { return to_dict(to_options(keywords)); },
      ("options(*, " + options +
       ")\n--\n\n"
       "All options as a dictionary: the defaults with these changes. localize(points, **options(...)) takes it.\n\n" +
       help + errors + ".\n")
          .c_str());
  py::class_<CudaDevice>(m, "CudaDevice", "The GPU that backend='cuda' would run on, or why there is none.")
      .def_property_readonly(
          "available", [](const CudaDevice& device) { return device.available; }, "Whether there is one.")
      .def_property_readonly(
          "name", [](const CudaDevice& device) { return device.name; }, "Such as 'NVIDIA H200'; '' where none is.")
      .def_property_readonly(
          "reason", [](const CudaDevice& device) { return device.reason; },
          "Why none is available, in one line; '' where one is.");
  m.def("cuda_device", &cuda_device, py::call_guard<py::gil_scoped_release>(),
        "cuda_device()\n--\n\n"
        "The first NVIDIA GPU, which backend='cuda' runs on. Asks the driver at each call; never raises for want of "
        "one.");
  m.attr("STEPS") = step_names();
  m.def("isa", &Localizer::isa,
        "isa()\n--\n\nInstruction set of the kernels in use: 'scalar', 'avx2', 'avx512' or 'neon'.");
}

}  // namespace handhold::python
