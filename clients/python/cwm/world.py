"""A world with all that changes it."""

from __future__ import annotations

import warnings
from typing import Mapping, Sequence

import numpy as np
import numpy.typing as npt

from cwm import arrays, changes, enums, ingest, live, poses, robots, shapes, watch
from cwm.connection import new_request_id, upload_chunks
from cwm.changes import Change, Thing
from cwm.v1 import perception_pb2, robot_pb2, world_pb2
from cwm.view import WorldView, check_timeout

_SEARCHES: tuple[enums.Search, ...] = ("planes", "cylinders", "spheres", "cones")


class World(WorldView):
    """One world of a server; leaving its `with` closes the connection.

    Writes return the revision that they made. They are sent once more when the server was not to be
    reached, under a request_id by which it recognises what it did already.
    """

    def __enter__(self) -> World:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Ends the connection, and every watch over it."""
        self._server.close()

    # Perception.

    def ingest(
        self,
        points: npt.ArrayLike,
        x_world_sensor: npt.ArrayLike | None = None,
        *,
        up: npt.ArrayLike | None = None,
        sensor: enums.SensorModelLike | float | Sequence[float] = "kinect",
        sensor_name: str = "",
        normals: npt.ArrayLike | None = None,
        mode: enums.IngestModeLike = "update",
        labels: bool = True,
        clustering: enums.ClusteringLike = "objects",
        search: Sequence[enums.Search] = _SEARCHES,
        frame: enums.CloudFrameLike = "sensor",
        viewpoint: npt.ArrayLike | None = None,
        scale: float = 1.0,
        force: bool = False,
        time_budget_s: float | None = None,
        expected_revision: int | None = None,
    ) -> ingest.IngestResult:
        """Shows the world a scan, and returns what it made of it.

        points: (N, 3), or (H, W, 3) as an organised cloud, metres in the sensor's frame; NaN where
        the sensor saw nothing. x_world_sensor: pose of the sensor, (4, 4) or (7,); None: estimated
        once for each `sensor_name`, with `up` (3,), in the sensor's frame, if given; an `up` that
        contradicts that estimate makes another one. sensor: "kinect", "realsense",
        "time_of_flight", "tilting_laser", or the standard deviation of its noise in metres; of
        views that were put together with the error of their registration; or (a, b) for
        a + b z^2 metres at depth z.
        normals: like points. search: kinds of shapes, of "planes", "cylinders", "spheres" and
        "cones". frame: "sensor", or "world", where z is up and neither a pose nor `up` is given.
        viewpoint: (3,), where the points were seen from, in their frame; None: its origin, or
        unknown in the world's frame. scale: metres per unit of points and not of viewpoint; 0.001
        for millimetres. force: take a scan that contradicts the world; it raises ScanRefused
        otherwise, as all supports would go or everything moved alike.
        """
        header, cloud = ingest.make_header(points, normals)
        header.world = self.name
        header.sensor = arrays.text(sensor_name, "sensor_name")
        header.request_id = new_request_id()
        header.mode = enums.word(enums.IngestMode, mode, "mode")
        header.want_point_labels = bool(labels)
        header.options.clustering = enums.word(enums.Clustering, clustering, "clustering")
        for kind in (
            unknown for unknown in arrays.texts(search, "search") if unknown not in _SEARCHES
        ):
            raise ValueError(f"search has {kind!r}, must be of {', '.join(_SEARCHES)}")
        for kind in _SEARCHES:
            setattr(header.options, f"search_{kind}", kind in search)
        ingest.set_sensor(header, sensor)
        ingest.set_pose(header, x_world_sensor, up)
        header.frame = enums.word(enums.CloudFrame, frame, "frame")
        ingest.set_viewpoint(header, viewpoint)
        header.scale = arrays.number(scale, "scale", low=0)
        header.force = bool(force)
        if time_budget_s is not None:
            header.time_budget.FromNanoseconds(
                round(1e9 * arrays.number(time_budget_s, "time_budget_s", low=0))
            )
        if expected_revision is not None:
            header.expected_revision = arrays.count(expected_revision, "expected_revision")
        reply = self.connection.repeat(
            lambda left_s: self.connection.perception.IngestCloud(
                ingest.messages(header, cloud), timeout=left_s
            ),
            self.timeout_s,
        )
        held = header.mode != perception_pb2.INGEST_MODE_SEGMENT_ONLY
        view = self._as_of(reply.revision, reply.world_uid) if held else None
        return ingest.result_of(reply, view, ingest.labels_of(reply, self) if labels else None)

    def stream_sensor(
        self,
        sensor_name: str,
        intrinsics: npt.ArrayLike,
        x_world_sensor: npt.ArrayLike | None = None,
        *,
        mount: live.SensorMount | None = None,
        sensor: enums.SensorModelLike | float | Sequence[float] = "kinect",
        unit_m: float | None = None,
        min_range_m: float = 0.0,
        max_range_m: float = 0.0,
        pose_sigma: tuple[float, float] | None = None,
        lockstep: bool = False,
    ) -> live.SensorStream:
        """Follows the world with the depth images of a running sensor: `with
        world.stream_sensor(...) as frames: frames.process(depth, stamp)`. See `SensorStream`.

        A sensor of the same name and calibration keeps what was learnt of it. intrinsics: (4,) fx
        fy cx cy in pixels, or the matrix (3, 3). x_world_sensor: its pose, (4, 4) or (7,), or
        mount: its place on a robot; neither where every frame has its pose, an earlier scan of the
        sensor had one, or the first frame is to tell it. sensor: as of `ingest`. unit_m: metres per
        unit; None: 0.001 for integers, 1 for floats. min_range_m, max_range_m: other depths are no
        return; 0: those of the model. pose_sigma: standard deviations of the pose, m and rad; None:
        5 mm, 0.005 rad. lockstep: frames take turns with those of other sensors, and each is
        answered when everything that it began is done: what all sensors of a world stream so can
        be replayed to the bit.
        """
        return live.SensorStream(
            self,
            live.calibration(
                self.name,
                sensor_name,
                intrinsics,
                x_world_sensor=x_world_sensor,
                mount=mount,
                sensor=sensor,
                unit_m=unit_m,
                min_range_m=min_range_m,
                max_range_m=max_range_m,
                pose_sigma=pose_sigma,
                lockstep=lockstep,
            ),
        )

    def stream_robot_states(
        self, robot: str, variables: Sequence[str] = ()
    ) -> live.RobotStateStream:
        """Tells where a robot stands while it moves, so that frames of sensors know where it was
        at their stamps: see `RobotStateStream`. variables: of the states' values; none: all, in
        the order of `Robot.variables`.
        """
        return live.RobotStateStream(
            self,
            robot_pb2.RobotStatesHeader(
                world=self.name,
                robot=arrays.text(robot, "robot"),
                variables=arrays.texts(variables, "variables"),
            ),
        )

    def sensors(self) -> tuple[live.Sensor, ...]:
        """The sensors that stream or have streamed, by name."""
        request = perception_pb2.ListSensorsRequest(world=self.name)
        reply = self.connection.call(
            self.connection.perception.ListSensors, request, self.timeout_s
        )
        return tuple(live.sensor_from_proto(sensor) for sensor in reply.sensors)

    def set_sensor_pose(
        self, sensor_name: str, x_world_sensor: npt.ArrayLike | None = None
    ) -> np.ndarray:
        """Sets the pose of a sensor, (4, 4) or (7,), or with None to its estimate; returns it,
        (4, 4). NotFound for an unknown sensor, FailedPrecondition without an estimate.
        """
        request = perception_pb2.SetSensorPoseRequest(
            world=self.name, sensor=arrays.text(sensor_name, "sensor_name")
        )
        if x_world_sensor is None:
            request.use_estimate = True
        else:
            request.x_world_sensor.CopyFrom(poses.to_proto(x_world_sensor, "x_world_sensor"))
        reply = self.connection.call(
            self.connection.perception.SetSensorPose, request, self.timeout_s
        )
        return poses.from_proto(reply.x_world_sensor)

    # Changes.

    def apply(
        self, changes_in_order: Sequence[Change], *, expected_revision: int | None = None
    ) -> int:
        """All changes in order, or none; one revision. RevisionConflict when the world, or an
        object, has another one than the one expected.
        """
        request = world_pb2.ApplyChangesRequest(
            world=self.name,
            request_id=new_request_id(),
            changes=changes.changes_to_proto(changes_in_order, "changes"),
        )
        if expected_revision is not None:
            request.expected_revision = arrays.count(expected_revision, "expected_revision")
        return self.connection.with_meshes(
            changes.meshes_of(changes_in_order),
            self.timeout_s,
            lambda: self.connection.call(
                self.connection.worlds.ApplyChanges, request, self.timeout_s
            ),
        ).revision

    def put(
        self,
        name: str,
        shape: shapes.ShapeLike,
        pose: npt.ArrayLike | None = None,
        *,
        margin_m: float = 0.0,
        supported_by: str = "",
        kind: enums.PutKindLike = "user",
        expected_revision: int | None = None,
    ) -> int:
        """Adds an object, or replaces the one of the name: a shape or several (`Placed`), at
        X_WO, (4, 4) or (7,). kind: "user", or "unseen" for space that no sensor has seen.
        """
        return self.apply(
            [
                changes.Put(
                    name,
                    shape,
                    pose,
                    margin_m,
                    supported_by,
                    kind=kind,
                    expected_revision=expected_revision,
                )
            ]
        )

    def move(self, name: str, pose: npt.ArrayLike, *, expected_revision: int | None = None) -> int:
        """Moves an object to X_WO, (4, 4) or (7,)."""
        return self.apply([changes.Move(name, pose, expected_revision=expected_revision)])

    def remove(self, name: str, *, expected_revision: int | None = None) -> int:
        """Removes an object; NotFound where there is none of the name."""
        return self.apply([changes.Remove(name, expected_revision=expected_revision)])

    def attach(
        self,
        name: str,
        robot: str,
        link: str,
        pose: npt.ArrayLike | None = None,
        *,
        touch_links: Sequence[str] = (),
    ) -> int:
        """Fixes an object to a link of a robot at X_link_object, by default where it is: it
        moves with the link from now on.
        """
        return self.apply([changes.Attach(name, robot, link, pose, touch_links)])

    def detach(self, name: str) -> int:
        """Lets an object stand where it is."""
        return self.apply([changes.Detach(name)])

    def allow(
        self,
        a: Thing,
        b: Thing,
        *,
        expires_after_s: float | None = None,
        withdraw: bool = False,
        check: bool = False,
    ) -> int:
        """Lets two things touch: each a name, (robot, link), or "*" for everything. withdraw ends
        it. check: the contrary, for two links of one robot that its SRDF disables, or that are
        fixed to each other.
        """
        return self.apply([changes.Allow(a, b, expires_after_s, withdraw, check=check)])

    def margin(self, a: Thing, b: Thing, margin_m: float | None) -> int:
        """Sets the margin of a pair; None ends it."""
        return self.apply([changes.Margin(a, b, margin_m)])

    def set_robot_state(
        self,
        robot: str,
        joints: Mapping[str, float] | None = None,
        *,
        named_state: tuple[str, str] | None = None,
        pose: npt.ArrayLike | None = None,
        expected_revision: int | None = None,
    ) -> int:
        """Where a robot is: a state of its SRDF (group, state), joints on top of it in rad or m,
        its base X_WB.
        """
        return self.apply(
            [
                changes.SetState(
                    robot, joints, named_state, pose, expected_revision=expected_revision
                )
            ]
        )

    def load_robot(
        self,
        urdf: robots.PathOrText,
        *,
        srdf: robots.PathOrText | None = None,
        spheres: robots.PathOrText | None = None,
        package_dirs: Sequence[robots.PathOrText] = (),
        name: str = "",
        pose: npt.ArrayLike | None = None,
        joints: Mapping[str, float] | None = None,
        named_state: tuple[str, str] | None = None,
        padding: Mapping[str, float] | None = None,
        scale: Mapping[str, float] | None = None,
        tools: Sequence[robots.Tool] = (),
    ) -> robots.Robot:
        """Loads a robot, in place of another one of its name. Files are paths, or texts that begin
        with "<".

        spheres: a "spherized" URDF of the same links. package_dirs: folders that hold packages
        of package:// URIs, or are one by their name or their package.xml; by default the folder of
        the URDF and the three above it. FileNotFoundError names a mesh that is not there. pose: X_WB.
        padding: extra margins in metres by link against the world, not against the robot itself;
        scale: factors by link for the collision geometry, each about its own origin; "*" stands for
        all links that are not named. tools: frames for `solve`.

        What a user should know of the files, such as which meshes are open, is a UserWarning each.
        """
        text, folder = robots.read_text(urdf, "urdf")
        header = robot_pb2.LoadRobotHeader(
            world=self.name, name=arrays.text(name, "name"), urdf=text, request_id=new_request_id()
        )
        if srdf is not None:
            header.srdf = robots.read_text(srdf, "srdf")[0]
        if spheres is not None:
            header.spheres = robots.read_text(spheres, "spheres")[0]
        if pose is not None:
            header.x_world_base.CopyFrom(poses.to_proto(pose, "pose"))
        if joints is not None or named_state is not None:
            header.initial_state.CopyFrom(robots.joint_state(joints, named_state, "joints"))
        header.link_padding.extend(robots.paddings_to_proto(padding, "padding"))
        header.link_scale.extend(robots.scales_to_proto(scale, "scale"))
        header.tools.extend(robots.tools_to_proto(tools, "tools"))
        files = {
            uri: robots.find_mesh(uri, folder, package_dirs).read_bytes()
            for uri in robots.collision_mesh_uris(text)
        }
        reply = self.connection.repeat(
            lambda left_s: self.connection.robots.LoadRobot(
                _robot_messages(header, files), timeout=left_s
            ),
            self.timeout_s,
        )
        for line in reply.warnings:
            warnings.warn(line, stacklevel=2)
        return robots.robot_from_proto(reply.robot) if reply.HasField("robot") else self.robot(name)

    def delete_robot(self, name: str) -> int:
        """Removes a robot; what it holds stands where it is."""
        request = robot_pb2.DeleteRobotRequest(
            world=self.name, name=arrays.text(name, "name"), request_id=new_request_id()
        )
        return self.connection.call(
            self.connection.robots.DeleteRobot, request, self.timeout_s
        ).revision

    # Events.

    def watch(
        self,
        *,
        from_revision: int | None = None,
        world_uid: str | None = None,
        coalesced: bool = False,
        view: enums.ObjectViewLike = "shapes",
        give_up_after_s: float | None = None,
    ) -> watch.Watch:
        """The world as it is and then what happens to it: see `cwm.watch`. `with world.watch() as
        events: ...` ends it.

        from_revision: only what comes after it. world_uid: of the world whose revision that is, as
        each event has it; needed but for 0. Where the name has another world by now the watch begins
        anew and says so. coalesced: of a burst only the newest state of each object. give_up_after_s: how long to look for a server that went away; None: for good.
        """
        if from_revision is not None:
            from_revision = arrays.count(from_revision, "from_revision")
            if from_revision > 0 and not world_uid:
                raise ValueError(
                    "world_uid is absent, must be that of the world whose revision "
                    f"{from_revision} is (from_revision)"
                )
        return watch.Watch(
            self,
            from_revision=from_revision,
            world_uid=world_uid,
            coalesced=coalesced,
            told=enums.word(enums.ObjectView, view, "view"),
            give_up_after_s=check_timeout(give_up_after_s),
        )


def _robot_messages(header: robot_pb2.LoadRobotHeader, files: Mapping[str, bytes]):
    yield robot_pb2.LoadRobotRequest(header=header)
    for name, data in files.items():
        yield robot_pb2.LoadRobotRequest(file=robot_pb2.RobotFile(name=name, total_bytes=len(data)))
        yield from upload_chunks(
            data,
            lambda offset, piece, crc: robot_pb2.LoadRobotRequest(
                chunk=robot_pb2.RobotFileChunk(offset=offset, data=piece, crc32c=crc)
            ),
        )
    yield robot_pb2.LoadRobotRequest(finish=robot_pb2.LoadRobotFinish())
