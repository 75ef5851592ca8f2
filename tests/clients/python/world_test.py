"""Objects, changes and errors against a real server, and beside what the command line says of
it.
"""

import pathlib
import tempfile
import time
import unittest

import numpy as np

import cwm
from server_case import ServerCase

TETRAHEDRON = cwm.Mesh(
    [[0, 0, 0], [0.1, 0, 0], [0, 0.1, 0], [0, 0, 0.1]], [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]]
)
CONVEX = cwm.Convex(TETRAHEDRON.vertices, TETRAHEDRON.triangles)
PLATE = cwm.Plate([[0, 0], [1, 0], [1, 1], [0, 1]], 0.02, [[[0.4, 0.4], [0.6, 0.4], [0.6, 0.6]]])
ALL_SHAPES = [
    cwm.Sphere(0.1),
    cwm.Box(0.1, 0.2, 0.3),
    cwm.Cylinder(0.1, 0.2),
    cwm.Cone(0.1, 0.05, 0.2),
    cwm.Capsule(0.1, 0.2),
    cwm.HalfSpace(),
    PLATE,
    CONVEX,
    TETRAHEDRON,
]


class Objects(ServerCase):
    def test_of_every_shape_come_back_as_they_were_put(self):
        pose = cwm.pose([1, 2, 3], [0, 0, 0.6, 0.8])
        for shape in ALL_SHAPES:
            with self.subTest(type(shape).__name__):
                revision = self.world.put("thing", shape, pose)
                obj = self.world.get("thing")
                self.assertEqual((obj.parts[0].shape, obj.world_revision), (shape, revision))
                self.assertIs(type(obj.parts[0].shape), type(shape))
                np.testing.assert_allclose(obj.pose, pose, atol=1e-12)
                self.assertEqual((obj.kind, obj.owner), (cwm.ObjectKind.USER, cwm.Owner.USER))

    def test_of_several_parts_have_poses_and_named_coefficients(self):
        knob = cwm.Placed(cwm.Sphere(0.02), cwm.pose([0, 0, 0.1]))
        self.world.put("lid", [cwm.Cylinder(0.1, 0.01), knob], cwm.pose([0, 0, 1]), margin_m=0.01)
        lid = self.world.get("lid")
        self.assertEqual(lid.margin_m, 0.01)
        self.assertEqual(
            [part.shape for part in lid.parts], [cwm.Cylinder(0.1, 0.01), cwm.Sphere(0.02)]
        )
        self.assertEqual(
            lid.parts[1].coefficients,
            {"center_x": 0, "center_y": 0, "center_z": 0.1, "radius": 0.02},
        )
        np.testing.assert_allclose(lid.parts[1].pose[:3, 3], [0, 0, 0.1])
        self.assertEqual(lid.position.tolist(), [0, 0, 1])

    def test_have_meshes_in_their_own_frame(self):
        self.world.put("tetrahedron", TETRAHEDRON, cwm.pose([5, 0, 0]))
        vertices, triangles = self.world.get("tetrahedron").mesh()
        np.testing.assert_allclose(np.sort(vertices, axis=0), np.sort(TETRAHEDRON.vertices, axis=0))
        self.assertEqual(triangles.shape, (4, 3))
        np.testing.assert_array_equal(self.world.mesh(TETRAHEDRON.hash)[1], TETRAHEDRON.triangles)
        self.world.put("floor", cwm.HalfSpace())
        with self.assertRaises(cwm.FailedPrecondition) as caught:
            self.world.get("floor").mesh()
        self.assertEqual(caught.exception.reason, "SURFACE_UNBOUNDED")

    def test_are_listed_by_kind_prefix_place_and_revision_as_the_command_line_does(self):
        self.world.apply(
            [cwm.Put(f"cup_{i:04d}", cwm.Sphere(0.01), cwm.pose([i, 0, 0])) for i in range(2500)]
        )
        then = self.world.put("bowl", cwm.Sphere(0.1))
        self.world.remove("bowl")
        everything = self.world.objects()
        listed = self.cli("objects")["objects"]
        self.assertEqual([obj.name for obj in everything], [obj["name"] for obj in listed])
        self.assertEqual([obj.uid for obj in everything], [obj["uid"] for obj in listed])
        self.assertEqual(len(everything), 2500)  # of three pages
        self.assertEqual(len(self.world.objects("user", "cup_10")), 100)
        self.assertEqual(self.world.objects(["support", cwm.ObjectKind.OBJECT]), [])
        near = self.world.objects(within=([2.5, -1, -1], [4.5, 1, 1]), view="basic")
        self.assertEqual(
            [(obj.name, obj.parts) for obj in near], [("cup_0003", ()), ("cup_0004", ())]
        )
        self.assertEqual(
            [obj.name for obj in self.world.objects(prefix="b", at=then)], ["bowl"]
        )

    def test_of_a_pinned_view_stay_as_they_were(self):
        self.world.put("ball", cwm.Sphere(0.1))
        then = self.world.at()
        self.world.move("ball", cwm.pose([9, 0, 0]))
        self.assertEqual((then.revision, self.world.revision), (1, 2))
        self.assertEqual(then.get("ball").position[0], 0)
        self.assertAlmostEqual(then.distance([0.0, 0, 0]).distance_m[0], -0.1, 6)
        self.assertEqual(self.world.at(1).uid, self.world.uid)
        self.assertFalse(hasattr(then, "put"))


