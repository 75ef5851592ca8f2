"""What is refused or converted before anything is sent; needs no server."""

import os
import tempfile
import unittest
from unittest import mock

import numpy as np

import cwm
from cwm import addresses, arrays, ingest, poses, shapes, subjects
from cwm.checksums import crc32c


def slow_crc32c(data: bytes) -> int:
    """Bit by bit, as RFC 3720 has it."""
    remainder = 0xFFFFFFFF
    for byte in data:
        remainder ^= byte
        for _ in range(8):
            remainder = (remainder >> 1) ^ (0x82F63B78 if remainder & 1 else 0)
    return remainder ^ 0xFFFFFFFF


class Crc32c(unittest.TestCase):
    def test_is_that_of_the_standard(self):  # RFC 3720, B.4
        self.assertEqual(crc32c(b"\0" * 32), 0x8A9136AA)
        self.assertEqual(crc32c(b"\xff" * 32), 0x62A8AB43)
        self.assertEqual(crc32c(bytes(range(32))), 0x46DD794E)
        self.assertEqual(crc32c(b""), 0)

    def test_of_lanes_is_that_of_bits(self):
        random = np.random.default_rng(1)
        for size in (1, 4095, 4096, 4097, 8192, 20_001):
            data = random.integers(0, 256, size, dtype=np.uint8).tobytes()
            self.assertEqual(crc32c(data), slow_crc32c(data), size)


class Poses(unittest.TestCase):
    def test_go_to_rows_and_back(self):
        random = np.random.default_rng(2)
        rows = random.normal(size=(1000, 7))
        rows[:, 3:] /= np.linalg.norm(rows[:, 3:], axis=1, keepdims=True)
        # Half turns, for which formulas that divide by w lose all digits.
        rows[:4, 3:] = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0.6, 0.8, 0, 0]]
        back = poses.to_rows(poses.to_matrices(rows), "poses")
        np.testing.assert_allclose(back[:, :3], rows[:, :3])
        same_way = np.abs(np.sum(back[:, 3:] * rows[:, 3:], axis=1))  # q and -q are one rotation
        np.testing.assert_allclose(same_way, 1, atol=1e-12)
        np.testing.assert_allclose(poses.to_matrices(back), poses.to_matrices(rows), atol=1e-12)

    def test_rounded_quaternions_turn_and_do_not_scale(self):
        random = np.random.default_rng(3)
        for _ in range(500):
            quaternion = random.normal(size=4)
            quaternion = np.round(quaternion / np.linalg.norm(quaternion), 3)
            pose = poses.pose((1, 2, 3), quaternion)
            np.testing.assert_allclose(pose[:3, :3].T @ pose[:3, :3], np.eye(3), atol=1e-12)
            self.assertEqual(poses.to_proto(pose, "pose").tx_m, 1)

    def test_of_odd_kinds_are_converted(self):
        turned = np.array([[0, -1, 0, 1], [1, 0, 0, 2], [0, 0, 1, 3], [0, 0, 0, 1]])
        expected = [[1, 2, 3, 0, 0, np.sqrt(0.5), np.sqrt(0.5)]]
        for given in (
            turned,
            turned.astype(np.float32),
            np.asfortranarray(turned.astype(float)),
            turned.tolist(),
            turned[np.newaxis],
            np.repeat(turned[np.newaxis].astype(float), 4, axis=0)[::4],
        ):
            np.testing.assert_allclose(poses.to_rows(given, "poses"), expected, atol=1e-6)
        self.assertEqual(poses.to_rows(turned.astype(np.float32), "poses").dtype, np.float32)

    def test_that_are_none_are_refused_by_name(self):
        mirrored, scaled, sheared = np.diag([1.0, 1, -1, 1]), np.diag([2.0, 2, 2, 1]), np.eye(4)
        sheared[3, 0] = 0.1
        good = np.eye(4)
        for bad in (mirrored, scaled, sheared):
            with self.assertRaisesRegex(ValueError, r"poses\[1\] is no pose"):
                poses.to_rows([good, bad], "poses")
        with self.assertRaisesRegex(
            ValueError, r"poses\[0\] has a quaternion of length 2, must be 1"
        ):
            poses.to_rows([0, 0, 0, 0, 0, 0, 2], "poses")
        with self.assertRaisesRegex(ValueError, r"poses has the shape \(3, 3\), must be"):
            poses.to_rows(np.eye(3), "poses")
        with self.assertRaisesRegex(ValueError, r"poses has the shape \(0, 4, 4\), must be"):
            poses.to_rows(np.empty((0, 4, 4)), "poses")
        with self.assertRaisesRegex(ValueError, r"poses\[0, 0, 3\] is nan, must be finite"):
            poses.to_rows([[1, 0, 0, np.nan], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]], "poses")
        with self.assertRaisesRegex(ValueError, "pose has 2 poses, must be one"):
            poses.to_proto([good, good], "pose")


