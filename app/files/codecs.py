"""The codecs that videos are written with, by the ending of their names."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Final

MP4: Final = ".mp4"
WEBM: Final = ".webm"
HEVC: Final = ".hevc.mp4"
BT709, BT470BG, BT601, BT2020 = 1, 5, 6, 9
"""Of colours, as ITU-T H.273 numbers them."""


@dataclass(frozen=True)
class Container:
    """What a file holds beside pictures."""

    name: str
    options: Mapping[str, str]
    sounds: frozenset[str]
    """Codecs of sound that are copied: it holds them and players know them."""
    sound: str
    """The encoder of any other sound."""
    sound_name: str
    """What that makes, in words."""
    sound_rate: int | None = None
    """Samples a second that it takes; None: any."""
    keeps_pixel_shape: bool = True
    """Whether PyAV can tell it that pixels are not square."""


@dataclass(frozen=True)
class Codec:
    """How FFmpeg makes it; the quality is such that a generation more is not seen."""

    name: str
    encoder: str
    options: Mapping[str, str]
    container: Container
    tag: str | None = None
    """By which players of one maker know it."""


IN_MP4: Final = Container(
    name="mp4",
    # With the index first, browsers start at once.
    options={"movflags": "+faststart"},
    sounds=frozenset({"aac", "ac3", "alac", "eac3", "flac", "mp3", "opus"}),
    sound="aac",
    sound_name="AAC",
)
IN_WEBM: Final = Container(
    name="webm",
    # It has names by chance, but for this flag: one video would not become the same bytes twice.
    options={"fflags": "+bitexact"},
    sounds=frozenset({"opus", "vorbis"}),
    sound="libopus",
    sound_name="Opus",
    sound_rate=48_000,
    keeps_pixel_shape=False,
)
CODECS: Final[Mapping[str, Codec]] = {
    # Macroblock-tree rate control reads stray memory in x264 165 (its AVX code, where the blocks in a row are
    # no multiple of 16): one video would not become the same bytes twice.
    MP4: Codec(
        name="H.264",
        encoder="libx264",
        options={"crf": "16", "preset": "veryfast", "x264-params": "mbtree=0"},
        container=IN_MP4,
    ),
    WEBM: Codec(
        name="VP9",
        encoder="libvpx-vp9",
        options={"crf": "20", "b": "0", "deadline": "realtime", "cpu-used": "6", "row-mt": "1"},
        container=IN_WEBM,
    ),
    HEVC: Codec(
        name="HEVC",
        encoder="libx265",
        options={"crf": "16", "preset": "ultrafast", "x265-params": "log-level=none"},
        container=IN_MP4,
        tag="hvc1",
    ),
}
"""H.264 plays everywhere; VP9 in browsers and without licences; HEVC on newer devices, in smaller files."""


def ending_of(path: Path) -> str:
    """The ending of CODECS that the name has; empty for none."""
    name = path.name.lower()
    return next((ending for ending in (HEVC, WEBM, MP4) if name.endswith(ending)), "")
