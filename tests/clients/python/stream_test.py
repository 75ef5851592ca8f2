"""Questions over a stream: the answers of single calls, several at a time, and what ends them."""

import threading
import unittest
from unittest import mock

import numpy as np

import cwm
from cwm import queries
from server_case import RunningServer, ServerCase


def poses_at(*positions) -> np.ndarray:
    poses = np.tile(np.eye(4), (len(positions), 1, 1))
    poses[:, :3, 3] = positions
    return poses


class Streams(ServerCase):
    def setUp(self) -> None:
        super().setUp()
        self.world.put("ball", cwm.Sphere(0.1))
        self.world.put("cube", cwm.Box(0.2, 0.2, 0.2), cwm.pose([1, 0, 0]))

    def test_answer_what_calls_answer(self):
        random = np.random.default_rng(4)
        poses = poses_at(*random.uniform(-1, 2, (300, 3)))
        directions = random.normal(size=(300, 3))
        queried = {
            "check": lambda w: w.check(cwm.Sphere(0.1), poses),
            "distance": lambda w: w.distance(cwm.Sphere(0.1), poses, k=2, max_distance_m=0.6),
            "contacts": lambda w: w.contacts(cwm.Sphere(0.2), poses),
            "motions": lambda w: w.motions(cwm.Sphere(0.1), poses[::2], poses[1::2]),
            "paths": lambda w: w.paths(cwm.Sphere(0.1), [poses[:2], poses[2:40], poses[40:]]),
            "rays": lambda w: w.rays(poses[:, :3, 3], directions),
            "sample": lambda w: w.sample(poses[:, :3, 3]),
        }
        with self.world.stream() as stream:
            for name, query in queried.items():
                for max_rows in (1_000, 37):
                    with self.subTest(name, max_rows=max_rows):
                        with mock.patch.object(queries, "_max_rows", return_value=max_rows):
                            streamed = query(stream)
                        for key, value in vars(query(self.world)).items():
                            np.testing.assert_array_equal(getattr(streamed, key), value, key)
            self.assertEqual([o.name for o in stream.objects()], ["ball", "cube"])

    def test_hold_what_is_supposed_until_they_end(self):
        probe, at = cwm.Sphere(0.05), cwm.pose([0.2, 0, 0])
        mesh = cwm.Mesh([[0, 0, 0], [0.1, 0, 0], [0, 0.1, 0]], [[0, 1, 2]])
        supposing = self.world.what_if(cwm.Put("ghost", mesh, at), cwm.Remove("cube"))
        with supposing.stream() as stream:
            self.assertEqual(stream.check(probe, at).objects.tolist(), ["ghost"])
            self.assertEqual(stream.distance(probe, at, k=5).objects.tolist(), ["ghost", "ball"])
            more = stream.what_if(cwm.Remove("ghost"))
            self.assertTrue(more.check(probe, at).free[0])
            self.assertEqual(stream.check(probe, at).objects.tolist(), ["ghost"])
        self.assertTrue(self.world.check(probe, at).free[0])
        with self.assertRaises(cwm.NotFound) as refused:
            self.world.what_if(cwm.Remove("nobody")).stream().check(probe, at)
        self.assertEqual(refused.exception.reason, "OBJECT_UNKNOWN")

    def test_of_a_pinned_view_stay_at_its_revision(self):
        with self.world.at().stream() as stream:
            self.world.remove("ball")
            self.assertTrue(stream.check(cwm.Sphere(0.05)).collision[0])
            self.assertTrue(self.world.check(cwm.Sphere(0.05)).free[0])

    def test_go_on_after_a_question_that_failed(self):
        with self.world.stream() as stream:
            with self.assertRaises(cwm.InvalidArgument) as refused:
                stream.distance(cwm.Sphere(0.1), k=1_000)
            self.assertTrue(refused.exception.fields)
            with self.assertRaises(cwm.NotFound) as unknown:
                stream.check("nobody")
            self.assertEqual(unknown.exception.reason, "OBJECT_UNKNOWN")
            self.assertTrue(stream.check(cwm.Sphere(0.05)).collision[0])

    def test_take_questions_of_several_threads(self):
        x_m = np.linspace(0.2, 0.8, 40)
        told = np.zeros((8, len(x_m)))

        def query(thread: int) -> None:
            for i, x in enumerate(x_m):
                told[thread, i] = stream.distance(cwm.Sphere(0.05), cwm.pose([x, 0, 0])).distance_m[
                    0
                ]

        with self.world.stream() as stream:
            threads = [threading.Thread(target=query, args=(k,)) for k in range(len(told))]
            for thread in threads:
                thread.start()
            for thread in threads:
                thread.join()
        expected = np.minimum(x_m - 0.15, 0.85 - x_m)
        np.testing.assert_allclose(told, np.tile(expected, (len(told), 1)), atol=1e-9)

    def test_ask_nothing_once_they_are_closed(self):
        with self.world.stream() as stream:
            self.assertTrue(stream.check(cwm.Sphere(0.05)).collision[0])
        with self.assertRaises(cwm.Cancelled):
            stream.check(cwm.Sphere(0.05))
        stream.close()
        self.assertTrue(self.world.check(cwm.Sphere(0.05)).collision[0])

    def test_end_with_their_server(self):
        running = RunningServer()
        self.addCleanup(running.close)
        with cwm.connect(running.address, "w") as world:
            world.put("ball", cwm.Sphere(0.1))
            stream = world.stream()
            self.assertTrue(stream.check(cwm.Sphere(0.05)).collision[0])
            running.restart()
            for _ in range(2):  # the server is there again, the stream is not
                with self.assertRaises(cwm.Unavailable) as told:
                    stream.check(cwm.Sphere(0.05))
                self.assertNotIn("no cwm-server answers", str(told.exception))
            stream.close()
            world.put("ball", cwm.Sphere(0.1))
            with world.stream() as another:
                self.assertTrue(another.check(cwm.Sphere(0.05)).collision[0])

    def test_say_that_they_are_lost_and_what_to_do(self):
        running = RunningServer()
        self.addCleanup(running.close)
        with cwm.connect(running.address, "w") as world:
            world.put("ball", cwm.Sphere(0.1))
            stream = world.stream()
            running.kill()
            running.start()
            with self.assertRaisesRegex(cwm.Unavailable, r"is lost \(.*opened anew with stream\(\)"):
                stream.check(cwm.Sphere(0.05))
            left = world.stream()
        with self.assertRaisesRegex(cwm.Cancelled, "is closed, as is its connection"):
            left.check(cwm.Sphere(0.05))


