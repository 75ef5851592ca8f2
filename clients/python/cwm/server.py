"""A server: where worlds are found."""

from __future__ import annotations

from dataclasses import dataclass, field

from cwm import arrays
from cwm.connection import Connection, new_request_id
from cwm.v1 import admin_pb2, world_pb2
from cwm.view import check_timeout
from cwm.world import World


@dataclass(frozen=True)
class WorldInfo:
    """A world that the server holds."""

    name: str
    uid: str
    revision: int
    object_count: int
    robot_count: int
    oldest_exact_revision: int  # still answered by `World.at`; later ones may be missing
    oldest_watch_revision: int  # a watch can still go on from here


@dataclass(frozen=True)
class ServerInfo:
    """What a server says of itself. `limits` and `retention` by the names of cwm.v1.Limits and
    Retention; `store_info` by those of cwm.v1.StoreInfo, None if worlds are kept in memory.
    """

    version: str
    uptime_s: float
    store: str
    engines: dict[str, str] = field(hash=False)  # versions by name
    limits: dict[str, int] = field(hash=False)
    retention: dict[str, float] = field(hash=False)
    store_info: dict[str, float | int | str] | None = field(default=None, hash=False)


class Server:
    """A connection to a server. `connect` makes one that is asked for a world; several worlds
    share one.
    """

    def __init__(self, address: str | None = None, *, timeout_s: float | None = None):
        """address: "unix:PATH" or "HOST:PORT", None: `default_address()`.

        Unavailable when none answers there; PermissionDenied when none was given and another user
        could answer in the server's place.
        """
        self.timeout_s = check_timeout(timeout_s)
        self.connection = Connection(address)
        try:
            self.connection.limits(self.timeout_s)
        except BaseException:
            self.close()
            raise

    def __enter__(self) -> Server:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def __repr__(self) -> str:
        return f"<Server {self.connection.address}>"

    def close(self) -> None:
        """Ends the connection, and every watch over it."""
        self.connection.close()

    def info(self) -> ServerInfo:
        """The server's version, engines, limits and store."""
        reply = self.connection.call(
            self.connection.admin.GetServerInfo, admin_pb2.GetServerInfoRequest(), self.timeout_s
        )

        def values(message) -> dict:
            return {
                descriptor.name: getattr(message, descriptor.name)
                for descriptor in message.DESCRIPTOR.fields
            }

        return ServerInfo(
            reply.version,
            reply.uptime_s,
            reply.store,
            {e.name: e.version for e in reply.engines},
            values(reply.limits),
            values(reply.retention),
            values(reply.store_info) if reply.HasField("store_info") else None,
        )

    def worlds(self) -> list[WorldInfo]:
        """By name."""
        reply = self.connection.call(
            self.connection.worlds.ListWorlds, world_pb2.ListWorldsRequest(), self.timeout_s
        )
        return [
            WorldInfo(
                w.name,
                w.world_uid,
                w.revision,
                w.object_count,
                w.robot_count,
                w.oldest_exact_revision,
                w.oldest_watch_revision,
            )
            for w in reply.worlds
        ]

    def world(self, name: str = "default") -> World:
        """The world of that name, there or not: the first ingest, put or load of a robot makes
        it.
        """
        return World(self, name, self.timeout_s)

    def delete_world(self, name: str) -> None:
        """Ends the world, and with NotFound its watches."""
        request = world_pb2.DeleteWorldRequest(
            world=arrays.text(name, "name"), request_id=new_request_id()
        )
        self.connection.call(self.connection.worlds.DeleteWorld, request, self.timeout_s)


def connect(
    address: str | None = None, world: str = "default", *, timeout_s: float | None = None
) -> World:
    """A world of a server, to be used in a `with`.

    address: "unix:PATH" or "HOST:PORT"; None: $CWM_ADDR, else the Unix socket that a server listens
    on by default. timeout_s: of every call, None: no limit (`World.within` sets another one).
    Unavailable when no server answers.
    """
    arrays.text(world, "world")
    return Server(address, timeout_s=timeout_s).world(world)
