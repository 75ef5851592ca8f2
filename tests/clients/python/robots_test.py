"""Robots: two links of a planar arm, whose kinematics the test knows by heart."""

import pathlib
import tempfile
import unittest
from unittest import mock

import numpy as np

import cwm
from cwm import queries
from server_case import ServerCase

URDF = """<robot name="arm">
  <link name="base"/>
  <link name="upper"><collision><origin xyz="0.5 0 0"/>
    <geometry><sphere radius="0.1"/></geometry></collision></link>
  <link name="lower"><collision><origin xyz="0.5 0 0"/>
    <geometry><sphere radius="0.1"/></geometry></collision></link>
  <joint name="shoulder" type="revolute"><parent link="base"/><child link="upper"/>
    <axis xyz="0 0 1"/>
    <limit lower="-3" upper="3"/></joint>
  <joint name="elbow" type="revolute"><parent link="upper"/><child link="lower"/>
    <origin xyz="0.5 0 0"/><axis xyz="0 0 1"/>
    <limit lower="-2" upper="2"/></joint></robot>"""
SRDF = """<robot name="arm"><group name="both"><joint name="shoulder"/><joint name="elbow"/></group>
  <group name="wrist"><joint name="elbow"/></group>
  <group_state name="bent" group="both">
    <joint name="shoulder" value="0.5"/><joint name="elbow" value="1"/></group_state>
  <disable_collisions link1="upper" link2="lower" reason="Adjacent"/></robot>"""


def hands(states: np.ndarray) -> np.ndarray:
    """(N, 2): where the sphere of the lower link is."""
    first, both = states[:, 0], states.sum(axis=1)
    return 0.5 * np.column_stack([np.cos(first) + np.cos(both), np.sin(first) + np.sin(both)])


