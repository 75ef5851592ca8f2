"""Objects of a world as values. Poses are (4, 4) arrays X_a_b: the frame b in the frame a,
metres.
"""

from __future__ import annotations

import datetime
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from cwm import display, enums, poses, shapes
from cwm.v1 import world_pb2

if TYPE_CHECKING:
    from cwm.view import WorldView

# PCL's names of a model's coefficients, in the object's frame.
_COEFFICIENTS: dict[str, tuple[str, ...]] = {
    "half_space": ("normal_x", "normal_y", "normal_z", "d"),
    "plate": ("normal_x", "normal_y", "normal_z", "d"),
    "sphere": ("center_x", "center_y", "center_z", "radius"),
    "cylinder": (
        "point_on_axis_x",
        "point_on_axis_y",
        "point_on_axis_z",
        "axis_direction_x",
        "axis_direction_y",
        "axis_direction_z",
        "radius",
    ),
    "cone": (
        "apex_x",
        "apex_y",
        "apex_z",
        "axis_direction_x",
        "axis_direction_y",
        "axis_direction_z",
        "half_angle_rad",
    ),
}


@dataclass(frozen=True)
class FitQuality:
    """How well a fitted shape explains its points."""

    rms_m: float
    max_residual_m: float
    inlier_count: int
    inlier_ratio: float
    observed_fraction: float
    # One standard deviation of each coefficient, in their order; for a box, of its three sizes.
    # Empty: unknown.
    parameter_sigma: tuple[float, ...]


@dataclass(frozen=True)
class Vessel:
    """An open vessel: a solid of revolution about z with a wall, a rim and a floor, the foot at
    z = -height/2.
    """

    rim_radius_m: float
    foot_radius_m: float
    height_m: float
    depth_m: float
    wall_thickness_m: float
    rim_radius_sigma_m: float | None
    wall_thickness_sigma_m: float | None
    # (K, 2): distance from the axis and z, up the outside and down the inside.
    outer_profile: np.ndarray = field(compare=False, repr=False)
    inner_profile: np.ndarray = field(compare=False, repr=False)


@dataclass(frozen=True)
class Part:
    """A shape of an object."""

    shape: shapes.Shape
    pose: np.ndarray = field(compare=False, repr=False)  # X_object_shape
    role: enums.PartRole = enums.PartRole.FITTED
    # By PCL's names, in the object's frame; empty if PCL has no such model.
    coefficients: dict[str, float] = field(default_factory=dict, hash=False)
    fit: FitQuality | None = None  # None: a user gave the shape
    vessel: Vessel | None = None
    # Space in the object's frame that no sensor saw and into which the part may extend.
    hidden: "OrientedBox | None" = None


@dataclass(frozen=True)
class Surface:
    """A measured mesh of an object; `World.mesh` reads its triangles by the hash."""

    hash: str
    vertex_count: int
    triangle_count: int
    watertight: bool
    point_count: int


@dataclass(frozen=True)
class OrientedBox:
    """A box in an object's frame, centred at `pose`."""

    size_m: tuple[float, float, float]
    pose: np.ndarray = field(compare=False, repr=False)  # X_object_box


@dataclass(frozen=True)
class Handle:
    """A part of an object by which it can be held."""

    shape_index: int  # of the part that it grew from; -1: a surface carries it
    point_count: int
    axis: tuple[float, float, float]  # unit, object's frame
    bounds: OrientedBox
    hash: str  # of its mesh; empty: none


@dataclass(frozen=True)
class Attachment:
    """What an object is attached by: it moves with the link."""

    robot: str
    link: str
    pose: np.ndarray = field(compare=False, repr=False)  # X_link_object
    touch_links: tuple[str, ...] = ()


