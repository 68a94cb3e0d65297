"""A program that fetches live pictures: it has one message at a time under way, whatever its pace."""

from __future__ import annotations

import socket
from typing import Final

HEARD: Final = 65536
"""Bytes of what a client says that are read at once, and passed over."""
BUFFER: Final = 1 << 19
"""Bytes that the system may hold for a client, so that it gets no pictures of long ago."""


class Client:
    """Written and read by one thread, which never waits for it."""

    def __init__(self, connection: socket.socket) -> None:
        self.connection = connection
        connection.setblocking(False)
        connection.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, BUFFER)
        connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self.has = 0
        """Number of the newest picture that was begun."""
        self._rest = memoryview(b"")

    @property
    def is_idle(self) -> bool:
        """The message before is sent."""
        return not self._rest

    def begin(self, number: int, message: memoryview) -> None:
        """The message of that picture, after the one before."""
        self.has, self._rest = number, message

    def write(self) -> bool:
        """As much as it takes now; True when that ends a message. Raises OSError: it is gone."""
        was_idle = self.is_idle
        try:
            while self._rest:
                self._rest = self._rest[self.connection.send(self._rest) :]
        except (BlockingIOError, InterruptedError):
            return False
        return not was_idle

    def hear(self) -> None:
        """Pass over what it says. Raises OSError: it is gone."""
        try:
            if not self.connection.recv(HEARD):
                raise ConnectionResetError("closed by the client")
        except (BlockingIOError, InterruptedError):
            return
