"""A real server of its own for a test, and what several tests ask of it."""

from __future__ import annotations

import json
import os
import pathlib
import subprocess
import tempfile
import time
import unittest

import cwm

BINARIES = pathlib.Path(os.environ.get("CWM_BIN", "build/bin"))


class RunningServer:
    """A cwm-server on a Unix socket; `restart` loses its memory, as a server without a store
    does.
    """

    def __init__(self) -> None:
        self._scratch = tempfile.TemporaryDirectory()
        self.folder = pathlib.Path(self._scratch.name)
        self.address = f"unix:{self.folder}/cwm.sock"
        self.start()

    def start(self) -> None:
        with open(self.folder / "server.log", "ab") as log:
            self._process = subprocess.Popen(
                [BINARIES / "cwm-server", "--listen", self.address], stdout=log, stderr=log
            )
        end = time.monotonic() + 20
        while True:
            try:
                cwm.connect(self.address).close()
                return
            except cwm.Unavailable:
                if self._process.poll() is not None or time.monotonic() > end:
                    raise AssertionError("the server did not come up: " + self.log()) from None
                time.sleep(0.02)

    def stop(self) -> None:
        self._process.terminate()
        if self._process.wait(20) != 0:
            raise AssertionError("the server did not end by itself: " + self.log())

    def kill(self) -> None:
        """Ends it without a farewell."""
        self._process.kill()
        self._process.wait(20)

    def restart(self) -> None:
        self.stop()
        self.start()

    def close(self) -> None:
        try:
            self.stop()
        finally:
            self._scratch.cleanup()

    def log(self) -> str:
        return (self.folder / "server.log").read_text()


class ServerCase(unittest.TestCase):
    """One server for all tests of a class; a world named after the test for each."""

    @classmethod
    def setUpClass(cls) -> None:
        cls.running = RunningServer()
        cls.addClassCleanup(cls.running.close)

    def setUp(self) -> None:
        self.world = cwm.connect(self.running.address, self._testMethodName)
        self.addCleanup(self.world.close)

    def cli(self, *arguments: str, stdin: str = "") -> dict:
        """What the command line says of this test's world, as JSON."""
        run = subprocess.run(
            [
                BINARIES / "cwm",
                "--addr",
                self.running.address,
                "--world",
                self.world.name,
                "-o",
                "json",
                *arguments,
            ],
            input=stdin,
            capture_output=True,
            text=True,
            check=False,
        )
        self.assertEqual(run.returncode, 0, run.stderr)
        return json.loads(run.stdout)
