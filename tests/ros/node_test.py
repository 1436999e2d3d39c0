"""The ROS node with a real roscore: publishers, the node and this subscriber are processes of their own.

    /usr/bin/python3 node_test.py BUILD/tools/ros BUILD/tools/handhold DATA CLASS...

Nothing depends on how long things take: every wait is for a condition, and ends after minutes only to fail.
"""
import json
import math
import os
import signal
import struct
import subprocess
import sys
import unittest

BUILD, PROGRAM, DATA = map(os.path.abspath, sys.argv[1:4])
HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.join(os.path.dirname(os.path.dirname(HERE)), "tools/ros"))
from ros_session import Session, wait_for  # noqa: E402

sys.path.insert(0, os.path.join(BUILD, "python"))
CENTER, RADIUS = (0.05, 0.0, 0.7), 0.02
session = None


def setUpModule():
    global session, rospy, roslib
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))
    session = Session(BUILD)
    os.environ.update(session.env)
    import rospy

    rospy.init_node("test", disable_signals=True)


def tearDownModule():
    rospy.signal_shutdown("done")
    left = session.close()
    assert not left, f"had to be killed: {left}"


def cylinder():
    """The half of a cylinder along y that a camera in the origin sees, every millimetre."""
    points = []
    steps = round(math.pi * RADIUS * 1000)
    for i in range(151):
        for j in range(steps + 1):
            angle = math.pi * j / steps
            across, towards = RADIUS * math.cos(angle), RADIUS * math.sin(angle)
            points.append((CENTER[0] + across, -0.075 + 0.001 * i, CENTER[2] - towards))
    return points


def cloud_message(frame="camera", number="f", order="<", names="xyz", points=None, stamp=None):
    """A field of noise comes first, so that nothing lies where it usually does."""
    from sensor_msgs.msg import PointCloud2, PointField

    points = cylinder() if points is None else points
    size = {"f": 4, "d": 8}[number]
    message = PointCloud2()
    message.header.frame_id = frame
    message.header.stamp = rospy.Time.now() if stamp is None else stamp
    message.width, message.height = len(points), 1
    message.is_bigendian = order == ">"
    message.point_step = 3 + 3 * size
    message.row_step = message.point_step * len(points)
    kind = {"f": PointField.FLOAT32, "d": PointField.FLOAT64}[number]
    message.fields = [PointField("noise", 0, PointField.UINT8, 1)]
    message.fields += [PointField(n, 3 + size * i, kind, 1) for i, n in enumerate(names)]
    message.data = b"".join(b"\xff\xff\xff" + struct.pack(order + "3" + number, *p) for p in points)
    message.is_dense = True
    return message


