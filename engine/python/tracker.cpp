// handhold.Tracker
#include "handhold/tracker.h"

#include <memory>
#include <utility>
#include <vector>

#include "localizer.h"
#include "numpy_views.h"
#include "results.h"

namespace handhold::python {
namespace {

struct PyTrack {
  std::shared_ptr<const Track> it;
};

Motion to_motion(const char* name, const py::object& matrix) {
  if (matrix.is_none()) return {};
  const Rigid rigid = to_rigid(name, matrix);
  return {rigid.R, rigid.t};
}

/// Copies: the tracker's own change with the next frame.
py::list copies_of(const std::vector<Track>& tracks) {
  const auto copies = std::make_shared<const std::vector<Track>>(tracks);
  py::list list;
  for (const Track& track : *copies) list.append(PyTrack{std::shared_ptr<const Track>(copies, &track)});
  return list;
}

}  // namespace

void bind_tracker(py::module_& m) {
  py::class_<PyTrack>(
      m, "Track", "A handle that is followed from frame to frame. It never changes: the next update makes new ones.")
      .def_property_readonly(
          "id", [](const PyTrack& t) { return t.it->id; },
          "Of this handle alone, as long as the tracker lives: 1, 2, ...")
      .def_property_readonly(
          "handle", [](const PyTrack& t) { return PyHandle{HandlePointer(t.it, &t.it->handle)}; },
          "Place, axis, radius, length and confidence smoothed over the frames, in the last frame's coordinates; the\n"
          "rest as when it was last seen.")
      .def_property_readonly(
          "velocity", [](const PyTrack& t) { return view(t.it, t.it->velocity); },
          "m a frame, (3,); of its center, beside the motion that update() was told")
      .def_property_readonly(
          "age", [](const PyTrack& t) { return t.it->age; }, "Frames in which it was seen.")
      .def_property_readonly(
          "unseen", [](const PyTrack& t) { return t.it->unseen; }, "Frames since; 0: it is in the last one.")
      .def("__repr__", [](const PyTrack& t) {
        return "<Track " + std::to_string(t.it->id) + ": age " + std::to_string(t.it->age) + ", unseen " +
               std::to_string(t.it->unseen) + ">";
      });

  constexpr TrackerOptions kDefaults;
  py::class_<Tracker>(
      m, "Tracker",
      "Carries handles from frame to frame: which is which, where it is on the mean, when it was last seen.\n\n"
      "    max_offset: a handle farther from where a track is expected is another one (m)\n"
      "    max_angle: the same for the angle between their axes (rad)\n"
      "    max_radius: share of the larger radius by which they may differ\n"
      "    weight: above 0, to 1; of a frame's measurement beside what was expected; 1: no smoothing\n"
      "    keep: frames that a handle is kept without being seen\n\n"
      "One tracker serves one call at a time. Raises ValueError for an option that is out of range.")
      .def(py::init([](double max_offset, double max_angle, double max_radius, double weight, int keep) {
             return Tracker({max_offset, max_angle, max_radius, weight, keep});
           }),
           py::kw_only(), py::arg("max_offset") = kDefaults.max_offset, py::arg("max_angle") = kDefaults.max_angle,
           py::arg("max_radius") = kDefaults.max_radius, py::arg("weight") = kDefaults.weight,
           py::arg("keep") = kDefaults.keep,
           "__init__(self, *, max_offset=0.04, max_angle=0.6, max_radius=0.4, weight=0.4, keep=15)\n--\n\n")
      .def(
          "update",
          [](Tracker& tracker, const py::object& handles, const py::object& T_now_last) {
            return copies_of(tracker.update(to_handles(handles), to_motion("T_now_last", T_now_last)));
          },
          py::arg("handles"), py::kw_only(), py::arg("T_now_last") = py::none(),
          "update(self, handles, *, T_now_last=None)\n--\n\n"
          "Takes the handles of the next frame and returns the tracks, in the order of their ids.\n\n"
          "handles: Result.handles, or a list of Handle. T_now_last: 4x4, brings points of the last frame to this "
          "one's\n"
          "coordinates, for a camera that moves.")
      .def_property_readonly(
          "tracks", [](const Tracker& tracker) { return copies_of(tracker.tracks()); }, "As update() returned them.")
      .def(
          "guesses",
          [](const Tracker& tracker, const py::object& T_next_now) {
            const auto places = std::make_shared<std::vector<Vector3>>();
            tracker.guesses(*places, to_motion("T_next_now", T_next_now));
            return view(places, *places);
          },
          py::kw_only(), py::arg("T_next_now") = py::none(),
          "guesses(self, *, T_next_now=None)\n--\n\n"
          "Places on the tracks (G, 3), m, in the coordinates of the next frame: what Localizer.localize takes.");
}

}  // namespace handhold::python
