"""The world as it is, then everything that happens to it, across lost connections and restarts of
the server.

`World.watch()` iterates `Snapshot` first, then `Changes` in the order of revisions, and `Bookmark`
when nothing happens. A connection that is lost is made again, and the watch goes on after the last
revision that was told whole. Where that cannot be, since the server has lost its memory or no
longer keeps what happened since, a new Snapshot says so in `anew`.
"""

from __future__ import annotations

import datetime
import threading
import time
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Mapping, Union

import grpc
import numpy as np

from cwm import enums, errors, objects, poses, robots
from cwm.v1 import world_pb2

if TYPE_CHECKING:
    from cwm.view import WorldView

# Delays between attempts to reach the server again.
_FIRST_PAUSE_S, _LONGEST_PAUSE_S = 0.1, 2.0


@dataclass(frozen=True)
class PairRule:
    """What holds between two things beside their shapes; each is a name, or (robot, link)."""

    a: str | tuple[str, str]
    b: str | tuple[str, str]
    allowed: bool
    expires: datetime.datetime | None
    margin_m: float | None
    check: bool = False  # two links of one robot are checked although its SRDF disables the pair


@dataclass(frozen=True)
class ObjectPut:
    """Added, or its geometry or another field changed."""

    object: objects.Object


@dataclass(frozen=True)
class ObjectMoved:
    """Only its pose changed."""

    name: str
    pose: np.ndarray = field(compare=False, repr=False)  # X_WO
    pose_revision: int
    motion: enums.Motion = enums.Motion.NOT_FOLLOWED


@dataclass(frozen=True)
class ObjectRemoved:
    """The object is no longer in the world."""

    name: str


@dataclass(frozen=True)
class RobotPut:
    """Loaded, or loaded anew in place of another one of its name."""

    robot: robots.Robot


@dataclass(frozen=True)
class RobotMoved:
    """Only its base or its state changed; one value a variable of the robot."""

    name: str
    pose: np.ndarray = field(compare=False, repr=False)  # X_WB
    state: tuple[float, ...]
    state_revision: int


@dataclass(frozen=True)
class RobotRemoved:
    """The robot is no longer in the world."""

    name: str


@dataclass(frozen=True)
class RuleSet:
    """The rule as it is now; one that allows and checks nothing and sets no margin is no
    more.
    """

    rule: PairRule


Event = Union[ObjectPut, ObjectMoved, ObjectRemoved, RobotPut, RobotMoved, RobotRemoved, RuleSet]


@dataclass(frozen=True)
class Snapshot:
    """All of the world at the revision. `anew`: why the watch had to begin again; "" for the
    first.
    """

    world_uid: str
    revision: int
    objects: tuple[objects.Object, ...]
    robots: tuple[robots.Robot, ...]
    rules: tuple[PairRule, ...]
    anew: str = ""


@dataclass(frozen=True)
class Changes:
    """All that happened up to the revision, since the last: to be taken over at once."""

    world_uid: str
    revision: int
    events: tuple[Event, ...]


@dataclass(frozen=True)
class SensorFacts:
    """What running sensors say of an object; see Object."""

    motion: enums.Motion
    visibility: enums.Visibility
    identity_certain: bool | None
    carried_by: str


@dataclass(frozen=True)
class Bookmark:
    """All up to the revision was told. last_observed: when scans saw what they saw once more, by
    name. facts: those of running sensors that changed, by name.
    """

    world_uid: str
    revision: int
    last_observed: Mapping[str, datetime.datetime] = field(hash=False)
    facts: Mapping[str, SensorFacts] = field(default_factory=dict, hash=False)


WatchEvent = Union[Snapshot, Changes, Bookmark]


def _thing(message: world_pb2.NamedThing) -> str | tuple[str, str]:
    return (message.name, message.link) if message.link else message.name


def rule_from_proto(message: world_pb2.PairRule) -> PairRule:
    return PairRule(
        _thing(message.pair.a),
        _thing(message.pair.b),
        message.allowed,
        objects.time_from_proto(message.expires) if message.HasField("expires") else None,
        message.margin_m if message.HasField("margin_m") else None,
        message.check,
    )


def _object_event(message: world_pb2.ObjectEvent, view: WorldView) -> Event:
    kind = message.WhichOneof("event")
    if kind == "put":
        return ObjectPut(objects.object_from_proto(message.put, view.pinned, view))
    if kind == "move":
        return ObjectMoved(
            message.move.name,
            poses.from_proto(message.move.x_world_object),
            message.pose_revision,
            enums.Motion(message.motion),
        )
    return ObjectRemoved(message.remove)


def _robot_event(message) -> Event:
    kind = message.WhichOneof("event")
    if kind == "put":
        return RobotPut(robots.robot_from_proto(message.put))
    if kind == "state":
        state = message.state
        return RobotMoved(
            state.name,
            poses.from_proto(state.x_world_base),
            tuple(state.state),
            state.state_revision,
        )
    return RobotRemoved(message.remove)