class Base(unittest.TestCase):
    def setUp(self):
        self.started, self.subscribers, self.count = [], [], 0
        self.name = "n" + self.id().split(".")[-1]

    def tearDown(self):
        for subscriber in self.subscribers:
            subscriber.unregister()
        for process in reversed(self.started):
            process.end()
        if rospy.has_param("/" + self.name):
            rospy.delete_param("/" + self.name)

    def start(self, name, command):
        process = session.start(name, command)
        self.started.append(process)
        return process

    def start_node(self, topic=None, **parameters):
        for name, value in parameters.items():
            rospy.set_param(f"/{self.name}/{name}", value)
        topic = topic or f"/{self.name}_cloud"
        node = self.start("node", [session.program("handhold_node"), f"__name:={self.name}", f"cloud:={topic}"])
        wait_for(lambda: "clouds from" in node.log(), "the node", explain=node.log)
        return node

    def listen(self, topic, kind):
        got = []
        self.subscribers.append(rospy.Subscriber(topic, kind, got.append))
        return got

    def handles(self):
        from handhold_ros.msg import HandleList

        got = self.listen(f"/{self.name}/handles", HandleList)
        wait_for(lambda: self.subscribers[-1].get_num_connections() > 0, "a connection to the node")
        return got

    def publisher(self, kind=None, topic=None):
        from sensor_msgs.msg import PointCloud2

        publisher = rospy.Publisher(topic or f"/{self.name}_cloud", kind or PointCloud2, queue_size=20)
        self.subscribers.append(publisher)
        return publisher

    def connected(self, publisher):
        wait_for(lambda: publisher.get_num_connections() > 0, "a connection to the node")
        return publisher

    def diagnosis(self, node, condition, what):
        """The first status for which condition(status, values) holds."""
        from diagnostic_msgs.msg import DiagnosticArray

        got = self.listen("/diagnostics", DiagnosticArray)

        def found():
            for array in got:
                for status in array.status:
                    if status.name.startswith(self.name + ":"):
                        values = {v.key: v.value for v in status.values}
                        if condition(status, values):
                            return status, values
            return None

        return wait_for(found, what, explain=node.log)

    def call(self, service, kind, *arguments):
        rospy.wait_for_service(f"/{self.name}/{service}", 120)
        return rospy.ServiceProxy(f"/{self.name}/{service}", kind)(*arguments)

    def reload(self):
        from std_srvs.srv import Trigger

        return self.call("reload", Trigger)

    def expect_cylinder(self, message):
        self.assertEqual(message.status, "ok")
        self.assertEqual(len(message.handles), 1)
        handle = message.handles[0]
        self.assertAlmostEqual(handle.pose.position.x, CENTER[0], delta=0.002)
        self.assertAlmostEqual(handle.pose.position.z, CENTER[2], delta=0.002)
        self.assertAlmostEqual(handle.radius, RADIUS, delta=0.001)
        self.assertGreater(handle.axis.y, 0.99)

    def search(self, node, message, got):
        """Publishes one cloud, and waits for what was found in it."""
        publisher = self.connected(self.publisher())
        publisher.publish(message)
        stamp = message.header.stamp
        return wait_for(lambda: next((m for m in got if m.header.stamp == stamp), None), "handles", explain=node.log)


