"""Running sensors and robots: frames and joint states in, what became of them out."""

from __future__ import annotations

import datetime
import queue
import threading
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Iterator, Sequence

import grpc
import numpy as np
import numpy.typing as npt

from cwm import arrays, enums, errors, ingest, objects, poses
from cwm.v1 import geometry_pb2, perception_pb2, robot_pb2

if TYPE_CHECKING:
    from cwm.view import WorldView

_DEPTH_TYPES = {
    np.dtype("<u2"): perception_pb2.DEPTH_TYPE_U16,
    np.dtype("<f4"): perception_pb2.DEPTH_TYPE_F32,
}
# Nanoseconds since 1970 in 64 bits end there. Stamps in other units are far greater.
_MAX_TIME_S = 9e9


@dataclass(frozen=True)
class PixelCounts:
    """Numbers of pixels of a frame by class; docs/live.md says what the classes are."""

    consistent: int
    nearer: int
    farther: int
    missing: int
    robot: int
    carried: int
    mixed: int
    hidden: int


@dataclass(frozen=True)
class FrameChanges:
    """What a frame did to the world, by name; `movers` are objects of the kind MOVER."""

    added: tuple[str, ...]
    moved: tuple[str, ...]
    replaced: tuple[str, ...]
    removed: tuple[str, ...]
    movers: tuple[str, ...]

    def __bool__(self) -> bool:
        """Whether an object was added, moved, replaced or removed."""
        return bool(self.added or self.moved or self.replaced or self.removed)


@dataclass(frozen=True)
class FrameResult:
    """What became of a frame. `reason` ("STALE_FRAME") and `message` say why it was refused, or
    processed with reservations; else they are empty.
    """

    frame: int  # its number in the stream, from 0
    stamp: datetime.datetime
    fate: enums.FrameFate
    reason: str
    message: str
    world_uid: str
    revision: int  # of the world after the frame
    changes: FrameChanges
    pixels: PixelCounts
    pose: np.ndarray = field(compare=False, repr=False)  # X_world_sensor that was used
    robot_state_age_ms: float | None
    stages: dict[str, float] = field(hash=False)  # ms
    interpreting: bool  # a region of the view is interpreted beside the frames
    # In the order in which the frames of all sensors were taken into the world, from 1; 0: it was
    # not processed.
    sequence_number: int


@dataclass(frozen=True)
class SensorMount:
    """The place of a sensor on a robot; pose: X_link_sensor, (4, 4) or (7,), None: the link's."""

    robot: str
    link: str
    pose: npt.ArrayLike | None = field(default=None, compare=False)


@dataclass(frozen=True)
class SensorPoseEstimate:
    """The pose of a sensor that surfaces at rest suggest, and its distance from the used one."""

    pose: np.ndarray = field(compare=False, repr=False)  # X_world_sensor
    translation_error_m: float
    rotation_error_rad: float
    sigma_m: float
    sigma_rad: float
    surface_count: int


@dataclass(frozen=True)
class Sensor:
    """A sensor that streams or has streamed."""

    name: str
    is_streaming: bool
    pose: np.ndarray = field(compare=False, repr=False)  # X_world_sensor of its newest frame
    mount: SensorMount | None
    last_frame: datetime.datetime | None
    frame_rate_hz: float  # of processed frames, over the last seconds
    latency_p50_ms: float
    latency_p95_ms: float
    processed_count: int
    dropped_count: int
    refused_count: int
    estimate: SensorPoseEstimate | None  # None: too few surfaces determine it
    delay_ms: float | None  # between stamps and arrival, the least
    conflicts: tuple[str, ...]  # with other sensors, the greatest first
    estimate_note: str  # why there is no estimate; empty if there is one, or no other sensor


@dataclass(frozen=True)
class RobotStatesSummary:
    """What the server took of a stream of states."""

    world_uid: str
    revision: int
    state_count: int
    ignored_count: int  # whose stamps were known already


def _set_time(message, value: datetime.datetime | float, name: str) -> None:
    """A datetime with a time zone, or seconds since 1970."""
    if isinstance(value, datetime.datetime):
        if value.tzinfo is None:
            raise ValueError(f"{name} is {value!r}, must have a time zone")
        message.FromDatetime(value.astimezone(datetime.timezone.utc))
    else:
        seconds = arrays.number(value, name)
        if abs(seconds) > _MAX_TIME_S:
            raise ValueError(f"{name} is {seconds:g}, must be seconds, at most {_MAX_TIME_S:g}")
        message.FromNanoseconds(round(1e9 * seconds))


