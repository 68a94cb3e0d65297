"""What a user works with comes back at the next start: method, statistics, pixels, comparison, where the
second window is, and the views of what is open."""

from __future__ import annotations

from dataclasses import replace

from app.enhancement.methods import preset_of
from app.gui.actions import actions, clip_actions
from app.gui.state.app_state import AppState
from app.gui.work.presets import BUILT_IN


def begin(state: AppState) -> None:
    """As the last window left it, the method with its standard parameters and without differences: what was
    turned far up for one clip surprises nobody at the next, nor does an image that one hardly recognises.

    At the very first start it is Vessel: vessels become clearer on every kind of picture that it was tried
    on, where the paper's method makes them fainter on some.
    """
    known, chosen = state.settings, state.enhancement
    chosen.params = next(params for params in BUILT_IN.values() if preset_of(params) == known.method)
    chosen.scope, chosen.pixels = known.scope, known.pixels
    mode = "side by side" if known.mode == "difference" else known.mode
    state.comparing.chosen = replace(state.comparing.chosen, mode=mode)
    chosen.past = [state.chosen]


def remember(state: AppState) -> None:
    """Called while no control is held: the choices are kept as soon as they change."""
    chosen = state.enhancement
    settings = replace(
        state.settings,
        method=preset_of(chosen.params),
        scope=chosen.scope,
        pixels=chosen.pixels,
        mode=state.comparing.chosen.mode,
    )
    if (second := state.second_window).shown and second.place is not None:
        settings = replace(settings, second_place=second.place, second_full_screen=second.full_screen)
    if settings != state.settings:
        actions.use_settings(state, settings)
    clip_actions.keep_views(state)
