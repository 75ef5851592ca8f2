"""Questions against formulas, against the command line, and against themselves in batches of
another size.
"""

import unittest
from unittest import mock

import numpy as np

import cwm
from cwm import queries
from server_case import ServerCase


def poses_at(*positions) -> np.ndarray:
    poses = np.tile(np.eye(4), (len(positions), 1, 1))
    poses[:, :3, 3] = positions
    return poses


class Answers(ServerCase):
    def setUp(self) -> None:
        super().setUp()
        self.world.put("ball", cwm.Sphere(0.1))
        self.world.put("cube", cwm.Box(0.2, 0.2, 0.2), cwm.pose([1, 0, 0]))

    def test_of_distances_are_the_formulas(self):
        x_m = np.linspace(-2, 0.5, 50)
        centers = np.column_stack([x_m, np.zeros((50, 2))])
        answer = self.world.distance(cwm.Sphere(0.05), poses_at(*centers))
        np.testing.assert_allclose(
            answer.distance_m, np.minimum(np.abs(x_m), 1 - x_m + 0.05) - 0.15, atol=1e-9
        )
        self.assertEqual((answer.complete, answer.row.tolist()), (True, list(range(50))))
        np.testing.assert_array_equal(answer.objects[x_m < 0.4], "ball")
        outside = x_m < -0.2
        np.testing.assert_allclose(
            answer.normal[outside], np.tile([1, 0, 0], (outside.sum(), 1)), atol=1e-9
        )
        np.testing.assert_allclose(
            answer.point_object[outside], np.tile([-0.1, 0, 0], (outside.sum(), 1)), atol=1e-9
        )
        self.assertTrue((answer.trust == cwm.Trust.EXACT).all())

    def test_of_every_subject_and_precision_are_alike(self):
        points = np.random.default_rng(3).uniform(-1, 2, (200, 3))
        expected = self.world.distance(points).distance_m
        poses = poses_at(*points)
        rows = np.column_stack([points, np.zeros((200, 3)), np.ones(200)])
        tiny = cwm.Sphere(1e-9)
        for given in (poses, np.asfortranarray(poses), poses.tolist(), rows):
            np.testing.assert_allclose(
                self.world.distance(tiny, given).distance_m, expected, atol=2e-9
            )
        np.testing.assert_allclose(
            self.world.distance(tiny, rows.astype(np.float32)).distance_m, expected, atol=1e-6
        )
        np.testing.assert_allclose(self.world.sample(points).distance_m, expected, atol=1e-12)
        self.world.put("probe", tiny, cwm.pose(points[0]))
        # A subject is not an obstacle for itself.
        np.testing.assert_allclose(
            self.world.distance("probe", rows).distance_m, expected, atol=2e-9
        )
        np.testing.assert_allclose(self.world.distance("probe").distance_m, expected[:1], atol=2e-9)

    def test_are_what_the_command_line_says(self):
        places = [[0.05, 0, 0], [0.5, 0.1, 0.2], [0.86, 0, 0], [3, 0, 0]]
        where = [argument for place in places for argument in ("--at", ",".join(map(str, place)))]
        sphere = cwm.Sphere(0.05)
        checked = self.world.check(sphere, poses_at(*places))
        rows = self.cli("check", "--sphere", "0.05", *where)["rows"]
        self.assertEqual(
            ["VERDICT_" + cwm.Verdict(v).name for v in checked.verdict],
            [row["verdict"] for row in rows],
        )
        self.assertEqual(checked.objects.tolist(), [row.get("object") for row in rows])
        measured = self.world.distance(sphere, poses_at(*places), k=2)
        answers = [
            a
            for row in self.cli("distance", "--sphere", "0.05", "--max-results", "2", *where)[
                "rows"
            ]
            for a in row["answers"]
        ]
        self.assertEqual(measured.distance_m.tolist(), [answer["distance_m"] for answer in answers])
        self.assertEqual(measured.objects.tolist(), [answer["object"] for answer in answers])
        self.assertEqual(
            measured.normal.tolist(),
            [[answer["normal"][axis] for axis in "xyz"] for answer in answers],
        )

    def test_of_contacts_have_depths_and_none_where_nothing_touches(self):
        answer = self.world.contacts(
            cwm.Sphere(0.05), poses_at([0.12, 0, 0], [0.5, 0, 0]), max_contacts=3
        )
        self.assertEqual(answer.row_begin.tolist(), [0, 1, 1])
        np.testing.assert_allclose(answer.distance_m, [-0.03], atol=1e-9)
        np.testing.assert_allclose(answer.nearest_m, [-0.03, np.nan], atol=1e-9)

    def test_of_motions_are_certified(self):
        left, right, up = [-1, 0, 0], [0.5, 0, 0], [-1, 0, 1]
        answer = self.world.motions(cwm.Sphere(0.05), poses_at(left, left), poses_at(right, up))
        self.assertEqual(
            answer.verdict.tolist(), [cwm.MotionVerdict.CONTACT, cwm.MotionVerdict.FREE]
        )
        self.assertEqual(answer.trust.tolist(), [cwm.Trust.EXACT, cwm.Trust.EXACT])
        touching = (1 - 0.15) / 1.5  # the share of the way where the surfaces meet
        self.assertLessEqual(answer.lo[0], touching)
        self.assertGreaterEqual(answer.hi[0], touching)
        self.assertEqual(answer.objects.tolist(), ["ball", None])
        paths = self.world.paths(
            cwm.Sphere(0.05), [poses_at(left, up), poses_at(left, up, right, left)]
        )
        self.assertEqual(paths.free.tolist(), [True, False])
        self.assertEqual(paths.segment.tolist(), [-1, 2])

    def test_of_rays_and_samples_name_what_they_meet(self):
        answer = self.world.rays([-1, 0, 0], [[2, 0, 0], [0, 1, 0]])
        self.assertEqual(
            (answer.hit.tolist(), answer.objects.tolist()), ([True, False], ["ball", None])
        )
        self.assertAlmostEqual(answer.distance_m[0], 0.9, 9)
        np.testing.assert_allclose(answer.normal[0], [-1, 0, 0], atol=1e-12)
        sampled = self.world.sample([[-1, 0, 0], [9, 0, 0]], max_distance_m=1)
        self.assertEqual(sampled.state.tolist(), [cwm.SampleState.SMOOTH, cwm.SampleState.BEYOND])
        self.assertEqual(sampled.objects.tolist(), ["ball", None])
        np.testing.assert_allclose(sampled.gradient[0], [-1, 0, 0], atol=1e-9)

    def test_depend_on_options(self):
        at = cwm.pose([0.2, 0, 0])
        probe = cwm.Sphere(0.05)
        self.assertTrue(self.world.check(probe, at).free[0])
        self.assertTrue(self.world.check(probe, at, margin_m=0.06).collision[0])
        self.assertTrue(self.world.check(probe, at, margin_m=0.06, ignore=["ball"]).free[0])
        self.assertEqual(self.world.distance(probe, at, ignore=["ball"]).objects[0], "cube")
        self.assertEqual(len(self.world.distance(probe, at, max_distance_m=0.01).distance_m), 0)
        there = [
            cwm.Put(
                "ghost",
                cwm.Mesh([[0, 0, 0], [0.1, 0, 0], [0, 0.1, 0]], [[0, 1, 2]]),
                cwm.pose([0.2, 0, 0]),
            )
        ]
        ghost = self.world.check(probe, at, overlay=there)
        self.assertEqual((ghost.objects.tolist(), ghost.uids), (["ghost"], ("",)))
        supposing = self.world.what_if(*there)
        for asking in (supposing, supposing.at(), supposing.what_if(cwm.Remove("cube"))):
            ghost = asking.check(probe, at)
            self.assertEqual((ghost.objects.tolist(), ghost.uids), (["ghost"], ("",)))
        self.assertTrue(supposing.check(probe, at, overlay=[cwm.Remove("ghost")]).free[0])
        self.assertTrue(self.world.check(probe, at).free[0])
        self.assertEqual([o.name for o in supposing.objects()], ["ball", "cube"])
        with self.assertRaises(TypeError):
            self.world.what_if("ghost")
        for engine in ("exact", "fcl", "bullet", cwm.Engine.AUTO):
            np.testing.assert_allclose(
                self.world.distance(probe, at, engine=engine).distance_m, [0.05], atol=1e-4
            )
        only = self.world.check(
            probe, poses_at([0, 0, 0]), verdicts_only=True, unseen="ignore", representation="shapes"
        )
        self.assertEqual((only.collision.tolist(), only.objects.tolist()), ([True], [None]))
        loose = self.world.check(
            "ball",
            cwm.pose([0.9, 0, 0]),
            ignore_pairs=[("ball", "cube")],
            margin_sigma=1,
            support_tolerance_m=0.01,
        )
        self.assertTrue(loose.free[0])

    def test_of_contacts_are_limited_by_pair(self):
        on_cube = cwm.pose([1, 0, 0.149])  # a face rests on the cube's
        box = cwm.Box(0.1, 0.1, 0.1)
        self.assertGreaterEqual(len(self.world.contacts(box, on_cube).distance_m), 4)
        self.assertEqual(
            len(self.world.contacts(box, on_cube, max_contacts_per_pair=2).distance_m), 2
        )
        with self.assertRaisesRegex(ValueError, "max_contacts_per_pair is 0, must be at least 1"):
            self.world.contacts(box, on_cube, max_contacts_per_pair=0)

    def test_in_batches_are_those_of_one_question(self):
        random = np.random.default_rng(4)
        poses = poses_at(*random.uniform(-1, 2, (1000, 3)))
        queried = {
            "check": lambda w: w.check(cwm.Sphere(0.1), poses),
            "distance": lambda w: w.distance(cwm.Sphere(0.1), poses, k=2, max_distance_m=0.6),
            "contacts": lambda w: w.contacts(cwm.Sphere(0.2), poses),
            "motions": lambda w: w.motions(cwm.Sphere(0.1), poses[::2], poses[1::2]),
            "paths": lambda w: w.paths(
                cwm.Sphere(0.1), [poses[:2], poses[2:40], poses[40:43], poses[43:]]
            ),
            "rays": lambda w: w.rays(
                poses[:, :3, 3], random.normal(size=(1000, 3)).round(6) + [0, 0, 9]
            ),
            "sample": lambda w: w.sample(poses[:, :3, 3]),
        }
        for name, query in queried.items():
            with self.subTest(name):
                random = np.random.default_rng(5)
                whole = query(self.world)
                random = np.random.default_rng(5)
                with mock.patch.object(queries, "_max_rows", return_value=37):
                    cut = query(self.world)
                for key, value in vars(whole).items():
                    np.testing.assert_array_equal(getattr(cut, key), value, key)

    def test_above_the_limit_are_of_one_revision_and_complete(self):
        points = np.random.default_rng(6).uniform(-1, 2, (150_000, 3))
        answer = self.world.sample(points)
        self.assertEqual((answer.completed_count, len(answer.distance_m)), (150_000, 150_000))
        np.testing.assert_array_equal(
            answer.distance_m[-1000:], self.world.sample(points[-1000:]).distance_m
        )

    def test_that_are_cut_see_nothing_of_what_is_written_meanwhile(self):
        poses = np.tile(cwm.pose([0, 0, 20]), (100, 1, 1))  # far from all else
        self.world.put("wanderer", cwm.Sphere(0.1), cwm.pose([5, 0, 20]))
        call, moved = self.world.connection.call, []

        def call_and_move(method, request, timeout_s):
            answer = call(method, request, timeout_s)
            if method is self.world.connection.queries.GetDistances:
                moved.append(0.1 * len(moved))
                self.world.move("wanderer", cwm.pose([1 + moved[-1], 0, 20]))
            return answer

        with (
            mock.patch.object(queries, "_max_rows", return_value=10),
            mock.patch.object(self.world.connection, "call", call_and_move),
        ):
            answer = self.world.distance(cwm.Sphere(0.01), poses)
        self.assertEqual((len(moved), len(np.unique(answer.distance_m))), (10, 1))
        self.assertNotEqual(
            self.world.distance(cwm.Sphere(0.01), poses[:1]).distance_m[0], answer.distance_m[0]
        )
        self.world.remove("wanderer")

    def test_that_are_cut_begin_anew_where_their_revision_is_forgotten(self):
        points = np.random.default_rng(8).uniform(-1, 2, (100, 3))
        call, calls = self.world.connection.call, []

        def forget_once(method, request, timeout_s):
            calls.append(method)
            if len(calls) == 3:
                raise cwm.RevisionCompacted("forgotten")
            return call(method, request, timeout_s)

        with (
            mock.patch.object(queries, "_max_rows", return_value=40),
            mock.patch.object(self.world.connection, "call", forget_once),
        ):
            answer = self.world.sample(points)
        self.assertEqual(len(calls), 6)
        np.testing.assert_array_equal(answer.distance_m, self.world.sample(points).distance_m)

    def test_in_a_time_budget_are_a_prefix(self):
        points = np.random.default_rng(7).uniform(-1, 2, (1_000_000, 3))
        some = self.world.sample(points, time_budget_s=0.01)
        self.assertFalse(some.complete)
        self.assertEqual(len(some.distance_m), some.completed_count)
        count = some.completed_count
        first = self.world.sample(points[: count + 1])
        np.testing.assert_array_equal(some.distance_m, first.distance_m[:count])

    def test_that_cannot_be_meant_are_refused(self):
        at = cwm.pose()
        cases = [
            (
                lambda: self.world.sample(np.ones((1, 3)), ignore_pairs=["ab"]),
                TypeError,
                r"ignore_pairs\[0\] is 'ab', must be a pair",
            ),
            (
                lambda: self.world.check(cwm.Sphere(1), at, margin=1),
                TypeError,
                "margin is no option of a question",
            ),
            (
                lambda: self.world.check(cwm.Sphere(1), at, margin_m=-1),
                ValueError,
                "margin_m is -1, must be finite and at least 0",
            ),
            (
                lambda: self.world.check(cwm.Sphere(1), at, engine="warp"),
                ValueError,
                "engine is 'warp', must be one of auto",
            ),
            (
                lambda: self.world.check(cwm.Sphere(1), at, ignore="ball"),
                TypeError,
                "ignore is 'ball', must be a sequence",
            ),
            (
                lambda: self.world.distance(cwm.Sphere(1), at, k=0),
                ValueError,
                "k is 0, must be at least 1",
            ),
            (
                lambda: self.world.distance(cwm.Sphere(1), at, k=1.5),
                TypeError,
                "k is 1.5, must be a whole number",
            ),
            (
                lambda: self.world.rays([0, 0, 0], [[0, 0, 0]]),
                ValueError,
                r"directions\[0\] is 0 0 0",
            ),
            (
                lambda: self.world.rays(np.ones((2, 3)), np.ones((3, 3))),
                ValueError,
                r"origins has the shape \(2, 3\)",
            ),
            (
                lambda: self.world.motions("ball", at, poses_at(at[:3, 3], at[:3, 3])),
                ValueError,
                "must be alike",
            ),
            (lambda: self.world.paths("ball", []), ValueError, "paths is empty"),
            (
                lambda: self.world.paths("ball", [at]),
                ValueError,
                r"paths\[0\] has 1 rows, must have at least 2",
            ),
        ]
        for query, kind, message in cases:
            with self.subTest(message), self.assertRaisesRegex(kind, message):
                query()
        with self.assertRaises(cwm.NotFound):
            self.world.check("nobody", at)
        with self.assertRaises(cwm.InvalidArgument) as caught:
            self.world.distance(cwm.Sphere(1), at, k=65)
        self.assertEqual(caught.exception.fields[0].field, "options.max_results")


if __name__ == "__main__":
    unittest.main()
