"""The call behind `QueryStream`: each query costs less than a call of its own, and what is
supposed is sent once.
"""

from __future__ import annotations

import queue
import threading
from concurrent.futures import Future, TimeoutError as NotInTime
from typing import Callable

import grpc

from cwm import bulk, errors
from cwm.changes import Change, changes_to_proto, meshes_of
from cwm.connection import Connection
from cwm.v1 import query_pb2

_REQUEST = query_pb2.StreamQueriesRequest


class Stream:
    """The call: queries go out under ids of their own, answers come back in order. Thread-safe."""

    def __init__(self, connection: Connection):
        self._address = connection.address
        self._lock = threading.Lock()
        self._outgoing: queue.SimpleQueue[bytes | None] = queue.SimpleQueue()
        self._awaited: dict[int, Future] = {}
        self._next_id = 1
        self._end: errors.Error | None = None  # why nothing more can be asked
        self._call = connection.open_queries(iter(self._outgoing.get, None))
        self._reader = threading.Thread(target=self._read, name="cwm-stream", daemon=True)
        self._reader.start()

    def evaluate(
        self, make_message: Callable[[int], bytes], timeout_s: float | None
    ) -> query_pb2.StreamQueriesResponse:
        """The reply to the message that `make_message` makes for an id; raises its error."""
        answer: Future = Future()
        with self._lock:
            if self._end is not None:
                raise self._end
            message = make_message(self._next_id)
            self._awaited[self._next_id] = answer
            self._next_id += 1
            self._outgoing.put(message)
        try:
            reply = answer.result(timeout_s)
        except NotInTime:
            raise errors.DeadlineExceeded(
                f"the stream had no answer within {timeout_s} s",
                code=grpc.StatusCode.DEADLINE_EXCEEDED,
            ) from None
        if reply.WhichOneof("answer") == "error":
            raise errors.from_query_error(reply.error)
        return reply

    def close(self) -> None:
        """What has been asked is still answered; nothing more can be."""
        with self._lock:
            if self._end is None:
                self._end = errors.Cancelled("the stream is closed", code=grpc.StatusCode.CANCELLED)
                self._outgoing.put(None)
        if threading.current_thread() is not self._reader:
            self._reader.join()

    def _read(self) -> None:
        end: errors.Error = errors.Cancelled(
            "the stream is closed", code=grpc.StatusCode.CANCELLED
        )
        try:
            for reply in self._call:
                with self._lock:
                    answer = self._awaited.pop(reply.id, None)
                if answer is not None:
                    answer.set_result(reply)
        except grpc.RpcError as error:
            end = _end_error(error, self._address)
        with self._lock:
            self._end = self._end or end
            left, self._awaited = list(self._awaited.values()), {}
            self._outgoing.put(None)
        for answer in left:
            answer.set_exception(end)


def _end_error(error: grpc.RpcError, address: str) -> errors.Error:
    """What every query from then on is told, also once the server is there again."""
    cause = errors.from_rpc(error, address)
    if cause.reason:  # the server's own words
        return cause
    said = error.details() or error.code().name
    if error.code() == grpc.StatusCode.CANCELLED:
        return errors.Cancelled(
            f"the stream is closed, as is its connection to {address}", code=error.code()
        )
    return errors.Unavailable(
        f"the stream to the cwm-server at {address} is lost ({said}); questions without an answer "
        "may be asked again, on a stream opened anew with stream()",
        code=error.code(),
    )


class _StreamedQueries:
    """The methods of QueryService by their names, as those of a connection, over a stream."""

    def __init__(self, stream: Stream):
        service = query_pb2.DESCRIPTOR.services_by_name["QueryService"]
        for field in _REQUEST.DESCRIPTOR.oneofs_by_name["query"].fields:
            name = field.message_type.name.removesuffix("Request")
            assert name in service.methods_by_name
            setattr(self, name, self._method(stream, field.name, field.number))

    @staticmethod
    def _method(stream: Stream, name: str, number: int) -> Callable:
        def evaluate(data: bytes, timeout: float | None = None):
            def message(id: int) -> bytes:
                return _REQUEST(id=id).SerializeToString() + bulk.embedded(number, data)

            return getattr(stream.evaluate(message, timeout), name)

        return evaluate


class StreamedConnection:
    """A connection whose queries go over a stream. They are not sent once more."""

    def __init__(self, connection: Connection, stream: Stream):
        self._connection = connection
        self._stream = stream
        self.queries = _StreamedQueries(stream)

    def __getattr__(self, name: str):
        return getattr(self._connection, name)

    def call(self, method: Callable, request: object, timeout_s: float | None):
        if method in vars(self.queries).values():
            return method(request, timeout=timeout_s)
        return self._connection.call(method, request, timeout_s)

    def suppose(self, world: str, supposed: tuple[Change, ...], timeout_s: float | None) -> None:
        """Every later query of the stream is answered as if the world had been changed so."""
        overlay = query_pb2.StreamOverlay(
            world=world, changes=changes_to_proto(supposed, "changes")
        )
        self._connection.with_meshes(
            meshes_of(supposed),
            timeout_s,
            lambda: self._stream.evaluate(
                lambda id: _REQUEST(id=id, overlay=overlay).SerializeToString(), timeout_s
            ),
        )
