"""Shapes: what objects are made of and what queries are asked with. Each lies in its own
frame, metres.
"""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, field
from typing import Sequence, Union

import numpy as np
import numpy.typing as npt

from cwm import arrays, poses
from cwm.v1 import geometry_pb2


def _positive(shape: object, *names: str) -> None:
    kind = type(shape).__name__
    for name in names:
        value = arrays.number(getattr(shape, name), f"{kind}.{name}")
        if value <= 0:
            raise ValueError(f"{kind}.{name} is {value:g}, must be greater than 0")


@dataclass(frozen=True)
class Sphere:
    """Centred at the origin."""

    radius_m: float

    def __post_init__(self) -> None:
        _positive(self, "radius_m")


@dataclass(frozen=True)
class Box:
    """Centred at the origin, edges along the axes."""

    size_x_m: float
    size_y_m: float
    size_z_m: float

    def __post_init__(self) -> None:
        _positive(self, "size_x_m", "size_y_m", "size_z_m")


@dataclass(frozen=True)
class Cylinder:
    """Centred at the origin, axis z."""

    radius_m: float
    length_m: float

    def __post_init__(self) -> None:
        _positive(self, "radius_m", "length_m")


@dataclass(frozen=True)
class Cone:
    """Axis z, centred: the bottom disc at z = -length/2, the top disc at z = +length/2. One
    radius may be 0.
    """

    radius_bottom_m: float
    radius_top_m: float
    length_m: float

    def __post_init__(self) -> None:
        arrays.number(self.radius_bottom_m, "Cone.radius_bottom_m", low=0)
        arrays.number(self.radius_top_m, "Cone.radius_top_m", low=0)
        _positive(self, "length_m")


@dataclass(frozen=True)
class Capsule:
    """All points within radius of a segment on z, centred; the length is the one between the two
    centres.
    """

    radius_m: float
    length_m: float

    def __post_init__(self) -> None:
        _positive(self, "radius_m", "length_m")


@dataclass(frozen=True)
class HalfSpace:
    """Solid where z <= 0."""


@dataclass(frozen=True)
class Plate:
    """Solid for -thickness <= z <= 0 inside the outline and outside of the holes; each a
    sequence of (x, y).
    """

    outline: tuple[tuple[float, float], ...]
    thickness_m: float
    holes: tuple[tuple[tuple[float, float], ...], ...] = ()

    def __post_init__(self) -> None:
        def corners(value: npt.ArrayLike, name: str) -> tuple[tuple[float, float], ...]:
            return tuple((float(x), float(y)) for x, y in arrays.rows(value, name, 2))

        _positive(self, "thickness_m")
        object.__setattr__(self, "outline", corners(self.outline, "Plate.outline"))
        object.__setattr__(
            self,
            "holes",
            tuple(corners(hole, f"Plate.holes[{i}]") for i, hole in enumerate(self.holes)),
        )


@dataclass(frozen=True)
class Mesh:
    """Triangles: solid if watertight, else a surface. They need not share vertices, as STL has it.

    vertices (V, 3) metres and triangles (T, 3) indices, or the hash alone of one that the server
    holds, whose triangles `World.mesh` reads. Meshes are equal when their hashes are.
    """

    vertices: np.ndarray | None = field(default=None, compare=False, repr=False)
    triangles: np.ndarray | None = field(default=None, compare=False, repr=False)
    hash: str = ""

    def __post_init__(self) -> None:
        if self.vertices is None and self.triangles is None:
            if not self.hash:
                raise ValueError(f"{type(self).__name__} needs vertices and triangles, or a hash")
            return
        vertices, triangles = check_mesh(self.vertices, self.triangles)
        object.__setattr__(self, "vertices", vertices)
        object.__setattr__(self, "triangles", triangles)
        object.__setattr__(
            self, "hash", hashlib.sha256(mesh_bytes(vertices, triangles)).hexdigest()
        )

    @property
    def blob(self) -> bytes | None:
        """What the server has to hold under the hash; None when only the hash is known here."""
        return None if self.vertices is None else mesh_bytes(self.vertices, self.triangles)


@dataclass(frozen=True)
class Convex(Mesh):
    """The convex hull of a mesh's vertices."""


Shape = Union[Sphere, Box, Cylinder, Cone, Capsule, HalfSpace, Plate, Convex, Mesh]
"""A shape in its own frame, metres."""

# Names of the oneof's fields in the messages.
_FIELDS: dict[type, str] = {
    Sphere: "sphere",
    Box: "box",
    Cylinder: "cylinder",
    Cone: "cone",
    Capsule: "capsule",
    HalfSpace: "half_space",
    Plate: "plate",
    Convex: "convex",
    Mesh: "mesh",
}


@dataclass(frozen=True)
class Placed:
    """A shape in the frame of a body: pose is X_body_shape, (4, 4) or (7,)."""

    shape: Shape
    pose: np.ndarray = field(default_factory=lambda: np.eye(4), compare=False)


