"""The ways in which a clip can come by depth, and why not by the others, before a person chooses one."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Final, Literal, get_args

from renderer.clip import Clip, ClipError
from renderer.depth.clip_depth import why_not_by_motion, with_depth
from renderer.depth.monocular import monocular_maps
from renderer.depth.stereo_pairs import right_eye
from renderer.readers.clip_options import ClipOptions, DepthSource

DepthWay = Literal["measured", "stereo", "motion", "guessed"]
DEPTH_WAYS: Final[tuple[DepthWay, ...]] = get_args(DepthWay)


@dataclass(frozen=True)
class DepthWays:
    """What a clip, as its own files give it, can be read with."""

    why_not: Mapping[DepthWay, str]
    """Of every way, in a sentence; empty: it can be."""
    guess: DepthSource
    """Of what a guess would be made."""

    def source(self, way: DepthWay) -> DepthSource:
        """The option that reads the clip in this way; "auto" where that comes to the same."""
        if way == "guessed":
            return self.guess
        auto: DepthWay = "stereo" if self.why_not["measured"] else "measured"
        return "auto" if way == auto else way


def way_of(clip: Clip) -> DepthWay | None:
    """In which its depth was come by, or is to be in training; None without any."""
    if clip.depth_origin == "motion":
        return "motion"
    if not clip.has_depth:
        return None
    if clip.depth_origin in ("monocular", "brightness"):
        return "guessed"
    return "stereo" if clip.depth_origin == "stereo" else "measured"


def depth_ways(bare: Clip, options: ClipOptions) -> DepthWays:
    """Of a clip without any depth but that of its files. Looks at a few pairs of a stereo clip."""
    if not bare.has_one_size:
        why = f"{bare.why_no_depth[:1].upper()}{bare.why_no_depth[1:]}."
        return DepthWays(dict.fromkeys(DEPTH_WAYS, why), "brightness")
    moves = "" if bare.camera_is_fixed else "The camera moves by known lengths, and a guess has no scale."
    why_not: dict[DepthWay, str] = {
        "measured": "" if bare.has_depth else "This clip comes with no measured depth.",
        "stereo": _why_not_stereo(bare, options),
        "motion": _sentence(why_not_by_motion(bare)),
        "guessed": moves,
    }
    return DepthWays(why_not, "monocular" if _has_maps(bare) else "brightness")


def _why_not_stereo(bare: Clip, options: ClipOptions) -> str:
    try:
        if right_eye(bare) is None:
            return "This clip has no right images to match with the left ones."
        with_depth(bare, replace(options, depth="stereo"))
    except (ClipError, OSError) as error:
        # A person knows which clip it is.
        return _sentence(str(error).removesuffix(f": {bare.path}"))
    return ""


def _sentence(said: str) -> str:
    return f"{said[:1].upper()}{said[1:]}." if said else ""


def _has_maps(bare: Clip) -> bool:
    try:
        return bool(monocular_maps(bare))
    except (ClipError, OSError):
        return False