def _result(reply: perception_pb2.StreamCloudsResponse) -> FrameResult:
    return FrameResult(
        reply.frame,
        objects.time_from_proto(reply.frame_stamp),
        enums.FrameFate(reply.fate),
        reply.reason,
        reply.message,
        reply.world_uid,
        reply.revision,
        FrameChanges(
            *(tuple(getattr(reply.changes, name)) for name in FrameChanges.__dataclass_fields__)
        ),
        PixelCounts(*(getattr(reply.pixels, name) for name in PixelCounts.__dataclass_fields__)),
        poses.from_proto(reply.x_world_sensor),
        reply.robot_state_age_ms if reply.HasField("robot_state_age_ms") else None,
        {stage.stage: stage.elapsed_ms for stage in reply.stages},
        reply.interpreting,
        reply.sequence_number,
    )


def sensor_from_proto(message: perception_pb2.Sensor) -> Sensor:
    mount = estimate = None
    if message.HasField("mount"):
        x_link_sensor = poses.from_proto(message.mount.x_link_sensor)
        mount = SensorMount(message.mount.robot, message.mount.link, x_link_sensor)
    if message.HasField("estimate"):
        e = message.estimate
        estimate = SensorPoseEstimate(
            poses.from_proto(e.x_world_sensor),
            e.translation_error_m,
            e.rotation_error_rad,
            e.sigma_m,
            e.sigma_rad,
            e.surface_count,
        )
    return Sensor(
        message.name,
        message.is_streaming,
        poses.from_proto(message.x_world_sensor),
        mount,
        objects.time_from_proto(message.last_frame) if message.HasField("last_frame") else None,
        message.frame_rate,
        message.latency_p50_ms,
        message.latency_p95_ms,
        message.processed_count,
        message.dropped_count,
        message.refused_count,
        estimate,
        message.delay_ms if message.HasField("delay_ms") else None,
        tuple(message.conflicts),
        message.estimate_note,
    )


def calibration(
    world: str,
    sensor_name: str,
    intrinsics: npt.ArrayLike,
    *,
    x_world_sensor: npt.ArrayLike | None,
    mount: SensorMount | None,
    sensor: enums.SensorModelLike | float | Sequence[float],
    unit_m: float | None,
    min_range_m: float,
    max_range_m: float,
    pose_sigma: tuple[float, float] | None,
    lockstep: bool,
) -> perception_pb2.SensorCalibration:
    """The calibration without the size and the type of the images."""
    message = perception_pb2.SensorCalibration(
        world=world, sensor=arrays.text(sensor_name, "sensor_name")
    )
    k = np.asarray(arrays.numbers(intrinsics, "intrinsics"), dtype=np.float64)
    if k.shape == (3, 3):
        k = k[[0, 1, 0, 1], [0, 1, 2, 2]]
    if k.shape != (4,):
        raise ValueError(
            f"intrinsics has the shape {k.shape}, must be (4,), fx fy cx cy, or (3, 3)"
        )
    pinhole = message.depth.pinhole
    pinhole.fx_px, pinhole.fy_px, pinhole.cx_px, pinhole.cy_px = arrays.finite(
        k, "intrinsics"
    ).tolist()
    ingest.set_sensor(message, sensor)
    if x_world_sensor is not None:
        message.x_world_sensor.CopyFrom(poses.to_proto(x_world_sensor, "x_world_sensor"))
    if mount is not None:
        message.mount.robot = arrays.text(mount.robot, "mount.robot")
        message.mount.link = arrays.text(mount.link, "mount.link")
        x_link_sensor = np.eye(4) if mount.pose is None else mount.pose
        message.mount.x_link_sensor.CopyFrom(poses.to_proto(x_link_sensor, "mount.pose"))
    if unit_m is not None:
        message.depth.unit_m = arrays.number(unit_m, "unit_m", low=0)
    message.least_range_m = arrays.number(min_range_m, "min_range_m", low=0)
    message.greatest_range_m = arrays.number(max_range_m, "max_range_m", low=0)
    if pose_sigma is not None:
        message.pose_sigma_m, message.pose_sigma_rad = arrays.vector(
            pose_sigma, "pose_sigma", 2
        ).tolist()
    message.lockstep = lockstep
    return message


