"""Where others fetch live pictures: an address of this computer and a port."""

from __future__ import annotations

from dataclasses import dataclass
from ipaddress import ip_address
from typing import Final

from app.console.flags import shortened
from app.errors import UserError

PORT: Final = 18944
"""Of OpenIGTLink."""
LOOPBACK: Final = "127.0.0.1"
EXPECTED: Final = "expected PORT or HOST:PORT to send at, a port from 1 to 65535 and a HOST of numbers"


@dataclass(frozen=True)
class Endpoint:
    """Nothing outside this computer reaches it unless a person names another host."""

    host: str = LOOPBACK
    """An IP address."""
    port: int = PORT

    def __str__(self) -> str:
        return f"[{self.host}]:{self.port}" if ":" in self.host else f"{self.host}:{self.port}"

    @property
    def is_local(self) -> bool:
        """Only programs of this computer can connect."""
        return ip_address(self.host).is_loopback

    @property
    def warning(self) -> str:
        """What a person is told who has named it; empty where frames stay on this computer."""
        if self.is_local:
            return ""
        return f"frames leave this computer: whoever reaches {self} sees them, and they may show a patient"


def endpoint_of(said: str) -> Endpoint:
    """What is meant by "PORT" or "HOST:PORT". Raises UserError: neither."""
    host, _, port = said.strip().rpartition(":")
    host = host.removeprefix("[").removesuffix("]") if ":" in said else LOOPBACK
    if host == "localhost":
        host = LOOPBACK
    try:
        if not (port.isascii() and port.isdecimal() and 0 < int(port) < 2**16):
            raise ValueError(port)
        # No name is looked up: that would ask the network.
        return Endpoint(str(ip_address(host)), int(port))
    except ValueError as error:
        raise UserError(f"{EXPECTED}, got {shortened(said)}") from error
