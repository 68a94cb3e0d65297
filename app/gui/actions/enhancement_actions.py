"""Method, parameters and statistics of the enhancement, and the steps of undo; as functions on the state."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import groupby
from typing import TypeVar

from app.enhancement.methods import EnhancementSettings
from app.enhancement.settable import Pixels, Scope
from app.gui.actions import actions
from app.gui.state.app_state import AppState

MOST_STEPS = 200
"""Of undo."""
L = TypeVar("L", bound=EnhancementSettings)


def set_params(state: AppState, params: EnhancementSettings) -> None:
    """Live, while a slider moves; `settle_params` makes it a step of undo."""
    state.enhancement.params = params


def use_params(state: AppState, params: EnhancementSettings, named: str) -> None:
    """Enhance with these parameters from now on and say so, calling them `named`; one step of undo."""
    enhance_by(state, params, state.enhancement.scope, state.enhancement.pixels, named)


def enhance_by(
    state: AppState, params: EnhancementSettings, scope: Scope, pixels: Pixels, named: str
) -> None:
    """The same with the statistics to use: all that the image depends on."""
    settle_params(state)
    chosen = state.enhancement
    chosen.params, chosen.scope, chosen.pixels, chosen.active = params, scope, pixels, True
    settle_params(state)
    actions.announce(state, f"now using {named}")


def latest(state: AppState, method: type[L]) -> L:
    """The parameters of a method, as they were when it was last chosen."""
    newest_first = (state.enhancement.params, *(step.params for step in reversed(state.enhancement.past)))
    return next((params for params in newest_first if isinstance(params, method)), method())


def choose_method(state: AppState, method: type[EnhancementSettings]) -> None:
    """Enhance by this method, with the parameters that it had last."""
    settle_params(state)
    state.enhancement.params = latest(state, method)


def choose_scope(state: AppState, scope: Scope) -> None:
    """What the automatic values are taken from."""
    state.enhancement.scope = scope


def choose_pixels(state: AppState, pixels: Pixels) -> None:
    """What counts in the statistics."""
    state.enhancement.pixels = pixels


def settle_params(state: AppState) -> None:
    """Called while no control is held: one drag of a slider is one step of undo."""
    chosen = state.chosen
    if chosen != state.enhancement.past[-1]:
        state.enhancement.past = [*state.enhancement.past[-MOST_STEPS:], chosen]
        state.enhancement.future.clear()


def rebase(state: AppState, past: Iterable[EnhancementSettings]) -> None:
    """Something else is open: of its past settings, undo goes back to those of the enhancement alone."""
    now = state.chosen
    state.enhancement.past = [now.with_params(params) for params, _ in groupby(past)]
    state.enhancement.future = []


def reset_params(state: AppState) -> None:
    """All that is set of the enhancement, but for the method."""
    chosen = state.enhancement
    chosen.params, chosen.scope, chosen.pixels = _defaults(state)


def can_reset(state: AppState) -> bool:
    """Something of that is not at its default."""
    chosen = state.enhancement
    return (chosen.params, chosen.scope, chosen.pixels) != _defaults(state)


def _defaults(state: AppState) -> tuple[EnhancementSettings, Scope, Pixels]:
    return type(state.enhancement.params)(), "automatic", "automatic"


def toggle_enhancement(state: AppState) -> None:
    state.enhancement.active = not state.enhancement.active


def peek(state: AppState, peeking: bool) -> None:
    """Show the original in the enhanced pane while a key is held."""
    state.enhancement.peeking = peeking


def white_light(state: AppState) -> None:
    """Plain white light on both sides, whatever was on."""
    state.enhancement.active = state.enhancement.peeking = False
