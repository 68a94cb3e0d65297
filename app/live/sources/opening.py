"""The source that an address names, or the two of a stereo pair."""

from __future__ import annotations

from functools import partial
from pathlib import Path

from app.files.image_files import is_still
from app.live.address import LiveAddress, LiveInput
from app.live.sources.both_eyes import BothEyesSource
from app.live.sources.paired import PairedSource
from app.live.sources.source import Source, Wish
from renderer.readers.clip_options import StereoLayout
from renderer.readers.video_decoding.stereo_layout import chosen_layout
from renderer.readers.video_header import read_video_header


def open_input(asked: LiveInput, wish: Wish) -> Source:
    """Opened, which may take seconds; called by the thread that will read it.

    Raises:
        SourceLost: nothing comes from there now.
        UserError, ClipError: nothing ever will.
    """
    if asked.right is not None:
        left, right = (partial(open_source, one, wish) for one in asked.addresses)
        return PairedSource((left, right), (asked.address.name, asked.right.name))
    source = open_source(asked.address, wish)
    layout = chosen_layout(asked.stereo, _told(asked))
    return source if layout is None else BothEyesSource(source, layout)


def open_source(address: LiveAddress, wish: Wish) -> Source:
    """One source; raises as `open_input`."""
    if address.kind == "file":
        from app.live.sources.played import PlayedSource

        return PlayedSource(Path(address.where), wish)
    if address.kind == "stream":
        from app.live.sources.stream import StreamSource

        return StreamSource(address.where, address.name)
    from app.live.sources.device import DeviceSource

    return DeviceSource(address.where, address.name, wish)


def _told(asked: LiveInput) -> StereoLayout | None:
    """What a file says of itself. Raises ClipError: it is no video."""
    path = Path(asked.address.where)
    if asked.stereo != "auto" or asked.address.kind != "file" or not path.is_file() or is_still(path):
        return None
    return read_video_header(path).stereo
