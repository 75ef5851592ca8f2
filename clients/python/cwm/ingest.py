"""Scans: an array of points in, what the world made of it out."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Iterator, Sequence

import numpy as np
import numpy.typing as npt

from cwm import arrays, enums, objects, poses
from cwm.connection import upload_chunks
from cwm.v1 import perception_pb2, world_pb2

if TYPE_CHECKING:
    from cwm.view import WorldView

_LAST_SUPPORT_LABEL = 9
_FIELD_TYPES = {4: perception_pb2.FIELD_TYPE_F32, 8: perception_pb2.FIELD_TYPE_F64}


@dataclass(frozen=True)
class IngestReport:
    """Points by what became of them."""

    points_in: int
    points_finite: int
    points_explained: int
    points_rejected: int
    warnings: tuple[str, ...]
    # The view did not change since it was interpreted: the known objects were returned, and nothing
    # was interpreted.
    unchanged_view: bool = False


@dataclass(frozen=True)
class IngestChanges:
    """What the scan did to the world, by name."""

    added: tuple[str, ...]
    moved: tuple[str, ...]
    replaced: tuple[str, ...]
    removed: tuple[str, ...]
    kept: tuple[str, ...]
    occluded: tuple[str, ...]


@dataclass(frozen=True)
class IngestResult:
    """What the world holds of a scan, at `revision`.

    labels: (N,) uint32, one a point in the order given (row by row of an organised cloud), or None
    when none were wanted. 0 is unexplained, 1 to 9 the supports (the tenth and later share 9),
    object i (from 1) has 10 * (i + 1) + part.
    """

    world_uid: str  # empty: no world holds it (SEGMENT_ONLY)
    revision: int
    pose: np.ndarray = field(compare=False, repr=False)  # X_world_sensor, given or estimated
    report: IngestReport
    supports: tuple[objects.Object, ...] = field(repr=False)
    objects: tuple[objects.Object, ...] = field(repr=False)
    changes: IngestChanges
    stages: dict[str, float] = field(hash=False)  # ms
    labels: np.ndarray | None = field(default=None, compare=False, repr=False)

    def mask(self, item: objects.Object | str) -> np.ndarray:
        """(N,) bool: the points of a support or an object of this result. KeyError for any
        other.
        """
        if self.labels is None:
            raise ValueError("labels were not asked for: ingest(..., labels=True)")
        # An object explained by a user's object has no name.
        def is_meant(other: objects.Object) -> bool:
            if isinstance(item, str):
                return other.name == item != ""
            return other is item or other.name == item.name != ""

        for i, support in enumerate(self.supports):
            if is_meant(support):
                return self.labels == min(i + 1, _LAST_SUPPORT_LABEL)
        for i, other in enumerate(self.objects):
            if is_meant(other):
                return self.labels // 10 == i + 2
        name = item if isinstance(item, str) else item.name
        raise KeyError(f"{name!r} is none of the supports and objects of this scan")


def _cloud(points: npt.ArrayLike, normals: npt.ArrayLike | None) -> tuple[np.ndarray, int, int]:
    """(N, 3) or (N, 6) numbers, not all finite, width and height."""
    cloud = arrays.numbers(points, "points")
    if cloud.ndim not in (2, 3) or cloud.shape[-1] != 3:
        raise ValueError(f"points has the shape {cloud.shape}, must be (N, 3) or (H, W, 3)")
    if cloud.size == 0:
        raise ValueError(f"points has the shape {cloud.shape}, must have at least one point")
    height, width = cloud.shape[:2] if cloud.ndim == 3 else (1, cloud.shape[0])
    if normals is not None:
        other = arrays.numbers(normals, "normals")
        if other.shape != cloud.shape:
            raise ValueError(
                f"normals has the shape {other.shape}, must be that of points, {cloud.shape}"
            )
        kind = np.promote_types(cloud.dtype, other.dtype)
        cloud = np.concatenate([cloud.astype(kind), other.astype(kind)], axis=-1)
    cloud = cloud.reshape(-1, cloud.shape[-1])
    if not np.isfinite(cloud[:, :3]).all(axis=1).any():
        raise ValueError(f"points has {len(cloud)} points, at least one must be finite")
    return np.ascontiguousarray(cloud), width, height


def make_header(
    points: npt.ArrayLike, normals: npt.ArrayLike | None
) -> tuple[perception_pb2.IngestCloudHeader, np.ndarray]:
    """A header with the layout of the cloud, and the cloud as it travels."""
    cloud, width, height = _cloud(points, normals)
    header = perception_pb2.IngestCloudHeader(
        point_count=len(cloud), total_bytes=cloud.nbytes, width=width, height=height
    )
    size = cloud.dtype.itemsize
    header.layout.point_step = size * cloud.shape[1]
    for i, name in enumerate(("x", "y", "z", "normal_x", "normal_y", "normal_z")[: cloud.shape[1]]):
        header.layout.fields.add(name=name, offset=i * size, type=_FIELD_TYPES[size])
    return header, cloud


def set_sensor(
    header: perception_pb2.IngestCloudHeader,
    sensor: enums.SensorModelLike | float | Sequence[float],
) -> None:
    """A model by its name, the standard deviation of a constant noise in metres, or a and b of
    a + b z^2.
    """
    if isinstance(sensor, (str, enums.SensorModel)):
        header.sensor_model.kind = enums.word(enums.SensorModel, sensor, "sensor")
        return
    if np.ndim(sensor) == 1:
        a_m, b_per_m = arrays.vector(sensor, "sensor", 2).tolist()
        if a_m < 0 or b_per_m < 0 or a_m + b_per_m == 0:
            raise ValueError(f"sensor is {sensor!r}, a and b must be at least 0, not both 0")
        header.sensor_model.kind = perception_pb2.SensorModel.KIND_QUADRATIC
        header.sensor_model.sigma_m, header.sensor_model.quadratic_per_m = a_m, b_per_m
        return
    sigma_m = arrays.number(sensor, "sensor")
    if sigma_m <= 0:
        raise ValueError(
            f"sensor is {sensor!r}, must be the name of a model or a standard deviation above 0 m"
        )
    header.sensor_model.kind = perception_pb2.SensorModel.KIND_CONSTANT
    header.sensor_model.sigma_m = sigma_m


def set_pose(
    header: perception_pb2.IngestCloudHeader,
    x_world_sensor: npt.ArrayLike | None,
    up: npt.ArrayLike | None,
) -> None:
    if x_world_sensor is not None:
        header.x_world_sensor.CopyFrom(poses.to_proto(x_world_sensor, "x_world_sensor"))
    if up is not None:
        header.up.x, header.up.y, header.up.z = arrays.vector(up, "up").tolist()


def set_viewpoint(
    header: perception_pb2.IngestCloudHeader, viewpoint: npt.ArrayLike | None
) -> None:
    if viewpoint is not None:
        place = arrays.vector(viewpoint, "viewpoint").tolist()
        header.viewpoint.x, header.viewpoint.y, header.viewpoint.z = place


def messages(
    header: perception_pb2.IngestCloudHeader, cloud: np.ndarray
) -> Iterator[perception_pb2.IngestCloudRequest]:
    """Header, chunks, finish."""
    data = memoryview(cloud).cast("B")
    yield perception_pb2.IngestCloudRequest(header=header)
    yield from upload_chunks(
        data,
        lambda offset, piece, crc: perception_pb2.IngestCloudRequest(
            chunk=perception_pb2.CloudChunk(offset=offset, data=piece, crc32c=crc)
        ),
    )
    digest = hashlib.sha256(data).hexdigest()
    yield perception_pb2.IngestCloudRequest(finish=perception_pb2.CloudFinish(sha256=digest))


def labels_of(reply: perception_pb2.IngestCloudResponse, view: WorldView) -> np.ndarray | None:
    data = reply.labels
    if reply.labels_hash:
        data = view.connection.read_blob(
            world_pb2.ReadGeometryRequest(hash=reply.labels_hash), view.timeout_s
        )
    return np.frombuffer(data, dtype="<u4") if data else None


def result_of(
    reply: perception_pb2.IngestCloudResponse, view: WorldView | None, labels: np.ndarray | None
) -> IngestResult:
    """`view` is the world at the reply's revision, None where no world holds the result."""

    def several(items) -> tuple[objects.Object, ...]:
        return tuple(
            objects.object_from_proto(item, reply.revision, view if item.name else None)
            for item in items
        )

    report, changes = reply.report, reply.changes
    return IngestResult(
        reply.world_uid,
        reply.revision,
        poses.from_proto(reply.x_world_sensor),
        IngestReport(
            report.points_in,
            report.points_finite,
            report.points_explained,
            report.points_rejected,
            tuple(report.warnings),
            report.unchanged_view,
        ),
        several(reply.supports),
        several(reply.objects),
        IngestChanges(
            *(tuple(getattr(changes, name)) for name in IngestChanges.__dataclass_fields__)
        ),
        {stage.stage: stage.elapsed_ms for stage in reply.stages},
        labels,
    )