def _depth_image(depth: npt.ArrayLike) -> np.ndarray:
    """(H, W) uint16 or float32; other floats become float32."""
    if isinstance(depth, np.ma.MaskedArray):
        raise TypeError("depth is a masked array, must be a plain one: set what is masked to 0")
    image = np.asarray(depth)
    if image.dtype.kind == "f":
        image = image.astype("<f4", copy=False)
    if image.dtype.newbyteorder("<") not in _DEPTH_TYPES:
        raise TypeError(f"depth has the type {image.dtype}, must be uint16 or a float")
    if image.ndim != 2 or image.size == 0:
        raise ValueError(f"depth has the shape {image.shape}, must be (H, W)")
    return np.ascontiguousarray(image, dtype=image.dtype.newbyteorder("<"))


class _Outgoing:
    """Requests of a call on their way; the last one is None."""

    def __init__(self) -> None:
        self._queue: queue.SimpleQueue = queue.SimpleQueue()
        self.put = self._queue.put

    def __iter__(self) -> Iterator:
        return iter(self._queue.get, None)


class SensorStream:
    """The frames of one running sensor: `process` sends one and waits for its answer; `send` only
    sends, while the stream, iterated here or in another thread, gives the answers in order.
    Leaving its `with` ends it.

    The newest frame wins: while one is processed at most one waits, and a newer one takes its
    place (FrameFate.DROPPED).
    """

    def __init__(self, view: WorldView, message: Any):
        self._address = view.connection.address
        self._open = view.connection.perception.StreamClouds
        self._calibration = message
        self._outgoing = _Outgoing()
        self._call: grpc.Call | None = None
        self._lock = threading.Lock()
        self._opened = threading.Event()
        self._sent = 0
        self._is_finished = False
        self._is_closed = False

    def __enter__(self) -> SensorStream:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def __iter__(self) -> SensorStream:
        return self

    def send(
        self,
        depth: npt.ArrayLike,
        stamp: datetime.datetime | float,
        x_world_sensor: npt.ArrayLike | None = None,
        *,
        covariance: npt.ArrayLike | None = None,
        exposure_s: float = 0.0,
    ) -> int:
        """Sends a depth image, and returns the number of the frame.

        depth: (H, W), uint16 (0 and 65535: no return) or float32 (0, NaN and infinite: no return)
        along the optical axis; all images of a stream have the first one's shape and type.
        stamp: the middle of the exposure, a datetime with a time zone or seconds since 1970.
        x_world_sensor: the pose at that time of a sensor that moves, (4, 4) or (7,), with
        covariance (6, 6): translation (m), then rotation (rad), in the world's frame.
        """
        image = _depth_image(depth)
        frame = perception_pb2.SensorFrame(depth=image.tobytes())
        _set_time(frame.frame_stamp, stamp, "stamp")
        if exposure_s:
            frame.exposure.FromNanoseconds(
                round(1e9 * arrays.number(exposure_s, "exposure_s", low=0))
            )
        if x_world_sensor is not None:
            frame.x_world_sensor.CopyFrom(poses.to_proto(x_world_sensor, "x_world_sensor"))
        if covariance is not None:
            matrix = arrays.numbers(covariance, "covariance")
            if matrix.shape != (6, 6):
                raise ValueError(f"covariance has the shape {matrix.shape}, must be (6, 6)")
            frame.pose_covariance.extend(arrays.finite(matrix, "covariance").ravel().tolist())
        with self._lock:
            if self._is_finished or self._is_closed:
                raise ValueError("the stream is finished, no more frames can be sent")
            self._begin(image)
            self._outgoing.put(perception_pb2.StreamCloudsRequest(frame=frame))
            self._sent += 1
            return self._sent - 1

    def _begin(self, image: np.ndarray) -> None:
        """Opens the call with the first image, and compares others with it."""
        layout = self._calibration.depth
        height, width = image.shape
        if self._call is None:
            layout.type = _DEPTH_TYPES[image.dtype]
            layout.width, layout.height = width, height
            self._outgoing.put(perception_pb2.StreamCloudsRequest(calibration=self._calibration))
            self._call = self._open(iter(self._outgoing))
            self._opened.set()
        elif (layout.height, layout.width, layout.type) != (
            height,
            width,
            _DEPTH_TYPES[image.dtype],
        ):
            raise ValueError(
                f"depth is {height} x {width} {image.dtype}, must be like the stream's first "
                f"image, {layout.height} x {layout.width}"
            )

    def __next__(self) -> FrameResult:
        self._opened.wait()
        try:
            reply = next(self._call, None) if self._call is not None else None
        except grpc.RpcError as error:
            self._outgoing.put(None)
            if self._is_closed:
                raise StopIteration from None
            raise errors.from_rpc(error, self._address) from None
        if reply is None:
            self._outgoing.put(None)
            raise StopIteration
        return _result(reply)

    def process(
        self,
        depth: npt.ArrayLike,
        stamp: datetime.datetime | float,
        x_world_sensor: npt.ArrayLike | None = None,
        *,
        covariance: npt.ArrayLike | None = None,
        exposure_s: float = 0.0,
    ) -> FrameResult:
        """Sends a frame like `send`, and waits for its answer."""
        number = self.send(
            depth, stamp, x_world_sensor, covariance=covariance, exposure_s=exposure_s
        )
        for result in self:
            if result.frame == number:
                return result
        raise errors.Cancelled("the stream was closed", code=grpc.StatusCode.CANCELLED)

    def finish(self) -> None:
        """No more frames come; those that were sent are still answered."""
        with self._lock:
            self._is_finished = True
            self._outgoing.put(None)
            self._opened.set()

    def close(self) -> None:
        """Ends the stream at once, from any thread: the iterator ends."""
        with self._lock:
            self._is_closed = True
            self._outgoing.put(None)
            if self._call is not None:
                self._call.cancel()
            self._opened.set()