class Rows(unittest.TestCase):
    def test_are_converted_in_their_precision(self):
        self.assertEqual(arrays.rows([[1, 2, 3]], "points", 3).dtype, np.float64)
        self.assertEqual(arrays.rows(np.ones((2, 3), np.float16), "points", 3).dtype, np.float64)
        self.assertEqual(arrays.rows(np.ones((2, 3), ">f4"), "points", 3).dtype, np.dtype("<f4"))
        fortran = np.asfortranarray(np.arange(6.0).reshape(2, 3))
        self.assertEqual(arrays.rows(fortran, "points", 3).tobytes(), np.arange(6.0).tobytes())
        np.testing.assert_array_equal(arrays.rows([1, 2, 3], "points", 3), [[1, 2, 3]])

    def test_of_wrong_shape_or_content_are_refused_by_name(self):
        cases = [
            (np.ones((2, 4)), ValueError, r"points has the shape \(2, 4\), must be \(N, 3\)"),
            (np.ones((2, 2, 3)), ValueError, r"points has the shape \(2, 2, 3\), must be \(N, 3\)"),
            (
                np.empty((0, 3)),
                ValueError,
                r"points has the shape \(0, 3\), must be \(N, 3\) with at least one row",
            ),
            ([[0, 0, 0], [0, np.nan, 0]], ValueError, r"points\[1, 1\] is nan, must be finite"),
            ([[0, 0, np.inf]], ValueError, r"points\[0, 2\] is inf, must be finite"),
            ([["a", "b", "c"]], TypeError, "points has the type <U1, must be real numbers"),
            ([[1j, 0, 0]], TypeError, "points has the type complex128, must be real numbers"),
            ([[True, False, True]], TypeError, "points has the type bool, must be real numbers"),
            ([[1, 2, 3], [1, 2]], TypeError, "points must be a rectangular array of numbers"),
            (np.ma.masked_array(np.ones((1, 3))), TypeError, "points is a masked array"),
            (None, TypeError, "points has the type object, must be real numbers"),
        ]
        for value, kind, message in cases:
            with self.subTest(message), self.assertRaisesRegex(kind, message):
                subjects.subject_of(value, None) if value is None else arrays.rows(
                    value, "points", 3
                )

    def test_of_points_have_no_others_beside_them(self):
        with self.assertRaisesRegex(TypeError, "rows is given with a subject of points"):
            subjects.subject_of(np.ones((2, 3)), np.ones((2, 7)))


class Clouds(unittest.TestCase):
    def test_keep_their_precision_and_order(self):
        picture = np.asfortranarray(np.arange(24, dtype=np.float32).reshape(2, 4, 3))
        header, cloud = ingest.make_header(picture, None)
        self.assertEqual(
            (header.width, header.height, header.point_count, header.layout.point_step),
            (4, 2, 8, 12),
        )
        self.assertEqual(cloud.tobytes(), np.arange(24, dtype=np.float32).tobytes())
        header, _ = ingest.make_header(np.ones((5, 3)), np.ones((5, 3), np.float32))
        self.assertEqual(
            (header.layout.point_step, [f.name for f in header.layout.fields][3:]),
            (48, ["normal_x", "normal_y", "normal_z"]),
        )

    def test_that_cannot_be_are_refused(self):
        for value, message in (
            (np.empty((0, 3)), "at least one point"),
            (np.ones((4, 2)), r"must be \(N, 3\) or \(H, W, 3\)"),
            (np.full((4, 3), np.nan), "at least one must be finite"),
        ):
            with self.subTest(message), self.assertRaisesRegex(ValueError, message):
                ingest.make_header(value, None)
        with self.assertRaisesRegex(
            ValueError, r"normals has the shape \(3, 3\), must be that of points, \(4, 3\)"
        ):
            ingest.make_header(np.ones((4, 3)), np.ones((3, 3)))


