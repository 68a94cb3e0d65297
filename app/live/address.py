"""What a person names as a live source: a capture device, a stream, or a file or folder played as if live."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final, Literal
from urllib.parse import urlsplit

from app.errors import UserError
from app.files.legible import legible
from renderer.readers.clip_options import Stereo

STREAMS: Final = ("http", "https", "rtmp", "rtp", "rtsp", "rtsps", "srt", "tcp", "udp")
Kind = Literal["device", "stream", "file"]


@dataclass(frozen=True)
class LiveAddress:
    """One source, of one eye or of both."""

    kind: Kind
    where: str
    """Number or path of a device, address of a stream, path of a file or folder."""
    name: str
    """As a person calls it; of a stream without what may be secret in it."""

    @classmethod
    def of_file(cls, path: Path) -> LiveAddress:
        return cls("file", str(path.absolute()), path.resolve().name or str(path))


@dataclass(frozen=True)
class LiveInput:
    """What is to be live."""

    address: LiveAddress
    """Of a stereo pair that comes from two sources, that of the left eye."""
    right: LiveAddress | None = None
    """The right eye's own source."""
    stereo: Stereo = "auto"
    """How both eyes lie in the frames of `address`. Auto: as a file says; other sources are of one eye."""

    @property
    def addresses(self) -> tuple[LiveAddress, ...]:
        return (self.address,) if self.right is None else (self.address, self.right)

    @property
    def name(self) -> str:
        return " and ".join(one.name for one in self.addresses)


@dataclass(frozen=True)
class Device:
    """A capture device as the system lists it."""

    where: str
    name: str


def names_itself(said: str) -> bool:
    """Whether it is clear without the list of devices: a stream, a number, a node, a file or a folder."""
    said = said.strip()
    return "://" in said or said.isdecimal() or said.startswith("/dev/") or Path(said).exists()


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


def input_of(
    address: LiveAddress, right: str | None, stereo: Stereo, devices: Sequence[Device] = ()
) -> LiveInput:
    """What is meant by a source, and by `right`, that of the right eye, where there is one.

    Raises:
        UserError: as `address_of`; one source for both eyes, or two whose frames are said to hold both.
    """
    if right is None:
        return LiveInput(address, stereo=stereo)
    if stereo not in ("auto", "off"):
        raise UserError(f"expected a source of the right eye or both eyes in one, got both: {stereo}")
    try:
        other = address_of(right, devices)
    except UserError as error:
        raise UserError(f"right eye: {error}") from error
    if other == address:
        raise UserError(f"expected another source for the right eye, got the same for both: {address.name}")
    return LiveInput(address, other)


def _without_secrets(address: str) -> str:
    """Scheme, host and port: paths and queries hold keys, and users their passwords.

    Raises UserError: it is no address.
    """
    try:
        parts = urlsplit(address)
    except ValueError as error:
        scheme = address.partition("://")[0]
        raise UserError(f"expected a stream such as {scheme}://HOST/PATH, got a HOST that is none") from error
    try:
        port = f":{parts.port}" if parts.port else ""
    except ValueError:
        port = ""
    return f"{parts.scheme}://{parts.hostname or ''}{port}"