class RobotStateStream:
    """Tells where a robot stands while it moves. Leaving its `with` ends the stream; `finish`
    returns what the server took.
    """

    def __init__(self, view: WorldView, header: Any):
        self._address = view.connection.address
        self._outgoing = _Outgoing()
        self._outgoing.put(robot_pb2.StreamRobotStatesRequest(header=header))
        self._call = view.connection.robots.StreamRobotStates.future(iter(self._outgoing))

    def __enter__(self) -> RobotStateStream:
        return self

    def __exit__(self, kind: type | None, *_: object) -> None:
        if kind is None:
            self.finish()
        else:
            self._outgoing.put(None)
            self._call.cancel()

    def send(
        self,
        stamps: datetime.datetime | float | Sequence[datetime.datetime | float],
        states: npt.ArrayLike,
        poses_of_base: npt.ArrayLike | None = None,
    ) -> None:
        """States (N, dof) in rad or m, or one (dof,), of the stream's variables, with their
        times, each a datetime with a time zone or seconds since 1970. poses_of_base: X_WB,
        (N, 4, 4) or (N, 7), for a base that moves.

        Raises what the server said, if it has ended the stream.
        """
        rows = np.asarray(arrays.rows(states, "states"), dtype="<f8")
        is_one = isinstance(stamps, datetime.datetime) or np.isscalar(stamps)
        times = [stamps] if is_one else list(stamps)
        if len(times) != len(rows):
            raise ValueError(f"stamps are {len(times)}, must be {len(rows)}, one for each state")
        message = robot_pb2.RobotStateRows()
        for i, time in enumerate(times):
            _set_time(message.stamps.add(), time, f"stamps[{i}]")
        message.rows.scalar = geometry_pb2.SCALAR_F64
        message.rows.width = rows.shape[1]
        message.rows.data = rows.tobytes()
        if poses_of_base is not None:
            base = np.asarray(poses.to_rows(poses_of_base, "poses_of_base"), dtype="<f8")
            if len(base) != len(rows):
                raise ValueError(f"poses_of_base are {len(base)}, must be {len(rows)}")
            message.x_world_base.scalar = geometry_pb2.SCALAR_F64
            message.x_world_base.data = base.tobytes()
        if self._call.done():
            self._summary()
            raise ValueError("the stream is finished, no more states can be sent")
        self._outgoing.put(robot_pb2.StreamRobotStatesRequest(states=message))

    def finish(self) -> RobotStatesSummary:
        """Ends the stream; raises what the server refused."""
        self._outgoing.put(None)
        return self._summary()

    def _summary(self) -> RobotStatesSummary:
        try:
            reply = self._call.result()
        except grpc.RpcError as error:
            self._outgoing.put(None)
            raise errors.from_rpc(error, self._address) from None
        return RobotStatesSummary(
            reply.world_uid, reply.revision, reply.state_count, reply.ignored_count
        )
