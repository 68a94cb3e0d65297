"""Whether what is on screen hides the vessels that it should show."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from app.enhancement.settable import ENHANCED
from app.gui.state.app_state import AppState
from app.gui.views.comparison import SIDES

LEAST: Final = 0.02
"""Share of the original's colour difference: less is nobody's loss."""


@dataclass(frozen=True)
class Fainter:
    """Colour difference (CIEDE2000) of vessels to their surroundings."""

    before: float
    after: float


def fainter(state: AppState) -> Fainter | None:
    """Of the frame on screen, where the enhancement that is shown makes vessels fainter than they were."""
    seen, pictures = state.picture.measured, state.picture.pictures
    shown = {state.comparing.chosen.source(side) for side in SIDES}
    if seen is None or pictures is None or ENHANCED not in shown or not state.enhancement.active:
        return None
    if seen.pictures is not pictures or pictures.request.params != state.enhancement.params:
        return None
    found = Fainter(seen.before.color_difference, seen.after.color_difference)
    return found if found.after < (1 - LEAST) * found.before else None
