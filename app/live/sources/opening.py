"""The source that an address names."""

from __future__ import annotations

from pathlib import Path

from app.live.address import LiveAddress
from app.live.sources.source import Source, Wish


def open_source(address: LiveAddress, wish: Wish) -> Source:
    """Opened, which may take seconds; called by the thread that will read it.

    Raises:
        SourceLost: nothing comes from there now.
        UserError, ClipError: nothing ever will.
    """
    if address.kind == "file":
        from app.live.sources.played import PlayedSource

        return PlayedSource(Path(address.where), wish)
    if address.kind == "stream":
        from app.live.sources.stream import StreamSource

        return StreamSource(address.where, address.name, wish)
    from app.live.sources.device import DeviceSource

    return DeviceSource(address.where, address.name, wish)
