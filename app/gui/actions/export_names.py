"""What exported files are called: after what is open, the frame, and what is shown of it."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Final

from app.files.device_names import is_device
from app.gui.actions.export_offers import OFFERS, Offer
from app.gui.state.app_state import AppState
from app.gui.state.exports import What

LONGEST: Final = 150
"""Characters: a number and a suffix are still to come, and file systems hold some 250."""
REFUSED: Final = re.compile(r'[\x00-\x1f\x7f/\\\\:*?"<>|]')
"""Characters that one system or another allows in no name."""


def default_name(state: AppState, what: What) -> str:
    """Without suffix: "liver-frame-12-left", "liver-frames-1-40-measures", "still-shown"."""
    offer = OFFERS[what]
    if offer.is_dicom:
        # Files are often named after patients.
        return "-".join(filter(None, (offer.name, _when(state, offer))))
    told = "-".join(filter(None, (_when(state, offer), offer.name, _seen(state, offer))))
    # Not by the very name of the still that is open.
    return f"{_of(state, offer)}-{told or 'shown'}"


def why_not_name(name: str) -> str:
    """What keeps it from being the name of a file, in a sentence; empty for nothing."""
    if found := REFUSED.search(name):
        return f"A name cannot contain {found[0]!r}."
    if name.startswith(".") or name.endswith((".", " ")):
        return "A name cannot begin or end with a dot or a space."
    if is_device(name):
        return "A name cannot be that of a device of Windows."
    return f"A name can have up to {LONGEST} characters." if len(name) > LONGEST else ""


def _of(state: AppState, offer: Offer) -> str:
    """The clip, or the model where nothing else is shown."""
    clip, model = state.source.clip, state.scene.model
    alone = offer.is_of_model or offer.form == "view video" or offer.sees == "still"
    name = clip.path.stem if clip is not None and not (alone and not offer.sides) else None
    if name is None and model is not None:
        name = Path(model.name).stem
    return REFUSED.sub("-", name or "vesselsplat").strip(". ")[: LONGEST // 2] or "vesselsplat"


def _when(state: AppState, offer: Offer) -> str:
    """Frames are counted as the timeline does."""
    clip, model = state.source.clip, state.scene.model
    if offer.form in ("panes video", "measures"):
        first, last = state.source.span
        return f"frames-{first + 1}-{last + 1}" if clip is None or len(clip) > 1 else ""
    if offer.form == "splats" and model is not None:
        return f"frame-{model.number_at(state.time):g}" if len(model.cameras) > 1 else ""
    if offer.form in ("picture", "DICOM still") and clip is not None and len(clip) > 1:
        return f"frame-{state.timeline.shown_index + 1}"
    return ""


def _seen(state: AppState, offer: Offer) -> str:
    """The kind of the 3D view where it is shown alone."""
    alone = offer.sees != "no" and not offer.sides and offer.form != "cameras"
    return state.scene.kind.replace(" ", "-") if alone and state.scene.kind != "color" else ""
