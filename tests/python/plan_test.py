"""Grasps are those of `handhold plan`; poses and paths are arrays that fit together."""

import importlib.util
import json
import os
import subprocess
import threading

import numpy as np
import pytest
from conftest import SOURCE

import handhold

if not importlib.util.find_spec("handhold._plan"):
    pytest.skip("there is no planner in this build", allow_module_level=True)
from handhold import plan

# The camera of data/table_scene.pcd stands at Baxter's chest and looks down by 39 degrees.
POSITION, QUATERNION = (0.05, -0.2, 0.45), (-0.6408, 0.6408, -0.2989, 0.2989)


def pose():
    """T_base_camera, by the same arithmetic as the command line's."""
    x, y, z, w = np.array(QUATERNION) / np.sqrt(sum(q * q for q in QUATERNION))
    T = np.eye(4)
    T[:3, :3] = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    T[:3, 3] = POSITION
    return T


@pytest.fixture(scope="module")
def handles(table):
    return handhold.localize(table, hand="baxter").handles


@pytest.fixture(scope="module")
def planner(table):
    planner = plan.GraspPlanner(plan.Arm.baxter("right"))
    planner.set_cloud(table, pose())
    return planner


@pytest.fixture(scope="module")
def made(planner, handles):
    return planner.plan(handles, pose())


@pytest.mark.skipif("HANDHOLD_CLI" not in os.environ, reason="there is no command line in this build")
@pytest.mark.parametrize("order", ["nearest", "confidence", "highest"])
def test_same_grasps_as_the_command_line(table, order):
    place = " ".join(map(str, (*POSITION, *QUATERNION)))
    command = [os.environ["HANDHOLD_CLI"], "plan", SOURCE / "data/table_scene.pcd", "--camera-pose", place]
    command += ["--order", order, "--slot", "2", "--tip", "soft", "--json", "-"]
    expected = json.loads(subprocess.run(command, check=True, capture_output=True).stdout)
    arm = plan.Arm.baxter(slot=2, tip="soft")
    assert (arm.base, arm.joints, arm.tip) == (expected["base"], expected["joints"], "right_gripper")
    planner = plan.GraspPlanner(arm, order=order)
    planner.set_cloud(table, pose())
    names = "center", "axis", "approach", "radius", "length", "confidence"
    handles = [handhold.Handle(*(h[name] for name in names), path=h.get("path", [])) for h in expected["handles"]]
    made = planner.plan(handles, pose())
    assert len(made.grasps) == len(expected["grasps"]) > 0
    assert len(made.rejected) == len(expected["rejected"]) > 0
    for grasp, right in zip(made.grasps, expected["grasps"]):
        for name in "handle", "opening", "width", "angle", "tilt", "flipped", "pregrasp_index":
            assert getattr(grasp, name) == right[name], name
        for name in "pregrasp", "grasp", "approach", "path", "times", "lift_path", "lift_times":
            assert getattr(grasp, name).tolist() == right[name], name
        assert grasp.lifted.tolist() == right["lift"]
    for rejection, right in zip(made.rejected, expected["rejected"]):
        for name in "handle", "reason", "what":
            assert getattr(rejection, name) == right[name], name
        assert {reason: n for reason, n in rejection.counts.items() if n} == right["counts"]


def test_poses_and_paths_fit_together(planner, made):
    arm = planner.arm
    assert len(made.grasps) > 0
    for grasp in made.grasps:
        samples, joints = grasp.path.shape
        assert joints == len(arm.joints) == 7
        assert grasp.times.shape == (samples,) and grasp.lift_times.shape == (len(grasp.lift_path),)
        assert (np.diff(grasp.times) > 0).all() and grasp.times[0] == 0
        assert grasp.path[0] == pytest.approx(arm.rest)
        assert (grasp.path[-1] == grasp.lift_path[0]).all()
        for q, T in (
            (grasp.path[-1], grasp.grasp),
            (grasp.path[grasp.pregrasp_index], grasp.pregrasp),
            (grasp.lift_path[-1], grasp.lifted),
        ):
            assert T.shape == (4, 4) and T[3].tolist() == [0, 0, 0, 1]
            assert arm.forward(q) == pytest.approx(T, abs=1e-3)
        assert grasp.grasp[:3, 2] == pytest.approx(grasp.approach, abs=1e-6)
        assert grasp.lifted[2, 3] - grasp.grasp[2, 3] == pytest.approx(0.15, abs=1e-6)


def test_every_handle_has_a_grasp_or_a_reason(made, handles):
    told = [grasp.handle for grasp in made.grasps] + [rejection.handle for rejection in made.rejected]
    assert sorted(told) == list(range(len(handles)))
    for rejection in made.rejected:
        assert rejection.counts[rejection.reason] > 0


def test_as_many_grasps_as_are_wanted(table, handles, made):
    planner = plan.GraspPlanner(plan.Arm.baxter(), grasps=1)
    planner.set_cloud(table, pose())
    (grasp,) = planner.plan(handles, pose()).grasps
    assert grasp.handle == made.grasps[0].handle


