"""One connection to a server: its calls, their deadline, and bytes in chunks."""

from __future__ import annotations

import hashlib
import time
import uuid
from typing import Callable, Iterable, Iterator, Sequence, TypeVar

import grpc

from cwm import errors, shapes
from cwm.addresses import default_address, prepare_default_address
from cwm.checksums import crc32c
from cwm.v1 import (
    admin_pb2,
    admin_pb2_grpc,
    perception_pb2_grpc,
    query_pb2,
    robot_pb2,
    robot_pb2_grpc,
    world_pb2,
    world_pb2_grpc,
)

Answer = TypeVar("Answer")

CHUNK_BYTES = 1 << 20
# A restarted server is back within this time; then a call is retried once.
_BACK_WITHIN_S = 3.0

_CHANNEL_OPTIONS = [
    # The server limits requests itself; replies with many answers may be large.
    ("grpc.max_receive_message_length", -1),
    ("grpc.max_send_message_length", -1),
    # The server answers pings of idle watches; 30 s detects a lost peer without waking a laptop
    # often.
    ("grpc.keepalive_time_ms", 30_000),
    # HTTP proxies are for the web, not for a local socket.
    ("grpc.enable_http_proxy", 0),
    # Each connection has a socket of its own, so that small calls do not wait behind large ones.
    ("grpc.use_local_subchannel_pool", 1),
    # A restarted local server is back soon.
    ("grpc.initial_reconnect_backoff_ms", 100),
    ("grpc.min_reconnect_backoff_ms", 100),
    ("grpc.max_reconnect_backoff_ms", 2_000),
]


def new_request_id() -> str:
    """Under which the server recognises a retry."""
    return uuid.uuid4().hex


def pieces(data: bytes | memoryview) -> Iterator[tuple[int, bytes]]:
    """Offset and bytes of each chunk."""
    view = memoryview(data)
    for offset in range(0, len(view), CHUNK_BYTES):
        yield offset, bytes(view[offset : offset + CHUNK_BYTES])


class _Queries:
    """The unary methods of QueryService by their names, which take requests as bytes (see
    bulk.py).
    """

    def __init__(self, channel: grpc.Channel):
        service = query_pb2.DESCRIPTOR.services_by_name["QueryService"]
        for method in service.methods:
            if method.name != "StreamQueries":
                answer = getattr(query_pb2, method.output_type.name)
                setattr(
                    self,
                    method.name,
                    channel.unary_unary(
                        f"/{service.full_name}/{method.name}",
                        response_deserializer=answer.FromString,
                    ),
                )