class Clouds(Base):
    def test_what_the_command_line_finds(self):
        from handhold_ros.msg import AffordanceList
        from sensor_msgs.msg import PointCloud2
        from visualization_msgs.msg import Marker, MarkerArray

        path = os.path.join(DATA, "table_scene.pcd")
        out = subprocess.run([PROGRAM, "localize", path, "--samples", "2000", "--no-times", "--json", "-"],
                             check=True, capture_output=True)
        expected = json.loads(out.stdout)
        node = self.start_node(samples=2000, track=False, viewpoint_frame="")
        affordances = self.listen(f"/{self.name}/affordances", AffordanceList)
        markers = self.listen(f"/{self.name}/markers", MarkerArray)
        clouds = self.listen(f"/{self.name}_cloud", PointCloud2)
        wait_for(lambda: all(s.get_num_connections() for s in self.subscribers[:2]), "connections", explain=node.log)
        got = self.handles()
        self.start("publisher", [session.program("cloud_publisher"), f"cloud:=/{self.name}_cloud", f"_file:={path}",
                                 "_frame:=some_camera", "_rate:=5", "__name:=p" + self.name])
        wait_for(lambda: len(got) >= 2 and affordances and markers and clouds, "handles", explain=node.log)

        message = got[0]
        # This listener may have met the publisher later than the node did.
        wait_for(lambda: any(m.header.stamp == c.header.stamp for m in got for c in clouds), "a cloud's stamp",
                 explain=node.log)
        self.assertEqual(message.header.frame_id, "some_camera")
        self.assertEqual((message.points, message.finite_points),
                         (expected["cloud"]["points"], expected["cloud"]["finite"]))
        self.assertGreater(len(message.handles), 2)
        self.assertEqual(len(message.handles), len(expected["handles"]))
        for handle, wanted in zip(message.handles, expected["handles"]):
            p = handle.pose.position
            self.assertEqual([p.x, p.y, p.z], wanted["center"])
            self.assertEqual([handle.axis.x, handle.axis.y, handle.axis.z], wanted["axis"])
            self.assertEqual([handle.approach.x, handle.approach.y, handle.approach.z], wanted["approach"])
            self.assertEqual((handle.radius, handle.length, handle.confidence),
                             (wanted["radius"], wanted["length"], wanted["confidence"]))
            self.assertEqual(list(handle.affordances), wanted["affordances"])
        # The same cloud gives the same handles.
        self.assertEqual(got[0].handles, got[1].handles)
        self.assertEqual(affordances[0].header.frame_id, "some_camera")
        self.assertEqual([a.radius for a in affordances[0].affordances], [a["radius"] for a in expected["affordances"]])

        drawn = markers[0].markers
        self.assertEqual(drawn[0].action, Marker.DELETEALL)
        self.assertTrue(all(m.action == Marker.ADD for m in drawn[1:]))
        self.assertTrue(all(m.header.frame_id == "some_camera" for m in drawn))
        for name in ("handles", "approach", "labels"):
            self.assertEqual(sum(m.ns == name for m in drawn), len(message.handles))
        _, values = self.diagnosis(node, lambda s, v: v.get("status") == "ok", "diagnostics")
        self.assertEqual(int(values["funnel.samples"]), expected["funnel"]["samples"])
        self.assertEqual(int(values["funnel.affordances"]), len(expected["affordances"]))
        self.assertEqual(int(values["handles"]), len(expected["handles"]))
        self.assertLessEqual(float(values["search_ms_p50"]), float(values["search_ms_p99"]))

    def test_layouts(self):
        node = self.start_node(track=False)
        got = self.handles()
        first = self.search(node, cloud_message(), got)
        self.expect_cylinder(first)
        for layout in ({"number": "d", "order": ">"}, {"order": ">"}, {"number": "d"}):
            self.assertEqual(self.search(node, cloud_message(**layout), got).handles, first.handles, layout)
        turned = [(z, y, x) for x, y, z in cylinder()]
        self.assertEqual(self.search(node, cloud_message(names="zyx", points=turned), got).handles, first.handles)

    def test_bad_messages_are_passed_over(self):
        node = self.start_node()
        got = self.handles()
        publisher = self.connected(self.publisher())
        for spoil, complaint in (
            (lambda m: setattr(m, "fields", m.fields[:3]), "there is no field 'z'"),
            (lambda m: setattr(m, "data", m.data[:100]), "data has 100 bytes"),
            (lambda m: setattr(m, "point_step", 0), "point_step = 0"),
            (lambda m: (setattr(m, "width", 2**32 - 1), setattr(m, "height", 2**32 - 1)), "row_step"),
        ):
            message = cloud_message()
            spoil(message)
            publisher.publish(message)
            wait_for(lambda: complaint in node.log(), complaint, explain=node.log)
        empty = cloud_message(points=[])
        self.assertEqual(self.search(node, empty, got).status, "empty")
        self.expect_cylinder(self.search(node, cloud_message(), got))
        self.assertEqual(len(got), 2)
        self.diagnosis(node, lambda s, v: v.get("skipped") == "4" and s.level == 0, "four that were passed over")

    def test_newest_cloud_wins(self):
        node = self.start_node(samples=50000, method="paper", track=False)
        got = self.handles()
        publisher = self.connected(self.publisher())
        self.search(node, cloud_message(), got)
        messages = [cloud_message() for _ in range(12)]
        for message in messages:
            publisher.publish(message)

        # ROS's own queue is short, too: what it drops is told from the gaps between the messages' numbers.
        def all_are_counted(_, values):
            count = {name: int(values.get(name, 0)) for name in ("received", "lost", "searched", "dropped")}
            return count["received"] + count["lost"] == 13 and count["searched"] + count["dropped"] == count["received"]

        _, values = self.diagnosis(node, all_are_counted, "13 clouds")
        self.assertGreater(int(values["dropped"]) + int(values["lost"]), 0)
        wait_for(lambda: len(got) == int(values["searched"]), "handles")
        self.assertEqual(got[-1].header.stamp, messages[-1].header.stamp)

    def test_tracks(self):
        from handhold_ros.msg import TrackList

        node = self.start_node()
        tracks = self.listen(f"/{self.name}/tracks", TrackList)
        wait_for(lambda: self.subscribers[-1].get_num_connections() > 0, "a connection to the node")
        got = self.handles()
        for age in (1, 2, 3):
            message = cloud_message()
            self.search(node, message, got)
            wait_for(lambda: len(tracks) == age, "tracks")
            self.assertEqual(tracks[-1].header, got[-1].header)
            self.assertEqual([(t.id, t.age, t.unseen) for t in tracks[-1].tracks], [(1, age, 0)])
        # The time goes back: another recording, other tracks.
        message = cloud_message(stamp=rospy.Time(1000))
        self.search(node, message, got)
        wait_for(lambda: len(tracks) == 4, "tracks")
        self.assertEqual(tracks[-1].tracks[0].age, 1)


