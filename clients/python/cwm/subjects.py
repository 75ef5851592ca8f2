"""What asks: a robot in many states, a shape or an object in many poses, points. Rows are
checked here and sent in batches.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Mapping, Sequence, Union

import numpy as np
import numpy.typing as npt

from cwm import arrays, enums, poses, robots, shapes
from cwm.bulk import Bulk
from cwm.v1 import query_pb2


@dataclass(frozen=True, eq=False)
class RobotSubject:
    """A robot of the world; rows are (N, dof), rad or m, in the order of the group's joints
    (`Robot.variables_of`).

    group: of the SRDF; "": every variable. base_state and named_state, (group, state): joints that
    are not in the group; what they leave out has the value that the robot has. pose: X_WB of the
    root link, None: where the robot stands. geometry "spheres_as_given" is a robot of its own, of
    which no answer says anything certain about the links. padding: metres by link, "*" for all
    others, in place of the paddings that those links were loaded with.
    """

    robot: str
    group: str = ""
    scope: enums.RobotScopeLike = enums.RobotScope.BOTH
    geometry: enums.RobotGeometryLike = enums.RobotGeometry.EXACT
    pose: npt.ArrayLike | None = None
    base_state: Mapping[str, float] | None = None
    named_state: tuple[str, str] | None = None
    padding: Mapping[str, float] | None = None


# A robot; a shape or several that form one body; the name of an object; or an array (N, 3) of
# points, which has no further rows.
SubjectLike = Union[RobotSubject, shapes.ShapeLike, str, npt.ArrayLike]


@dataclass(frozen=True, eq=False)
class Subject:
    """A subject with its rows, ready to be cut into batches."""

    message: query_pb2.Subject  # without the bytes of the rows
    bulk: Bulk  # no rows: the one row that the server knows
    meshes: Sequence[shapes.Mesh] = ()

    @property
    def row_count(self) -> int:
        return 1 if self.bulk.rows is None else len(self.bulk.rows)

    def with_rows(self, rows: np.ndarray) -> Subject:
        """The same with other rows, as wide."""
        return _subject(self.message, rows, *self.bulk.path[1:-1], meshes=self.meshes)


def _subject(
    message: query_pb2.Subject,
    rows: np.ndarray | None,
    *path: str,
    meshes: Sequence[shapes.Mesh] = (),
) -> Subject:
    """`path`: from the subject to the message that has the scalar and the data of the rows."""
    if rows is not None:
        target = message
        for name in path:
            target = getattr(target, name)
        target.scalar = arrays.scalar_of(rows)
    return Subject(message, Bulk(rows, ("subject", *path, "data")), meshes)


def _robot(what: RobotSubject, value: npt.ArrayLike | None, name: str) -> Subject:
    message = query_pb2.Subject()
    robot = message.robot
    robot.robot = arrays.text(what.robot, "robot")
    robot.group = arrays.text(what.group, "group")
    robot.scope = enums.word(enums.RobotScope, what.scope, "scope")
    robot.robot_geometry = enums.word(enums.RobotGeometry, what.geometry, "geometry")
    if what.pose is not None:
        robot.x_world_base.CopyFrom(poses.to_proto(what.pose, "pose"))
    if what.base_state is not None or what.named_state is not None:
        robot.base_state.CopyFrom(
            robots.joint_state(what.base_state, what.named_state, "base_state")
        )
    robot.link_padding.extend(robots.paddings_to_proto(what.padding, "padding"))
    rows = None if value is None else arrays.rows(value, name)
    if rows is not None:
        robot.rows.width = rows.shape[1]
    return _subject(message, rows, "robot", "rows")


def _body(items: list[shapes.Placed], value: npt.ArrayLike | None, name: str) -> Subject:
    message = query_pb2.Subject()
    message.shapes.shapes.extend(shapes.placed_to_proto(item) for item in items)
    rows = poses.to_rows(np.eye(4) if value is None else value, name)
    return _subject(message, rows, "shapes", "x_world_body", meshes=shapes.meshes_of(items))


def _is_shapes(what: object) -> bool:
    if isinstance(what, (list, tuple)):
        return bool(what) and any(
            isinstance(item, (shapes.Placed, *shapes.Shape.__args__)) for item in what
        )
    return isinstance(what, (shapes.Placed, *shapes.Shape.__args__))


def subject_of(what: SubjectLike, value: npt.ArrayLike | None, name: str = "rows") -> Subject:
    """`value`: joint rows of a robot, poses of a body or of an object (default: its stored
    pose); none of points.
    """
    if isinstance(what, RobotSubject):
        return _robot(what, value, name)
    if isinstance(what, str):
        message = query_pb2.Subject()
        message.object.name = what
        return _subject(
            message,
            None if value is None else poses.to_rows(value, name),
            "object",
            "x_world_object",
        )
    if _is_shapes(what):
        return _body(shapes.placed(what, "subject"), value, name)
    if value is not None:
        raise TypeError(
            f"{name} is given with a subject of points, which has no rows beside the points"
        )
    message = query_pb2.Subject()
    message.points.SetInParent()
    return _subject(message, arrays.rows(what, "points", 3), "points")
