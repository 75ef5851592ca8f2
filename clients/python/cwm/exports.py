"""Worlds as files of other tools."""

from __future__ import annotations

import os
import pathlib
from dataclasses import dataclass
from typing import Sequence

from cwm.v1 import world_pb2


@dataclass(frozen=True)
class ExportedWorld:
    """A file, and those that it refers to."""

    world_uid: str
    revision: int
    data: bytes
    files: dict[str, bytes]  # beside it, by name relative to it: the meshes of URDF and SDF
    warnings: tuple[str, ...]  # what the format says otherwise, or not at all

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes the file to `path` and the others beside it; folders of theirs are made."""
        path = pathlib.Path(path)
        for name, data in self.files.items():
            beside = path.parent / name
            beside.parent.mkdir(parents=True, exist_ok=True)
            beside.write_bytes(data)
        path.write_bytes(self.data)


def exported_from_replies(replies: Sequence[world_pb2.ExportWorldResponse]) -> ExportedWorld:
    """From all replies of the call, in order."""
    data = b"".join(reply.data for reply in replies)
    last = replies[-1]
    parts: dict[str, bytes] = {}
    begin = 0
    for file in replies[0].files:
        name = pathlib.PurePosixPath(file.name)
        if name.is_absolute() or ".." in name.parts:
            raise ValueError(f"file {file.name!r} is not below the first")
        parts[file.name] = data[begin : begin + file.byte_count]
        begin += file.byte_count
    first = parts.pop("", data)
    return ExportedWorld(last.world_uid, last.revision, first, parts, tuple(last.warnings))
