"""The codecs that videos are written with, by the ending of their names."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Final

MP4: Final = ".mp4"
WEBM: Final = ".webm"
HEVC: Final = ".hevc.mp4"


@dataclass(frozen=True)
class Codec:
    """How FFmpeg makes it; the quality is such that a generation more is not seen."""

    name: str
    encoder: str
    options: Mapping[str, str]
    container: str
    sounds: frozenset[str]
    """Codecs of sound that are copied: the container holds them and players know them."""
    sound: str
    """The encoder of any other sound, and what it makes in words."""
    sound_name: str
    tag: str | None = None
    """By which players of one maker know it."""


IN_MP4: Final = frozenset({"aac", "ac3", "alac", "eac3", "flac", "mp3", "opus"})
# Macroblock-tree rate control reads stray memory in x264 165 (its AVX code, where the blocks in a row are no
# multiple of 16): one video would not become the same bytes twice.
H264: Final = Codec(
    name="H.264",
    encoder="libx264",
    options={"crf": "16", "preset": "veryfast", "x264-params": "mbtree=0"},
    container="mp4",
    sounds=IN_MP4,
    sound="aac",
    sound_name="AAC",
)
CODECS: Final[Mapping[str, Codec]] = {
    MP4: H264,
    WEBM: Codec(
        name="VP9",
        encoder="libvpx-vp9",
        options={"crf": "20", "b": "0", "deadline": "realtime", "cpu-used": "6", "row-mt": "1"},
        container="webm",
        sounds=frozenset({"opus", "vorbis"}),
        sound="libopus",
        sound_name="Opus",
    ),
    HEVC: Codec(
        name="HEVC",
        encoder="libx265",
        options={"crf": "16", "preset": "ultrafast", "x265-params": "log-level=none"},
        container="mp4",
        sounds=IN_MP4,
        sound="aac",
        sound_name="AAC",
        tag="hvc1",
    ),
}
"""H.264 plays everywhere; VP9 in browsers and without licences; HEVC on newer devices, in smaller files."""


def ending_of(path: Path) -> str:
    """The ending of CODECS that the name has; empty for none."""
    name = path.name.lower()
    return next((ending for ending in (HEVC, WEBM, MP4) if name.endswith(ending)), "")
