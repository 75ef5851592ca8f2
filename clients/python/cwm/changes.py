"""Changes of a world, for `World.apply` and for the `overlay` of a query.

`expected_revision` is the object's revision as the writer knows it (`Object.revision`; of a robot
`state_revision`): another one raises RevisionConflict, and nothing is changed.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Mapping, Sequence, Union

import numpy.typing as npt

from cwm import arrays, enums, poses, robots, shapes
from cwm.v1 import world_pb2

# An object or a robot by its name ("*": everything), or a link of a robot as (robot, link).
Thing = Union[str, tuple[str, str]]


def thing_to_proto(value: Thing, name: str) -> world_pb2.NamedThing:
    if isinstance(value, tuple):
        if len(value) != 2:
            raise TypeError(f"{name} is {value!r}, must be a name or (robot, link)")
        return world_pb2.NamedThing(
            name=arrays.text(value[0], name), link=arrays.text(value[1], name)
        )
    return world_pb2.NamedThing(name=arrays.text(value, name))


def pair_to_proto(a: Thing, b: Thing) -> world_pb2.NamedPair:
    return world_pb2.NamedPair(a=thing_to_proto(a, "a"), b=thing_to_proto(b, "b"))


def _kind(value: enums.PutKindLike) -> enums.ObjectKind:
    kind = enums.word(enums.ObjectKind, value, "kind")
    if kind not in (enums.ObjectKind.USER, enums.ObjectKind.UNSEEN):
        raise ValueError(f"kind is {kind.name.lower()!r}, must be user or unseen")
    return kind


@dataclass(frozen=True, eq=False)  # poses are arrays
class Put:
    """Adds the object, or replaces the one of that name. `shape`: one or several, each maybe
    `Placed`. kind: "user", or "unseen" for space that no sensor has seen, which queries may
    ignore, report or block (`QueryOptions`).
    """

    name: str
    shape: shapes.ShapeLike
    pose: npt.ArrayLike | None = None
    margin_m: float = 0.0
    supported_by: str = ""
    kind: enums.PutKindLike = field(default=enums.ObjectKind.USER, kw_only=True)
    expected_revision: int | None = field(default=None, kw_only=True)

    def _parts(self) -> list[shapes.Placed]:
        return shapes.placed(self.shape, "shape")

    def _fill(self, change: world_pb2.Change) -> None:
        item = change.put.object
        item.name = arrays.text(self.name, "name")
        item.kind = _kind(self.kind)
        if self.pose is not None:
            item.x_world_object.CopyFrom(poses.to_proto(self.pose, "pose"))
        else:
            item.x_world_object.qw = 1
        item.margin_m = arrays.number(self.margin_m, "margin_m", low=0)
        item.supported_by = arrays.text(self.supported_by, "supported_by")
        for part in self._parts():
            message = item.shapes.add(x_object_shape=poses.to_proto(part.pose, "pose"))
            shapes.set_shape(part.shape, message)


@dataclass(frozen=True, eq=False)  # poses are arrays
class Move:
    """`pose` is X_WO."""

    name: str
    pose: npt.ArrayLike
    expected_revision: int | None = field(default=None, kw_only=True)

    def _fill(self, change: world_pb2.Change) -> None:
        change.move.name = arrays.text(self.name, "name")
        change.move.x_world_object.CopyFrom(poses.to_proto(self.pose, "pose"))


@dataclass(frozen=True)
class Remove:
    """Removes the object; NotFound where there is none of the name."""

    name: str
    expected_revision: int | None = field(default=None, kw_only=True)

    def _fill(self, change: world_pb2.Change) -> None:
        change.remove.name = arrays.text(self.name, "name")


@dataclass(frozen=True, eq=False)  # poses are arrays
class Attach:
    """Fixes an object to a link of a robot, as a gripper does; without a pose (X_link_object)
    where it is now.
    """

    name: str
    robot: str
    link: str
    pose: npt.ArrayLike | None = None
    touch_links: Sequence[str] = ()
    expected_revision: int | None = field(default=None, kw_only=True)

    def _fill(self, change: world_pb2.Change) -> None:
        attach = change.attach
        attach.name = arrays.text(self.name, "name")
        attach.robot = arrays.text(self.robot, "robot")
        attach.link = arrays.text(self.link, "link")
        if self.pose is not None:
            attach.x_link_object.CopyFrom(poses.to_proto(self.pose, "pose"))
        attach.touch_links.extend(arrays.texts(self.touch_links, "touch_links"))


@dataclass(frozen=True)
class Detach:
    """Lets the object stand where it is."""

    name: str
    expected_revision: int | None = field(default=None, kw_only=True)

    def _fill(self, change: world_pb2.Change) -> None:
        change.detach.name = arrays.text(self.name, "name")


@dataclass(frozen=True)
class Allow:
    """Lets the two touch, for so many seconds or for good; `withdraw` ends it. `check` is the
    contrary, until it is withdrawn: two links of one robot are checked although its SRDF disables
    the pair, or although they are fixed to each other.
    """

    a: Thing
    b: Thing
    expires_after_s: float | None = None
    withdraw: bool = False
    check: bool = field(default=False, kw_only=True)

    def _fill(self, change: world_pb2.Change) -> None:
        change.allow.pair.CopyFrom(pair_to_proto(self.a, self.b))
        change.allow.withdraw = bool(self.withdraw)
        change.allow.check = bool(self.check)
        if self.expires_after_s is not None:
            seconds = arrays.seconds(self.expires_after_s, "expires_after_s")
            change.allow.expires_after.FromNanoseconds(round(1e9 * seconds))


@dataclass(frozen=True)
class Margin:
    """The margin of the pair in place of all others; None ends what was set."""

    a: Thing
    b: Thing
    margin_m: float | None

    def _fill(self, change: world_pb2.Change) -> None:
        change.margin.pair.CopyFrom(pair_to_proto(self.a, self.b))
        if self.margin_m is not None:
            change.margin.margin_m = arrays.number(self.margin_m, "margin_m", low=0)


@dataclass(frozen=True, eq=False)  # poses are arrays
class SetState:
    """Where a robot is: what is not named stays as it is."""

    robot: str
    joints: Mapping[str, float] | None = None
    named_state: tuple[str, str] | None = None
    pose: npt.ArrayLike | None = None
    expected_revision: int | None = field(default=None, kw_only=True)

    def _fill(self, change: world_pb2.Change) -> None:
        state = change.robot_state
        state.name = arrays.text(self.robot, "robot")
        state.joints.CopyFrom(robots.joint_state(self.joints, self.named_state, "joints"))
        if self.pose is not None:
            state.x_world_base.CopyFrom(poses.to_proto(self.pose, "pose"))


Change = Union[Put, Move, Remove, Attach, Detach, Allow, Margin, SetState]
"""A change of a world, for `World.apply`, and for queries that suppose it."""


def change_to_proto(change: Change, name: str) -> world_pb2.Change:
    if not isinstance(change, (Put, Move, Remove, Attach, Detach, Allow, Margin, SetState)):
        raise TypeError(f"{name} is {change!r}, must be one of the classes of cwm.changes")
    message = world_pb2.Change()
    change._fill(message)
    expected = getattr(change, "expected_revision", None)
    if expected is not None:
        message.expected_object_revision = arrays.count(expected, f"{name}.expected_revision")
    return message


def changes_to_proto(changes: Sequence[Change], name: str) -> list[world_pb2.Change]:
    if not isinstance(changes, Sequence) or isinstance(changes, str):
        raise TypeError(f"{name} is {changes!r}, must be a sequence of changes")
    return [change_to_proto(change, f"{name}[{i}]") for i, change in enumerate(changes)]


def meshes_of(changes: Sequence[Change]) -> list[shapes.Mesh]:
    """Those that the server may not hold yet."""
    return [
        mesh
        for change in changes
        if isinstance(change, Put)
        for mesh in shapes.meshes_of(change._parts())
    ]
