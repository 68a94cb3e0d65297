"""What to export, how large, how far it has come."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from imgui_bundle import ImVec2, imgui, imgui_ctx

from app.gui.actions import export_actions
from app.gui.actions.export_actions import OFFERS, What
from app.gui.look import theme
from app.gui.look.widgets import button, em, explain
from app.gui.state.app_state import AppState

SCALES = (1, 2, 3, 4)
Start = Callable[[What, int], None]


def draw_export(state: AppState, start: Start, cancel: Callable[[], None]) -> None:
    """A window of its own; `start` begins an export, `cancel` gives up the one under way."""
    if not state.export_open:
        return
    center = imgui.get_main_viewport().get_center()
    imgui.set_next_window_pos(center, imgui.Cond_.appearing, ImVec2(0.5, 0.5))
    imgui.set_next_window_size(ImVec2(em(42), 0), imgui.Cond_.appearing)
    flags = imgui.WindowFlags_.no_collapse | imgui.WindowFlags_.no_docking
    with imgui_ctx.begin("Export", True, flags) as window:
        state.export_open = bool(window.opened)
        if not window:
            return
        _draw_scale(state)
        imgui.separator()
        for what, offer in OFFERS.items():
            reason = export_actions.why_not_export(state, what)
            act = partial(start, what, state.export_scale)
            button(f"{what[0].upper()}{what[1:]}###{what}", act, enabled=not reason, width=12)
            explain(reason or offer.text)
            imgui.same_line()
            imgui.align_text_to_frame_padding()
            imgui.text_colored(theme.now().muted, offer.text)
        imgui.separator()
        _draw_progress(state, cancel)


def _draw_scale(state: AppState) -> None:
    imgui.align_text_to_frame_padding()
    imgui.text("Size")
    imgui.same_line(em(6.2))
    imgui.set_next_item_width(em(6))
    labels = [f"{scale}×" for scale in SCALES]
    _, index = imgui.combo("##scale", SCALES.index(state.export_scale), labels)
    explain("Pixels of the file a pixel of the picture, each way. The 3D view is drawn with as many.")
    state.export_scale = SCALES[index]


def _draw_progress(state: AppState, cancel: Callable[[], None]) -> None:
    under_way = state.exporting
    if under_way is None:
        imgui.text_colored(
            theme.now().muted, "Everything says inside or beside it how it was made: vesselsplat replay."
        )
        return
    total = max(under_way.request.steps, 1)
    imgui.progress_bar(under_way.done / total, ImVec2(-em(7), 0), f"{under_way.done} of {total}")
    imgui.same_line()
    button("Cancel", cancel, width=6)
    explain("Nothing is left half-written.")