class Parameters(Base):
    def extent(self, node, affordances, got):
        """The width of a finger that is in use."""
        message = cloud_message()
        self.expect_cylinder(self.search(node, message, got))
        stamp = message.header.stamp
        lists = wait_for(lambda: [a for a in affordances if a.header.stamp == stamp], "affordances", explain=node.log)
        return lists[0].affordances[0].extent

    def test_wrong_ones_are_reported_and_stay(self):
        from handhold_ros.msg import AffordanceList

        config = os.path.join(session.folder, "options.toml")
        with open(config, "w") as file:
            file.write("finger_width = 0.015\nsamples = 3000\n")
        node = self.start_node(samples="many", hand_apertur=0.07, radius=[0.02, -1], finger_thickness={"a": 1},
                               config=config, track="maybe", arm="middle")
        where = f"/{self.name}/"
        log = node.log()
        for text in (
            f"parameter {where}samples = 'many': must be",
            f"unknown parameter {where}hand_apertur; did you mean 'hand_aperture'?",
            f"parameter {where}radius = ",
            f"parameter {where}finger_thickness is a group",
            f"parameter {where}track = 'maybe': must be true or false",
            f"parameter {where}arm: ",  # an unknown name, or a node that cannot plan
        ):
            self.assertIn(text, log)
        self.assertEqual(log.count("ERROR"), 6, log)
        self.diagnosis(node, lambda s, v: s.name.endswith("parameters") and s.level == 2, "an error in diagnostics")
        affordances = self.listen(f"/{self.name}/affordances", AffordanceList)
        wait_for(lambda: self.subscribers[-1].get_num_connections() > 0, "a connection to the node")
        got = self.handles()
        self.assertEqual(self.extent(node, affordances, got), 0.015)

        for name in ("hand_apertur", "finger_thickness", "samples", "radius", "track", "arm"):
            rospy.delete_param(where + name)
        rospy.set_param(where + "finger_width", 0.018)  # wins over the file
        answer = self.reload()
        self.assertTrue(answer.success, answer.message)
        self.assertEqual(self.extent(node, affordances, got), 0.018)

        rospy.set_param(where + "finger_width", -1)
        answer = self.reload()
        self.assertFalse(answer.success)
        self.assertIn(f"parameter {where}finger_width = -1", answer.message)
        self.assertEqual(self.extent(node, affordances, got), 0.018)

        rospy.delete_param(where + "finger_width")
        rospy.set_param(where + "config", config + ".none")
        answer = self.reload()
        self.assertFalse(answer.success)
        self.assertIn("no such file", answer.message)
        self.assertEqual(self.extent(node, affordances, got), 0.018)
        self.assertTrue(node.lives())

    def test_names_that_are_none(self):
        node = self.start("node", [session.program("handhold_node"), f"__name:={self.name}", "cloud:=/my camera",
                                   f"cloud:=/{self.name}_cloud"])
        wait_for(lambda: "clouds from" in node.log(), "the node", explain=node.log)
        self.assertIn("'cloud:=/my camera' is no remapping and was left out", node.log())
        self.expect_cylinder(self.search(node, cloud_message(), self.handles()))

    def test_topic_without_clouds(self):
        from std_msgs.msg import String

        self.publisher(topic="/where_clouds_are")
        node = self.start_node(topic="/nowhere", input_timeout=0.1, diagnostics_period=0.1)
        error = "no cloud on /nowhere: nobody publishes it; remap 'cloud' to one of these: /where_clouds_are"
        wait_for(lambda: error in node.log(), error, explain=node.log)
        self.publisher(kind=String, topic="/nowhere")
        wait_for(lambda: "it has type std_msgs/String, not sensor_msgs/PointCloud2" in node.log(), "an error",
                 explain=node.log)
        self.diagnosis(node, lambda s, v: s.level == 2 and "no cloud on" in s.message, "an error in diagnostics")
        self.assertTrue(node.lives())


