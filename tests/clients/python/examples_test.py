"""Each example runs as a user would run it, and says what it should."""

import os
import pathlib
import subprocess
import sys
import unittest

import cwm
from server_case import RunningServer

EXAMPLES = pathlib.Path(__file__).parents[3] / "clients/python/examples"


class Examples(unittest.TestCase):
    @classmethod
    def setUpClass(cls) -> None:
        cls.running = RunningServer()
        cls.addClassCleanup(cls.running.close)

    def run_example(self, name: str, *arguments: str) -> str:
        environment = {
            **os.environ,
            "CWM_ADDR": self.running.address,
            "MPLCONFIGDIR": str(self.running.folder),
        }
        run = subprocess.run(
            [sys.executable, EXAMPLES / name, *arguments],
            env=environment,
            capture_output=True,
            text=True,
            timeout=120,
            check=False,
        )
        self.assertEqual(run.returncode, 0, run.stderr)
        server = cwm.Server(self.running.address)
        self.addCleanup(server.close)
        # Examples are run on servers that others use: each has a world of its own.
        self.assertNotIn("default", [world.name for world in server.worlds()])
        return run.stdout

    def test_every_example_is_run(self):
        tests = {name.removeprefix("test_") for name in dir(self) if name.startswith("test_")}
        scripts = {path.stem for path in EXAMPLES.glob("*.py") if "with cwm." in path.read_text()}
        self.assertEqual(scripts - tests, set())

    def test_follow_sensor(self):
        out = self.run_example("follow_sensor.py")
        self.assertIn("table: 60 frames", out)
        self.assertNotIn("REFUSED", out)

    def test_ingest_and_list(self):
        out = self.run_example("ingest_and_list.py")
        for expected in (
            "support_1 (SUPPORT)",
            "object_1 (OBJECT)",
            "Sphere(radius_m=0.0",
            "Box(size_x_m=",
        ):
            self.assertIn(expected, out)

    def test_put_and_query(self):
        out = self.run_example("put_and_query.py")
        self.assertIn("x = 0.50 m:    -3.0 mm to can", out)
        self.assertIn("CONTACT at", out)

    def test_robot_batches(self):
        self.assertRegex(
            self.run_example("robot_batches.py"),
            r"\d+ of 100000 states are free(.|\n)* hit the pillar",
        )

    def test_watch_world(self):
        out = self.run_example("watch_world.py").splitlines()
        self.assertEqual(
            out,
            [
                "revision 1: ['ball'] ",
                "revision 2: ['ObjectMoved']",
                "revision 3: ['ObjectPut']",
                "revision 4: ['ObjectRemoved']",
            ],
        )

    def test_draw_scan(self):
        picture = self.running.folder / "scan.png"
        self.assertIn("1 supports and 2 objects", self.run_example("draw_scan.py", str(picture)))
        import matplotlib.pyplot as plt

        pixels = plt.imread(picture)[..., :3]
        # The table, the box and the ball have the first three colours of tab10; white paper is not
        # enough.
        for color in plt.get_cmap("tab10").colors[:3]:
            self.assertGreater((abs(pixels - color).max(axis=-1) < 0.02).sum(), 300, color)


if __name__ == "__main__":
    unittest.main()
