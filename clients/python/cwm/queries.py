"""Queries in batches: what is above the server's limits is cut, asked of one revision, and put
together again.
"""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import TYPE_CHECKING, Callable, Iterator, Sequence, TypedDict

import numpy as np

from cwm import arrays, changes as changes_module, enums, errors, results, shapes
from cwm.bulk import Bulk
from cwm.changes import Change, Thing
from cwm.results import NOTHING
from cwm.v1 import geometry_pb2, query_pb2

if TYPE_CHECKING:
    from cwm.view import WorldView

_DEFAULT_CONTACTS = 16
# Chosen: most robots have fewer links with geometry, and fewer things near each of them.
_LINKS_A_ROW, _PAIRS_A_LINK = 64, 8
# The bytes reserved in a message for everything but rows.
_HEAD_BYTES = 1 << 16


class QueryOptions(TypedDict, total=False):
    """Keyword arguments of every query. Lengths in metres.

    * margin_m: of verdicts, motions and contacts: nearer than that, strictly, is a collision;
      distances are geometric
    * max_distance_m: how far to look
    * k: nearest objects a row, 1 to 64; of distances link by link, those of each link
    * max_contacts: points a row, 1 to 1 024: the deepest of each pair before further ones
    * engine: "auto", "exact", "fcl" or "bullet"
    * representation: "shapes", "surfaces" or "hybrid", of objects, of the one that asks and of
      carried ones as well
    * unseen: what space that no sensor has seen counts as: "ignore", "report" or "block"
    * ignore: names of objects and robots left out
    * only: nothing else is tested: names of objects and robots, or (robot, link). Links of the
      robot that asks restrict it to them; its own name stands for its self pairs, which are left
      out if others alone are named
    * ignore_pairs: pairs that may collide, see `Allow`
    * overlay: changes that hold for this query alone; for several, see `what_if`
    * time_budget_s: the rows completed by then are the answer
    * margin_sigma: inflates fitted parts by so many standard deviations
    * support_tolerance_m: how deep what stands may sink into what supports it
    * verdicts_only: of `check`: names no pair, which is sooner told
    """

    margin_m: float
    max_distance_m: float
    k: int
    max_contacts: int
    engine: enums.EngineLike
    representation: enums.RepresentationLike
    unseen: enums.UnseenSpaceLike
    ignore: Sequence[str]
    only: Sequence[Thing]
    ignore_pairs: Sequence[tuple[Thing, Thing]]
    overlay: Sequence[Change]
    time_budget_s: float
    margin_sigma: float
    support_tolerance_m: float
    verdicts_only: bool


_NUMBERS = ("margin_m", "max_distance_m", "margin_sigma", "support_tolerance_m")
_WORDS = {
    "engine": enums.Engine,
    "representation": enums.Representation,
    "unseen": enums.UnseenSpace,
}


def options_to_proto(options: QueryOptions) -> query_pb2.QueryOptions:
    unknown = sorted(set(options) - set(QueryOptions.__annotations__))
    if unknown:
        known = ", ".join(sorted(QueryOptions.__annotations__))
        raise TypeError(f"{unknown[0]} is no option of a question, must be one of {known}")
    message = query_pb2.QueryOptions(scalar=geometry_pb2.SCALAR_F64)
    for name in _NUMBERS:
        if options.get(name) is not None:
            setattr(message, name, arrays.number(options[name], name, low=0))
    for name, kind in _WORDS.items():
        if options.get(name) is not None:
            setattr(message, name, enums.word(kind, options[name], name))
    if options.get("k") is not None:
        message.max_results = arrays.count(options["k"], "k", low=1, high=arrays.INT32_MAX)
    if options.get("max_contacts") is not None:
        message.max_contacts = arrays.count(
            options["max_contacts"], "max_contacts", low=1, high=arrays.INT32_MAX
        )
    message.ignore.extend(arrays.texts(options.get("ignore") or (), "ignore"))
    if isinstance(options.get("only"), str):
        raise TypeError(f"only is {options['only']!r}, must be a sequence of names")
    for i, named in enumerate(options.get("only") or ()):
        message.only.append(changes_module.thing_to_proto(named, f"only[{i}]"))
    for i, pair in enumerate(options.get("ignore_pairs") or ()):
        if isinstance(pair, str) or len(pair) != 2:
            raise TypeError(f"ignore_pairs[{i}] is {pair!r}, must be a pair of things")
        message.ignore_pairs.append(changes_module.pair_to_proto(*pair))
    message.overlay.extend(changes_module.changes_to_proto(options.get("overlay") or (), "overlay"))
    message.verdicts_only = bool(options.get("verdicts_only", False))
    return message