class Frames(Base):
    def publish_transform(self, parent, child, translation, rotation):
        """Latched, as robots publish what does not move."""
        from geometry_msgs.msg import TransformStamped
        from tf2_msgs.msg import TFMessage

        publisher = rospy.Publisher("/tf_static", TFMessage, queue_size=10, latch=True)
        self.subscribers.append(publisher)
        t = TransformStamped()
        t.header.frame_id, t.child_frame_id = parent, child
        t.transform.translation.x, t.transform.translation.y, t.transform.translation.z = translation
        r = t.transform.rotation
        r.x, r.y, r.z, r.w = rotation
        publisher.publish(TFMessage([t]))

    def test_workspace_in_another_frame(self):
        # room: x forward, y left, z up; the camera looks ahead from (1, 2, 1).
        self.publish_transform("room", "camera", (1, 2, 1), (-0.5, 0.5, -0.5, 0.5))
        x, y, z = 1 + CENTER[2], 2 - CENTER[0], 1 - CENTER[1]
        around = [x - 0.1, x + 0.1, y - 0.1, y + 0.1, z - 0.2, z + 0.2]
        node = self.start_node(workspace=around, workspace_frame="room", transform_timeout=60, track=False)
        got = self.handles()
        message = self.search(node, cloud_message(), got)
        self.assertEqual(message.header.frame_id, "camera")
        self.expect_cylinder(message)
        self.assertGreater(message.handles[0].approach.z, 0.5)

        rospy.set_param(f"/{self.name}/workspace", [v + 1 for v in around])
        self.assertTrue(self.reload().success)
        self.assertEqual(self.search(node, cloud_message(), got).handles, [])

        # A wrong frame: an error that says which there are, no handles, and a node that lives.
        rospy.set_param(f"/{self.name}/workspace", around)
        rospy.set_param(f"/{self.name}/workspace_frame", "rom")
        rospy.set_param(f"/{self.name}/transform_timeout", 0.1)
        self.assertTrue(self.reload().success)
        count = len(got)
        self.connected(self.publisher()).publish(cloud_message())
        wait_for(lambda: "no transform from 'camera' to 'rom'" in node.log() and "room" in node.log(), "an error",
                 explain=node.log)
        self.diagnosis(node, lambda s, v: v.get("skipped") == "1" and s.level == 2, "an error in diagnostics")
        self.assertEqual(len(got), count)
        rospy.set_param(f"/{self.name}/workspace_frame", "room")
        self.assertTrue(self.reload().success)
        self.expect_cylinder(self.search(node, cloud_message(), got))

    def test_cloud_in_another_frame_than_the_camera(self):
        self.publish_transform("hall", "lens", (0, 0, 0.3), (0, 0, 0, 1))
        moved = [(x, y, z + 0.3) for x, y, z in cylinder()]
        node = self.start_node(viewpoint_frame="lens", transform_timeout=60, track=False)
        got = self.handles()
        message = self.search(node, cloud_message(frame="hall", points=moved), got)
        self.assertEqual(len(message.handles), 1)
        self.assertAlmostEqual(message.handles[0].pose.position.z, CENTER[2] + 0.3, delta=0.002)

    def test_camera_that_moves(self):
        from geometry_msgs.msg import TransformStamped
        from handhold_ros.msg import TrackList
        from tf2_msgs.msg import TFMessage

        node = self.start_node(fixed_frame="ground", transform_timeout=60)
        tracks = self.listen(f"/{self.name}/tracks", TrackList)
        wait_for(lambda: self.subscribers[-1].get_num_connections() > 0, "a connection to the node")
        got = self.handles()
        transforms = self.connected(rospy.Publisher("/tf", TFMessage, queue_size=10))
        self.subscribers.append(transforms)
        for age in (1, 2, 3):
            # 0.2 m to the right each time: more than a handle may jump.
            x = 0.2 * age
            message = cloud_message(frame="dolly", points=[(p[0] - x, p[1], p[2]) for p in cylinder()])
            t = TransformStamped()
            t.header.stamp, t.header.frame_id, t.child_frame_id = message.header.stamp, "ground", "dolly"
            t.transform.translation.x, t.transform.rotation.w = x, 1
            transforms.publish(TFMessage([t]))
            self.search(node, message, got)
            wait_for(lambda: len(tracks) == age, "tracks", explain=node.log)
            self.assertEqual([(t.id, t.age) for t in tracks[-1].tracks], [(1, age)])
            self.assertAlmostEqual(tracks[-1].tracks[0].handle.pose.position.x, CENTER[0] - x, delta=0.005)
            # A cloud that is passed over, from another place, moves no track.
            bad = cloud_message(frame="dolly")
            bad.point_step = 0
            t.header.stamp, t.transform.translation.x = bad.header.stamp, x + 5
            transforms.publish(TFMessage([t]))
            self.connected(self.publisher()).publish(bad)
            self.diagnosis(node, lambda s, v: v.get("skipped") == str(age), "a cloud that is passed over")

    def test_plan(self):
        from handhold_ros.srv import PlanGrasps

        # As in the command line's test: the cylinder stands before Baxter.
        self.publish_transform("base", "head_camera", (0.05, -0.2, 0.15), (-0.5, 0.5, -0.5, 0.5))
        node = self.start_node(transform_timeout=60, track=False)
        got = self.handles()
        answer = self.call("plan", PlanGrasps, [], 0, 0)
        self.assertFalse(answer.success)
        if "built without" in answer.message:
            self.skipTest(answer.message)
        self.assertIn("no arm is chosen; set the parameter arm", answer.message)
        rospy.set_param(f"/{self.name}/arm", "right")
        self.assertTrue(self.reload().success)
        self.assertIn("no cloud has been searched", self.call("plan", PlanGrasps, [], 0, 0).message)
        message = cloud_message(frame="head_camera")
        self.assertEqual(len(self.search(node, message, got).handles), 1)

        answer = self.call("plan", PlanGrasps, [], 0, 0)
        self.assertTrue(answer.success, answer.message)
        self.assertEqual((answer.header.frame_id, answer.handles_frame), ("base", "head_camera"))
        self.assertEqual(answer.header.stamp, message.header.stamp)
        self.assertEqual(len(answer.handles), 1)
        self.assertEqual((len(answer.grasps), len(answer.rejected)), (1, 0))
        grasp = answer.grasps[0]
        self.assertAlmostEqual(grasp.grasp.position.x, 0.75, delta=0.05)
        self.assertAlmostEqual(grasp.grasp.position.y, -0.25, delta=0.05)
        self.assertEqual(grasp.path.header.frame_id, "base")
        self.assertEqual([n[:6] for n in grasp.path.joint_names], ["right_"] * 7)
        times = [p.time_from_start.to_sec() for p in grasp.path.points]
        self.assertEqual(times[0], 0)
        self.assertEqual(times, sorted(times))
        self.assertTrue(all(len(p.positions) == 7 for p in grasp.path.points))
        self.assertTrue(0 < grasp.pregrasp_index < len(grasp.path.points))
        self.assertEqual(grasp.lift_path.points[0].positions, grasp.path.points[-1].positions)

        answer = self.call("plan", PlanGrasps, [9] * 7, 0, 0)
        self.assertFalse(answer.success)
        self.assertIn("right_s0 from", answer.message)
        # Out of reach: rejected, with the reason.
        self.publish_transform("base", "far_base", (5, 0, 0), (0, 0, 0, 1))
        rospy.set_param(f"/{self.name}/base_frame", "far_base")
        self.assertTrue(self.reload().success)
        answer = self.call("plan", PlanGrasps, [], 0, 0)
        self.assertTrue(answer.success, answer.message)
        self.assertEqual(answer.header.frame_id, "far_base")
        self.assertEqual([(r.handle, r.reason) for r in answer.rejected], [(0, "out of reach")])
        self.assertIn("out of reach", answer.rejected[0].reasons)
        self.assertIn("max_age", self.call("plan", PlanGrasps, [], 0, 1e-9).message)
        # A base that nobody knows.
        rospy.set_param(f"/{self.name}/base_frame", "basis")
        rospy.set_param(f"/{self.name}/transform_timeout", 0.1)
        self.assertTrue(self.reload().success)
        self.assertIn("to 'basis'", self.call("plan", PlanGrasps, [], 0, 0).message)
        self.assertTrue(node.lives())


