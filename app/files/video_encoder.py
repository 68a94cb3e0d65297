"""What writes videos on this machine, and who can play them."""

from __future__ import annotations

import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from shutil import which
from typing import Final, Literal

from app.errors import UserError
from app.files.codecs import CODECS, MP4, Codec, ending_of
from renderer.pyav_presence import has_pyav, why_not_pyav

H264: Final = ("libx264", "libopenh264", "h264_videotoolbox", "h264_mf")
"""Encoders of FFmpeg that need no graphics card, the best one first."""
NO_ENCODER: Final = "VP9 and HEVC need PyAV with their encoders: pip install av"
SECONDS: Final = 20
"""That FFmpeg may take to say what it can do."""


@dataclass(frozen=True)
class VideoEncoder:
    """A program and the encoder in it."""

    program: Literal["PyAV", "ffmpeg", "OpenCV"]
    name: str
    """As the program calls it."""

    @property
    def plays_in_browsers(self) -> bool:
        return self.program != "OpenCV"

    @property
    def said(self) -> str:
        """In a line, before a video is made."""
        if self.program == "PyAV":
            return "H.264, encoded by PyAV: plays everywhere, also in browsers."
        if self.program == "ffmpeg":
            return (
                f"H.264, encoded by this system's ffmpeg ({self.name}): plays everywhere, also in browsers."
            )
        return "MPEG-4 part 2, encoded by OpenCV: media players show it, browsers do not."

    @property
    def way_out(self) -> str:
        """What makes it H.264; empty where it is."""
        if self.plays_in_browsers:
            return ""
        pip = "" if getattr(sys, "frozen", False) else ", or PyAV (pip install av)"
        broken = f" {said}." if (said := why_not_pyav()) else ""
        return f"For H.264, install ffmpeg{pip}, then start VesselSplat again.{broken}"


def video_encoder() -> VideoEncoder:
    """The best there is; asking FFmpeg takes a moment."""
    if has_pyav() and _pyav_has("libx264"):
        return VideoEncoder("PyAV", "libx264")
    known = _ffmpeg_encoders()
    found = next((name for name in H264 if name in known), None)
    return VideoEncoder("OpenCV", "mp4v") if found is None else VideoEncoder("ffmpeg", found)


def _pyav_has(name: str) -> bool:
    """Some systems build it without."""
    from av.codec import codecs_available

    return name in codecs_available


def _ffmpeg_encoders() -> set[str]:
    """Names of the encoders of the system's FFmpeg; empty without one."""
    if (program := which("ffmpeg")) is None:
        return set()
    command = (program, "-hide_banner", "-loglevel", "error", "-encoders")
    try:
        told = subprocess.run(
            command, stdin=subprocess.DEVNULL, capture_output=True, timeout=SECONDS, check=False
        )
    except (OSError, subprocess.TimeoutExpired):
        return set()
    lines = (line.split() for line in told.stdout.decode(errors="replace").splitlines())
    return {words[1] for words in lines if len(words) > 1}


def codec_for(path: Path) -> Codec:
    """By the ending of the name.

    Raises UserError: it needs an encoder that is not there.
    """
    ending = ending_of(path) or MP4
    if not is_encoded(ending):
        raise UserError(f"{NO_ENCODER}, or a name that ends in {MP4}: {path}")
    return CODECS[ending]


def is_encoded(ending: str) -> bool:
    """Whether videos of that ending of CODECS can be written: of any other than MP4, by PyAV alone."""
    return ending == MP4 or (has_pyav() and _pyav_has(CODECS[ending].encoder))