@dataclass(frozen=True, eq=False)
class Batches:
    """How a query is cut. A unit, a row or a motion of several, stays whole; unit i has rows
    begin[i] to begin[i + 1].
    """

    bulk: Bulk
    unit_begin: np.ndarray
    answers_a_row: int = 1

    @property
    def unit_count(self) -> int:
        return len(self.unit_begin) - 1


def _ranges(batches: Batches, max_rows: int) -> Iterator[tuple[int, int]]:
    begin, first = batches.unit_begin, 0
    while first < batches.unit_count:
        end = int(np.searchsorted(begin, begin[first] + max_rows, side="right")) - 1
        end = max(end, first + 1)  # the server refuses a unit above the limit
        yield first, end
        first = end


def _max_rows(view: WorldView, batches: Batches, head_bytes: int) -> int:
    limits = view.connection.limits(view.timeout_s)
    free_bytes = limits.max_message_bytes - _HEAD_BYTES - head_bytes
    return max(
        1,
        min(
            limits.max_batch_rows,
            free_bytes // batches.bulk.row_bytes,
            limits.max_answers // batches.answers_a_row,
        ),
    )


# A world with joint states at 100 Hz keeps a revision for two or three seconds.
_MAX_ATTEMPTS = 3


def evaluate(
    view: WorldView,
    method: Callable,
    kind: type,
    fill: Callable[[object, int, int], None],
    batches: Batches,
    options: QueryOptions,
    meshes: Sequence[shapes.Mesh] = (),
) -> list:
    """The replies, in order, all of one revision. `fill(request, begin, end)` puts what is not
    rows of those units into a request of the kind. A query of several requests begins anew
    where the server has forgotten its revision meanwhile, unless the view is pinned to it.
    """
    for _ in range(_MAX_ATTEMPTS - 1):
        try:
            return _evaluate_once(view, method, kind, fill, batches, options, meshes)
        except errors.RevisionCompacted:
            if view.pinned is not None:
                raise
    return _evaluate_once(view, method, kind, fill, batches, options, meshes)


def _evaluate_once(
    view: WorldView,
    method: Callable,
    kind: type,
    fill: Callable[[object, int, int], None],
    batches: Batches,
    options: QueryOptions,
    meshes: Sequence[shapes.Mesh],
) -> list:
    overlay = [*view.supposed, *(options.get("overlay") or ())]
    message = options_to_proto({**options, "overlay": overlay})
    budget_s = options.get("time_budget_s")
    end_s = (
        None
        if budget_s is None
        else time.monotonic() + arrays.seconds(budget_s, "time_budget_s")
    )
    meshes = [*meshes, *changes_module.meshes_of(overlay)]
    max_rows = _max_rows(view, batches, message.ByteSize())
    replies: list = []
    view.fill_revision(message)
    for first, end in _ranges(batches, max_rows):
        if end_s is not None:
            left_s = end_s - time.monotonic()
            if left_s <= 0 and replies:
                break
            message.time_budget.FromNanoseconds(max(1, round(1e9 * left_s)))
        request = kind(world=view.name, options=message)
        fill(request, first, end)
        data = batches.bulk.request_bytes(
            request, batches.unit_begin[first], batches.unit_begin[end]
        )
        reply = view.connection.with_meshes(
            meshes, view.timeout_s, lambda: view.connection.call(method, data, view.timeout_s)
        )
        replies.append(reply)
        if reply.completed_count < end - first:
            break
        message.at_revision.exact = reply.revision
        message.world_uid = reply.world_uid
    return replies