class Shapes(unittest.TestCase):
    def test_with_impossible_sizes_are_refused(self):
        for make, message in (
            (lambda: cwm.Sphere(0), r"Sphere.radius_m is 0, must be greater than 0"),
            (lambda: cwm.Box(1, -1, 1), r"Box.size_y_m is -1, must be greater than 0"),
            (
                lambda: cwm.Cone(-1, 0, 1),
                r"Cone.radius_bottom_m is -1, must be finite and at least 0",
            ),
            (lambda: cwm.Cylinder(float("nan"), 1), r"Cylinder.radius_m is nan, must be finite"),
            (lambda: cwm.Mesh(), r"Mesh needs vertices and triangles, or a hash"),
            (lambda: cwm.Mesh(np.eye(3), [[0, 1, 3]]), r"triangles\[0, 2\] is 3, must be 0 to 2"),
            (
                lambda: cwm.Plate([[0, 0, 0]], 0.1),
                r"Plate.outline has the shape \(1, 3\), must be \(N, 2\)",
            ),
        ):
            with self.subTest(message), self.assertRaisesRegex(ValueError, message):
                make()
        with self.assertRaisesRegex(TypeError, "Sphere.radius_m is 'big', must be a number"):
            cwm.Sphere("big")
        with self.assertRaisesRegex(
            TypeError, "triangles has the type float64, must be whole numbers"
        ):
            cwm.Mesh(np.eye(3), [[0.0, 1, 2]])

    def test_that_are_meshes_are_told_apart_by_their_hash(self):
        triangle = cwm.Mesh(np.eye(3), [[0, 1, 2]])
        self.assertEqual(triangle, cwm.Mesh(np.eye(3).tolist(), np.array([[0, 1, 2]], np.int16)))
        self.assertNotEqual(triangle, cwm.Mesh(2 * np.eye(3), [[0, 1, 2]]))
        self.assertEqual(cwm.Mesh(hash=triangle.hash), triangle)
        vertices, triangles = shapes.mesh_from_bytes(triangle.blob)
        np.testing.assert_array_equal(vertices, np.eye(3))
        np.testing.assert_array_equal(triangles, [[0, 1, 2]])


class DefaultAddress(unittest.TestCase):
    def test_is_that_of_the_server(self):
        with mock.patch.dict(os.environ, {"CWM_ADDR": "", "XDG_RUNTIME_DIR": ""}):
            self.assertEqual(cwm.default_address(), f"unix:/tmp/cwm-{os.getuid()}/cwm.sock")
            os.environ["XDG_RUNTIME_DIR"] = "/run/user/7"
            self.assertEqual(cwm.default_address(), f"unix:/run/user/7/cwm-{os.getuid()}.sock")
            os.environ["CWM_ADDR"] = "localhost:1"
            self.assertEqual(cwm.default_address(), "localhost:1")

    def test_is_refused_where_another_user_could_answer(self):
        with tempfile.TemporaryDirectory() as folder:
            with mock.patch.dict(os.environ, {"CWM_ADDR": "", "XDG_RUNTIME_DIR": folder}):
                for mode in (0o700, 0o755):
                    os.chmod(folder, mode)
                    addresses.prepare_default_address()
                for mode in (0o770, 0o702, 0o1777):
                    os.chmod(folder, mode)
                    with self.assertRaisesRegex(
                        cwm.PermissionDenied,
                        f"XDG_RUNTIME_DIR: {folder}: has mode {mode:04o}, must not be writable by "
                        "its group or others; .* CWM_ADDR",
                    ):
                        cwm.connect()
                os.environ["XDG_RUNTIME_DIR"] = f"{folder}/missing"
                with self.assertRaisesRegex(cwm.Unavailable, "XDG_RUNTIME_DIR does not exist"):
                    cwm.connect()
                os.environ["CWM_ADDR"] = "unix:/nowhere/cwm.sock"
                addresses.prepare_default_address()

    def test_without_a_runtime_directory_is_in_one_of_the_users_own(self):
        with tempfile.TemporaryDirectory() as parent:
            folder = f"{parent}/cwm"
            for _ in range(2):
                addresses.make_private_folder(folder)
            self.assertEqual(os.stat(folder).st_mode & 0o7777, 0o700)
            for mode in (0o710, 0o701, 0o755, 0o1777):
                os.chmod(folder, mode)
                with self.assertRaisesRegex(cwm.PermissionDenied, f"has mode {mode:04o}"):
                    addresses.make_private_folder(folder)
            os.chmod(folder, 0o700)
            os.symlink(folder, f"{parent}/link")
            for link in (f"{parent}/link", f"{parent}/link/"):
                with self.assertRaisesRegex(cwm.PermissionDenied, "is a symbolic link"):
                    addresses.check_folder(link, private=True)
            with open(f"{parent}/file", "w"):
                pass
            with self.assertRaisesRegex(cwm.PermissionDenied, "is no directory"):
                addresses.make_private_folder(f"{parent}/file")
            with self.assertRaisesRegex(cwm.PermissionDenied, "cannot be made"):
                addresses.make_private_folder(f"{parent}/none/cwm")

    @unittest.skipUnless(os.geteuid() == 0, "only root can make a folder another user's")
    def test_is_refused_in_a_folder_of_another_user(self):
        with tempfile.TemporaryDirectory() as folder:
            os.chown(folder, 65534, 65534)
            with self.assertRaisesRegex(
                cwm.PermissionDenied, f"{folder}: belongs to user 65534, must belong to user 0"
            ):
                addresses.make_private_folder(folder)
            with mock.patch.dict(os.environ, {"CWM_ADDR": "", "XDG_RUNTIME_DIR": folder}):
                with self.assertRaisesRegex(cwm.PermissionDenied, "belongs to user 65534"):
                    cwm.connect()


if __name__ == "__main__":
    unittest.main()
