"""Queries to a world, at its newest revision or at one that is pinned.

This file is longer than 500 lines: a view opens query streams, and a query stream is a view.
"""

from __future__ import annotations

import copy
from typing import TYPE_CHECKING, Iterator, Sequence, Unpack

import numpy as np
import numpy.typing as npt

from cwm import arrays, enums, exports, kinematics, objects, queries, results, robots, shapes, watch
from cwm.bulk import Bulk
from cwm.changes import Change, changes_to_proto
from cwm.connection import Connection
from cwm.queries import Batches, Merged, QueryOptions
from cwm.stream import Stream, StreamedConnection
from cwm.subjects import RobotSubject, Subject, SubjectLike, subject_of
from cwm.v1 import query_pb2, robot_pb2, world_pb2

if TYPE_CHECKING:
    from cwm.server import Server


class WorldView:
    """Queries about one world. Made by `connect`, `Server.world`, `at`, `within` and
    `what_if`; cheap, thread-safe.

    Every method raises `cwm.Error` and its subclasses for calls that fail, ValueError and TypeError
    for arguments that cannot be right. Queries take the keyword arguments of `cwm.QueryOptions`;
    batches above the server's limits are cut, and all of them asked of one revision.
    """

    def __init__(
        self,
        server: Server,
        name: str,
        timeout_s: float | None,
        pinned: int | None = None,
        uid: str = "",
    ):
        self._server = server
        self.name = arrays.text(name, "world")
        self.timeout_s = timeout_s
        self.pinned = pinned
        self.supposed: tuple[Change, ...] = ()
        self._uid = uid

    def __repr__(self) -> str:
        at = "" if self.pinned is None else f", revision {self.pinned}"
        return f"<{type(self).__name__} {self.name!r} at {self.connection.address}{at}>"

    @property
    def server(self) -> Server:
        """The server that has the world."""
        return self._server

    @property
    def connection(self) -> Connection:
        """What all calls go through."""
        return self._server.connection

    def _state(self) -> world_pb2.GetWorldResponse:
        return self.connection.call(
            self.connection.worlds.GetWorld,
            world_pb2.GetWorldRequest(world=self.name),
            self.timeout_s,
        )

    @property
    def revision(self) -> int:
        """The newest revision, or that of a pinned view. NotFound where nothing has made the
        world yet.
        """
        return self._state().revision if self.pinned is None else self.pinned

    @property
    def uid(self) -> str:
        """Of this world alone: another one under the name, also after a restart of the server,
        has another.
        """
        return self._uid or self._state().world_uid

    def rules(self) -> tuple[watch.PairRule, ...]:
        """Allowed collisions and margins of pairs, as they are now."""
        return tuple(watch.rule_from_proto(rule) for rule in self._state().pair_rules)

    def _as_of(self, revision: int, uid: str) -> WorldView:
        """The view of that revision, without asking whether it is there."""
        return WorldView(self._server, self.name, self.timeout_s, revision, uid)

    def at(self, revision: int | None = None) -> WorldView:
        """The world pinned to a revision, by default the newest: every answer is of that one.

        A server keeps the last ones, thinned if there are many in a second, and one that is used
        at least once a minute; else RevisionCompacted. The first use should follow within a
        second.
        """
        state = self._state()
        view = self._as_of(
            state.revision if revision is None else arrays.count(revision, "revision"),
            state.world_uid,
        )
        view.supposed = self.supposed
        return view

    def within(self, timeout_s: float | None):
        """The same, each of whose calls ends within so many seconds, or raises DeadlineExceeded;
        None: no limit.
        """
        other = copy.copy(self)
        other.timeout_s = check_timeout(timeout_s)
        return other

    def what_if(self, *changes: Change) -> WorldView:
        """The same, each of whose queries is answered as if the world had been changed so: nobody
        else sees it and no revision is made. What is listed is the world as it is. A query's own
        `overlay` comes after these changes.
        """
        changes_to_proto(changes, "changes")
        other = copy.copy(self)
        other.supposed = (*self.supposed, *changes)
        return other

    def stream(self) -> QueryStream:
        """The same over one stream, for many small queries: each takes less time, those of
        several threads overlap, and what is supposed is sent once.

            with world.at().stream() as stream:
                while planning:
                    answer = stream.check(arm, rows)
        """
        return QueryStream(self)

    def fill_revision(self, request) -> None:
        """Sets at_revision and world_uid where the view is pinned."""
        if self.pinned is not None:
            request.at_revision.exact = self.pinned
            request.world_uid = self._uid

    def _pages(self, method, request, field: str) -> Iterator[tuple[object, int, str]]:
        """Items of all pages, each with the revision and the world_uid."""
        while True:
            reply = self.connection.call(method, request, self.timeout_s)
            for item in getattr(reply, field):
                yield item, reply.revision, reply.world_uid
            if not reply.next_page_token:
                return
            request.page_token = reply.next_page_token

    def objects(
        self,
        kind: enums.ObjectKindLike | Sequence[enums.ObjectKindLike] | None = None,
        prefix: str = "",
        *,
        within: tuple[npt.ArrayLike, npt.ArrayLike] | None = None,
        view: enums.ObjectViewLike = "full",
        at: int | None = None,
    ) -> list[objects.Object]:
        """Objects by name: of one kind or several, with a prefix, whose bounds touch the box
        `within` (min, max), (3,) each.
        """
        if at is not None:
            return self.at(at).objects(kind, prefix, within=within, view=view)
        kinds = (
            []
            if kind is None
            else [kind]
            if isinstance(kind, (str, enums.ObjectKind))
            else list(kind)
        )
        request = world_pb2.ListObjectsRequest(
            world=self.name,
            name_prefix=arrays.text(prefix, "prefix"),
            kinds=[enums.word(enums.ObjectKind, k, "kind") for k in kinds],
            view=enums.word(enums.ObjectView, view, "view"),
        )
        if within is not None:
            for corner, value, name in zip(
                (request.within.min, request.within.max), within, ("min", "max")
            ):
                corner.x, corner.y, corner.z = arrays.vector(value, f"within {name}").tolist()
        self.fill_revision(request)
        return [
            objects.object_from_proto(item, revision, self._as_of(revision, uid))
            for item, revision, uid in self._pages(
                self.connection.worlds.ListObjects, request, "objects"
            )
        ]

    def get(self, name: str) -> objects.Object:
        """The object with all that is known of it. NotFound where there is none."""
        request = world_pb2.GetObjectRequest(world=self.name, name=arrays.text(name, "name"))
        self.fill_revision(request)
        reply = self.connection.call(self.connection.worlds.GetObject, request, self.timeout_s)
        return objects.object_from_proto(
            reply.object, reply.revision, self._as_of(reply.revision, reply.world_uid)
        )

    def surface(self, name: str) -> tuple[np.ndarray, np.ndarray]:
        """All that an object is made of as one mesh in its frame: vertices (V, 3) float64,
        triangles (T, 3) uint32.
        """
        request = world_pb2.ReadGeometryRequest(
            object=world_pb2.ObjectSurface(world=self.name, name=name)
        )
        self.fill_revision(request.object)
        return shapes.mesh_from_bytes(self.connection.read_blob(request, self.timeout_s))

    def mesh(
        self, what: str | shapes.Mesh | objects.Surface | objects.Handle
    ) -> tuple[np.ndarray, np.ndarray]:
        """The mesh that a hash, or something with one, names: vertices (V, 3) float64, triangles
        (T, 3) uint32.
        """
        wanted = what if isinstance(what, str) else what.hash
        request = world_pb2.ReadGeometryRequest(hash=wanted)
        return shapes.mesh_from_bytes(self.connection.read_blob(request, self.timeout_s))

    def robots(self) -> list[robots.Robot]:
        """By name."""
        request = robot_pb2.ListRobotsRequest(world=self.name)
        self.fill_revision(request)
        return [
            robots.robot_from_proto(item)
            for item, _, _ in self._pages(self.connection.robots.ListRobots, request, "robots")
        ]

    def robot(self, name: str) -> robots.Robot:
        """NotFound where there is none of the name."""
        request = robot_pb2.ListRobotsRequest(world=self.name, name=arrays.text(name, "name"))
        self.fill_revision(request)
        reply = self.connection.call(self.connection.robots.ListRobots, request, self.timeout_s)
        return robots.robot_from_proto(reply.robots[0])

    def export(
        self, format: enums.ExportFormatLike = "moveit_scene", *, robot: str = ""
    ) -> exports.ExportedWorld:
        """The world as a file of another tool: `world.export("glb").save("kitchen.glb")`.

        format: "moveit_scene", "moveit_yaml", "glb", "ply", "urdf" or "sdf"; robot: of
        "moveit_yaml", whose state and frame it is.
        """
        request = world_pb2.ExportWorldRequest(
            world=self.name,
            format=enums.word(enums.ExportFormat, format, "format"),
            robot=arrays.text(robot, "robot"),
        )
        self.fill_revision(request)
        calls = self.connection.stream(self.connection.worlds.ExportWorld, request, self.timeout_s)
        return exports.exported_from_replies(list(calls))

    def _evaluate(
        self, method, form, subject: Subject, options: QueryOptions, answers_a_row: int = 1
    ) -> Merged:
        """The answers to requests like `form`, which lacks world, options and rows."""
        replies = queries.evaluate(
            self,
            method,
            type(form),
            lambda request, *_: request.MergeFrom(form),
            queries.rows_of(subject.bulk, answers_a_row),
            options,
            subject.meshes,
        )
        return Merged(replies, subject.row_count)

    def check(
        self,
        subject: SubjectLike,
        rows: npt.ArrayLike | None = None,
        **options: Unpack[QueryOptions],
    ) -> results.CheckResult:
        """Which states collide: a verdict a row, and on the way which pair.

        subject: a `RobotSubject` with joint rows (N, dof); a shape, or several that are one body,
        with poses (N, 4, 4) or (N, 7); the name of an object with poses; or points (N, 3) alone.
        Without rows a robot and an object are asked where they are, and a body at the origin.
        """
        bound = subject_of(subject, rows)
        merged = self._evaluate(
            self.connection.queries.CheckCollisions,
            query_pb2.CheckCollisionsRequest(subject=bound.message),
            bound,
            options,
        )
        return results.CheckResult(
            **merged.head(),
            **merged.robot(),
            **merged.limits(),
            object_index=merged.indices(),
            body_part=merged.column("body_part", "<i4"),
            object_part=merged.column("object_part", "<i4"),
            verdict=merged.column("verdicts", "u1"),
            trust=merged.column("trust", "u1"),
        )

    def distance(
        self,
        subject: SubjectLike,
        rows: npt.ArrayLike | None = None,
        *,
        pairs: enums.DistancePairsLike = enums.DistancePairs.OBJECTS,
        joint_gradient: bool = False,
        **options: Unpack[QueryOptions],
    ) -> results.PairResult:
        """Signed distances of each row, with points and normal. Subjects as of `check`.

        pairs: "objects": the k nearest objects (k: 1), of which the robot that asks counts as one.
        "links": each link of the robot, and each object that it carries, with each object, each
        link of other robots and each of its own links, by their nearest parts: the k nearest of
        each link or, without k, all within max_distance_m, which must then be given. A self pair
        is told once, with its lower part as body_part.
        joint_gradient: also d distance_m / d joint of a robot, (A, V) in m/rad or m/m, see
        `PairResult`; it costs a second look at each pair.
        """
        kind = enums.word(enums.DistancePairs, pairs, "pairs")
        bound = subject_of(subject, rows)
        message = query_pb2.GetDistancesRequest(
            subject=bound.message, pairs=int(kind), want_joint_gradient=bool(joint_gradient)
        )
        merged = self._evaluate(
            self.connection.queries.GetDistances,
            message,
            bound,
            options,
            queries.distances_a_row(options, kind),
        )
        gradients = merged.gradients() if joint_gradient else {}
        return results.PairResult(**merged.head(), **merged.robot(), **merged.pairs(), **gradients)

    def contacts(
        self,
        subject: SubjectLike,
        rows: npt.ArrayLike | None = None,
        *,
        max_contacts_per_pair: int | None = None,
        **options: Unpack[QueryOptions],
    ) -> results.PairResult:
        """What each row touches, with depth (distance_m < 0), points and normal; several points
        of a pair whose faces or edges meet, at most max_contacts_per_pair, the deepest first.
        Subjects as of `check`.
        """
        bound = subject_of(subject, rows)
        message = query_pb2.GetContactsRequest(subject=bound.message)
        if max_contacts_per_pair is not None:
            message.max_contacts_per_pair = arrays.count(
                max_contacts_per_pair, "max_contacts_per_pair", low=1, high=arrays.INT32_MAX
            )
        merged = self._evaluate(
            self.connection.queries.GetContacts,
            message,
            bound,
            options,
            queries.contacts_a_row(options),
        )
        return results.PairResult(**merged.head(), **merged.robot(), **merged.pairs())

    def all_contacts(self, **options: Unpack[QueryOptions]) -> results.WorldContacts:
        """All pairs of objects and robots of the world that are nearer than their margin, deepest
        first, each pair of parts by its nearest points; with the self pairs of robots. max_contacts
        limits the pairs, by default to 65 536.
        """
        return queries.world_contacts(self, options)

    def motions(
        self,
        subject: RobotSubject | shapes.ShapeLike | str,
        starts: npt.ArrayLike,
        ends: npt.ArrayLike,
        **options: Unpack[QueryOptions],
    ) -> results.MotionResult:
        """Whether the way from starts[i] to ends[i] is free, certified: rows as of `check`, as many
        starts as ends.

        Joints go linearly, continuous ones the short way; of poses, and of planar and floating
        joints, the origin linearly, the rotation by slerp.
        """
        first, last = subject_of(subject, starts, "starts"), subject_of(subject, ends, "ends")
        begin, end = first.bulk.rows, last.bulk.rows
        if begin is None or end is None or begin.shape != end.shape:
            given = [None if rows is None else rows.shape for rows in (begin, end)]
            raise ValueError(f"starts has the shape {given[0]} and ends {given[1]}, must be alike")
        both = np.stack([begin, end], axis=1).reshape(-1, begin.shape[1])  # of the finer precision
        return self._motions(first, both, np.arange(0, len(both) + 1, 2), False, options)

    def paths(
        self,
        subject: RobotSubject | shapes.ShapeLike | str,
        paths: Sequence[npt.ArrayLike],
        **options: Unpack[QueryOptions],
    ) -> results.MotionResult:
        """Likewise whole paths, each of two rows or more; one verdict a path, `segment` says
        where on it.
        """
        bound = [subject_of(subject, path, f"paths[{i}]") for i, path in enumerate(paths)]
        if not bound:
            raise ValueError("paths is empty, must have at least one")
        widths = {None if item.bulk.rows is None else item.bulk.rows.shape[1] for item in bound}
        short = next((i for i, item in enumerate(bound) if item.row_count < 2), None)
        if short is not None:
            raise ValueError(
                f"paths[{short}] has {bound[short].row_count} rows, must have at least 2"
            )
        if len(widths) > 1:
            raise ValueError(f"paths have rows of {sorted(widths)} numbers, must be alike")
        rows = np.concatenate([item.bulk.rows for item in bound])
        begin = np.concatenate([[0], np.cumsum([item.row_count for item in bound])])
        return self._motions(bound[0], rows, begin, True, options)

    def _motions(
        self,
        subject: Subject,
        rows: np.ndarray,
        begin: np.ndarray,
        counted: bool,
        options: QueryOptions,
    ) -> results.MotionResult:
        whole = subject.with_rows(rows)

        def fill(request: query_pb2.CheckMotionsRequest, first: int, end: int) -> None:
            request.subject.CopyFrom(whole.message)
            if counted:
                request.path_row_counts.extend(np.diff(begin[first : end + 1]).tolist())

        replies = queries.evaluate(
            self,
            self.connection.queries.CheckMotions,
            query_pb2.CheckMotionsRequest,
            fill,
            Batches(whole.bulk, begin),
            options,
            whole.meshes,
        )
        merged = Merged(replies, len(begin) - 1)
        return results.MotionResult(
            **merged.head(),
            **merged.robot(),
            **merged.limits(),
            object_index=merged.indices(),
            **{
                name: merged.column(name, "<i4") for name in ("body_part", "object_part", "segment")
            },
            **{name: merged.scalars(name) for name in ("lo", "hi", "clearance_m")},
            verdict=merged.column("verdicts", "u1"),
            trust=merged.column("trust", "u1"),
        )

    def solve(
        self,
        robot: RobotSubject | str,
        poses: npt.ArrayLike,
        *,
        tool_link: str = "",
        tool: npt.ArrayLike | str | None = None,
        seeds: npt.ArrayLike | None = None,
        max_solutions: int = 1,
        position_tolerance_m: float = 1e-6,
        rotation_tolerance_rad: float = 1e-6,
        avoid_collision: bool = False,
        same_branch: bool = False,
        max_steps: int = 0,
        **options: Unpack[QueryOptions],
    ) -> kinematics.PoseResult:
        """Inverse kinematics: joint values of the robot's group for poses (N, 4, 4) of a tool in
        the world.

        tool: the name of a tool that the robot was loaded with, or its pose (4, 4) in the frame of
        `tool_link`. By default the only tool of the group, or else the link that the SRDF names
        for the group. seeds: (dof,) or (N, dof), by default where the robot is; the
        search begins there and at values drawn within the limits, with same_branch at the seed
        alone. avoid_collision leaves out states that `check` does not call free, with the same
        options. max_solutions: at most 64 of each pose, which differ by more than 0.1 rad or m.
        The same call gives the same answer: it is bounded by max_steps (0: 2000), never by time.
        """
        request = kinematics.solve_request(
            tool_link,
            tool,
            max_solutions,
            (position_tolerance_m, rotation_tolerance_rad),
            avoid_collision,
            same_branch,
            max_steps,
        )
        return kinematics.solve(self, robot, poses, request, seeds, options)

    def link_poses(
        self,
        robot: RobotSubject | str,
        rows: npt.ArrayLike | None = None,
        links: Sequence[str] = (),
        **options: Unpack[QueryOptions],
    ) -> kinematics.LinkPoses:
        """Forward kinematics: the poses X_world_link of links (all, in the order of the URDF) for
        rows (N, dof), by default where the robot is.
        """
        return kinematics.link_poses(self, robot, rows, links, options)

    def rays(
        self, origins: npt.ArrayLike, directions: npt.ArrayLike, **options: Unpack[QueryOptions]
    ) -> results.RayResult:
        """The first thing that each ray hits: origins (N, 3) or (3,), directions (N, 3) of any
        positive length.
        """
        begin, along = arrays.rows(origins, "origins", 3), arrays.rows(directions, "directions", 3)
        if len(begin) != len(along) and len(begin) != 1:
            raise ValueError(
                f"origins has the shape {begin.shape}, must be (3,) or that of directions, "
                f"{along.shape}"
            )
        zero = np.flatnonzero(~along.any(axis=1))
        if zero.size:
            raise ValueError(f"directions[{zero[0]}] is 0 0 0, must have a positive length")
        rows = np.concatenate([np.broadcast_to(begin, along.shape), along], axis=1)
        scalar = arrays.scalar_of(rows)
        replies = queries.evaluate(
            self,
            self.connection.queries.CastRays,
            query_pb2.CastRaysRequest,
            lambda request, *_: setattr(request.rays, "scalar", scalar),
            queries.rows_of(Bulk(rows, ("rays", "data"))),
            options,
        )
        merged = Merged(replies, len(rows))
        return results.RayResult(
            **merged.head(),
            hit=merged.column("hit", "u1").astype(bool),
            distance_m=merged.scalars("distance_m"),
            normal=merged.scalars("normal", 3),
            object_index=merged.indices(),
            object_part=merged.column("object_part", "<i4"),
            trust=merged.column("trust", "u1"),
        )

    def sample(
        self, points: npt.ArrayLike, **options: Unpack[QueryOptions]
    ) -> results.SampleResult:
        """The signed distance of the world at points (N, 3), and its gradient."""
        rows = arrays.rows(points, "points", 3)
        scalar = arrays.scalar_of(rows)
        replies = queries.evaluate(
            self,
            self.connection.queries.SamplePoints,
            query_pb2.SamplePointsRequest,
            lambda request, *_: setattr(request.points, "scalar", scalar),
            queries.rows_of(Bulk(rows, ("points", "data"))),
            options,
        )
        merged = Merged(replies, len(rows))
        return results.SampleResult(
            **merged.head(),
            state=merged.column("state", "u1"),
            distance_m=merged.scalars("distance_m"),
            gradient=merged.scalars("gradient", 3),
            object_index=merged.indices(),
            object_part=merged.column("object_part", "<i4"),
            trust=merged.column("trust", "u1"),
            bound_m=merged.scalars("bound_m"),
        )