def world_contacts(view: WorldView, options: QueryOptions) -> results.WorldContacts:
    """The answer about the whole world, which has no rows."""
    overlay = [*view.supposed, *(options.get("overlay") or ())]
    message = options_to_proto({**options, "overlay": overlay})
    if options.get("time_budget_s") is not None:
        budget_s = arrays.seconds(options["time_budget_s"], "time_budget_s")
        message.time_budget.FromNanoseconds(max(1, round(1e9 * budget_s)))
    view.fill_revision(message)
    request = query_pb2.GetWorldContactsRequest(world=view.name, options=message)
    reply = view.connection.with_meshes(
        changes_module.meshes_of(overlay),
        view.timeout_s,
        lambda: view.connection.call(
            view.connection.queries.GetWorldContacts,
            request.SerializeToString(),
            view.timeout_s,
        ),
    )
    count = len(reply.trust)

    def integers(name: str) -> np.ndarray:
        return np.frombuffer(getattr(reply, name), dtype="<i4")

    def scalars(name: str, width: int = 1) -> np.ndarray:
        return arrays.columns(getattr(reply, name), reply.scalar, width)

    return results.WorldContacts(
        world_uid=reply.world_uid,
        revision=reply.revision,
        complete=reply.is_complete,
        names=tuple(ref.name for ref in reply.objects),
        uids=tuple(ref.uid for ref in reply.objects),
        part_links=tuple(tuple(ref.part_links) for ref in reply.objects),
        index_a=integers("object_a"),
        index_b=integers("object_b"),
        part_a=integers("part_a"),
        part_b=integers("part_b"),
        distance_m=scalars("distance_m"),
        point_a=scalars("point_a", 3),
        point_b=scalars("point_b", 3),
        normal=scalars("normal", 3),
        trust=np.frombuffer(reply.trust, dtype=np.uint8),
        bound_m=scalars("bound_m") if reply.bound_m else np.zeros(count),
    )


def rows_of(bulk: Bulk, answers_a_row: int = 1) -> Batches:
    """Each row is a unit."""
    return Batches(bulk, np.arange((1 if bulk.rows is None else len(bulk.rows)) + 1), answers_a_row)


def contacts_a_row(options: QueryOptions) -> int:
    return options.get("max_contacts") or _DEFAULT_CONTACTS


def distances_a_row(options: QueryOptions, pairs: enums.DistancePairs) -> int:
    """The most answers that a row of a batch is cut for; link by link it may have more."""
    if pairs == enums.DistancePairs.LINKS:
        return _LINKS_A_ROW * (options.get("k") or _PAIRS_A_LINK)
    return options.get("k") or 1


