"""Serves live pictures to programs that connect, in a thread of its own: each gets what it has time for.

pyigtl, which reads the messages in the tests, could send them as well, but its server has one client, keeps a
hundred pictures for it, drops it when a message takes longer than 10 ms and takes over Ctrl+C.
"""

from __future__ import annotations

import logging
import os
import selectors
import socket
import threading
from contextlib import suppress
from dataclasses import dataclass
from typing import Final

from app.errors import UserError, sentence
from app.live.igtl.client import Client
from app.live.igtl.endpoint import Endpoint
from app.live.igtl.message import message_of
from app.live.newest import Newest
from app.live.picture import LivePicture

MOST: Final = 8
"""Clients; more are turned away."""

log = logging.getLogger(__name__)


@dataclass(frozen=True)
class Sending:
    """How it stands; counts are summed over all clients."""

    address: str
    clients: int = 0
    """Connected now."""
    sent: int = 0
    """Pictures that went out to the last byte."""
    left_out: int = 0
    """Pictures that a connected client had no time for."""
    is_over: bool = False
    trouble: str = ""
    """Why it ended before it was told to."""

    def __str__(self) -> str:
        return f"sending to {self.address}, {self.clients} client{'' if self.clients == 1 else 's'}"


class Sender:
    """Give it pictures by `add`, which never waits; end it by `finish`."""

    def __init__(self, endpoint: Endpoint) -> None:
        """Listen at once. Raises UserError: the port or address is not to be had."""
        self.endpoint = endpoint
        self._door = _listening(endpoint)
        self._bell, self._rung = socket.socketpair()
        """A byte in it wakes the thread."""
        self._selector = selectors.DefaultSelector()
        for one in (self._door, self._bell, self._rung):
            one.setblocking(False)
        for one in (self._door, self._bell):
            self._selector.register(one, selectors.EVENT_READ)
        self._pictures: Newest[LivePicture] = Newest()
        self._clients: dict[socket.socket, Client] = {}
        self._number = 0
        """Of the newest picture, which `_picture` and, once a client has had time for it, `_message` are."""
        self._picture: LivePicture | None = None
        self._message: memoryview | None = None
        self._sent = self._left_out = 0
        self._ending, self._trouble = threading.Event(), ""
        self._thread = threading.Thread(target=self._run, name="vesselsplat-igtl", daemon=True)
        self._thread.start()

    @property
    def state(self) -> Sending:
        left_out = self._left_out + self._pictures.dropped
        is_over = not self._thread.is_alive()
        return Sending(str(self.endpoint), len(self._clients), self._sent, left_out, is_over, self._trouble)

    def add(self, picture: LivePicture) -> None:
        """The next picture, in the order of arrival; without a client it costs nothing."""
        if self._clients and not self._ending.is_set():
            self._pictures.put(picture)
            self._ring()

    def end(self) -> None:
        """Close all connections, without waiting for it."""
        self._ending.set()
        self._ring()

    def finish(self, timeout: float = 3.0) -> Sending:
        """The same, and wait for it."""
        self.end()
        self._thread.join(timeout)
        return self.state

    def _ring(self) -> None:
        # A full bell has been rung, and one that is gone has no one to wake.
        with suppress(OSError):
            self._rung.send(b"\0")

    def _run(self) -> None:
        try:
            while not self._ending.is_set():
                self._follow()
        except Exception as error:
            # The picture on the screen outlives whatever a connection or a message comes to.
            log.info("sending has ended early", exc_info=True)
            self._trouble = sentence(error)
        finally:
            self._close()

    def _follow(self) -> None:
        """Wait for a picture or a client, and do what there is to do."""
        ready = {key.fileobj for key, _ in self._selector.select()}
        if self._door in ready:
            self._let_in()
        if self._bell in ready:
            self._bell.recv(4096)
            self._take()
        for connection, client in [*self._clients.items()]:
            try:
                if connection in ready:
                    client.hear()
                self._serve(client)
            except OSError:
                log.info("a client is gone", exc_info=True)
                self._let_go(client)

    def _take(self) -> None:
        picture = self._pictures.take()
        if picture is None:
            return
        # Whoever has not begun the one before never will.
        self._left_out += sum(0 < self._number != client.has for client in self._clients.values())
        self._number, self._picture, self._message = self._number + 1, picture, None

    def _serve(self, client: Client) -> None:
        """Go on with its message, and then with the newest, until it takes no more for now."""
        self._sent += client.write()
        if client.is_idle and self._picture is not None and client.has < self._number:
            if self._message is None:
                self._message = message_of(self._picture)
            client.begin(self._number, self._message)
            self._sent += client.write()
        wanted = selectors.EVENT_READ | (0 if client.is_idle else selectors.EVENT_WRITE)
        self._selector.modify(client.connection, wanted)

    def _let_in(self) -> None:
        try:
            connection, _ = self._door.accept()
        except OSError:
            return  # It was gone again.
        if len(self._clients) == MOST:
            connection.close()
            return
        client = Client(connection)
        client.has = self._number
        self._selector.register(connection, selectors.EVENT_READ)
        self._clients[connection] = client

    def _let_go(self, client: Client) -> None:
        self._selector.unregister(client.connection)
        del self._clients[client.connection]
        client.connection.close()

    def _close(self) -> None:
        for client in [*self._clients.values()]:
            self._let_go(client)
        self._selector.close()
        for one in (self._door, self._bell, self._rung):
            one.close()


def _listening(endpoint: Endpoint) -> socket.socket:
    """Raises UserError: the port is taken, or the address is none of this computer."""
    family = socket.AF_INET6 if ":" in endpoint.host else socket.AF_INET
    try:
        return socket.create_server((endpoint.host, endpoint.port), family=family)
    except OSError as error:
        # Its own text names the address again, in another way on each system.
        reason = os.strerror(error.errno) if error.errno else sentence(error)
        raise UserError(f"cannot send at {endpoint}: {reason}") from error
