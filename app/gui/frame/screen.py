"""Which panels and bars the window has, and whether it fills the screen."""

from __future__ import annotations

from collections.abc import Callable

from imgui_bundle import glfw_utils, hello_imgui

from app.gui.actions import presenting, window_actions
from app.gui.frame import dockings
from app.gui.frame.bare import ALONE, Bare
from app.gui.frame.full_screen import FullScreen
from app.gui.frame.shares import Shares
from app.gui.state.app_state import AppState
from app.gui.style import theme

FRAMES_TO_END = 3
"""Bars come back with the next frame, panels get their part of what these leave with that after it."""


class Screen:
    """`add_timeline` gives the runner the toolbar that a presentation takes away."""

    def __init__(self, add_timeline: Callable[[hello_imgui.RunnerParams], None]) -> None:
        self._add_timeline = add_timeline
        self._bare, self._full_screen, self._ends_in = Bare(), FullScreen(), 0
        self._shares = Shares()

    def follow(self, state: AppState, params: hello_imgui.RunnerParams) -> None:
        """Before a frame."""
        presenting.follow(state)
        if self._bare.is_over and not window_actions.is_reduced(state):
            # The runner keeps the panels of the layout before, which are all there.
            dockings.follow_content(state)
        presents = state.presenting.pane is not None
        kept = () if presents else ALONE if state.window.bare else None
        self._bare.follow(kept, params.docking_params.dockable_windows)
        if not presents and self._bare.has_returned:
            presenting.end(state)
        self._shares.follow(params.docking_params)
        self._full_screen.follow(glfw_utils.glfw_window_hello_imgui(), state.window.full_screen)
        self._show_bars(params, shown=not presents)
        theme.show_ground_of_panels(shown=not presents)
        if self._ends_in:
            self._ends_in -= 1
            if not self._ends_in:
                dockings.quit_app()

    def _show_bars(self, params: hello_imgui.RunnerParams, *, shown: bool) -> None:
        window, calls = params.imgui_window_params, params.callbacks
        window.show_menu_bar = window.show_status_bar = shown
        # A presentation ends at fractions of pixels: what it leaves at its edges is as dark as it is.
        window.background_color = theme.now().ground if shown else theme.SURROUND
        if shown and not calls.edges_toolbars:
            self._add_timeline(params)
        elif not shown:
            calls.edges_toolbars = {}

    def end_whole(self, state: AppState) -> None:
        """The runner keeps panels and place for the next window when it ends: before, they are brought back,
        which takes some frames."""
        params = hello_imgui.get_runner_params()
        if params.app_shall_exit and window_actions.is_reduced(state):
            params.app_shall_exit, self._ends_in = False, FRAMES_TO_END
            window_actions.restore(state)
