"""What the panel says before an export: what its file will not hold, and what is assumed."""

from __future__ import annotations

from functools import lru_cache

from app.exports.splats.writing import SPZ
from app.gui.actions.export_actions import suffix_of
from app.gui.actions.export_offers import OFFERS, ONE_COLOR, THROUGH_TIME
from app.gui.state.app_state import AppState
from app.scenes.clip_speed import FRAMES_PER_SECOND
from renderer.raw_gaussians import RawGaussians
from renderer.splat_files.spz_writing import clipped


def doubts(state: AppState) -> str:
    """What the model has and the chosen format does not hold, and what is assumed, in sentences; empty for
    nothing."""
    model, offer = state.scene.model, OFFERS[state.exports.what]
    if model is None:
        return ""
    loses = suffix_of(state) in ONE_COLOR and model.model.raw.harmonics.shape[1] > 0
    plays = (offer.form in THROUGH_TIME or offer.sees == "time") and len(model.cameras) > 1
    said = ["Colours by direction are left out of the file."] if loses else []
    if suffix_of(state).endswith(SPZ):
        said += (f"{notice}." for notice in _clipped(model.model.raw))
    if plays and model.frames_per_second is None:
        said.append(
            f"How fast the clip goes is not known: {FRAMES_PER_SECOND:g} frames a second are assumed."
        )
    return " ".join(said)


@lru_cache(maxsize=1)
def _clipped(raw: RawGaussians) -> tuple[str, ...]:
    """Asked at every frame of the panel, and counted once."""
    return clipped(raw)
