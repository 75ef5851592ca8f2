"""Words of the interface. Arguments take the member or its name in any case: `engine="exact"`.
Each `...Like` is the type of such an argument, with the names as type checkers and editors know
them.
"""

from __future__ import annotations

import enum
from typing import Literal, Type, TypeVar, Union

Word = TypeVar("Word", bound=enum.IntEnum)


class ObjectKind(enum.IntEnum):
    """What an object is: OBJECT stands on a SUPPORT, RESIDUAL is what no shape explains, UNSEEN
    is space that no sensor has seen, USER was put by somebody, MOVER is a piece of something that
    moves and is not modelled, such as a hand.
    """

    SUPPORT = 1
    OBJECT = 2
    RESIDUAL = 3
    UNSEEN = 4
    USER = 5
    MOVER = 6


ObjectKindLike = Union[
    ObjectKind, Literal["support", "object", "residual", "unseen", "user", "mover"]
]


class Owner(enum.IntEnum):
    """Who made an object, and may change it: scans never touch what is a USER's."""

    PERCEPTION = 1
    USER = 2


class ObjectState(enum.IntEnum):
    """What the last scan said of an object: seen, hidden, or not found where it was."""

    UNKNOWN = 0
    CONFIRMED = 1
    OCCLUDED = 2
    LOST = 3


class Motion(enum.IntEnum):
    """Whether an object moves, as running sensors see it; NOT_FOLLOWED: none does. AT_REST: its
    pose is constant to the bit.
    """

    NOT_FOLLOWED = 0
    AT_REST = 1
    MOVING = 2
    SETTLING = 3


class Visibility(enum.IntEnum):
    """How running sensors see an object. OCCLUDED: something is in front of it; STALE: out of
    view or without a return; LOST: followed while it moved, and not seen since.
    """

    NOT_FOLLOWED = 0
    VISIBLE = 1
    OCCLUDED = 2
    STALE = 3
    LOST = 4


class FrameFate(enum.IntEnum):
    """What became of a frame. DROPPED: a newer one came while it waited."""

    PROCESSED = 1
    DROPPED = 2
    REFUSED = 3


class PartRole(enum.IntEnum):
    """FITTED was measured, COMPLETED supplied where nothing was measured."""

    FITTED = 1
    COMPLETED = 2


class ObjectView(enum.IntEnum):
    """How much of an object is told: BASIC without shapes, FULL with surfaces and handles."""

    BASIC = 1
    SHAPES = 2
    FULL = 3


ObjectViewLike = Union[ObjectView, Literal["basic", "shapes", "full"]]


class Verdict(enum.IntEnum):
    """Of a state."""

    FREE = 1
    COLLISION = 2
    OUT_OF_LIMITS = 3
    UNDECIDED = 4
    NOT_COMPUTED = 5


class MotionVerdict(enum.IntEnum):
    """Of a motion. FREE and CONTACT are never wrong."""

    FREE = 1
    CONTACT = 2
    GRAZING = 3
    UNDECIDED = 4
    NOT_COMPUTED = 5
    OUT_OF_LIMITS = 6


class PoseStatus(enum.IntEnum):
    """Of a pose of a robot's tool. UNREACHABLE: not reached from any start, which proves nothing;
    IN_COLLISION: no solution that was found is free.
    """

    SOLVED = 1
    UNREACHABLE = 2
    OUT_OF_LIMITS = 3
    IN_COLLISION = 4
    NOT_COMPUTED = 5


class Trust(enum.IntEnum):
    """How far an answer may be believed: BOUNDED is off by at most bound_m, SURFACE_ONLY is of
    open geometry without an inside, DEGRADED has no known bound.
    """

    NONE = 0
    EXACT = 1
    BOUNDED = 2
    SURFACE_ONLY = 3
    DEGRADED = 4


class SampleState(enum.IntEnum):
    """Of a point: SMOOTH has the gradient of the distance, at a KINK two nearest places pull
    different ways, BEYOND is farther than max_distance_m from everything.
    """

    SMOOTH = 1
    KINK = 2
    BEYOND = 3


class Engine(enum.IntEnum):
    """What computes an answer."""

    AUTO = 1
    EXACT = 2
    FCL = 3
    BULLET = 4


