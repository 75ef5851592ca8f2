"""Running sensors and robots with a real server."""

import datetime
import threading
import time
import unittest

import numpy as np

import cwm
from robots_test import URDF
from server_case import ServerCase

WIDTH, HEIGHT = 160, 120
INTRINSICS = (140.0, 140.0, 79.5, 59.5)
FRAME_S = 0.033


def overhead() -> np.ndarray:
    """X_WS of a camera 1 m above the floor that looks straight down."""
    pose = np.diag([1.0, -1.0, -1.0, 1.0])
    pose[2, 3] = 1
    return pose


def depths() -> np.ndarray:
    """The floor with a block of 10 cm on it, in millimetres."""
    image = np.full((HEIGHT, WIDTH), 1000, np.uint16)
    image[50:70, 70:90] = 900
    return image


class Sensors(ServerCase):
    def setUp(self) -> None:
        super().setUp()
        self.begin = time.time()

    def stream(self, **options) -> cwm.SensorStream:
        return self.world.stream_sensor("overhead", INTRINSICS, overhead(), **options)

    def test_each_frame_is_answered(self):
        with self.stream() as frames:
            for k in range(3):
                result = frames.process(depths(), self.begin + k * FRAME_S)
                self.assertEqual((result.frame, result.fate), (k, cwm.FrameFate.PROCESSED))
                self.assertAlmostEqual(
                    result.stamp.timestamp(), self.begin + k * FRAME_S, delta=1e-5
                )
                counts = vars(result.pixels).values()
                self.assertEqual(sum(counts), WIDTH * HEIGHT)
                np.testing.assert_allclose(result.pose, overhead(), atol=1e-9)
                self.assertEqual(result.world_uid, self.world.uid)
                self.assertGreater(len(result.stages), 0)
        (sensor,) = self.world.sensors()
        self.assertEqual((sensor.name, sensor.processed_count), ("overhead", 3))
        self.assertIsNone(sensor.mount)
        self.assertIsNone(sensor.estimate)
        self.assertEqual((sensor.conflicts, sensor.estimate_note), ((), ""))

    def test_frames_in_lockstep_are_numbered_and_answered_when_all_is_done(self):
        with self.stream(lockstep=True) as frames:
            for k in range(5):
                result = frames.process(depths(), self.begin + k * FRAME_S)
                self.assertEqual(result.sequence_number, k + 1)
                self.assertFalse(result.interpreting)
            late = frames.process(depths(), self.begin)
            self.assertEqual((late.reason, late.sequence_number), ("STALE_FRAME", 0))

    def test_frames_of_one_thread_are_answered_in_another(self):
        frames = self.stream()
        image = np.full((HEIGHT, WIDTH), 1.0, np.float32)

        def send() -> None:
            for k in range(20):
                frames.send(image, self.begin + k * FRAME_S)
            frames.finish()

        sender = threading.Thread(target=send)
        sender.start()
        results = list(frames)
        sender.join()
        self.assertEqual([result.frame for result in results], list(range(20)))
        self.assertNotIn(cwm.FrameFate.REFUSED, [result.fate for result in results])
        with self.assertRaisesRegex(ValueError, "finished"):
            frames.send(image, self.begin + 1)

    def test_late_frames_are_refused_and_the_stream_goes_on(self):
        with self.stream() as frames:
            stamp = datetime.datetime.now(datetime.timezone.utc)
            self.assertEqual(frames.process(depths(), stamp).fate, cwm.FrameFate.PROCESSED)
            late = frames.process(depths(), stamp - datetime.timedelta(seconds=1))
            self.assertEqual((late.fate, late.reason), (cwm.FrameFate.REFUSED, "STALE_FRAME"))
            self.assertTrue(late.message)
            later = frames.process(depths(), stamp + datetime.timedelta(seconds=0.1))
            self.assertEqual(later.fate, cwm.FrameFate.PROCESSED)

    def test_arguments_that_cannot_be_right_are_named(self):
        with self.stream() as frames:
            with self.assertRaisesRegex(ValueError, r"depth has the shape \(3,\)"):
                frames.send(np.zeros(3, np.uint16), self.begin)
            with self.assertRaisesRegex(TypeError, "depth has the type int64"):
                frames.send(np.zeros((3, 3), np.int64), self.begin)
            with self.assertRaisesRegex(TypeError, "depth is a masked array, must be a plain one"):
                frames.send(np.ma.masked_equal(depths(), 900), self.begin)
            with self.assertRaisesRegex(ValueError, r"stamp is 1.8e\+18, must be seconds"):
                frames.send(depths(), 1.8e18)
            with self.assertRaisesRegex(ValueError, "time zone"):
                frames.send(depths(), datetime.datetime.now())
            with self.assertRaisesRegex(ValueError, r"covariance has the shape \(3, 3\)"):
                frames.send(depths(), self.begin, overhead(), covariance=np.eye(3))
            frames.process(depths(), self.begin)
            with self.assertRaisesRegex(ValueError, "depth is 3 x 4 uint16, must be like"):
                frames.send(np.zeros((3, 4), np.uint16), self.begin + FRAME_S)
        with self.assertRaisesRegex(ValueError, r"intrinsics has the shape \(2,\)"):
            self.world.stream_sensor("s", (1, 2))
        with self.assertRaisesRegex(ValueError, "mount.pose"):
            mount = cwm.SensorMount("arm", "hand", np.zeros((4, 4)))
            self.world.stream_sensor("s", INTRINSICS, mount=mount)

    def test_streams_end_with_the_reason_of_the_server(self):
        mount = cwm.SensorMount("nobody", "hand")
        with self.world.stream_sensor("overhead", INTRINSICS, mount=mount) as frames:
            with self.assertRaises(cwm.NotFound) as raised:
                frames.process(depths(), self.begin)
            self.assertEqual(raised.exception.reason, "ROBOT_UNKNOWN")
        with self.stream() as frames:
            frames.process(depths(), self.begin)
            self.world.server.delete_world(self.world.name)
            with self.assertRaises(cwm.NotFound):
                next(frames)

    def test_close_ends_the_iterator(self):
        frames = self.stream()
        frames.process(depths(), self.begin)
        threading.Timer(0.1, frames.close).start()
        self.assertEqual(list(frames), [])

    def test_poses_of_sensors_are_set(self):
        with self.assertRaises(cwm.NotFound):
            self.world.set_sensor_pose("overhead", overhead())
        with self.stream() as frames:
            frames.process(depths(), self.begin)
            moved = overhead()
            moved[0, 3] = 0.01
            told = self.world.set_sensor_pose("overhead", moved)
            np.testing.assert_allclose(told, moved, atol=1e-9)
            result = frames.process(depths(), self.begin + FRAME_S)
            np.testing.assert_allclose(result.pose, moved, atol=1e-9)


