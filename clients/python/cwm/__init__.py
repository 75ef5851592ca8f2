"""Ask a collision world model server, with numpy arrays in and out.

    import cwm

    with cwm.connect() as world:
        scan = world.ingest(points)  # (N, 3) metres, as a depth camera gives them
        for thing in scan.objects:
            print(thing.name, thing.position, [part.shape for part in thing.parts])
        answer = world.distance(cwm.Sphere(0.05), poses)  # (N, 4, 4)
        print(answer.distance_m, answer.objects)

Metres, radians, seconds; world Z up; poses are (4, 4) arrays X_a_b, the frame b in the frame a.
`World` lists what can be asked and changed, `QueryOptions` the keyword arguments of questions,
`Error` what a call may raise. The messages of the interface are in `cwm.v1`, e.g. `from cwm.v1
import world_pb2`.
"""

from cwm.changes import Allow, Attach, Change, Detach, Margin, Move, Put, Remove, SetState
from cwm.connection import default_address
from cwm.enums import (
    Clustering,
    Engine,
    ExportFormat,
    IngestMode,
    JointKind,
    MotionVerdict,
    ObjectKind,
    ObjectState,
    ObjectView,
    Owner,
    PartRole,
    Representation,
    RobotGeometry,
    RobotScope,
    SampleState,
    SensorModel,
    Trust,
    UnseenSpace,
    Verdict,
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
    Unavailable,
    WorldReplaced,
)
from cwm.exports import ExportedWorld
from cwm.ingest import IngestChanges, IngestReport, IngestResult
from cwm.objects import Attachment, FitQuality, Handle, Object, OrientedBox, Part, Surface, Vessel
from cwm.poses import pose
from cwm.queries import QueryOptions
from cwm.results import CheckResult, MotionResult, PairResult, RayResult, SampleResult
from cwm.robots import Group, Link, Robot, Variable
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
from cwm.view import WorldView
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
    Snapshot,
    Watch,
)
from cwm.world import World

__all__ = [
    name
    for name in dir()
    if not name.startswith("_")
    and name
    not in {
        "arrays",
        "changes",
        "checksums",
        "connection",
        "enums",
        "errors",
        "exports",
        "ingest",
        "objects",
        "poses",
        "queries",
        "results",
        "robots",
        "server",
        "shapes",
        "subjects",
        "v1",
        "view",
        "watch",
        "world",
    }
]
