"""What the panel says before an export: what its file will not hold, and what is assumed."""

from __future__ import annotations

from functools import lru_cache
from typing import Final

from app.exports.splats.writing import COMPRESSED, clipped
from app.gui.actions.export_actions import suffix_of
from app.gui.actions.export_offers import OFFERS, ONE_COLOR
from app.gui.state.app_state import AppState
from app.scenes.clip_speed import FRAMES_PER_SECOND
from renderer.raw_gaussians import RawGaussians

MOST_ORDERED: Final = 20_000
"""Gaussians that are put in the order of a compressed PLY within a frame of the window, in about 50 ms."""


def doubts(state: AppState) -> str:
    """What the model has and the chosen format does not hold, and what is assumed, in sentences; empty for
    nothing."""
    model, said = state.scene.model, list[str]()
    if model is not None and suffix_of(state) in ONE_COLOR and model.model.raw.harmonics.shape[1] > 0:
        said.append("Colours by direction are left out of the file.")
    if model is not None:
        said += (f"{notice}." for notice in _clipped(suffix_of(state), model.model.raw))
    if _assumes_speed(state):
        said.append(
            f"How fast the clip goes is not known: {FRAMES_PER_SECOND:g} frames a second are assumed."
        )
    if _evens_out(state):
        said.append("The frame rate of the clip varies: here frames follow evenly, at its average.")
    return " ".join(said)


def _evens_out(state: AppState) -> bool:
    """Of what plays a model: its moments are numbered, not timed."""
    clip, offer = state.source.clip, OFFERS[state.exports.what]
    plays = offer.traits.plays or offer.sees == "time"
    return plays and clip is not None and not clip.is_steady and not state.shows_other_clip


def _assumes_speed(state: AppState) -> bool:
    """Of what plays: videos of panes as fast as the clip, those of the model as fast as that."""
    model, clip, offer = state.scene.model, state.source.clip, OFFERS[state.exports.what]
    if offer.form in ("panes video", "DICOM video"):
        return clip is not None and len(clip) > 1 and clip.frames_per_second is None
    plays = offer.traits.plays or offer.sees == "time"
    return plays and model is not None and len(model.cameras) > 1 and model.frames_per_second is None


@lru_cache(maxsize=1)
def _clipped(ending: str, raw: RawGaussians) -> tuple[str, ...]:
    """Asked at every frame of the panel, and counted once; what takes too long, the record alone tells."""
    if ending.endswith(COMPRESSED) and len(raw) > MOST_ORDERED:
        return ()
    return clipped(ending, raw)
