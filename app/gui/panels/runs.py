"""Reconstructions that wait for their turn."""

from __future__ import annotations

from imgui_bundle import icons_fontawesome_4 as icons
from imgui_bundle import imgui, imgui_ctx

from app.gui import queue_actions, theme
from app.gui.legible import legible
from app.gui.state import AppState, Waiting
from app.gui.widgets import em, explain


def draw_runs(state: AppState) -> None:
    """What waits, the next one first."""
    imgui.text_unformatted("Waiting")
    explain("One reconstruction is made at a time; these follow by themselves.")
    if not state.queue:
        imgui.same_line()
        imgui.text_colored(theme.now().muted, "nothing")
        return
    if not state.reconstruction.is_alive and (reason := queue_actions.why_held(state)):
        with imgui_ctx.push_text_wrap_pos(0):
            imgui.text_colored(theme.now().warning, reason)
    for place, waiting in enumerate(state.queue):
        with imgui_ctx.push_id(f"waiting {place}"):
            _draw_waiting(state, waiting, first=place == 0)


def _draw_waiting(state: AppState, waiting: Waiting, *, first: bool) -> None:
    request = waiting.request
    imgui.align_text_to_frame_padding()
    end = imgui.get_content_region_avail().x - 2 * (imgui.get_frame_height() + em(0.3))
    imgui.text_unformatted(f"{request.config.method} · {request.input} · {request.config.iterations:,} steps")
    explain(f"{legible(waiting.clip.name)}: {request.run_path}")
    imgui.same_line(end)
    imgui.begin_disabled(first)
    if imgui.button(f"{icons.ICON_FA_ARROW_UP}###to front"):
        queue_actions.to_front(state, waiting)
    imgui.end_disabled()
    explain("Move to the front: make this one next.")
    imgui.same_line(0, em(0.3))
    if imgui.button(f"{icons.ICON_FA_TIMES}###withdraw"):
        queue_actions.withdraw(state, waiting)
    explain("Take it out of the queue.")