class Changes(ServerCase):
    def test_are_made_all_or_none(self):
        self.world.put("ball", cwm.Sphere(0.1))
        with self.assertRaises(cwm.NotFound) as caught:
            self.world.apply([cwm.Move("ball", cwm.pose([1, 0, 0])), cwm.Remove("nothing")])
        self.assertEqual(caught.exception.reason, "OBJECT_UNKNOWN")
        self.assertEqual(self.world.get("ball").position[0], 0)
        revision = self.world.apply(
            [cwm.Move("ball", cwm.pose([1, 0, 0])), cwm.Put("cube", cwm.Box(1, 1, 1))]
        )
        self.assertEqual([revision, self.world.revision], [2, 2])
        self.assertEqual(self.world.remove("cube"), 3)

    def test_expect_revisions(self):
        self.world.put("ball", cwm.Sphere(0.1))
        ball = self.world.get("ball")
        self.world.move("ball", cwm.pose([1, 0, 0]), expected_revision=ball.revision)
        with self.assertRaises(cwm.RevisionConflict) as caught:
            self.world.remove("ball", expected_revision=ball.revision)
        self.assertEqual(caught.exception.reason, "OBJECT_REVISION_MISMATCH")
        self.assertEqual(caught.exception.metadata["actual_revision"], "2")
        with self.assertRaises(cwm.RevisionConflict) as caught:
            self.world.apply([cwm.Remove("ball")], expected_revision=1)
        self.assertEqual(caught.exception.reason, "REVISION_MISMATCH")

    def test_of_rules_hold_and_end(self):
        self.world.put("ball", cwm.Sphere(0.1))
        self.world.put("cube", cwm.Box(1, 1, 1), cwm.pose([0.55, 0, 0]))
        self.assertTrue(self.world.check("ball").collision[0])
        self.world.allow("cube", "ball", expires_after_s=60)
        self.assertTrue(self.world.check("ball").free[0])
        rule = self.world.rules()[0]
        self.assertEqual(({rule.a, rule.b}, rule.allowed), ({"ball", "cube"}, True))
        self.assertIsNotNone(rule.expires)
        self.world.allow("cube", "ball", withdraw=True)
        self.world.margin("cube", "*", 0.5)
        self.assertEqual([rule.margin_m for rule in self.world.rules()], [0.5])
        self.world.margin("cube", "*", None)
        self.assertEqual(self.world.rules(), ())

    def test_that_cannot_be_meant_are_refused_here_or_there(self):
        with self.assertRaisesRegex(TypeError, r"changes\[0\] is 'ball', must be one of"):
            self.world.apply(["ball"])
        with self.assertRaisesRegex(TypeError, "shape has 'round', must be one of Sphere, Box"):
            self.world.put("ball", "round")
        with self.assertRaisesRegex(ValueError, "shape is empty"):
            self.world.put("ball", [])
        with self.assertRaisesRegex(TypeError, "name is 3, must be a string"):
            self.world.remove(3)
        with self.assertRaises(cwm.InvalidArgument) as caught:
            self.world.put("no spaces", cwm.Sphere(0.1))
        self.assertEqual(caught.exception.reason, "INVALID_FIELD")
        self.assertEqual(caught.exception.fields[0].field, "changes[0].put.object.name")
        self.assertIn("must be 1 to 128 letters", caught.exception.fields[0].description)