class Launches(Base):
    def launch(self, file, *arguments):
        return self.start("roslaunch", ["roslaunch", "handhold_ros", file, "--wait", f"name:={self.name}", *arguments])

    def test_pcd_file(self):
        from handhold_ros.msg import HandleList

        got = self.listen(f"/{self.name}/handles", HandleList)
        launch = self.launch("pcd.launch", f"file:={DATA}/table_scene.pcd", "frame:=lens", f"cloud:=/{self.name}_cloud")
        message = wait_for(lambda: got and got[-1], "handles", explain=launch.log)
        self.assertEqual(message.header.frame_id, "lens")
        self.assertGreater(len(message.handles), 2)

    def test_sensor_with_parameters(self):
        from handhold_ros.msg import AffordanceList

        path = os.path.join(session.folder, "parameters.yaml")
        with open(path, "w") as file:
            file.write("finger_width: 0.016\ntrack: false\n")
        affordances = self.listen(f"/{self.name}/affordances", AffordanceList)
        launch = self.launch("sensor.launch", f"cloud:=/{self.name}_cloud", f"params:={path}")
        publisher = self.connected(self.publisher())
        got = self.handles()
        wait_for(lambda: self.subscribers[0].get_num_connections() > 0, "a connection", explain=launch.log)
        publisher.publish(cloud_message())
        wait_for(lambda: got and affordances, "handles", explain=launch.log)
        self.expect_cylinder(got[0])
        self.assertEqual(affordances[0].affordances[0].extent, 0.016)

    def test_recorded_bag(self):
        import rosbag
        from handhold_ros.msg import HandleList

        bag = os.path.join(session.folder, self.name + ".bag")
        topic = f"/{self.name}_cloud"
        publisher = self.publisher()
        record = self.start("record", ["rosbag", "record", "-O", bag, "--limit=3", topic])
        self.connected(publisher)
        messages = [cloud_message() for _ in range(3)]
        for message in messages:
            publisher.publish(message)

        wait_for(lambda: os.path.exists(bag), "a bag with three clouds", explain=record.log)
        publisher.unregister()
        self.subscribers.remove(publisher)
        with rosbag.Bag(bag) as file:
            stamps = [m.header.stamp for _, m, _ in file.read_messages()]
        self.assertEqual(stamps, [m.header.stamp for m in messages])

        got = self.listen(f"/{self.name}/handles", HandleList)
        try:
            launch = self.launch("bag.launch", f"bag:={bag}", f"cloud:={topic}", "play:=--loop")
            wait_for(lambda: got, "handles", explain=launch.log)
            self.assertIn(got[0].header.stamp, stamps)
            self.expect_cylinder(got[0])
        finally:
            self.started[-1].end()
            rospy.delete_param("/use_sim_time")


class Cleanup(unittest.TestCase):
    def test_nothing_is_left_when_a_test_is_killed(self):
        program = ("import sys, time; sys.path.insert(0, sys.argv[1]); from ros_session import Session\n"
                   "s = Session(sys.argv[2]); s.start('node', [s.program('handhold_node')])\n"
                   "print(s.folder, flush=True); time.sleep(3600)")
        tools = os.path.dirname(sys.modules["ros_session"].__file__)
        child = subprocess.Popen(["/usr/bin/python3", "-c", program, tools, BUILD], stdout=subprocess.PIPE, text=True)
        folder = child.stdout.readline().strip()
        probe = Session.__new__(Session)
        probe.folder = folder
        self.assertGreaterEqual(len(probe.leftovers()), 3)  # roscore, rosmaster, rosout, the node
        child.kill()
        child.wait()
        child.stdout.close()
        try:
            wait_for(lambda: not probe.leftovers(), "the end of all processes")
        finally:
            probe.processes = []
            probe.close()


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], "-v", *sys.argv[4:]], warnings="ignore")