class UnseenSpace(ServerCase):
    def test_is_put_and_counts_as_questions_say(self):
        self.world.put("dark", cwm.Box(1, 1, 1), kind="unseen")
        self.world.put("box", cwm.Box(1, 1, 1), cwm.pose([3, 0, 0]))
        kinds = {o.name: o.kind for o in self.world.objects()}
        self.assertEqual(kinds, {"dark": cwm.ObjectKind.UNSEEN, "box": cwm.ObjectKind.USER})
        probe = cwm.Sphere(0.1)
        for unseen, verdict in (
            ("block", cwm.Verdict.COLLISION),
            ("report", cwm.Verdict.UNDECIDED),
            ("ignore", cwm.Verdict.FREE),
        ):
            self.assertEqual(self.world.check(probe, unseen=unseen).verdict.tolist(), [verdict])
        overlay = [cwm.Put("darker", probe, cwm.pose([6, 0, 0]), kind=cwm.ObjectKind.UNSEEN)]
        there = self.world.check(probe, cwm.pose([6, 0, 0]), overlay=overlay, unseen="report")
        self.assertEqual(there.verdict.tolist(), [cwm.Verdict.UNDECIDED])

    def test_takes_no_other_kind(self):
        for kind in ("support", "nothing"):
            with self.assertRaisesRegex(ValueError, "kind is"):
                self.world.put("thing", cwm.Sphere(0.1), kind=kind)


if __name__ == "__main__":
    unittest.main()
