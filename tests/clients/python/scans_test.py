"""Scans whose truth is known, and beside what the command line makes of the same cloud."""

import pathlib
import subprocess
import sys
import unittest

import numpy as np

import cwm
from server_case import BINARIES, ServerCase

EXAMPLES = pathlib.Path(__file__).parents[3] / "clients/python/examples"
sys.path.insert(0, str(EXAMPLES))
import table_scan  # noqa: E402


def write_pcd(path: pathlib.Path, points: np.ndarray) -> None:
    height, width = points.shape[:2]
    header = (
        "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\n"
        f"WIDTH {width}\nHEIGHT {height}\n"
        f"VIEWPOINT 0 0 0 1 0 0 0\nPOINTS {width * height}\nDATA binary\n"
    )
    path.write_bytes(header.encode() + points.astype("<f4").tobytes())


class Scans(ServerCase):
    @classmethod
    def setUpClass(cls) -> None:
        super().setUpClass()
        cls.points, cls.pose = table_scan.table_scan(), table_scan.camera_pose()

    def test_find_what_is_there(self):
        scan = self.world.ingest(self.points, self.pose)
        self.assertEqual(
            (len(scan.supports), len(scan.objects), scan.revision), (1, 2, self.world.revision)
        )
        self.assertEqual(scan.report.points_in, self.points.size // 3)
        self.assertEqual(scan.report.points_finite, np.isfinite(self.points).all(axis=-1).sum())
        self.assertEqual(set(scan.changes.added), {"support_1", "object_1", "object_2"})
        self.assertGreater(sum(scan.stages.values()), 0)
        np.testing.assert_allclose(scan.pose, self.pose, atol=1e-9)
        ball = next(obj for obj in scan.objects if isinstance(obj.parts[0].shape, cwm.Sphere))
        center = (ball.pose @ ball.parts[0].pose)[:3, 3]
        # The noise of a millimetre averages out to less than a tenth of it over a thousand points;
        # the rest is due to the grid.
        np.testing.assert_allclose(center, table_scan.BALL_CENTER, atol=2e-3)
        self.assertAlmostEqual(ball.parts[0].shape.radius_m, table_scan.BALL_RADIUS_M, delta=2e-3)
        self.assertLess(ball.parts[0].fit.rms_m, 3e-3)
        self.assertGreater(ball.parts[0].fit.inlier_count, 500)
        held = self.world.get(ball.name)
        self.assertEqual((held.kind, held.owner), (cwm.ObjectKind.OBJECT, cwm.Owner.PERCEPTION))
        vertices, _ = ball.mesh()
        world_vertices = vertices @ ball.pose[:3, :3].T + ball.position
        off_m = np.abs(
            np.linalg.norm(world_vertices - table_scan.BALL_CENTER, axis=1)
            - table_scan.BALL_RADIUS_M
        )
        self.assertLess(off_m.max(), 4e-3)

    def test_label_each_point(self):
        scan = self.world.ingest(self.points, self.pose)
        flat = self.points.reshape(-1, 3)
        self.assertEqual((scan.labels.shape, scan.labels.dtype), ((len(flat),), np.uint32))
        self.assertFalse(scan.labels[~np.isfinite(flat).all(axis=1)].any())
        in_world = flat @ self.pose[:3, :3].T + self.pose[:3, 3]
        ball = next(obj for obj in scan.objects if isinstance(obj.parts[0].shape, cwm.Sphere))
        on_ball = (
            np.linalg.norm(in_world - table_scan.BALL_CENTER, axis=1)
            < table_scan.BALL_RADIUS_M + 0.01
        )
        upper = on_ball & (in_world[:, 2] > 0.03)
        self.assertGreater(np.mean(scan.mask(ball)[upper]), 0.95)
        self.assertGreater(np.mean(on_ball[scan.mask(ball.name)]), 0.95)
        self.assertGreater(scan.mask("support_1").sum(), 10_000)
        with self.assertRaises(KeyError):
            scan.mask("nobody")

    def test_of_an_unchanged_view_are_answered_by_the_known_objects(self):
        first = self.world.ingest(self.points, self.pose)
        again = self.world.ingest(self.points, self.pose)
        self.assertEqual(
            (first.report.unchanged_view, again.report.unchanged_view), (False, True)
        )
        self.assertEqual(again.revision, first.revision)
        self.assertEqual([obj.name for obj in again.objects], [obj.name for obj in first.objects])
        self.assertEqual(set(again.changes.kept), set(first.changes.added))
        np.testing.assert_array_equal(again.labels, first.labels)
        self.assertNotIn("shapes", again.stages)
        forced = self.world.ingest(self.points, self.pose, force=True)
        self.assertFalse(forced.report.unchanged_view)

    def test_are_what_the_command_line_makes_of_them(self):
        scan = self.world.ingest(self.points, self.pose)
        path = self.running.folder / "table.pcd"
        write_pcd(path, self.points)
        labelled = self.running.folder / "labels.pcd"
        row = ",".join(repr(float(v)) for v in cwm.poses.to_rows(self.pose, "pose")[0])
        run = subprocess.run(
            [
                BINARIES / "cwm",
                "--addr",
                self.running.address,
                "--world",
                "by_hand",
                "-o",
                "json",
                "ingest",
                path,
                "--x-world-sensor",
                row,
                "--labels",
                labelled,
            ],
            capture_output=True,
            text=True,
            check=False,
        )
        self.assertEqual(run.returncode, 0, run.stderr)
        other = self.world.server.world("by_hand").objects()
        self.assertEqual(
            [obj.name for obj in other], [obj.name for obj in self.world.objects()]
        )
        for mine, theirs in zip(self.world.objects(), other):
            self.assertEqual(
                [part.shape for part in mine.parts], [part.shape for part in theirs.parts]
            )
        self.assertIsNotNone(scan.labels)

    def test_take_what_numpy_has(self):
        expected = [
            [part.shape for part in obj.parts]
            for obj in self.world.ingest(self.points, self.pose).objects
        ]
        flat = self.points.reshape(-1, 3)
        seen = np.isfinite(flat).all(axis=1)
        for given in (flat.astype(np.float64), np.asfortranarray(self.points), flat[seen].tolist()):
            world = self.world.server.world("as_given")
            found = world.ingest(given, self.pose, labels=False)
            self.assertIsNone(found.labels)
            kinds = {type(obj.parts[0].shape) for obj in found.objects if obj.parts}
            self.assertLessEqual({cwm.Sphere, cwm.Box}, kinds)
            if np.ndim(given) == 3:  # the same picture: the same answer
                self.assertEqual(
                    [[part.shape for part in obj.parts] for obj in found.objects], expected
                )
            self.world.server.delete_world("as_given")

    def test_of_half_a_million_points_have_labels_by_hash(self):
        scan = self.world.ingest(table_scan.table_scan(800, 600), self.pose)  # 1.9 MB of labels
        self.assertEqual(scan.labels.shape, (480_000,))
        self.assertGreater(scan.mask("support_1").sum(), 100_000)

    def test_need_no_pose_and_no_world(self):
        provisional = self.world.ingest(self.points, mode="segment_only", up=[0, -0.7, -0.7])
        self.assertEqual(provisional.world_uid, "")
        with self.assertRaises(cwm.NotFound):
            self.world.objects()
        with self.assertRaisesRegex(ValueError, "provisional"):
            provisional.objects[0].mesh()
        self.assertEqual(len(provisional.objects), 2)

    def test_in_the_worlds_frame_give_the_same_objects_and_no_pose(self):
        expected = self.world.ingest(self.points, self.pose)
        rotation, place = self.pose[:3, :3], self.pose[:3, 3]
        in_world = self.points.reshape(-1, 3) @ rotation.T + place
        for scale, points in ((1.0, in_world), (0.001, 1000 * in_world)):
            scan = self.world.ingest(
                points, frame="world", viewpoint=place, scale=scale, mode="segment_only"
            )
            np.testing.assert_allclose(scan.pose, np.eye(4), atol=1e-12)
            self.assertEqual(len(scan.objects), len(expected.objects))
            for found, known in zip(scan.objects, expected.objects):
                np.testing.assert_allclose(
                    found.pose[:3, 3], known.pose[:3, 3], atol=0.01
                )
        with self.assertRaisesRegex(cwm.InvalidArgument, "x_world_sensor: is set, must be absent"):
            self.world.ingest(in_world, self.pose, frame="world")

    def test_that_contradict_the_world_are_refused_unless_forced(self):
        before = self.world.ingest(self.points, self.pose).revision
        for wrong in (1000 * self.points, 3 * self.points):
            with self.assertRaises(cwm.ScanRefused) as refused:
                self.world.ingest(wrong, self.pose)
            self.assertIn(refused.exception.metadata["contradiction"], ("SCALE", "SUPPORTS_GONE"))
        self.assertEqual(self.world.ingest(self.points, self.pose).revision, before)
        forced = self.world.ingest(3 * self.points, self.pose, force=True)
        self.assertIn("support_1", forced.changes.removed)

    def test_that_cannot_be_are_refused(self):
        cases = [
            (dict(points=np.ones((5, 2))), ValueError, r"points has the shape \(5, 2\)"),
            (dict(points=[["x", "y", "z"]]), TypeError, "points has the type <U1"),
            (dict(sensor="eye"), ValueError, "sensor is 'eye', must be one of kinect"),
            (
                dict(sensor=-0.1),
                ValueError,
                "sensor is -0.1, must be the name of a model or a standard deviation",
            ),
            (dict(sensor=(0.001, -1)), ValueError, "a and b must be at least 0"),
            (dict(frame="here"), ValueError, "frame is 'here', must be one of sensor, world"),
            (dict(scale=-1), ValueError, "scale is -1, must be finite and at least 0"),
            (
                dict(mode="often"),
                ValueError,
                "mode is 'often', must be one of update, add, segment_only",
            ),
            (dict(up=[0, 0]), ValueError, r"up has the shape \(2,\), must be \(3,\)"),
            (dict(x_world_sensor=np.ones((4, 4))), ValueError, r"x_world_sensor\[0\] is no pose"),
            (dict(search=["cubes"]), ValueError, "search has 'cubes', must be of planes"),
        ]
        for arguments, kind, message in cases:
            with self.subTest(message), self.assertRaisesRegex(kind, message):
                self.world.ingest(**{"points": self.points, **arguments})
        with self.assertRaises(cwm.InvalidArgument):
            self.world.ingest(self.points, up=[0, 0, 0])
        self.world.put("ball", cwm.Sphere(0.1))
        with self.assertRaises(cwm.RevisionConflict):
            self.world.ingest(self.points, self.pose, expected_revision=7)


if __name__ == "__main__":
    unittest.main()
