"""Rows of numbers in a request, without the copies that protobuf would make of them: half of what a
batch costs in Python.

A message that comes twice in the bytes of another is merged by whoever parses them, so that the
request is written as protobuf does it, and behind it once more the messages around the rows,
holding nothing else.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from google.protobuf.message import Message

_LENGTH_DELIMITED = 2


def _varint(value: int) -> bytes:
    out = bytearray()
    while value > 0x7F:
        out.append(value & 0x7F | 0x80)
        value >>= 7
    out.append(value)
    return bytes(out)


def embedded(number: int, message: bytes) -> bytes:
    """A field of that number that holds a message, of which these are the bytes."""
    return b"".join((_varint(number << 3 | _LENGTH_DELIMITED), _varint(len(message)), message))


@dataclass(frozen=True, eq=False)
class Bulk:
    """Rows (N, W), C-ordered, for the `bytes` field at the path of names, from the request on.
    None: there are no rows.
    """

    rows: np.ndarray | None
    path: tuple[str, ...]

    @property
    def row_bytes(self) -> int:
        return 1 if self.rows is None else self.rows.shape[1] * self.rows.itemsize

    def request_bytes(self, request: Message, begin: int, end: int) -> bytes:
        """The request with those rows."""
        if self.rows is None:
            return request.SerializeToString()
        data = memoryview(self.rows[begin:end]).cast("B")
        fields, descriptor = [], request.DESCRIPTOR
        for name in self.path:
            field = descriptor.fields_by_name[name]
            fields.append(field.number)
            descriptor = field.message_type
        before, length = b"", len(data)
        for number in reversed(fields):
            before = _varint(number << 3 | _LENGTH_DELIMITED) + _varint(length) + before
            length = len(before) + len(data)
        return b"".join((request.SerializeToString(), before, data))