EngineLike = Union[Engine, Literal["auto", "exact", "fcl", "bullet"]]


class DistancePairs(enum.IntEnum):
    """What a distance is told of: OBJECTS, the nearest objects; LINKS, each link of the robot that
    asks with each object, each link of other robots and each of its own links.
    """

    OBJECTS = 1
    LINKS = 2


DistancePairsLike = Union[DistancePairs, Literal["objects", "links"]]


class Representation(enum.IntEnum):
    """What stands for an object: its shapes, its measured meshes, or both."""

    SHAPES = 1
    SURFACES = 2
    HYBRID = 3


RepresentationLike = Union[Representation, Literal["shapes", "surfaces", "hybrid"]]


class UnseenSpace(enum.IntEnum):
    """What space that no sensor has seen counts as."""

    IGNORE = 1
    REPORT = 2
    BLOCK = 3


UnseenSpaceLike = Union[UnseenSpace, Literal["ignore", "report", "block"]]


class RobotScope(enum.IntEnum):
    """Against what a robot is asked."""

    WORLD = 1
    SELF = 2
    BOTH = 3


RobotScopeLike = Union[RobotScope, Literal["world", "self", "both"]]


class RobotGeometry(enum.IntEnum):
    """What stands for the links of a robot."""

    EXACT = 1
    SPHERES_CONTAINING = 2
    SPHERES_AS_GIVEN = 3


RobotGeometryLike = Union[RobotGeometry, Literal["exact", "spheres_containing", "spheres_as_given"]]


class JointKind(enum.IntEnum):
    """How a link moves on its parent; NONE is that of the root."""

    NONE = 0
    FIXED = 1
    REVOLUTE = 2
    CONTINUOUS = 3
    PRISMATIC = 4
    PLANAR = 5
    FLOATING = 6


class IngestMode(enum.IntEnum):
    """UPDATE replaces the view, ADD removes and moves nothing, SEGMENT_ONLY leaves the world as
    it is.
    """

    UPDATE = 1
    ADD = 2
    SEGMENT_ONLY = 3


IngestModeLike = Union[IngestMode, Literal["update", "add", "segment_only"]]


class SensorModel(enum.IntEnum):
    """The noise of a sensor, which drives every threshold."""

    KINECT = 1
    REALSENSE = 2
    TIME_OF_FLIGHT = 3
    TILTING_LASER = 4


SensorModelLike = Union[
    SensorModel,
    Literal["kinect", "realsense", "time_of_flight", "tilting_laser"],
]


class CloudFrame(enum.IntEnum):
    """The frame of a scan's points: the sensor's, or the world's, where z is up."""

    SENSOR = 1
    WORLD = 2


CloudFrameLike = Union[CloudFrame, Literal["sensor", "world"]]


class Clustering(enum.IntEnum):
    """OBJECTS divides what stands on a support before shapes are searched; NONE does not, for
    dense clutter.
    """

    OBJECTS = 1
    NONE = 2


ClusteringLike = Union[Clustering, Literal["objects", "none"]]


class ExportFormat(enum.IntEnum):
    """The kind of file that a world is written as."""

    MOVEIT_SCENE = 1
    MOVEIT_YAML = 2
    GLB = 3
    PLY = 4
    URDF = 5
    SDF = 6


ExportFormatLike = Union[
    ExportFormat,
    Literal["moveit_scene", "moveit_yaml", "glb", "ply", "urdf", "sdf"],
]


# What `World.put` takes, and the shapes that `World.ingest` searches.
PutKindLike = Union[ObjectKind, Literal["user", "unseen"]]
Search = Literal["planes", "cylinders", "spheres", "cones"]


def word(kind: Type[Word], value: Word | str | int, name: str) -> Word:
    """The member; ValueError names the argument and the words there are."""
    words = ", ".join(member.name.lower() for member in kind)
    if isinstance(value, str):
        try:
            return kind[value.upper().replace("-", "_")]
        except KeyError:
            raise ValueError(f"{name} is {value!r}, must be one of {words}") from None
    if isinstance(value, kind):
        return value
    raise TypeError(f"{name} is {value!r}, must be one of {words}")
