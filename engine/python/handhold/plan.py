"""From handles to grasps that an arm can carry out. Where the build has KDL and urdfdom.

    planner = handhold.plan.GraspPlanner(handhold.plan.Arm.baxter("right"))
    planner.set_cloud(points, T_base_camera)
    for grasp in planner.plan(result.handles, T_base_camera).grasps:
        print(grasp.grasp, grasp.path)          # 4x4, (S, J)

Metres, radians, seconds; the frame `base` is the arm's base link, the frame of the hand its tip link. Poses are 4x4:
T_base_camera brings points of the camera's frame to the base's.
"""

from . import _core  # noqa: F401  (the types of handles)

try:
    from ._plan import Arm, Grasp, GraspPlanner, Plan, Rejection
except ImportError as error:
    raise ImportError(
        "handhold.plan: this build has no planner, or its libraries are gone; install liborocos-kdl-dev and "
        "liburdfdom-dev, and handhold again"
    ) from error

__all__ = ["Arm", "Grasp", "GraspPlanner", "Plan", "Rejection"]