class Robots(ServerCase):
    def setUp(self) -> None:
        super().setUp()
        self.arm = self.world.load_robot(URDF, srdf=SRDF, spheres=URDF)

    def test_tell_what_they_are(self):
        self.assertEqual([link.name for link in self.arm.links], ["base", "upper", "lower"])
        self.assertEqual(self.arm.links[2].joint_kind, cwm.JointKind.REVOLUTE)
        np.testing.assert_array_equal(self.arm.limits("both"), [[-3, 3], [-2, 2]])
        np.testing.assert_array_equal(self.arm.limits("wrist"), [[-2, 2]])
        np.testing.assert_array_equal(self.arm.row("both", "bent"), [0.5, 1])
        self.assertEqual(self.world.robots(), [self.world.robot("arm")])
        nothing = SRDF.replace('<joint name="shoulder" value="0.5"/>', "").replace(
            '<joint name="elbow" value="1"/>', ""
        )
        with self.assertRaisesRegex(ValueError, "'bent' says nothing"):
            self.world.load_robot(URDF, srdf=nothing, name="idle").row("both", "bent")
        with self.assertRaises(cwm.NotFound) as caught:
            self.world.robot("leg")
        self.assertEqual(caught.exception.reason, "ROBOT_UNKNOWN")

    def test_gradients_of_distances_are_finite_differences(self):
        self.world.put("ball", cwm.Sphere(0.1), cwm.pose([0.4, 0.8, 0]))
        subject = cwm.RobotSubject("arm", "both", scope="world")
        rows = np.random.default_rng(2).uniform(-1.9, 1.9, (50, 2))

        def distances(states):
            answer = self.world.distance(
                subject, states, pairs="links", joint_gradient=True, max_distance_m=5
            )
            self.assertEqual(answer.row_begin.tolist(), list(range(0, 101, 2)))
            links = [answer.body_links[part] for part in answer.body_part[:2]]
            self.assertEqual(links, ["upper", "lower"])
            return answer

        answer = distances(rows)
        self.assertEqual(answer.variables, ("shoulder", "elbow"))
        self.assertEqual(answer.joint_gradient.shape, (100, 2))
        self.assertFalse(answer.gradient_kink.any())
        for joint in range(2):
            step = 1e-6 * np.eye(2)[joint]
            above, below = distances(rows + step), distances(rows - step)
            difference = (above.distance_m - below.distance_m) / 2e-6
            np.testing.assert_allclose(answer.joint_gradient[:, joint], difference, atol=1e-7)
        # In several batches, and for the group of one joint.
        with mock.patch.object(queries, "_LINKS_A_ROW", 1 << 17):
            again = distances(rows)
        np.testing.assert_array_equal(again.joint_gradient, answer.joint_gradient)
        wrist = self.world.distance(
            cwm.RobotSubject("arm", "wrist", base_state={"shoulder": rows[0, 0]}),
            rows[:1, 1:],
            k=1,
            only=["ball"],
            pairs="links",
            joint_gradient=True,
        )
        np.testing.assert_allclose(wrist.joint_gradient, answer.joint_gradient[:2, 1:], atol=1e-12)
        plain = self.world.distance(subject, rows)
        self.assertEqual((plain.variables, plain.joint_gradient), ((), None))
        with self.assertRaisesRegex(cwm.InvalidArgument, "want_joint_gradient"):
            self.world.distance(cwm.Sphere(1), joint_gradient=True)
        with self.assertRaisesRegex(cwm.InvalidArgument, "options.max_distance_m: is absent"):
            self.world.distance(subject, rows, pairs="links")
        with self.assertRaisesRegex(ValueError, "pairs is 'parts', must be one of objects, links"):
            self.world.distance(subject, rows, pairs="parts")

    def test_are_asked_about_named_links_and_objects_only(self):
        self.world.put("near", cwm.Sphere(0.1), cwm.pose([0.5, 0.4, 0]))
        self.world.put("far", cwm.Sphere(0.1), cwm.pose([1, 2, 0]))
        subject = cwm.RobotSubject("arm", "both")
        rows = np.zeros((1, 2))  # the spheres of the links are at x = 0.5 and x = 1

        def distance(*only):
            return self.world.distance(subject, rows, only=only).distance_m

        np.testing.assert_allclose(distance(), [0.2], atol=1e-9)
        np.testing.assert_allclose(distance("far"), [1.8], atol=1e-9)
        to_lower = [np.hypot(0.5, 0.4) - 0.2]
        np.testing.assert_allclose(distance(("arm", "lower")), to_lower, atol=1e-9)
        np.testing.assert_allclose(distance(("arm", "lower"), "far"), [1.8], atol=1e-9)
        ray = self.world.rays([-1, 0, 0], [1, 0, 0], only=[("arm", "lower")])
        np.testing.assert_allclose(ray.distance_m, [1.9], atol=1e-9)
        with self.assertRaisesRegex(cwm.InvalidArgument, r"only\[0\].link: is .hand., must be"):
            distance(("arm", "hand"))
        with self.assertRaisesRegex(TypeError, "only is 'near', must be a sequence of names"):
            self.world.check(subject, rows, only="near")

    def test_a_row_of_another_width_is_refused(self):
        subject = cwm.RobotSubject("arm", "both", scope="world")
        for rows in (np.zeros((3, 4)), np.zeros((2, 6)), np.zeros(4), np.zeros((4, 1))):
            with self.assertRaisesRegex(cwm.InvalidArgument, r"rows\.width.*must be 2"):
                self.world.check(subject, rows)
        with self.assertRaisesRegex(cwm.InvalidArgument, r"rows\.width: is 4, must be 2"):
            self.world.motions(subject, np.zeros((1, 4)), np.ones((1, 4)))

    def test_what_a_user_should_know_of_the_files_is_a_warning(self):
        with self.assertWarnsRegex(UserWarning, "no SRDF was given"):
            self.world.load_robot(URDF, name="alone")
        with self.assertWarnsRegex(UserWarning, 'is of the robot "leg", the URDF is of "arm"'):
            self.world.load_robot(URDF, srdf=SRDF.replace('"arm"', '"leg"', 1), name="other")
        with self.assertWarnsRegex(UserWarning, "has neither groups nor pairs"):
            self.world.load_robot(URDF, srdf=URDF, name="mistaken")

    def test_tell_where_links_are_and_which_states_bring_them_there(self):
        rows = np.array([[0.3, 0.9], [-1, 0.5]])
        links = self.world.link_poses(cwm.RobotSubject("arm", "both"), rows)
        self.assertEqual(links.links, ("base", "upper", "lower"))
        self.assertEqual(links.poses.shape, (2, 3, 4, 4))
        elbow = 0.5 * np.column_stack([np.cos(rows[:, 0]), np.sin(rows[:, 0])])
        np.testing.assert_allclose(links["lower"][:, :2, 3], elbow, atol=1e-12)
        np.testing.assert_allclose(links["lower"][:, 0, 0], np.cos(rows.sum(axis=1)), atol=1e-12)
        tool = cwm.pose([0.5, 0, 0])  # where the sphere of the lower link is
        wanted = links["lower"] @ tool
        np.testing.assert_allclose(wanted[:, :2, 3], hands(rows), atol=1e-12)
        solved = self.world.solve(cwm.RobotSubject("arm", "both"), wanted, tool=tool)
        self.assertTrue(solved.solved.all())
        self.assertEqual(solved.tool_link, "lower")
        self.assertEqual(solved.variables, ("shoulder", "elbow"))
        np.testing.assert_allclose(solved.best, rows, atol=1e-5)
        with self.world.stream() as stream:
            again = stream.solve(cwm.RobotSubject("arm", "both"), wanted, tool=tool)
        np.testing.assert_array_equal(again.rows, solved.rows)

    def test_tell_why_a_pose_is_not_solved(self):
        subject = cwm.RobotSubject("arm", "both", scope="world")
        far, blocked = cwm.pose([3, 0, 0]), cwm.pose([1, 0, 0])
        self.world.put("post", cwm.Box(0.1, 0.1, 0.1), blocked)
        result = self.world.solve(
            subject,
            np.stack([far, blocked]),
            tool=cwm.pose([0.5, 0, 0]),
            avoid_collision=True,
            max_steps=200,
        )
        self.assertEqual(
            list(result.status), [cwm.PoseStatus.UNREACHABLE, cwm.PoseStatus.IN_COLLISION]
        )
        self.assertAlmostEqual(result.position_error_m[0], 2, places=3)
        self.assertTrue(np.isnan(result.best).all())
        self.assertEqual(result.solutions(1).shape, (0, 2))
        free = self.world.what_if(cwm.Remove("post")).solve(
            subject, blocked, tool=cwm.pose([0.5, 0, 0]), avoid_collision=True
        )
        np.testing.assert_allclose(free.best, [[0, 0]], atol=1e-5)
        with self.assertRaisesRegex(cwm.InvalidArgument, 'tool_link: is "hand", must be a link'):
            self.world.solve(subject, far, tool_link="hand")
        with self.assertRaisesRegex(cwm.InvalidArgument, "no joint of group .* moves link"):
            self.world.solve(subject, far, tool_link="base")
        with self.assertRaisesRegex(ValueError, "seeds has 3 rows, must have 1"):
            self.world.solve(subject, far, seeds=np.zeros((3, 2)))
        with self.assertRaisesRegex(cwm.InvalidArgument, 'links.0.: is "hand"'):
            self.world.link_poses("arm", links=["hand"])

    def test_have_paddings_scales_and_tools(self):
        tip = cwm.Tool("tip", "lower", cwm.pose([0.7, 0, 0]), group="both")
        arm = self.world.load_robot(
            URDF, srdf=SRDF, padding={"lower": 0.05}, scale={"*": 0.5}, tools=[tip]
        )
        self.assertEqual([link.padding_m for link in arm.links], [0, 0, 0.05])
        self.assertEqual([link.scale for link in arm.links], [0.5, 0.5, 0.5])
        self.assertEqual([(tool.name, tool.link, tool.group) for tool in arm.tools],
                         [("tip", "lower", "both")])
        np.testing.assert_array_equal(arm.tools[0].pose[:3, 3], [0.7, 0, 0])
        # The sphere of the lower link has a radius of 0.05 m and is at x = 1 m.
        self.world.put("post", cwm.Box(0.1, 0.1, 0.1), cwm.pose([1.14, 0, 0]))
        both = cwm.RobotSubject("arm", "both")
        bare = cwm.RobotSubject("arm", "both", padding={"*": 0.03})
        self.assertEqual(list(self.world.check(both, np.zeros((1, 2))).collision), [True])
        self.assertEqual(list(self.world.check(bare, np.zeros((1, 2))).free), [True])
        with self.assertRaisesRegex(cwm.InvalidArgument, "link_padding"):
            self.world.check(cwm.RobotSubject("arm", padding={"hand": 0.1}))
        with self.assertRaisesRegex(ValueError, "padding"):
            self.world.load_robot(URDF, padding={"lower": -1})
        # The arm is straight: its elbow is at x = 0.5, its tool 0.7 m beyond.
        at = cwm.pose([1.2, 0, 0])
        for solved in (
            self.world.solve(both, at, seeds=[0.1, 0.1]),
            self.world.solve(both, at, tool="tip", seeds=[0.1, 0.1]),
        ):
            self.assertEqual(list(solved.solved), [True])
            self.assertEqual(solved.tool_link, "lower")
            np.testing.assert_allclose(solved.best[0], [0, 0], atol=1e-5)
        with self.assertRaisesRegex(cwm.InvalidArgument, '"tip"'):
            self.world.solve(both, at, tool="hook")

    def test_have_pairs_checked_that_the_srdf_disables(self):
        both = cwm.RobotSubject("arm", "both", scope="self")
        bent = [[0, 2]]  # the spheres are 2 * 0.5 * sin(1) apart: the pair may collide anyhow
        larger = self.world.load_robot(URDF, srdf=SRDF, scale={"*": 5})
        self.assertEqual(larger.links[1].scale, 5)
        self.assertEqual(list(self.world.check(both, bent).free), [True])
        self.world.allow(("arm", "upper"), ("arm", "lower"), check=True)
        self.assertEqual([(rule.allowed, rule.check) for rule in self.world.rules()],
                         [(False, True)])
        self.assertEqual(list(self.world.check(both, bent).collision), [True])
        self.world.allow(("arm", "upper"), ("arm", "lower"), withdraw=True)
        self.assertEqual(self.world.rules(), ())

    def test_are_in_contact_with_the_world(self):
        self.world.put("post", cwm.Sphere(0.1), cwm.pose([1.15, 0, 0]))
        self.world.put("next", cwm.Sphere(0.1), cwm.pose([1.33, 0, 0]))
        found = self.world.all_contacts()
        self.assertTrue(found.complete)
        self.assertEqual(list(zip(found.a, found.b)), [("arm", "post"), ("next", "post")])
        self.assertEqual(list(found.link_a), ["lower", None])
        np.testing.assert_allclose(found.distance_m, [-0.05, -0.02], atol=1e-9)
        np.testing.assert_allclose(found.normal[0], [1, 0, 0], atol=1e-9)
        self.assertEqual(len(self.world.all_contacts(max_contacts=1)), 1)
        self.assertFalse(self.world.all_contacts(max_contacts=1).complete)
        self.assertEqual(len(self.world.what_if(cwm.Remove("post")).all_contacts()), 0)
        with self.world.at().stream() as stream:
            self.assertEqual(list(stream.all_contacts().b), ["post", "post"])

    def test_are_asked_about_many_states(self):
        self.world.put("ball", cwm.Sphere(0.2), cwm.pose([0.6, 0.5, 0]))
        states = np.random.default_rng(8).uniform([-3, -2], [3, 2], (70_000, 2))
        subject = cwm.RobotSubject("arm", "both", scope="world")
        upper = 0.5 * np.column_stack([np.cos(states[:, 0]), np.sin(states[:, 0])])
        gap_m = (
            np.minimum(
                *(np.linalg.norm(place - [0.6, 0.5], axis=1) for place in (hands(states), upper))
            )
            - 0.3
        )
        answer = self.world.check(subject, states)
        decided = np.abs(gap_m) > 1e-9
        np.testing.assert_array_equal(answer.collision[decided], gap_m[decided] < 0)
        self.assertEqual(set(answer.objects[answer.collision]), {"ball"})
        self.assertEqual(answer.body_links, ("upper", "lower"))
        np.testing.assert_allclose(
            self.world.distance(subject, states).distance_m, gap_m, atol=1e-9
        )
        single = self.world.check(subject, states.astype(np.float32), verdicts_only=True)
        self.assertGreater(np.mean(single.verdict == answer.verdict), 0.999)
        given = self.world.check(
            cwm.RobotSubject("arm", "both", "world", "spheres_as_given"), states
        )
        np.testing.assert_array_equal(given.verdict[decided], answer.verdict[decided])

    def test_are_asked_where_they_stand(self):
        self.world.put("ball", cwm.Sphere(0.2), cwm.pose([1, 0, 0]))
        self.assertEqual(self.world.check(cwm.RobotSubject("arm")).objects.tolist(), ["ball"])
        self.world.set_robot_state("arm", named_state=("both", "bent"))
        self.assertEqual(self.world.robot("arm").state, {"shoulder": 0.5, "elbow": 1.0})
        self.assertTrue(self.world.check(cwm.RobotSubject("arm")).free[0])
        self.world.set_robot_state("arm", {"elbow": 0.25}, pose=cwm.pose([0, 0, 1]))
        robot = self.world.robot("arm")
        self.assertEqual(
            (robot.state["shoulder"], robot.state["elbow"], robot.pose[2, 3]), (0.5, 0.25, 1)
        )
        at_origin = cwm.RobotSubject("arm", "wrist", pose=np.eye(4), base_state={"shoulder": 0})
        self.assertEqual(
            self.world.check(at_origin, [[0.0], [2.0]]).collision.tolist(), [True, False]
        )

    def test_say_what_is_out_of_limits_and_certify_motions(self):
        both = cwm.RobotSubject("arm", "both")
        checked = self.world.check(both, [[0, 2.5], [0, 0], [4, 2.5]])
        self.assertEqual(checked.verdict[0], cwm.Verdict.OUT_OF_LIMITS)
        self.assertEqual(checked.out_of_limits.tolist(), ["elbow", None, "shoulder"])
        self.assertEqual(self.world.check(both, [[0, 0]]).out_of_limits.tolist(), [None])
        moved = self.world.motions(both, [[0, 0], [0, 0]], [[0, 2.5], [0, 1]])
        self.assertEqual(moved.out_of_limits.tolist(), ["elbow", None])
        self.world.put("ball", cwm.Sphere(0.2), cwm.pose([1, 0, 0]))
        answer = self.world.motions(both, [[-1, 0], [1, 0]], [[1, 0], [2, 0]])
        self.assertEqual(
            answer.verdict.tolist(), [cwm.MotionVerdict.CONTACT, cwm.MotionVerdict.FREE]
        )

    def test_carry_what_is_attached(self):
        self.world.put("cup", cwm.Sphere(0.05), cwm.pose([1.2, 0, 0]))
        self.world.attach("cup", "arm", "lower", touch_links=["upper"])
        cup = self.world.get("cup")
        self.assertEqual(
            (cup.attachment.robot, cup.attachment.link, cup.attachment.touch_links),
            ("arm", "lower", ("upper",)),
        )
        self.world.set_robot_state("arm", {"shoulder": np.pi / 2})
        np.testing.assert_allclose(self.world.get("cup").position, [0, 1.2, 0], atol=1e-9)
        self.world.put("wall", cwm.Box(0.1, 1, 1), cwm.pose([1.28, 0, 0]))
        hit = self.world.check(cwm.RobotSubject("arm", "both"), [[0, 0]])
        self.assertEqual((hit.objects[0], hit.body_objects[hit.body_part[0]]), ("wall", "cup"))
        self.world.detach("cup")
        self.assertIsNone(self.world.get("cup").attachment)

    def test_are_loaded_from_files_with_meshes(self):
        with tempfile.TemporaryDirectory() as folder:
            package = pathlib.Path(folder) / "my_robot"
            (package / "urdf").mkdir(parents=True)
            urdf = package / "urdf" / "box.urdf"
            urdf.write_text(
                """<robot name="box"><link name="base"><collision><geometry>
                <mesh filename="package://my_robot/meshes/box.obj"/>
                </geometry></collision></link></robot>"""
            )
            with self.assertRaisesRegex(
                FileNotFoundError,
                "mesh package://my_robot/meshes/box.obj of the URDF was not found",
            ):
                self.world.load_robot(urdf)
            far = urdf.read_text().replace("package://my_robot", "http://my.org")
            with self.assertRaisesRegex(FileNotFoundError, "must be at package://, at file://"):
                self.world.load_robot(far)
            (package / "meshes").mkdir()
            (package / "meshes" / "box.obj").write_text(
                "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n"
            )
            for dirs in ((), (folder,), (package,)):
                self.assertEqual(
                    self.world.load_robot(urdf, package_dirs=dirs).links[0].triangle_count, 4
                )
            checkout = package.rename(pathlib.Path(folder) / "checkout")
            urdf = checkout / "urdf" / "box.urdf"
            with self.assertRaisesRegex(FileNotFoundError, "was not found"):
                self.world.load_robot(urdf)
            (checkout / "package.xml").write_text("<package><name>my_robot</name></package>")
            slashes = urdf.read_text().replace("package://", "package:///")
            for robot, dirs in (
                (urdf, ()),
                (urdf, (checkout,)),
                (urdf.read_text(), (folder,)),  # below, by the name in its package.xml
                (slashes, (folder,)),
            ):
                self.assertEqual(
                    self.world.load_robot(robot, package_dirs=dirs).links[0].triangle_count, 4
                )
        self.world.delete_robot("box")
        self.assertEqual([robot.name for robot in self.world.robots()], ["arm"])

    def test_that_cannot_be_are_refused(self):
        both = cwm.RobotSubject("arm", "both")
        cases = [
            (
                lambda: self.world.check(both, np.empty((0, 2))),
                ValueError,
                r"rows has the shape \(0, 2\)",
            ),
            (
                lambda: self.world.check(both, [[0, np.nan]]),
                ValueError,
                r"rows\[0, 1\] is nan, must be finite",
            ),
            (
                lambda: self.world.check(both, np.zeros((2, 2, 2))),
                ValueError,
                r"rows has the shape \(2, 2, 2\)",
            ),
            (
                lambda: self.world.check(cwm.RobotSubject("arm", scope="all"), [[0, 0]]),
                ValueError,
                "scope is 'all'",
            ),
            (
                lambda: self.world.set_robot_state("arm", [1, 2]),
                TypeError,
                r"joints is \[1, 2\], must be a mapping",
            ),
            (
                lambda: self.world.set_robot_state("arm", named_state="bent"),
                TypeError,
                "must be .group, state.",
            ),
            (lambda: self.world.load_robot(3), TypeError, "urdf is 3, must be a path or the text"),
            (lambda: self.world.load_robot("/no/such.urdf"), FileNotFoundError, "/no/such.urdf"),
        ]
        for query, kind, message in cases:
            with self.subTest(message), self.assertRaisesRegex(kind, message):
                query()
        for query in (
            lambda: self.world.check(both, [[0, 0, 0]]),
            lambda: self.world.load_robot("<robot>"),
            lambda: self.world.check(cwm.RobotSubject("arm", "leg"), [[0]]),
        ):
            with self.assertRaises((cwm.InvalidArgument, cwm.NotFound)) as caught:
                query()
            self.assertTrue(caught.exception.reason)


if __name__ == "__main__":
    unittest.main()
