// handhold._plan: the grasp planner. The only part of the package that needs KDL and urdfdom.
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <memory>
#include <mutex>
#include <shared_mutex>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "handhold/planner.h"
#include "numpy_views.h"
#include "points.h"
#include "public_names.h"
#include "results.h"

namespace handhold::python {
namespace {

using plan::Arm;
using plan::ElectricGripper;
using plan::JointVector;
using plan::PlannerOptions;
using plan::Pose;

/// Several threads may plan at once; whoever changes the obstacles waits for them, without the GIL.
struct PyPlanner {
  plan::GraspPlanner planner;
  mutable std::shared_mutex mutex;

  explicit PyPlanner(plan::GraspPlanner p) : planner(std::move(p)) {}
};
struct PyPlan {
  std::shared_ptr<const plan::Plan> it;
};
struct PyGrasp {
  std::shared_ptr<const plan::Grasp> it;
};
struct PyRejection {
  std::shared_ptr<const plan::Rejection> it;
};

/// @throws std::invalid_argument "NAME = 'TEXT': must be one of ..."
template <class T, std::size_t N>
T by_name(const char* name, const std::string& text, const std::pair<const char*, T> (&choices)[N]) {
  std::string known;
  for (const auto& [choice, value] : choices) {
    if (text == choice) return value;
    known += (known.empty() ? "'" : ", '") + std::string(choice) + "'";
  }
  throw std::invalid_argument(std::string(name) + " = '" + text + "': must be one of " + known);
}

Pose to_pose(const char* name, const py::object& matrix) {
  const Rigid rigid = to_rigid(name, matrix);
  return {rigid.R, rigid.t};
}

py::array_t<double> matrix(const Pose& T) {
  py::array_t<double> array({4, 4});
  auto at = array.mutable_unchecked<2>();
  for (py::ssize_t r = 0; r < 4; ++r) {
    for (py::ssize_t c = 0; c < 4; ++c) {
      const auto row = static_cast<std::size_t>(r), column = static_cast<std::size_t>(c);
      at(r, c) = r == 3 ? (c == 3 ? 1 : 0) : c == 3 ? T.t[row] : T.R[3 * row + column];
    }
  }
  return array;
}

/// (S, J)
py::array_t<double> rows(const std::vector<JointVector>& path) {
  const std::size_t joints = path.empty() ? 0 : path[0].size();
  py::array_t<double> array({path.size(), joints});
  auto at = array.mutable_unchecked<2>();
  for (std::size_t s = 0; s < path.size(); ++s) {
    for (std::size_t j = 0; j < joints; ++j) at(static_cast<py::ssize_t>(s), static_cast<py::ssize_t>(j)) = path[s][j];
  }
  return array;
}

Arm baxter(const std::string& side, const std::string& fingers, int slot, const std::string& tip) {
  using Finger = ElectricGripper::Finger;
  using Tip = ElectricGripper::Tip;
  ElectricGripper gripper;
  gripper.finger = by_name<Finger>("fingers", fingers,
                                   {{"standard-narrow", Finger::kStandardNarrow},
                                    {"standard-wide", Finger::kStandardWide},
                                    {"extended-narrow", Finger::kExtendedNarrow},
                                    {"extended-wide", Finger::kExtendedWide}});
  gripper.slot = slot;
  gripper.tip = by_name<Tip>(
      "tip", tip,
      {{"hard", Tip::kHard}, {"soft", Tip::kSoft}, {"paddle", Tip::kPaddle}, {"half-round", Tip::kHalfRound}});
  return Arm::baxter(by_name<plan::Side>("side", side, {{"right", plan::Side::kRight}, {"left", plan::Side::kLeft}}),
                     gripper);
}

std::unique_ptr<PyPlanner> make_planner(const Arm& arm, const py::object& start, const std::string& order,
                                        std::size_t grasps) {
  PlannerOptions options;
  if (!start.is_none()) options.start = start.cast<JointVector>();
  options.order = by_name<plan::Order>("order", order,
                                       {{"nearest", plan::Order::kNearest},
                                        {"confidence", plan::Order::kConfidence},
                                        {"highest", plan::Order::kHighest}});
  options.max_grasps = grasps;
  return std::make_unique<PyPlanner>(plan::GraspPlanner(arm, options));
}

void set_cloud(PyPlanner& p, const py::object& points, const py::object& T_base_camera) {
  const Points cloud(points, py::none());
  const Pose pose = to_pose("T_base_camera", T_base_camera);
  const py::gil_scoped_release released;
  // The arm stands where the camera may see it.
  plan::CloudObstacleOptions seen;
  seen.own = plan::bodies_of(p.planner.arm(), p.planner.options().start);
  std::vector<float> copy;
  const std::unique_lock lock(p.mutex);
  p.planner.obstacles().set_cloud(cloud.view(copy), pose, seen);
}

void add_box(PyPlanner& p, const std::string& name, const py::object& size, const py::object& T_base_box) {
  plan::Body box;
  box.kind = plan::Shape::Kind::kBox;
  box.size = to_vector3("size", size);
  box.T_base_body = to_pose("T_base_box", T_base_box);
  const py::gil_scoped_release released;
  const std::unique_lock lock(p.mutex);
  p.planner.obstacles().add(name, box);
}

void clear_bodies(PyPlanner& p) {
  const py::gil_scoped_release released;
  const std::unique_lock lock(p.mutex);
  p.planner.obstacles().clear_bodies();
}

PyPlan make_plan(const PyPlanner& p, const py::object& handles, const py::object& T_base_camera) {
  const std::vector<Handle> copies = to_handles(handles);
  const Pose pose = to_pose("T_base_camera", T_base_camera);
  const py::gil_scoped_release released;
  const std::shared_lock lock(p.mutex);
  return {std::make_shared<const plan::Plan>(p.planner.plan(copies, pose))};
}

/// Elements of a plan, which they keep.
template <class Py, class Element>
py::list list_of(const PyPlan& plan, const std::vector<Element>& elements) {
  py::list list;
  for (const Element& element : elements) list.append(Py{std::shared_ptr<const Element>(plan.it, &element)});
  return list;
}

void bind_arm(py::module_& m) {
  py::class_<Arm>(m, "Arm", "An arm from its base link to its tip link, with its hand.")
      .def_static(
          "baxter", &baxter, py::arg("side") = "right", py::kw_only(), py::arg("fingers") = "standard-narrow",
          py::arg("slot") = 3, py::arg("tip") = "hard",
          "baxter(side='right', *, fingers='standard-narrow', slot=3, tip='hard')\n--\n\n"
          "One of Baxter's arms, 'right' or 'left', with its electric gripper.\n\n"
          "fingers: 'standard-narrow', 'standard-wide', 'extended-narrow' or 'extended-wide'; slot: 1 to 4, from\n"
          "the middle outwards; tip: 'hard', 'soft', 'paddle' or 'half-round'.")
      .def_static(
          "read",
          [](const py::object& path) {
            return plan::read_arm(py::module_::import("os").attr("fsencode")(path).cast<std::string>());
          },
          py::arg("path"),
          "read(path)\n--\n\nAny arm, from a TOML file that names its URDF, base, tip and hand, as the main README has "
          "it.")
      .def_property_readonly("base", &Arm::base, "Name of its base link: the frame of everything that is planned.")
      .def_property_readonly("tip", &Arm::tip, "Name of its tip link: the frame of the hand.")
      .def_property_readonly(
          "joints",
          [](const Arm& arm) {
            py::list names;
            for (const plan::Joint& joint : arm.joints()) names.append(joint.name);
            return names;
          },
          "Names of its joints, from base to tip: the columns of a path.")
      .def_property_readonly("rest", &Arm::rest, "Where its joints are at ease (rad; m of a prismatic one).")
      .def(
          "forward", [](const Arm& arm, const JointVector& q) { return matrix(arm.forward(q)); }, py::arg("q"),
          "forward(self, q)\n--\n\nT_base_tip, 4x4, of the positions of its joints.");
}

void bind_grasp(py::module_& m) {
  const auto pose = [](Pose plan::Grasp::*field) {
    return [field](const PyGrasp& g) { return matrix((*g.it).*field); };
  };
  const auto path = [](std::vector<JointVector> plan::Grasp::*field) {
    return [field](const PyGrasp& g) { return rows((*g.it).*field); };
  };
  const auto number = [](auto plan::Grasp::*field) { return [field](const PyGrasp& g) { return (*g.it).*field; }; };
  const auto array = [](auto plan::Grasp::*field) {
    return [field](const PyGrasp& g) { return view(g.it, (*g.it).*field); };
  };
  py::class_<PyGrasp>(m, "Grasp", "How the arm comes to hold a handle. Poses are T_base_tip, 4x4.")
      .def_property_readonly("handle", number(&plan::Grasp::handle), "Index into the handles given.")
      .def_property_readonly("pregrasp", pose(&plan::Grasp::pregrasp), "From where the hand comes straight.")
      .def_property_readonly("grasp", pose(&plan::Grasp::grasp), "Where it closes.")
      .def_property_readonly("lifted", pose(&plan::Grasp::lifted), "Where it is after the lift.")
      .def_property_readonly("opening", number(&plan::Grasp::opening), "m; of the hand on its way to the part")
      .def_property_readonly("width", number(&plan::Grasp::width), "m; of the part, where the fingers meet it")
      .def_property_readonly("approach", array(&plan::Grasp::approach),
                             "unit, base frame; direction in which the hand moves")
      .def_property_readonly("angle", number(&plan::Grasp::angle),
                             "rad; about the part's axis, from the paper's approach")
      .def_property_readonly("tilt", number(&plan::Grasp::tilt), "rad; towards the axis")
      .def_property_readonly("flipped", number(&plan::Grasp::flipped),
                             "Whether the hand is turned by half a turn about its approach.")
      .def_property_readonly(
          "path", path(&plan::Grasp::path),
          "(S, J) positions of the joints (rad, m), from the start by way of the pre-grasp to the grasp")
      .def_property_readonly("times", array(&plan::Grasp::times), "(S,) s; of each, from 0 on")
      .def_property_readonly("pregrasp_index", number(&plan::Grasp::pregrasp_index), "Of the pre-grasp in `path`.")
      .def_property_readonly("lift_path", path(&plan::Grasp::lift_path), "(S, J) from the grasp to the end of the lift")
      .def_property_readonly("lift_times", array(&plan::Grasp::lift_times), "(S,) s; of each, from 0 on")
      .def("__repr__", [](const PyGrasp& g) {
        return "<Grasp of handle " + std::to_string(g.it->handle) + ": " + std::to_string(g.it->path.size()) +
               " positions>";
      });
}

void bind_plan(py::module_& m) {
  const auto reason = [](const plan::Rejection& r) { return std::string(to_string(r.reason)); };
  py::class_<PyRejection>(m, "Rejection", "A handle that was looked at and has no grasp.")
      .def_property_readonly(
          "handle", [](const PyRejection& r) { return r.it->handle; }, "Index into the handles given.")
      .def_property_readonly(
          "reason", [reason](const PyRejection& r) { return reason(*r.it); },
          "Of the way to hold it that came furthest: 'too wide', 'too thin', 'out of reach', 'hand hits',\n"
          "'joint limits', 'arm hits itself', 'arm hits', 'path hits' or 'lift hits'.")
      .def_property_readonly(
          "what", [](const PyRejection& r) { return r.it->what; },
          "What is hit: 'cloud', the name of a known body or of a link; may be empty.")
      .def_property_readonly(
          "counts",
          [](const PyRejection& r) {
            py::dict counts;
            for (std::size_t i = 0; i < plan::kReasons; ++i) {
              counts[py::str(std::string(to_string(static_cast<plan::Reason>(i))))] = r.it->counts[i];
            }
            return counts;
          },
          "How many ways to hold it ended for each reason.")
      .def("__repr__", [reason](const PyRejection& r) {
        return "<Rejection of handle " + std::to_string(r.it->handle) + ": " + reason(*r.it) +
               (r.it->what.empty() ? "" : " (" + r.it->what + ")") + ">";
      });
  py::class_<PyPlan>(m, "Plan", "Grasps for handles, and why the others have none. It never changes.")
      .def_property_readonly(
          "grasps", [](const PyPlan& p) { return list_of<PyGrasp>(p, p.it->grasps); }, "In the order asked for.")
      .def_property_readonly(
          "rejected", [](const PyPlan& p) { return list_of<PyRejection>(p, p.it->rejected); },
          "Handles that were looked at and have no grasp, in the same order.")
      .def("__repr__", [](const PyPlan& p) {
        return "<Plan: " + std::to_string(p.it->grasps.size()) + " grasps, " + std::to_string(p.it->rejected.size()) +
               " rejected>";
      });
}

void bind_planner(py::module_& m) {
  py::class_<PyPlanner>(
      m, "GraspPlanner",
      "Plans for one arm.\n\n"
      "start: where the arm stands, a position for each joint; None: its rest. order: which handle is\n"
      "tried first, 'nearest' (to the arm's mount), 'confidence' or 'highest'. grasps: how many are wanted,\n"
      "one a handle; 0: one for every handle that has one. Raises ValueError for what is out of range.")
      .def(py::init(&make_planner), py::arg("arm"), py::kw_only(), py::arg("start") = py::none(),
           py::arg("order") = "nearest", py::arg("grasps") = 0,
           "__init__(self, arm, *, start=None, order='nearest', grasps=0)\n--\n\n")
      .def_property_readonly(
          "arm", [](const PyPlanner& p) { return p.planner.arm(); }, "The arm.")
      .def("set_cloud", &set_cloud, py::arg("points"), py::arg("T_base_camera"),
           "set_cloud(self, points, T_base_camera)\n--\n\n"
           "What the arm keeps clear of, instead of the cloud before: an array as localize() takes it, and where the "
           "camera\n"
           "stands. What the camera sees of the arm at its start is left out.")
      .def("add_box", &add_box, py::arg("name"), py::arg("size"), py::arg("T_base_box"),
           "add_box(self, name, size, T_base_box)\n--\n\n"
           "A body that is known, as a table: its edges (three lengths, m) and the pose of its middle.")
      .def("clear_bodies", &clear_bodies, "clear_bodies(self)\n--\n\nForgets the boxes.")
      .def("plan", &make_plan, py::arg("handles"), py::arg("T_base_camera"),
           "plan(self, handles, T_base_camera)\n--\n\n"
           "Grasps for handles in the camera's frame: Result.handles, or a list of Handle. Other Python threads run\n"
           "meanwhile. The same arguments and obstacles give the same plan.");
}

}  // namespace
}  // namespace handhold::python

PYBIND11_MODULE(_plan, m) {
  namespace py = pybind11;
  using namespace handhold::python;
  py::options docstrings;
  docstrings.disable_function_signatures();
  py::module_::import("handhold._core");  // the types of handles
  translate_errors();
  bind_arm(m);
  bind_grasp(m);
  bind_plan(m);
  bind_planner(m);
  make_public(m, "handhold.plan");
}
