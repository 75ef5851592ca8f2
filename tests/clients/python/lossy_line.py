"""A line to a server that loses replies: bytes between a client and the socket of a server."""

from __future__ import annotations

import os
import socket
import tempfile
import threading


class LossyLine:
    """Passes bytes on, both ways. After `lose_replies` the server hears the client, and the client
    nothing; `cut` ends every connection, and those that come afterwards are whole again.
    """

    def __init__(self, address: str) -> None:
        self._server = address.removeprefix("unix:")
        self._scratch = tempfile.TemporaryDirectory()
        path = os.path.join(self._scratch.name, "line.sock")
        self.address = "unix:" + path
        self._losing = threading.Event()
        self._ends: list[socket.socket] = []
        self._threads: list[threading.Thread] = []
        self._listener = socket.socket(socket.AF_UNIX)
        self._listener.bind(path)
        self._listener.listen()
        self._run(self._accept)

    def lose_replies(self) -> None:
        self._losing.set()

    def cut(self) -> None:
        ends, self._ends = self._ends, []
        self._losing.clear()
        for end in ends:
            _shut(end)

    def close(self) -> None:
        _shut(self._listener)
        self.cut()
        for thread in self._threads:
            thread.join(10)
        self._listener.close()
        self._scratch.cleanup()

    def _run(self, work, *arguments) -> None:
        thread = threading.Thread(target=work, args=arguments, daemon=True)
        self._threads.append(thread)
        thread.start()

    def _accept(self) -> None:
        while True:
            try:
                client, _ = self._listener.accept()
            except OSError:
                return
            server = socket.socket(socket.AF_UNIX)
            server.connect(self._server)
            self._ends += [client, server]
            lost = threading.Event()  # of this connection, once and for all
            self._run(self._pass_on, client, server, None)
            self._run(self._pass_on, server, client, lost)

    def _pass_on(
        self, source: socket.socket, sink: socket.socket, lost: threading.Event | None
    ) -> None:
        try:
            while data := source.recv(1 << 16):
                if lost is not None and self._losing.is_set():
                    lost.set()
                if lost is None or not lost.is_set():
                    sink.sendall(data)
        except OSError:
            pass
        _shut(sink)
        source.close()


def _shut(end: socket.socket) -> None:
    try:
        end.shutdown(socket.SHUT_RDWR)
    except OSError:
        pass  # the other side did already