def test_known_bodies_are_obstacles():
    planner = plan.GraspPlanner(plan.Arm.baxter())
    handle = handhold.Handle([0.7, -0.3, 0.1], [0, 0, 1], [1, 0, 0], 0.02, 0.2)
    (free,) = planner.plan([handle], np.eye(4)).grasps
    T = np.eye(4)
    T[:3, 3] = handle.center
    planner.add_box("pillar", (0.1, 0.1, 0.4), T)
    walled = planner.plan([handle], np.eye(4))
    assert walled.grasps == []
    assert [(r.handle, r.reason, r.what) for r in walled.rejected] == [(0, "hand hits", "pillar")]
    assert "hand hits (pillar)" in repr(walled.rejected[0])
    planner.clear_bodies()
    (again,) = planner.plan([handle], np.eye(4)).grasps
    assert np.array_equal(again.path, free.path)


def test_a_plan_outlives_its_planner(table, handles):
    planner = plan.GraspPlanner(plan.Arm.baxter())
    planner.set_cloud(table.astype(float)[::-1], pose())
    grasp = planner.plan(handles, pose()).grasps[0]
    del planner
    assert grasp.times[-1] > 0 and np.isfinite(grasp.path).all()
    assert "Grasp of handle" in repr(grasp)


def test_threads_plan_side_by_side_and_clouds_change_in_turn(table, handles, planner, made):
    paths = [g.path.tolist() for g in made.grasps]
    failures = []

    def work():
        if [g.path.tolist() for g in planner.plan(handles, pose()).grasps] != paths:
            failures.append("another plan")
        planner.set_cloud(table, pose())

    threads = [threading.Thread(target=work) for _ in range(3)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert failures == []


def test_the_start_is_another(table, handles):
    arm = plan.Arm.baxter("left")
    start = [q + 0.1 for q in arm.rest]
    planner = plan.GraspPlanner(arm, start=np.array(start), grasps=1)
    handle = handhold.Handle([0.7, 0.2, 0.1], [0, 0, 1], [1, 0, 0], 0.02, 0.2)
    (grasp,) = planner.plan([handle], np.eye(4)).grasps
    assert grasp.path[0] == pytest.approx(start)


def test_other_arms(tmp_path):
    hand = "[hand]\nopening_min_m = 0.0\nopening_max_m = 0.08\n"
    (tmp_path / "arm.toml").write_text('urdf = "arm.urdf"\nbase = "a"\ntip = "b"\n' + hand)
    with pytest.raises(ValueError, match="arm.urdf"):
        plan.Arm.read(tmp_path / "arm.toml")
    (tmp_path / "arm.urdf").write_text(
        '<robot name="r"><link name="a"/><link name="b"/><joint name="j" type="prismatic"><parent link="a"/>'
        '<child link="b"/><axis xyz="1 0 0"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint></robot>'
    )
    arm = plan.Arm.read(str(tmp_path / "arm.toml"))
    assert (arm.base, arm.tip, arm.joints, arm.rest) == ("a", "b", ["j"], [0])
    assert arm.forward([0.5])[:3, 3].tolist() == [0.5, 0, 0]
    with pytest.raises(ValueError):
        arm.forward([0.5, 0.5])


def test_what_cannot_be_planned(planner, handles):
    for make, message in (
        (lambda: plan.Arm.baxter("middle"), "side = 'middle': must be one of 'right', 'left'"),
        (lambda: plan.Arm.baxter(slot=5), "slot"),
        (lambda: plan.Arm.baxter(tip="sharp"), "tip = 'sharp': must be one of 'hard', 'soft', 'paddle', 'half-round'"),
        (lambda: plan.Arm.baxter(fingers="long"), "fingers = 'long': must be one of 'standard-narrow'"),
        (lambda: plan.GraspPlanner(plan.Arm.baxter(), order="first"), "order = 'first': must be one of 'nearest'"),
        (lambda: plan.GraspPlanner(plan.Arm.baxter(), start=[9] * 7), "start"),
        (lambda: planner.plan(handles, np.eye(3)), "T_base_camera = .*: must be a 4x4 matrix"),
        (lambda: planner.plan(handles, 1.001 * np.eye(4)), "T_base_camera"),
        (lambda: planner.plan([1], np.eye(4)), r"handles\[0\] = 1: must be a handhold.Handle"),
        (lambda: planner.plan([handhold.Handle([0] * 3, [0] * 3, [0, 0, 1], 1, 1)], np.eye(4)), "handle"),
        (lambda: planner.set_cloud(np.zeros((3, 2)), np.eye(4)), r"points: shape \(3, 2\)"),
        (lambda: planner.add_box("x", [1, 2], np.eye(4)), "size = .*: must be three numbers"),
        (lambda: planner.add_box("x", [1, -2, 3], np.eye(4)), "size|edge|negative"),
    ):
        with pytest.raises(ValueError, match=message) as error:
            make()
        assert "\n" not in str(error.value)