@dataclass(frozen=True, repr=False)
class Object:
    """Something of a world, as of `world_revision`. `pose` is X_WO, the object in the world."""

    name: str
    uid: str
    kind: enums.ObjectKind
    owner: enums.Owner
    state: enums.ObjectState
    pose: np.ndarray = field(compare=False, repr=False)
    parts: tuple[Part, ...]
    surfaces: tuple[Surface, ...]
    handles: tuple[Handle, ...]
    supported_by: str
    bounds: OrientedBox | None  # None: unbounded
    point_count: int
    create_revision: int
    geometry_revision: int
    pose_revision: int
    last_observed: datetime.datetime | None
    margin_m: float
    attachment: Attachment | None
    reachable: bool | None  # of supports; None: not known
    world_revision: int
    motion: enums.Motion = enums.Motion.NOT_FOLLOWED
    visibility: enums.Visibility = enums.Visibility.NOT_FOLLOWED
    # False: it may have been swapped with an object of the same shape. None: not followed.
    identity_certain: bool | None = None
    carried_by: str = ""  # "robot/link" that it moves with though it is not attached
    _view: WorldView | None = field(default=None, compare=False, repr=False)

    def __repr__(self) -> str:
        return display.object_line(self)

    def _repr_html_(self) -> str:
        return display.object_html(self)

    @property
    def position(self) -> np.ndarray:
        """(3,) of the object's origin in the world, metres."""
        return self.pose[:3, 3]

    @property
    def revision(self) -> int:
        """What a change may expect it to be (`expected_revision`)."""
        return max(self.pose_revision, self.geometry_revision)

    def mesh(self) -> tuple[np.ndarray, np.ndarray]:
        """All that the object is made of as one mesh in its own frame: vertices (V, 3) float64,
        triangles (T, 3) uint32.

        FailedPrecondition for an object with a half-space, RevisionCompacted when the object was
        read too long ago.
        """
        if self._view is None:
            raise ValueError(
                f"{self.name} was provisional: no world holds it, and nobody knows its mesh"
            )
        return self._view.surface(self.name)


def _oriented_box(message) -> OrientedBox:
    box = message.box
    return OrientedBox(
        (box.size_x_m, box.size_y_m, box.size_z_m), poses.from_proto(message.x_object_box)
    )


def _optional(message, name: str) -> float | None:
    return getattr(message, name) if message.HasField(name) else None


def _vessel(message) -> Vessel:
    def profile(vertices) -> np.ndarray:
        return np.array([(vertex.x, vertex.y) for vertex in vertices]).reshape(-1, 2)

    return Vessel(
        message.rim_radius_m,
        message.foot_radius_m,
        message.height_m,
        message.depth_m,
        message.wall_thickness_m,
        _optional(message, "rim_radius_sigma_m"),
        _optional(message, "wall_thickness_sigma_m"),
        profile(message.outer_profile),
        profile(message.inner_profile),
    )


def part_from_proto(message: world_pb2.ShapePart) -> Part:
    fit = None
    if message.HasField("fit"):
        f = message.fit
        fit = FitQuality(
            f.rms_m,
            f.max_residual_m,
            f.inlier_count,
            f.inlier_ratio,
            f.observed_fraction,
            tuple(f.parameter_sigma),
        )
    names = _COEFFICIENTS.get(message.WhichOneof("shape"), ())
    return Part(
        shapes.shape_from_proto(message),
        poses.from_proto(message.x_object_shape),
        enums.PartRole(message.role or enums.PartRole.FITTED),
        dict(zip(names, message.coefficients)),
        fit,
        _vessel(message.vessel) if message.HasField("vessel") else None,
        _oriented_box(message.hidden) if message.HasField("hidden") else None,
    )


def attachment_from_proto(message: world_pb2.Attachment) -> Attachment:
    return Attachment(
        message.robot,
        message.link,
        poses.from_proto(message.x_link_object),
        tuple(message.touch_links),
    )


def time_from_proto(message) -> datetime.datetime:
    return message.ToDatetime(tzinfo=datetime.timezone.utc)


def object_from_proto(message: world_pb2.Object, revision: int, view: WorldView | None) -> Object:
    """`view` is the world at the revision; None for one that no world holds."""
    return Object(
        name=message.name,
        uid=message.uid,
        kind=enums.ObjectKind(message.kind),
        owner=enums.Owner(message.owner),
        state=enums.ObjectState(message.state),
        pose=poses.from_proto(message.x_world_object),
        parts=tuple(part_from_proto(part) for part in message.shapes),
        surfaces=tuple(
            Surface(s.hash, s.vertex_count, s.triangle_count, s.watertight, s.point_count)
            for s in message.surfaces
        ),
        handles=tuple(
            Handle(
                h.shape_index,
                h.point_count,
                (h.axis.x, h.axis.y, h.axis.z),
                _oriented_box(h.bounds),
                h.hash,
            )
            for h in message.handles
        ),
        supported_by=message.supported_by,
        bounds=_oriented_box(message.bounds) if message.HasField("bounds") else None,
        point_count=message.point_count,
        create_revision=message.create_revision,
        geometry_revision=message.geometry_revision,
        pose_revision=message.pose_revision,
        last_observed=time_from_proto(message.last_observed)
        if message.HasField("last_observed")
        else None,
        margin_m=message.margin_m,
        attachment=attachment_from_proto(message.attachment)
        if message.HasField("attachment")
        else None,
        reachable=message.reachable if message.HasField("reachable") else None,
        motion=enums.Motion(message.motion),
        visibility=enums.Visibility(message.visibility),
        identity_certain=message.identity_certain
        if message.HasField("identity_certain")
        else None,
        carried_by=message.carried_by,
        world_revision=revision,
        _view=view,
    )