class Watch:
    """An iterator of Snapshot, Changes and Bookmark. `close`, from any thread, ends it; so does
    leaving its `with`.

    NotFound ends it where the world is deleted, Unavailable where no server was found for
    `give_up_after_s`.
    """

    def __init__(
        self,
        view: WorldView,
        *,
        from_revision: int | None,
        world_uid: str | None,
        coalesced: bool,
        told: enums.ObjectView,
        give_up_after_s: float | None,
    ):
        self._view = view
        request = self._request = world_pb2.WatchWorldRequest(
            world=view.name,
            view=told,
            mode=world_pb2.WATCH_MODE_COALESCED if coalesced else world_pb2.WATCH_MODE_LOSSLESS,
        )
        if from_revision is not None:
            request.from_revision = from_revision
        if world_uid is not None:
            request.world_uid = world_uid
        self._give_up_after_s = give_up_after_s
        self._call: grpc.Call | None = None
        self._closed = threading.Event()
        self._lost_at: float | None = None
        self._pause_s = _FIRST_PAUSE_S
        self._anew = ""
        self._begun = request.HasField("from_revision")
        self._initial: world_pb2.WatchWorldResponse.InitialState | None = None
        self._pending: list[Event] = []

    def __enter__(self) -> Watch:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def __iter__(self) -> Watch:
        return self

    def close(self) -> None:
        """The iterator ends, also one that waits in another thread."""
        self._closed.set()
        call = self._call
        if call is not None:
            call.cancel()

    def __next__(self) -> WatchEvent:
        while not self._closed.is_set():
            try:
                event = self._read()
            except grpc.RpcError as error:
                if self._closed.is_set():
                    break
                self._recover(errors.from_rpc(error, self._view.connection.address))
                continue
            if event is not None:
                return event
        self.close()
        raise StopIteration

    def _read(self) -> WatchEvent | None:
        if self._call is None:
            if self._view.connection.closed:
                self._closed.set()
                return None
            self._initial, self._pending = None, []
            self._call = self._view.connection.worlds.WatchWorld(self._request)
            if self._closed.is_set():
                self._call.cancel()
        message = next(self._call, None)
        if message is None:  # the server ended it without an error: it is shutting down
            self._lose(
                errors.Unavailable("the server ended the watch", code=grpc.StatusCode.UNAVAILABLE)
            )
            return None
        self._lost_at, self._pause_s = None, _FIRST_PAUSE_S
        return self._event(message)

    def _event(self, message: world_pb2.WatchWorldResponse) -> WatchEvent | None:
        what = message.WhichOneof("what")
        if what == "initial_state":
            return self._snapshot(message)
        uid, revision = message.world_uid, message.revision
        if what == "events":
            view = self._view._as_of(revision, uid)
            self._pending += [_object_event(event, view) for event in message.events.events]
            self._pending += [_robot_event(event) for event in message.events.robot_events]
            self._pending += [RuleSet(rule_from_proto(rule)) for rule in message.events.pair_rules]
            if message.events.more:
                return None
            events, self._pending = tuple(self._pending), []
            self._told(uid, revision)
            return Changes(uid, revision, events)
        if self._pending or self._initial is not None:
            return None  # in the middle of a revision it says nothing about it
        self._told(uid, revision)
        seen = {
            name: objects.time_from_proto(stamp)
            for name, stamp in message.bookmark.last_observed.items()
        }
        facts = {
            name: SensorFacts(
                enums.Motion(told.motion),
                enums.Visibility(told.visibility),
                told.identity_certain if told.HasField("identity_certain") else None,
                told.carried_by,
            )
            for name, told in message.bookmark.facts.items()
        }
        return Bookmark(uid, revision, seen, facts)

    def _snapshot(self, message: world_pb2.WatchWorldResponse) -> Snapshot | None:
        if self._initial is None:
            self._initial = world_pb2.WatchWorldResponse.InitialState()
        self._initial.MergeFrom(message.initial_state)
        if not message.initial_state.initial_state_done:
            return None
        state, self._initial = self._initial, None
        uid, revision = message.world_uid, message.revision
        view = self._view._as_of(revision, uid)
        anew, self._anew = self._anew, ""
        self._told(uid, revision)
        return Snapshot(
            uid,
            revision,
            tuple(objects.object_from_proto(o, revision, view) for o in state.objects),
            tuple(robots.robot_from_proto(robot) for robot in state.robots),
            tuple(rule_from_proto(rule) for rule in state.pair_rules),
            anew,
        )

    def _told(self, world_uid: str, revision: int) -> None:
        """A lost connection goes on from here."""
        self._begun = True
        self._request.world_uid = world_uid
        self._request.from_revision = revision

    def _begin_anew(self, why: str) -> None:
        self._anew = why
        self._request.ClearField("from_revision")
        self._request.ClearField("world_uid")
        self._call = None

    def _recover(self, error: errors.Error) -> None:
        """Goes on, or raises."""
        if isinstance(error, errors.WorldReplaced):
            return self._begin_anew(
                "the world was replaced: the server was restarted, or the world deleted"
            )
        if isinstance(error, errors.RevisionCompacted):
            return self._begin_anew(
                f"the server no longer keeps what happened since: {error.message}"
            )
        # A restarted server does not have the world until somebody creates it again.
        waits_for_world = self._lost_at is not None and error.reason == "WORLD_UNKNOWN"
        # Not cancelled by this client, so the server is shutting down.
        ended = (
            isinstance(error, (errors.Unavailable, errors.Cancelled))
            or error.reason == "WATCH_TOO_SLOW"
        )
        if not (ended or waits_for_world) or not self._begun:
            self._closed.set()
            raise error
        self._lose(error)

    def _lose(self, error: errors.Error) -> None:
        now = time.monotonic()
        if self._lost_at is None:
            self._lost_at = now
        if self._give_up_after_s is not None and now - self._lost_at > self._give_up_after_s:
            self._closed.set()
            raise error
        self._call = None
        self._closed.wait(self._pause_s)
        self._pause_s = min(2 * self._pause_s, _LONGEST_PAUSE_S)