class RobotStates(ServerCase):
    def setUp(self) -> None:
        super().setUp()
        self.robot = self.world.load_robot(URDF)
        self.begin = time.time()

    def test_are_taken_one_by_one_and_together(self):
        dof = len(self.robot.variables)
        states = self.world.stream_robot_states(self.robot.name)
        states.send(self.begin, np.full(dof, 0.1))
        states.send([self.begin + 0.01, self.begin + 0.02], np.full((2, dof), 0.2))
        summary = states.finish()
        self.assertEqual((summary.state_count, summary.ignored_count), (3, 0))
        self.assertEqual(summary.world_uid, self.world.uid)

    def test_that_fit_no_robot_are_refused(self):
        with self.assertRaises(cwm.NotFound) as raised:
            self.world.stream_robot_states("nobody").finish()
        self.assertEqual(raised.exception.reason, "ROBOT_UNKNOWN")
        wide = self.world.stream_robot_states(self.robot.name)
        wide.send(self.begin, np.zeros(len(self.robot.variables) + 1))
        with self.assertRaises(cwm.InvalidArgument):
            wide.finish()
        with self.world.stream_robot_states(self.robot.name) as states:
            with self.assertRaisesRegex(ValueError, "stamps are 1, must be 2"):
                states.send(self.begin, np.zeros((2, len(self.robot.variables))))


if __name__ == "__main__":
    unittest.main()