def check_mesh(vertices: npt.ArrayLike, triangles: npt.ArrayLike) -> tuple[np.ndarray, np.ndarray]:
    """Vertices (V, 3) float64 and triangles (T, 3) uint32, each corner a vertex."""
    points = arrays.rows(vertices, "vertices", 3).astype("<f8")
    corners = np.asarray(triangles)
    if corners.dtype.kind not in "iu":
        raise TypeError(f"triangles has the type {corners.dtype}, must be whole numbers")
    if corners.ndim != 2 or corners.shape[1] != 3 or not len(corners):
        raise ValueError(
            f"triangles has the shape {corners.shape}, must be (T, 3) with at least one row"
        )
    bad = np.argwhere((corners < 0) | (corners >= len(points)))
    if bad.size:
        row, column = bad[0]
        raise ValueError(
            f"triangles[{row}, {column}] is {corners[row, column]}, must be 0 to {len(points) - 1}"
        )
    return points, np.ascontiguousarray(corners, dtype="<u4")


def mesh_bytes(vertices: np.ndarray, triangles: np.ndarray) -> bytes:
    """As meshes travel and are hashed: GEOMETRY_FORMAT_MESH_F64."""
    counts = np.array([len(vertices), len(triangles)], dtype="<u4")
    return counts.tobytes() + vertices.tobytes() + triangles.tobytes()


def mesh_from_bytes(data: bytes) -> tuple[np.ndarray, np.ndarray]:
    vertex_count, triangle_count = np.frombuffer(data, dtype="<u4", count=2).tolist()
    vertices = np.frombuffer(data, dtype="<f8", count=3 * vertex_count, offset=8)
    triangles = np.frombuffer(
        data, dtype="<u4", count=3 * triangle_count, offset=8 + 24 * vertex_count
    )
    return vertices.reshape(-1, 3), triangles.reshape(-1, 3)


def _polygon(corners: Sequence[tuple[float, float]]) -> geometry_pb2.Polygon:
    return geometry_pb2.Polygon(vertices=[geometry_pb2.Vector2(x=x, y=y) for x, y in corners])


def set_shape(shape: Shape, message) -> None:
    """Sets the oneof `shape` of a PlacedShape or a ShapePart."""
    name = _FIELDS.get(type(shape))
    if name is None:
        raise TypeError(
            f"shape is {shape!r}, must be one of {', '.join(kind.__name__ for kind in _FIELDS)}"
        )
    target = getattr(message, name)
    target.SetInParent()
    if isinstance(shape, Plate):
        target.outline.CopyFrom(_polygon(shape.outline))
        target.holes.extend(_polygon(hole) for hole in shape.holes)
        target.thickness_m = shape.thickness_m
    elif isinstance(shape, Mesh):
        target.hash = shape.hash
    else:
        for key, value in vars(shape).items():
            setattr(target, key, value)


def shape_from_proto(message) -> Shape:
    """The oneof `shape` of a PlacedShape or a ShapePart."""
    name = message.WhichOneof("shape")
    value = getattr(message, name)
    kind = next(kind for kind, field_name in _FIELDS.items() if field_name == name)
    if kind is Plate:

        def corners(polygon):
            return tuple((vertex.x, vertex.y) for vertex in polygon.vertices)

        return Plate(
            corners(value.outline), value.thickness_m, tuple(corners(hole) for hole in value.holes)
        )
    if issubclass(kind, Mesh):
        return kind(hash=value.hash)
    return kind(
        **{
            descriptor.name: getattr(value, descriptor.name)
            for descriptor in value.DESCRIPTOR.fields
        }
    )


ShapeLike = Union[Shape, Placed, Sequence[Union[Shape, Placed]]]


def placed(what: ShapeLike, name: str) -> list[Placed]:
    """One shape or several, placed or not."""
    several = what if isinstance(what, Sequence) and not isinstance(what, (str, bytes)) else [what]
    if not several:
        raise ValueError(f"{name} is empty, must have at least one shape")
    result = [item if isinstance(item, Placed) else Placed(item) for item in several]
    for item in result:
        if type(item.shape) not in _FIELDS:
            raise TypeError(
                f"{name} has {item.shape!r}, must be one of "
                f"{', '.join(kind.__name__ for kind in _FIELDS)}"
            )
    return result


def placed_to_proto(item: Placed) -> geometry_pb2.PlacedShape:
    message = geometry_pb2.PlacedShape(x_body_shape=poses.to_proto(item.pose, "pose"))
    set_shape(item.shape, message)
    return message


def meshes_of(items: Sequence[Placed]) -> list[Mesh]:
    """Those that the server may not hold yet."""
    return [
        item.shape
        for item in items
        if isinstance(item.shape, Mesh) and item.shape.vertices is not None
    ]
