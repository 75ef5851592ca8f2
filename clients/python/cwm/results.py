"""Answers as numpy columns, read from the reply without a copy (they are read-only).

Answers name what they are about by an index into `names`; `objects` resolves them. Rows are those
of the query; when a time budget was spent first, the columns have the rows that were completed,
from the first on.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cwm import enums

# Special values of object_index: no object; the subject robot itself.
NOTHING, ITSELF = -1, -2


@dataclass(frozen=True, eq=False)
class Head:
    """What every answer begins with."""

    world_uid: str
    revision: int
    row_count: int  # asked
    completed_count: int  # answered
    names: tuple[str, ...]  # of what answers mention, ordered
    uids: tuple[str, ...]
    part_links: tuple[
        tuple[str, ...], ...
    ]  # of each that is a robot, the link of each of its parts

    @property
    def complete(self) -> bool:
        """Whether all rows were answered in time."""
        return self.completed_count == self.row_count

    def _resolve(self, index: np.ndarray) -> np.ndarray:
        """Names, None where nothing is named, "" for the robot that asks. Negative indices count
        from the end.
        """
        return np.array([*self.names, "", None], dtype=object)[index]


@dataclass(frozen=True, eq=False)
class _Pairs(Head):
    # int32: into names; -1: no object; -2: the robot itself, whose other part is object_part
    object_index: np.ndarray
    body_part: np.ndarray  # int32
    object_part: np.ndarray  # int32
    body_links: tuple[str, ...]  # of a robot that asks, the link of each body part
    body_objects: tuple[
        str, ...
    ]  # the object that it carries, "" where the part is its own; nothing carried: empty

    @property
    def objects(self) -> np.ndarray:
        """Names as an array of str; None where nothing is named, "" for the robot that asks."""
        return self._resolve(self.object_index)


@dataclass(frozen=True, eq=False)
class _Limited(_Pairs):
    variables: tuple[str, ...]  # of the robot that asks; empty where nothing is OUT_OF_LIMITS
    # int32: for OUT_OF_LIMITS rows the first variable out of its limits, as an index into
    # variables; else -1
    variable_index: np.ndarray

    @property
    def out_of_limits(self) -> np.ndarray:
        """The names of those variables as an array of str; None where all are within limits."""
        return np.array([*self.variables, None], dtype=object)[self.variable_index]


@dataclass(frozen=True, eq=False)
class CheckResult(_Limited):
    """A verdict a row. The pair named means something where the verdict is COLLISION."""

    verdict: np.ndarray  # (N,) uint8, see Verdict
    trust: np.ndarray  # (N,) uint8, see Trust

    @property
    def free(self) -> np.ndarray:
        """(N,) bool."""
        return self.verdict == enums.Verdict.FREE

    @property
    def collision(self) -> np.ndarray:
        """(N,) bool."""
        return self.verdict == enums.Verdict.COLLISION


@dataclass(frozen=True, eq=False)
class PairResult(_Pairs):
    """Distances or contacts: A answers to N rows; those of row i are row_begin[i] to row_begin[i
    + 1]. Distances link by link are ordered by the link of the body, then by distance.
    """

    row_begin: np.ndarray  # (N + 1,) uint32
    distance_m: np.ndarray  # (A,) < 0: penetration; without margins
    point_body: np.ndarray  # (A, 3) world frame
    point_object: np.ndarray  # (A, 3)
    normal: np.ndarray  # (A, 3) unit, from the body that asks to the object
    trust: np.ndarray  # (A,) uint8, see Trust
    # (A,) error bound of a BOUNDED or SURFACE_ONLY answer; 0 for EXACT, NaN for DEGRADED
    bound_m: np.ndarray
    # The names of a row's V joint variables, of a distance with joint_gradient
    variables: tuple[str, ...] = ()
    # (A, V) d distance_m / d variable, in m/rad or m/m, by the movement of the robot's own links
    # at the nearest points; None unless joint_gradient was asked for
    joint_gradient: np.ndarray | None = None
    # (A,) bool: the gradient is one of several, since another pair of parts, or other points of
    # the two, are as near; None likewise
    gradient_kink: np.ndarray | None = None

    @property
    def row(self) -> np.ndarray:
        """(A,) the row that each answer is to."""
        return np.repeat(
            np.arange(len(self.row_begin) - 1), np.diff(self.row_begin.astype(np.int64))
        )

    @property
    def nearest_m(self) -> np.ndarray:
        """(N,) the least distance of each row; NaN where there is none."""
        least = np.full(len(self.row_begin) - 1, np.inf)
        np.minimum.at(least, self.row, self.distance_m)
        least[np.diff(self.row_begin.astype(np.int64)) == 0] = np.nan
        return least


@dataclass(frozen=True, eq=False)
class WorldContacts:
    """Pairs of parts that are nearer than their margin, deepest first. `a` has the name that comes
    first, and of a robot's self pair the lower part.
    """

    world_uid: str
    revision: int
    complete: bool  # False: the time budget or max_contacts ended the list
    names: tuple[str, ...]
    uids: tuple[str, ...]
    part_links: tuple[tuple[str, ...], ...]  # of each that is a robot, the link of each part
    index_a: np.ndarray  # (A,) int32 into names; equal for self pairs
    index_b: np.ndarray
    part_a: np.ndarray  # (A,) int32
    part_b: np.ndarray
    distance_m: np.ndarray  # (A,) < 0: penetration; without margins
    point_a: np.ndarray  # (A, 3) world frame
    point_b: np.ndarray
    normal: np.ndarray  # (A, 3) unit, from a to b
    trust: np.ndarray  # (A,) uint8, see Trust
    bound_m: np.ndarray  # (A,) as in PairResult

    def __len__(self) -> int:
        return len(self.distance_m)

    @property
    def a(self) -> np.ndarray:
        """(A,) names."""
        return np.array(self.names, dtype=object)[self.index_a]

    @property
    def b(self) -> np.ndarray:
        """(A,) names."""
        return np.array(self.names, dtype=object)[self.index_b]

    @property
    def link_a(self) -> np.ndarray:
        """(A,) links of robots; None for objects."""
        return self._links(self.index_a, self.part_a)

    @property
    def link_b(self) -> np.ndarray:
        """(A,) links of robots; None for objects."""
        return self._links(self.index_b, self.part_b)

    def _links(self, index: np.ndarray, part: np.ndarray) -> np.ndarray:
        links = np.full(len(index), None, dtype=object)
        for i, (of, k) in enumerate(zip(index, part)):
            if self.part_links[of]:
                links[i] = self.part_links[of][k]
        return links


@dataclass(frozen=True, eq=False)
class MotionResult(_Limited):
    """One entry a motion; row_count and completed_count are of motions."""

    verdict: np.ndarray  # (M,) uint8, see MotionVerdict
    # (M,) int32: from the motion's row `segment` to the next; -1 if free or not computed
    segment: np.ndarray
    lo: np.ndarray  # (M,) share of the segment: nothing is met before
    hi: np.ndarray  # (M,) share of the segment: the pair named is in contact there
    # (M,) for a free motion: the least distance of any pair above its margin; up to 0.02
    clearance_m: np.ndarray
    # (M,) uint8, see Trust: of the named pair; for a free motion, the weakest of the pairs nearby
    trust: np.ndarray

    @property
    def free(self) -> np.ndarray:
        """(M,) bool."""
        return self.verdict == enums.MotionVerdict.FREE


@dataclass(frozen=True, eq=False)
class RayResult(Head):
    """The nearest hit of each ray; the other columns mean something where `hit`."""

    hit: np.ndarray  # (N,) bool
    distance_m: np.ndarray  # (N,)
    normal: np.ndarray  # (N, 3) outward
    object_index: np.ndarray  # (N,) int32
    object_part: np.ndarray  # (N,) int32
    trust: np.ndarray  # (N,) uint8, see Trust

    @property
    def objects(self) -> np.ndarray:
        """(N,) names as an array of str; None where nothing was hit."""
        return self._resolve(np.where(self.hit, self.object_index, NOTHING))


@dataclass(frozen=True, eq=False)
class SampleResult(Head):
    """The signed distance of the world at points; the other columns mean something where state
    is not BEYOND.
    """

    state: np.ndarray  # (N,) uint8, see SampleState
    distance_m: np.ndarray  # (N,) < 0: inside
    gradient: np.ndarray  # (N, 3) unit: d distance / d point
    object_index: np.ndarray  # (N,) int32
    object_part: np.ndarray  # (N,) int32
    trust: np.ndarray  # (N,) uint8, see Trust
    bound_m: np.ndarray  # (N,) by how much a BOUNDED point may be deeper; 0 for others

    @property
    def objects(self) -> np.ndarray:
        """(N,) names as an array of str; None where nothing is near enough."""
        return self._resolve(
            np.where(self.state == enums.SampleState.BEYOND, NOTHING, self.object_index)
        )
