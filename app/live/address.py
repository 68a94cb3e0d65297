"""What a person names as a live source: a capture device, a stream, or a file or folder played as if live."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final, Literal
from urllib.parse import urlsplit

from app.errors import UserError
from app.files.legible import legible

STREAMS: Final = ("http", "https", "rtmp", "rtp", "rtsp", "rtsps", "srt", "tcp", "udp")
Kind = Literal["device", "stream", "file"]


@dataclass(frozen=True)
class LiveAddress:
    """One source, or, of a stereo pair that comes by two devices, that of one eye."""

    kind: Kind
    where: str
    """Number or path of a device, address of a stream, path of a file or folder."""
    name: str
    """As a person calls it; of a stream without what may be secret in it."""

    @classmethod
    def of_file(cls, path: Path) -> LiveAddress:
        return cls("file", str(path.absolute()), path.resolve().name)


@dataclass(frozen=True)
class Device:
    """A capture device as the system lists it."""

    where: str
    name: str


def address_of(said: str, devices: Sequence[Device] = ()) -> LiveAddress:
    """What is meant by `said`.

    Raises:
        UserError: neither number nor name of a device, nor address of a stream, nor a file or folder.
    """
    said = said.strip()
    scheme, colon, _ = said.partition("://")
    if colon:
        if scheme.lower() not in STREAMS:
            raise UserError(f"expected a stream by {', '.join(STREAMS)}, got {scheme}: {legible(said)}")
        return LiveAddress("stream", said, _without_secrets(said))
    for one in devices:
        if said in (one.where, one.name):
            return LiveAddress("device", one.where, one.name)
    if said.isdecimal():
        return LiveAddress("device", said, f"device {said}")
    if said.startswith("/dev/"):
        return LiveAddress("device", said, Path(said).name)
    path = Path(said)
    if said and path.exists():
        return LiveAddress.of_file(path)
    known = ", ".join(f"{one.where} ({one.name})" for one in devices) or "none"
    raise UserError(
        "expected a capture device by number or name, a stream address such as rtsp://HOST/PATH, or a file "
        f"or folder, got {legible(said)!r}; devices here: {known}"
    )


def _without_secrets(address: str) -> str:
    """Scheme, host and port: paths and queries hold keys, and users their passwords."""
    parts = urlsplit(address)
    try:
        port = f":{parts.port}" if parts.port else ""
    except ValueError:
        port = ""
    return f"{parts.scheme}://{parts.hostname or ''}{port}"
