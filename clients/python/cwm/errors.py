"""What a call raises: one class for each kind of failure, with what the server said about it.

`Error` is the base of all of them. Arrays that cannot be right are refused before anything is sent,
by ValueError or TypeError that name the argument.
"""

from __future__ import annotations

from dataclasses import dataclass

import grpc
from google.protobuf.message import DecodeError

from cwm.v1 import error_details_pb2, query_pb2

_DETAILS_KEY = "grpc-status-details-bin"


@dataclass(frozen=True)
class FieldViolation:
    """A field of the request that the server refused, and the rule that it breaks."""

    field: str
    description: str


class Error(Exception):
    """A call that failed.

    code: the gRPC status code, `reason`: a stable word for programs ("OBJECT_UNKNOWN"), `message`:
    a sentence for people, `metadata`: names and values that belong to the reason, `fields`: what
    was wrong in the request, `retry_after_s`: when the server wants to be asked again, or None.
    """

    def __init__(
        self,
        message: str,
        *,
        code: grpc.StatusCode = grpc.StatusCode.UNKNOWN,
        reason: str = "",
        metadata: dict[str, str] | None = None,
        fields: tuple[FieldViolation, ...] = (),
        retry_after_s: float | None = None,
    ):
        super().__init__(message)
        self.message = message
        self.code = code
        self.reason = reason
        self.metadata = metadata or {}
        self.fields = fields
        self.retry_after_s = retry_after_s

    def __str__(self) -> str:
        return f"{self.message} ({self.reason or self.code.name})"


class Cancelled(Error):
    """The call was cancelled."""


class InvalidArgument(Error):
    """The server refused what was asked; `fields` says which fields and by which rules."""


class NotFound(Error):
    """The world, object, robot or geometry is not there."""


class Aborted(Error):
    """Something else happened first."""


class RevisionConflict(Aborted):
    """The world, the object or the robot has another revision than the one expected. Nothing was
    changed.
    """


class FailedPrecondition(Error):
    """The world is not in a state that allows this."""


class WorldReplaced(FailedPrecondition):
    """The world of that name is another one by now: it was deleted, or the server lost its
    memory.
    """


class ScanRefused(FailedPrecondition):
    """The scan contradicts the world: another unit, another pose of its sensor. Nothing was changed;
    `ingest(..., force=True)` takes it all the same.
    """


class OutOfRange(Error):
    """A revision that is in the future, or no longer kept."""


class RevisionCompacted(OutOfRange):
    """The server no longer keeps that revision."""


class DeadlineExceeded(Error):
    """The timeout of the call struck."""


class ResourceExhausted(Error):
    """The server has too much to do, or a limit was met; `retry_after_s` where waiting helps."""


class Unavailable(Error):
    """No server answers at the address, or it is shutting down."""


class PermissionDenied(Error):
    """The server does not serve this caller, or another user could answer in its place."""


class DataLoss(Error):
    """Bytes arrived that are not those that were sent."""


class Internal(Error):
    """A fault of the server."""


_BY_CODE: dict[grpc.StatusCode, type[Error]] = {
    grpc.StatusCode.CANCELLED: Cancelled,
    grpc.StatusCode.INVALID_ARGUMENT: InvalidArgument,
    grpc.StatusCode.NOT_FOUND: NotFound,
    grpc.StatusCode.ABORTED: Aborted,
    grpc.StatusCode.FAILED_PRECONDITION: FailedPrecondition,
    grpc.StatusCode.OUT_OF_RANGE: OutOfRange,
    grpc.StatusCode.DEADLINE_EXCEEDED: DeadlineExceeded,
    grpc.StatusCode.RESOURCE_EXHAUSTED: ResourceExhausted,
    grpc.StatusCode.UNAVAILABLE: Unavailable,
    grpc.StatusCode.PERMISSION_DENIED: PermissionDenied,
    grpc.StatusCode.UNAUTHENTICATED: PermissionDenied,
    grpc.StatusCode.DATA_LOSS: DataLoss,
    grpc.StatusCode.INTERNAL: Internal,
}

_CODES = {code.value[0]: code for code in grpc.StatusCode}

_BY_REASON: dict[str, type[Error]] = {
    "REVISION_MISMATCH": RevisionConflict,
    "OBJECT_REVISION_MISMATCH": RevisionConflict,
    "REVISION_COMPACTED": RevisionCompacted,
    "WORLD_REPLACED": WorldReplaced,
    "SCAN_CONTRADICTS_WORLD": ScanRefused,
}


def _details_of(error: grpc.RpcError) -> dict:
    """What the trailing metadata of the call carries, as arguments of Error."""
    packed = error_details_pb2.Status()
    trailing = error.trailing_metadata() if hasattr(error, "trailing_metadata") else None
    for key, value in trailing or ():
        if key == _DETAILS_KEY:
            try:
                packed.ParseFromString(value)
            except DecodeError:
                return {}
    details: dict = {}
    for item in packed.details:
        # The standard types are read by our own messages with the same field numbers, so only the
        # name is compared.
        name = item.type_url.rpartition("/")[2]
        if name == "google.rpc.ErrorInfo":
            info = error_details_pb2.ErrorInfo.FromString(item.value)
            details["reason"] = info.reason
            details["metadata"] = dict(info.metadata)
        elif name == "google.rpc.BadRequest":
            request = error_details_pb2.BadRequest.FromString(item.value)
            details["fields"] = tuple(
                FieldViolation(v.field, v.description) for v in request.field_violations
            )
        elif name == "google.rpc.RetryInfo":
            delay = error_details_pb2.RetryInfo.FromString(item.value).retry_delay
            details["retry_after_s"] = delay.seconds + 1e-9 * delay.nanos
    return details


def from_query_error(message: query_pb2.QueryError) -> Error:
    """The error that stands in a stream in place of an answer."""
    code = _CODES.get(message.code, grpc.StatusCode.UNKNOWN)
    kind = _BY_REASON.get(message.reason) or _BY_CODE.get(code, Error)
    delay = message.retry_delay
    return kind(
        message.message,
        code=code,
        reason=message.reason,
        metadata=dict(message.metadata),
        fields=tuple(FieldViolation(f.field, f.description) for f in message.fields),
        retry_after_s=delay.seconds + 1e-9 * delay.nanos
        if message.HasField("retry_delay")
        else None,
    )


def from_rpc(error: grpc.RpcError, address: str) -> Error:
    """The error that a failed call stands for."""
    code = error.code()
    details = _details_of(error)
    kind = _BY_REASON.get(details.get("reason", "")) or _BY_CODE.get(code, Error)
    message = error.details() or code.name
    if code == grpc.StatusCode.UNAVAILABLE and not details:
        message = f"no cwm-server answers at {address}: {message}"
    return kind(message, code=code, **details)