class Merged:
    """Columns of several replies as those of one."""

    def __init__(self, replies: list, row_count: int):
        self.replies = replies
        self.row_count = row_count
        self.completed = sum(reply.completed_count for reply in replies)
        refs = {ref.name: ref for reply in replies for ref in reply.objects}
        names = sorted(refs)  # by code point, as the server's bytes
        position = {name: i for i, name in enumerate(names)}
        self._maps = [
            np.array([position[ref.name] for ref in reply.objects], dtype=np.int32)
            for reply in replies
        ]
        self._head = dict(
            world_uid=replies[0].world_uid,
            revision=replies[0].revision,
            row_count=row_count,
            completed_count=self.completed,
            names=tuple(names),
            uids=tuple(refs[n].uid for n in names),
            part_links=tuple(tuple(refs[n].part_links) for n in names),
        )

    def head(self) -> dict:
        return self._head

    def robot(self) -> dict:
        first = self.replies[0]
        return dict(body_links=tuple(first.body_links), body_objects=tuple(first.body_objects))

    def _join(self, parts: list[np.ndarray]) -> np.ndarray:
        return parts[0] if len(parts) == 1 else np.concatenate(parts)

    def _trim(self, reply, column: np.ndarray) -> np.ndarray:
        return column[: reply.completed_count]

    def column(self, name: str, dtype: str) -> np.ndarray:
        """A column of the replies themselves, one entry a unit; -1 where they have none."""
        parts = []
        for reply in self.replies:
            data = getattr(reply, name)
            column = (
                np.frombuffer(data, dtype=dtype)
                if data
                else np.full(reply.completed_count, NOTHING, dtype=dtype)
            )
            parts.append(self._trim(reply, column))
        return self._join(parts)

    def scalars(self, name: str, width: int = 1) -> np.ndarray:
        """Likewise of the replies' precision; 0 where they have none."""
        parts = []
        for reply in self.replies:
            data = getattr(reply, name)
            column = (
                arrays.columns(data, reply.scalar, width)
                if data
                else np.zeros((reply.completed_count, width)[: 1 + (width > 1)])
            )
            parts.append(self._trim(reply, column))
        return self._join(parts)

    def indices(self, name: str = "object_index") -> np.ndarray:
        return self._join(
            [
                self._renumbered(getattr(reply, name), i, reply.completed_count)
                for i, reply in enumerate(self.replies)
            ]
        )

    def _renumbered(self, data: bytes, i: int, count: int | None) -> np.ndarray:
        if not data:
            return np.full(count or 0, NOTHING, dtype="<i4")
        index = np.frombuffer(data, dtype="<i4")[:count]
        if len(self.replies) == 1 or not len(self._maps[i]):
            return index
        return np.where(index >= 0, self._maps[i][np.maximum(index, 0)], index).astype("<i4")

    def limits(self) -> dict:
        """What rows are out of limits by; a reply without such a row names no variable."""
        variables = next((reply.variables for reply in self.replies if reply.variables), ())
        return dict(
            variables=tuple(variables), variable_index=self.column("variable_index", "<i4")
        )

    def pairs(self) -> dict:
        """The PairColumns of the replies."""
        columns = [reply.columns for reply in self.replies]
        begins, total = [np.zeros(1, dtype="<u4")], 0
        for c in columns:
            begin = np.frombuffer(c.row_begin, dtype="<u4")
            begins.append((begin[1:] + np.uint32(total)).astype("<u4"))
            total += int(begin[-1]) if begin.size else 0

        def scalars(name: str, width: int = 1) -> np.ndarray:
            return self._join([arrays.columns(getattr(c, name), c.scalar, width) for c in columns])

        def plain(name: str, dtype: str) -> np.ndarray:
            return self._join([np.frombuffer(getattr(c, name), dtype=dtype) for c in columns])

        trust = [np.frombuffer(c.trust, dtype=np.uint8) for c in columns]
        bounds = [
            arrays.columns(c.bound_m, c.scalar) if c.bound_m else np.zeros(len(t))
            for c, t in zip(columns, trust)
        ]
        return dict(
            row_begin=np.concatenate(begins),
            distance_m=scalars("distance_m"),
            point_body=scalars("point_body", 3),
            point_object=scalars("point_object", 3),
            normal=scalars("normal", 3),
            trust=self._join(trust),
            bound_m=self._join(bounds),
            object_index=self._join(
                [self._renumbered(c.object_index, i, None) for i, c in enumerate(columns)]
            ),
            body_part=plain("body_part", "<i4"),
            object_part=plain("object_part", "<i4"),
        )

    def gradients(self) -> dict:
        """The derivatives of distances by the variables that the replies name."""
        variables = tuple(self.replies[0].variables)
        columns = [reply.columns for reply in self.replies]
        return dict(
            variables=variables,
            joint_gradient=self._join(
                [
                    arrays.columns(c.joint_gradient, c.scalar).reshape(len(c.trust), len(variables))
                    for c in columns
                ]
            ),
            gradient_kink=self._join([np.frombuffer(c.gradient_kink, dtype="?") for c in columns]),
        )
