"""Forward and inverse kinematics of the robots of a world."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Sequence

import numpy as np
import numpy.typing as npt

from cwm import arrays, enums, poses, queries
from cwm.bulk import Bulk
from cwm.queries import QueryOptions
from cwm.subjects import RobotSubject, subject_of
from cwm.v1 import query_pb2, robot_pb2

if TYPE_CHECKING:
    from cwm.view import WorldView

_MAX_SOLUTIONS = 64
# More links than most robots have: batches are cut by it where all links are asked for.
_MANY_LINKS = 128


@dataclass(frozen=True, eq=False)
class PoseResult:
    """States of a robot for poses of its tool. The rows of pose i are those from row_begin[i] to
    row_begin[i + 1]: its solutions, nearest to the seed first, or one row that shows how far a pose
    without a solution could be met.
    """

    world_uid: str
    revision: int
    row_count: int  # poses asked
    completed_count: int  # poses answered
    status: np.ndarray  # (N,) uint8, see PoseStatus
    row_begin: np.ndarray  # (N + 1,) uint32
    rows: np.ndarray  # (M, dof) rad or m, in the order of `variables`
    position_error_m: np.ndarray  # (M,)
    rotation_error_rad: np.ndarray  # (M,)
    variables: tuple[str, ...]
    tool_link: str  # that carries the tool

    @property
    def complete(self) -> bool:
        """Whether all rows were answered in time."""
        return self.completed_count == self.row_count

    @property
    def solved(self) -> np.ndarray:
        """(N,) bool."""
        return self.status == enums.PoseStatus.SOLVED

    @property
    def best(self) -> np.ndarray:
        """(N, dof): of each pose the solution nearest to its seed; NaN where there is none."""
        best = np.full((len(self.status), len(self.variables)), np.nan)
        best[self.solved] = self.rows[self.row_begin[:-1][self.solved]]
        return best

    def solutions(self, pose: int) -> np.ndarray:
        """(K, dof) of one pose, none if it is not solved."""
        if not self.solved[pose]:
            return self.rows[:0]
        return self.rows[self.row_begin[pose] : self.row_begin[pose + 1]]


@dataclass(frozen=True, eq=False)
class LinkPoses:
    """The poses of links in states of a robot."""

    world_uid: str
    revision: int
    links: tuple[str, ...]
    poses: np.ndarray  # (N, L, 4, 4) X_world_link

    def __getitem__(self, link: str) -> np.ndarray:
        """(N, 4, 4) of one link; KeyError for one that was not asked for."""
        if link not in self.links:
            raise KeyError(link)
        return self.poses[:, self.links.index(link)]


def _robot(robot: RobotSubject | str) -> RobotSubject:
    return RobotSubject(robot) if isinstance(robot, str) else robot


def solve(
    view: WorldView,
    robot: RobotSubject | str,
    wanted: npt.ArrayLike,
    request: query_pb2.SolvePosesRequest,
    seeds: npt.ArrayLike | None,
    options: QueryOptions,
) -> PoseResult:
    """`request` has all but the robot, the poses and the seeds."""
    subject = subject_of(_robot(robot), seeds, "seeds")
    targets = poses.to_rows(wanted, "poses")
    start = subject.bulk.rows
    if start is not None and len(start) not in (1, len(targets)):
        raise ValueError(
            f"seeds has {len(start)} rows, must have 1, or one for each of {len(targets)} poses"
        )

    def fill(message: query_pb2.SolvePosesRequest, first: int, end: int) -> None:
        message.MergeFrom(request)
        message.robot.CopyFrom(subject.message.robot)
        message.x_world_tool.scalar = arrays.scalar_of(targets)
        if start is not None:
            part = start if len(start) == 1 else start[first:end]
            message.robot.rows.data = part.tobytes()

    replies = queries.evaluate(
        view,
        view.connection.queries.SolvePoses,
        query_pb2.SolvePosesRequest,
        fill,
        queries.rows_of(Bulk(targets, ("x_world_tool", "data")), max(1, request.max_solutions)),
        options,
    )
    width = len(replies[0].variables)
    begins, total = [np.zeros(1, dtype="<u4")], 0
    for reply in replies:
        begin = np.frombuffer(reply.row_begin, dtype="<u4")
        begins.append((begin[1:] + np.uint32(total)).astype("<u4"))
        total += int(begin[-1]) if begin.size else 0

    def joined(name: str) -> np.ndarray:
        return np.concatenate(
            [arrays.columns(getattr(reply, name), reply.joints.scalar) for reply in replies]
        )

    return PoseResult(
        world_uid=replies[0].world_uid,
        revision=replies[0].revision,
        row_count=len(targets),
        completed_count=sum(reply.completed_count for reply in replies),
        status=np.concatenate([np.frombuffer(reply.status, dtype="u1") for reply in replies]),
        row_begin=np.concatenate(begins),
        rows=np.concatenate(
            [
                arrays.columns(reply.joints.data, reply.joints.scalar).reshape(-1, width)
                for reply in replies
            ]
        ),
        position_error_m=joined("position_error_m"),
        rotation_error_rad=joined("rotation_error_rad"),
        variables=tuple(replies[0].variables),
        tool_link=replies[0].tool_link,
    )


def solve_request(
    tool_link: str,
    tool: npt.ArrayLike | str | None,
    max_solutions: int,
    tolerances: tuple[float, float],
    avoid_collision: bool,
    same_branch: bool,
    max_steps: int,
) -> query_pb2.SolvePosesRequest:
    request = query_pb2.SolvePosesRequest(
        tool_link=arrays.text(tool_link, "tool_link"),
        max_solutions=arrays.count(max_solutions, "max_solutions", low=1, high=_MAX_SOLUTIONS),
        position_tolerance_m=arrays.number(tolerances[0], "position_tolerance_m", low=0),
        rotation_tolerance_rad=arrays.number(tolerances[1], "rotation_tolerance_rad", low=0),
        avoid_collision=bool(avoid_collision),
        same_branch=bool(same_branch),
        max_steps=arrays.count(max_steps, "max_steps", high=arrays.INT32_MAX),
    )
    if isinstance(tool, str):
        request.tool = arrays.text(tool, "tool")
    elif tool is not None:
        request.x_link_tool.CopyFrom(poses.to_proto(tool, "tool"))
    return request


def link_poses(
    view: WorldView,
    robot: RobotSubject | str,
    rows: npt.ArrayLike | None,
    links: Sequence[str],
    options: QueryOptions,
) -> LinkPoses:
    subject = subject_of(_robot(robot), rows)
    names = arrays.texts(links, "links")

    def fill(message: robot_pb2.GetLinkPosesRequest, *_) -> None:
        message.robot.CopyFrom(subject.message.robot)
        message.links.extend(names)

    replies = queries.evaluate(
        view,
        view.connection.link_poses,
        robot_pb2.GetLinkPosesRequest,
        fill,
        queries.rows_of(
            Bulk(subject.bulk.rows, ("robot", "rows", "data")), len(names) or _MANY_LINKS
        ),
        options,
    )
    count = len(replies[0].links)
    numbers = np.concatenate(
        [
            arrays.columns(reply.x_world_link.data, reply.x_world_link.scalar, 7)
            for reply in replies
        ]
    )
    return LinkPoses(
        world_uid=replies[0].world_uid,
        revision=replies[0].revision,
        links=tuple(replies[0].links),
        poses=poses.to_matrices(numbers).reshape(-1, count, 4, 4),
    )