class QueryStream(WorldView):
    """Queries about one world over one stream, made by `WorldView.stream`; leaving its `with`
    ends it.

    It asks what a view asks, with the same answers. Several threads may ask at once: the next
    query is on its way while one is answered. What the view supposes (`what_if`) is sent once.
    A query that fails leaves the stream as it is; a connection that is lost ends it, and
    Unavailable is raised from then on.
    """

    def __init__(self, view: WorldView):
        super().__init__(view.server, view.name, view.timeout_s, view.pinned, view._uid)
        self._stream = Stream(view.connection)
        self._streamed = StreamedConnection(view.connection, self._stream)
        try:
            if view.supposed:
                self._streamed.suppose(self.name, view.supposed, self.timeout_s)
        except BaseException:
            self.close()
            raise

    def __enter__(self) -> QueryStream:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    @property
    def connection(self) -> Connection:
        """What all calls go through."""
        return self._streamed  # what a connection has, it has

    def close(self) -> None:
        """Nothing more can be asked; what other threads have asked is still answered."""
        self._stream.close()


def check_timeout(timeout_s: float | None) -> float | None:
    if timeout_s is None:
        return None
    if arrays.number(timeout_s, "timeout_s") <= 0:
        raise ValueError(f"timeout_s is {timeout_s!r}, must be greater than 0, or None")
    return float(timeout_s)
