"""Ask a collision world model server, with numpy arrays in and out.

    import cwm
    with cwm.connect(world="kitchen") as world:
        scan = world.ingest(points)                         # (N, 3) metres, of a depth camera
        answer = world.distance(cwm.Sphere(0.05), poses)    # (N, 4, 4)
    print(scan.objects, answer.distance_m, answer.objects)

Metres, radians, seconds; world Z up; poses are (4, 4) arrays X_a_b, the frame b in the frame a.
`World`, below, is what can be asked and changed. `help(cwm.NAME)` tells of the rest:

    begin      connect, Server, World, WorldView (one revision), default_address, pose,
               ServerInfo, WorldInfo
    shapes     Sphere, Box, Cylinder, Cone, Capsule, HalfSpace, Plate, Convex, Mesh, Placed
    queries    RobotSubject, QueryOptions (the keyword arguments of all of them), QueryStream
    answers    CheckResult, PairResult, WorldContacts, MotionResult, RayResult, SampleResult,
               PoseResult, LinkPoses, Verdict, Trust
    scans      IngestResult, IngestReport, IngestChanges
    live       SensorStream, SensorMount: FrameResult, FrameChanges, PixelCounts;
               Sensor, SensorPoseEstimate; RobotStateStream, RobotStatesSummary
    world      Object, Part, FitQuality, Handle, Surface, Vessel, OrientedBox, Attachment,
               PairRule, Robot, Group, Link, Variable, Tool, ExportedWorld
    changes    Put, Move, Remove, Attach, Detach, Allow, Margin, SetState, for World.apply
    watch      Watch: Snapshot, Bookmark (SensorFacts), and Changes of ObjectPut, ObjectMoved, ObjectRemoved,
               RobotPut, RobotMoved, RobotRemoved, RuleSet
    errors     Error (reason, metadata, FieldViolation), NotFound, Unavailable, ...

Words of the interface are enums (`cwm.Engine`); arguments take their names too: engine="exact".
"""

from typing import TYPE_CHECKING

from cwm.addresses import default_address
from cwm.changes import Allow, Attach, Change, Detach, Margin, Move, Put, Remove, SetState
from cwm.enums import (
    CloudFrame,
    Clustering,
    DistancePairs,
    Engine,
    ExportFormat,
    FrameFate,
    IngestMode,
    JointKind,
    Motion,
    MotionVerdict,
    ObjectKind,
    ObjectState,
    ObjectView,
    Owner,
    PartRole,
    PoseStatus,
    Representation,
    RobotGeometry,
    RobotScope,
    SampleState,
    SensorModel,
    Trust,
    UnseenSpace,
    Verdict,
    Visibility,
)
from cwm.errors import (
    Aborted,
    Cancelled,
    DataLoss,
    DeadlineExceeded,
    Error,
    FailedPrecondition,
    FieldViolation,
    Internal,
    InvalidArgument,
    NotFound,
    OutOfRange,
    PermissionDenied,
    ResourceExhausted,
    RevisionCompacted,
    RevisionConflict,
    ScanRefused,
    Unavailable,
    WorldReplaced,
)
from cwm.exports import ExportedWorld
from cwm.ingest import IngestChanges, IngestReport, IngestResult
from cwm.kinematics import LinkPoses, PoseResult
from cwm.live import (
    FrameChanges,
    FrameResult,
    PixelCounts,
    RobotStatesSummary,
    RobotStateStream,
    Sensor,
    SensorMount,
    SensorPoseEstimate,
    SensorStream,
)
from cwm.objects import Attachment, FitQuality, Handle, Object, OrientedBox, Part, Surface, Vessel
from cwm.poses import pose
from cwm.queries import QueryOptions
from cwm.results import (
    CheckResult,
    MotionResult,
    PairResult,
    RayResult,
    SampleResult,
    WorldContacts,
)
from cwm.robots import Group, Link, Robot, Tool, Variable
from cwm.server import Server, ServerInfo, WorldInfo, connect
from cwm.shapes import (
    Box,
    Capsule,
    Cone,
    Convex,
    Cylinder,
    HalfSpace,
    Mesh,
    Placed,
    Plate,
    Shape,
    Sphere,
)
from cwm.subjects import RobotSubject
from cwm.view import QueryStream, WorldView
from cwm.watch import (
    Bookmark,
    Changes,
    ObjectMoved,
    ObjectPut,
    ObjectRemoved,
    PairRule,
    RobotMoved,
    RobotPut,
    RobotRemoved,
    RuleSet,
    SensorFacts,
    Snapshot,
    Watch,
)
from cwm.world import World

# The names that `help(cwm)` explains in full; the list above has all others. Type checkers take
# __all__ for the public names.
__all__ = ["World", "connect", "pose"]
if TYPE_CHECKING:
    __all__ += [
        "Aborted",
        "Allow",
        "Attach",
        "Attachment",
        "Bookmark",
        "Box",
        "Cancelled",
        "Capsule",
        "Change",
        "Changes",
        "CheckResult",
        "CloudFrame",
        "Clustering",
        "Cone",
        "Convex",
        "Cylinder",
        "DataLoss",
        "DeadlineExceeded",
        "Detach",
        "DistancePairs",
        "Engine",
        "Error",
        "ExportFormat",
        "ExportedWorld",
        "FailedPrecondition",
        "FieldViolation",
        "FitQuality",
        "FrameChanges",
        "FrameFate",
        "FrameResult",
        "Group",
        "HalfSpace",
        "Handle",
        "IngestChanges",
        "IngestMode",
        "IngestReport",
        "IngestResult",
        "Internal",
        "InvalidArgument",
        "JointKind",
        "Link",
        "LinkPoses",
        "Margin",
        "Mesh",
        "Motion",
        "MotionResult",
        "MotionVerdict",
        "Move",
        "NotFound",
        "Object",
        "ObjectKind",
        "ObjectMoved",
        "ObjectPut",
        "ObjectRemoved",
        "ObjectState",
        "ObjectView",
        "OrientedBox",
        "OutOfRange",
        "Owner",
        "PairResult",
        "PairRule",
        "Part",
        "PartRole",
        "PermissionDenied",
        "PixelCounts",
        "Placed",
        "Plate",
        "PoseResult",
        "PoseStatus",
        "Put",
        "QueryOptions",
        "QueryStream",
        "RayResult",
        "Remove",
        "Representation",
        "ResourceExhausted",
        "RevisionCompacted",
        "RevisionConflict",
        "Robot",
        "RobotGeometry",
        "RobotMoved",
        "RobotPut",
        "RobotRemoved",
        "RobotScope",
        "RobotStateStream",
        "RobotStatesSummary",
        "RobotSubject",
        "RuleSet",
        "SampleResult",
        "SampleState",
        "ScanRefused",
        "Sensor",
        "SensorFacts",
        "SensorModel",
        "SensorMount",
        "SensorPoseEstimate",
        "SensorStream",
        "Server",
        "ServerInfo",
        "SetState",
        "Shape",
        "Snapshot",
        "Sphere",
        "Surface",
        "Tool",
        "Trust",
        "Unavailable",
        "UnseenSpace",
        "Variable",
        "Verdict",
        "Vessel",
        "Visibility",
        "Watch",
        "WorldContacts",
        "WorldInfo",
        "WorldReplaced",
        "WorldView",
        "default_address",
    ]
