"""Adds `cwm.v1` to the package: the Python code of ../../proto/cwm/v1, generated while it is built.

pyproject.toml says everything else.
"""

import importlib.util
import pathlib
import shutil
import subprocess
import sys
import tempfile

from setuptools import setup
from setuptools.command.build_py import build_py
from setuptools.command.editable_wheel import editable_wheel
from setuptools.errors import SetupError

PROTOS = pathlib.Path(__file__).resolve().parents[2] / "proto"


def installed_protoc() -> list[str] | None:
    """The command of protoc with gRPC's plugin from PATH, if both are there. They come first,
    because code of a newer protoc needs a newer protobuf than Debian's.
    """
    protoc, plugin = shutil.which("protoc"), shutil.which("grpc_python_plugin")
    return [protoc, f"--plugin=protoc-gen-grpc_python={plugin}"] if protoc and plugin else None


def generator() -> list[str]:
    command = installed_protoc()
    if command is None and importlib.util.find_spec("grpc_tools"):
        command = [sys.executable, "-m", "grpc_tools.protoc"]
    if command is None:
        raise SetupError(
            "nothing here generates the code of the protos: install protoc and grpc_python_plugin "
            "(Debian: protobuf-compiler, protobuf-compiler-grpc) or the Python package grpcio-tools"
        )
    return command


class BuildWithMessages(build_py):
    def run(self) -> None:
        names = sorted(f"cwm/v1/{path.name}" for path in PROTOS.glob("cwm/v1/*.proto"))
        if not names:
            raise SetupError(
                f"no protos in {PROTOS}/cwm/v1: build from a checkout of the whole repository, "
                "with pip install clients/python"
            )
        super().run()
        out = pathlib.Path(self.build_lib)
        outputs = [f"--{kind}_out={out}" for kind in ("python", "pyi", "grpc_python")]
        subprocess.run([*generator(), f"--proto_path={PROTOS}", *outputs, *names], check=True)
        (out / "cwm/v1/__init__.py").write_text(
            '"""The messages and services of the interface, generated from proto/cwm/v1."""\n'
        )


class RefuseEditable(editable_wheel):
    def run(self) -> None:
        raise SetupError(
            "cwm cannot be installed as editable, because part of it is generated; the target "
            "cwm_python of CMake makes build/python for PYTHONPATH"
        )


# The build has a folder of its own: setuptools would install files that an earlier build left.
with tempfile.TemporaryDirectory() as scratch:
    setup(
        cmdclass={"build_py": BuildWithMessages, "editable_wheel": RefuseEditable},
        setup_requires=[] if installed_protoc() else ["grpcio-tools"],
        options={"build": {"build_base": scratch}, "egg_info": {"egg_base": scratch}},
    )