class Connection:
    """Thread-safe. Shared by everything that was made from it."""

    def __init__(self, address: str | None):
        if address is not None and not isinstance(address, str):
            raise TypeError(f'address is {address!r}, must be "unix:PATH" or "HOST:PORT"')
        if not address:
            prepare_default_address()
        self.address = address or default_address()
        self._channel = grpc.insecure_channel(self.address, options=_CHANNEL_OPTIONS)
        self.worlds = world_pb2_grpc.WorldServiceStub(self._channel)
        self.perception = perception_pb2_grpc.PerceptionServiceStub(self._channel)
        self.queries = _Queries(self._channel)
        self._stream_queries = self._channel.stream_stream(
            "/cwm.v1.QueryService/StreamQueries",
            response_deserializer=query_pb2.StreamQueriesResponse.FromString,
        )
        self.robots = robot_pb2_grpc.RobotServiceStub(self._channel)
        # Takes requests as bytes, like the methods of QueryService.
        self.link_poses = self._channel.unary_unary(
            "/cwm.v1.RobotService/GetLinkPoses",
            response_deserializer=robot_pb2.GetLinkPosesResponse.FromString,
        )
        self.admin = admin_pb2_grpc.AdminServiceStub(self._channel)
        self._limits: admin_pb2.Limits | None = None
        self._held: set[str] = set()  # hashes of meshes that were sent
        self._closed = False

    def close(self) -> None:
        self._closed = True
        self._channel.close()

    @property
    def closed(self) -> bool:
        return self._closed

    def limits(self, timeout_s: float | None) -> admin_pb2.Limits:
        """As the server published them when it was asked first."""
        if self._limits is None:
            limits = self.call(
                self.admin.GetServerInfo, admin_pb2.GetServerInfoRequest(), timeout_s
            ).limits
            # Allocates and frees a block of a message's size: afterwards the C library keeps blocks
            # of up to that size instead of returning each to the system, which would double the
            # cost of a batch.
            bytes(limits.max_message_bytes)
            self._limits = limits
        return self._limits

    def call(
        self, method: Callable[..., Answer], request: object, timeout_s: float | None
    ) -> Answer:
        """A call that may be repeated: a query, or a write with a request_id. UNAVAILABLE is
        tried once more.
        """
        return self.repeat(lambda timeout_s: method(request, timeout=timeout_s), timeout_s)

    def repeat(self, attempt: Callable[[float | None], Answer], timeout_s: float | None) -> Answer:
        """`attempt` gets the time that is left, and makes all that it sends anew."""
        self._check_open()
        end = None if timeout_s is None else time.monotonic() + timeout_s
        try:
            return self._run(attempt, timeout_s)
        except errors.Unavailable as error:
            if self._limits is None or not self._is_back(
                error.retry_after_s, end
            ):  # it has never answered, or is away
                raise
        return self._run(attempt, None if end is None else max(0.0, end - time.monotonic()))

    def _is_back(self, retry_after_s: float | None, end: float | None) -> bool:
        """Waits a little for the server; false when it does not come back, or only after the
        time `end`.
        """
        pause_s = retry_after_s or 0
        time.sleep(pause_s if end is None else max(0.0, min(pause_s, end - time.monotonic())))
        wait_s = _BACK_WITHIN_S if end is None else min(_BACK_WITHIN_S, end - time.monotonic())
        try:
            grpc.channel_ready_future(self._channel).result(timeout=max(0.0, wait_s))
        except grpc.FutureTimeoutError:
            return False
        return True

    def _run(self, attempt: Callable[[float | None], Answer], timeout_s: float | None) -> Answer:
        try:
            return attempt(timeout_s)
        except grpc.RpcError as error:
            raise errors.from_rpc(error, self.address) from None

    def _check_open(self) -> None:
        if self._closed:
            raise ValueError(f"the connection to {self.address} is closed")

    def stream(
        self, method: Callable[..., Iterable[Answer]], request: object, timeout_s: float | None
    ) -> Iterator[Answer]:
        """The messages of a call that streams; not repeated."""
        self._check_open()
        try:
            yield from method(request, timeout=timeout_s)
        except grpc.RpcError as error:
            raise errors.from_rpc(error, self.address) from None

    def open_queries(self, requests: Iterator[bytes]) -> Iterable[query_pb2.StreamQueriesResponse]:
        """The call StreamQueries, of requests as bytes; iterating it raises grpc.RpcError."""
        self._check_open()
        return self._stream_queries(requests)

    def read_blob(self, request: world_pb2.ReadGeometryRequest, timeout_s: float | None) -> bytes:
        """Whole, and what its hash says."""

        def read(left_s: float | None) -> tuple[bytes, str]:
            parts, expected = [], request.hash
            for answer in self.worlds.ReadGeometry(request, timeout=left_s):
                if answer.HasField("header"):
                    expected = answer.header.hash
                parts.append(answer.data)
            return b"".join(parts), expected

        data, expected = self.repeat(read, timeout_s)
        if hashlib.sha256(data).hexdigest() != expected:
            raise errors.DataLoss(
                f"geometry {expected} arrived with another hash", code=grpc.StatusCode.DATA_LOSS
            )
        return data

    def write_mesh(self, mesh: shapes.Mesh, timeout_s: float | None) -> None:
        blob = mesh.blob

        def messages() -> Iterator[world_pb2.WriteGeometryRequest]:
            header = world_pb2.WriteGeometryRequest.Header(
                format=world_pb2.GEOMETRY_FORMAT_MESH_F64, total_bytes=len(blob), hash=mesh.hash
            )
            yield world_pb2.WriteGeometryRequest(header=header)
            for offset, data in pieces(blob):
                chunk = world_pb2.WriteGeometryRequest.Chunk(offset=offset, data=data)
                yield world_pb2.WriteGeometryRequest(chunk=chunk)

        self.repeat(lambda left_s: self.worlds.WriteGeometry(messages(), timeout=left_s), timeout_s)
        self._held.add(mesh.hash)

    def with_meshes(
        self, meshes: Sequence[shapes.Mesh], timeout_s: float | None, query: Callable[[], Answer]
    ) -> Answer:
        """Runs `query` once the server holds the meshes, and once more if it has lost those that
        were sent before.
        """
        for mesh in meshes:
            if mesh.hash not in self._held:
                self.write_mesh(mesh, timeout_s)
        try:
            return query()
        except errors.Error as error:
            if error.reason != "GEOMETRY_UNKNOWN" or not meshes:
                raise
        for mesh in meshes:
            self.write_mesh(mesh, timeout_s)
        return query()


def upload_chunks(
    data: bytes | memoryview, make: Callable[[int, bytes, int], Answer]
) -> Iterator[Answer]:
    """A message of offset, bytes and CRC-32C for each chunk."""
    for offset, piece in pieces(data):
        yield make(offset, piece, crc32c(piece))