class Worlds(ServerCase):
    def test_are_listed_and_deleted(self):
        server = self.world.server
        self.world.put("ball", cwm.Sphere(0.1))
        info = next(world for world in server.worlds() if world.name == self.world.name)
        self.assertEqual((info.uid, info.revision, info.object_count), (self.world.uid, 1, 1))
        server.delete_world(self.world.name)
        with self.assertRaises(cwm.NotFound) as caught:
            self.world.objects()
        self.assertEqual(
            (caught.exception.reason, caught.exception.metadata),
            ("WORLD_UNKNOWN", {"world": self.world.name}),
        )

    def test_that_are_replaced_are_told_apart(self):
        self.world.put("ball", cwm.Sphere(0.1))
        then = self.world.at()
        self.world.server.delete_world(self.world.name)
        self.world.put("ball", cwm.Sphere(0.2))
        with self.assertRaises(cwm.WorldReplaced):
            then.get("ball")

    def test_go_to_other_tools(self):
        self.world.put("ball", cwm.Sphere(0.1))
        self.assertIn(b"* ball\n", self.world.export().data)
        self.assertIn(b"ball", self.world.export("moveit_yaml").data)
        self.assertEqual(self.world.export("glb").data[:4], b"glTF")
        with self.assertRaisesRegex(
            ValueError, "format is 'blender', must be one of moveit_scene, moveit_yaml, glb"
        ):
            self.world.export("blender")

    def test_go_to_simulators_with_their_meshes_beside(self):
        self.world.put("cup", cwm.Cone(0.03, 0.04, 0.1))
        exported = self.world.export("urdf")
        self.assertEqual(list(exported.files), [f"{self.world.name}_meshes/0_cup.stl"])
        self.assertTrue(any("truncated cone" in warning for warning in exported.warnings))
        with tempfile.TemporaryDirectory() as folder:
            exported.save(f"{folder}/kitchen.urdf")
            for name, data in exported.files.items():
                self.assertIn(name.encode(), exported.data)
                self.assertEqual(pathlib.Path(folder, name).read_bytes(), data)
            self.assertEqual(pathlib.Path(folder, "kitchen.urdf").read_bytes(), exported.data)

    def test_keep_revisions_for_a_while(self):
        for i in range(400):
            if i == 300:
                time.sleep(1.1)  # those of the last second are all kept
            self.world.put("ball", cwm.Sphere(0.1 + 0.001 * i))
        compacted = []
        for revision in range(1, 100):
            try:
                self.world.at(revision).get("ball")
            except cwm.RevisionCompacted as error:
                compacted.append(error)
        self.assertGreater(len(compacted), 0)
        nearest = int(compacted[0].metadata["nearest_revision"])
        self.assertEqual(self.world.at(nearest).get("ball").world_revision, nearest)
        with self.assertRaises(cwm.OutOfRange) as caught:
            self.world.at(1000).get("ball")
        self.assertEqual(caught.exception.reason, "REVISION_IN_FUTURE")


class Connections(ServerCase):
    def test_tell_about_the_server(self):
        info = self.world.server.info()
        self.assertIn("EXACT", info.engines)
        self.assertEqual(info.limits["max_batch_rows"], 65536)
        self.assertGreater(info.retention["watch_seconds"], 0)
        self.assertEqual(info.store, "memory")
        self.assertIsNone(info.store_info)

    def test_to_nobody_say_where_they_looked(self):
        with self.assertRaisesRegex(
            cwm.Unavailable, "no cwm-server answers at unix:/tmp/nobody.sock"
        ):
            cwm.connect("unix:/tmp/nobody.sock", timeout_s=5)

    def test_end_calls_by_their_timeout(self):
        self.world.put("ball", cwm.Sphere(0.1))
        with self.assertRaises(cwm.DeadlineExceeded):
            self.world.within(1e-4).sample(np.ones((60_000, 3)))
        self.assertTrue(self.world.within(60).objects())
        for bad in (0, -1, float("nan"), float("inf")):
            with self.assertRaisesRegex(ValueError, "timeout_s is"):
                self.world.within(bad)

    def test_that_are_closed_say_so(self):
        self.world.close()
        with self.assertRaisesRegex(ValueError, "is closed"):
            self.world.objects()

    def test_find_the_server_again_and_send_what_it_lost(self):
        self.world.put("tetrahedron", TETRAHEDRON)
        self.running.restart()
        self.assertEqual(self.world.put("tetrahedron", TETRAHEDRON), 1)
        self.assertEqual(self.world.get("tetrahedron").parts[0].shape, TETRAHEDRON)

    def test_have_types_and_messages(self):
        from cwm.v1 import query_pb2, world_pb2

        for words, message in (
            (cwm.Verdict, query_pb2.Verdict),
            (cwm.MotionVerdict, query_pb2.MotionVerdict),
            (cwm.Engine, query_pb2.Engine),
            (cwm.DistancePairs, query_pb2.DistancePairs),
            (cwm.ObjectKind, world_pb2.ObjectKind),
            (cwm.UnseenSpace, query_pb2.UnseenSpace),
            (cwm.SampleState, query_pb2.SampleState),
        ):
            prefix = message.DESCRIPTOR.values_by_number[0].name.removesuffix("UNSPECIFIED")
            told = {
                value.name.removeprefix(prefix): value.number
                for value in message.DESCRIPTOR.values
                if value.number
            }
            self.assertEqual({word.name: word.value for word in words}, told)


if __name__ == "__main__":
    unittest.main()
