"""What to export, how large, how far it has come."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from imgui_bundle import ImVec2, imgui, imgui_ctx

from app.exports.sizing import LEAST_WIDTH, MOST_WIDTH, Sizing
from app.files.legible import legible
from app.gui.actions import export_actions, window_actions
from app.gui.actions.export_actions import OFFERS
from app.gui.state.app_state import AppState
from app.gui.style.widgets import button, choose, choose_row, em, explain, floating, muted, note
from app.scenes.supersampling import FACTORS

OTHER_WIDTH, OTHER_SIZE = Sizing(width=1024), (1024, 1024)
SCALES = {Sizing(scale): f"{scale}×" for scale in (1, 2, 3, 4)} | {OTHER_WIDTH: "Width…"}
SCALE_TEXT = "File pixels per image pixel along each axis, or a width in pixels to resample to."
SIZES = ((1280, 720), (1920, 1080), (2560, 1440), (3840, 2160))
VIEW_SIZES: dict[tuple[int, int] | None, str] = {
    None: "As shown", **{size: f"{size[0]} × {size[1]}" for size in SIZES}, OTHER_SIZE: "Other…"
}  # fmt: skip
SAMPLINGS = {factor: "No supersampling" if factor == 1 else f"{factor}× supersampling" for factor in FACTORS}
VIEW_TEXT = (
    "Size of the 3D view in pixels. As shown: its shape on screen, at least as large as the clip's frames."
)
FACTOR_TEXT = (
    "Supersampling: rendered with this many times the pixels along each axis, then averaged. "
    "Smoother edges, slower."
)
WINDOW_TEXT = "F12: the whole window as it is on screen. It cannot be replayed."
GROUPS = (("Images", ("picture",)), ("Videos", ("panes video", "view video")), ("Measures", ("measures",)))
REPLAY = "Each file records how it was made: vesselsplat replay FILE reproduces it."


def draw_export(state: AppState) -> None:
    """A window of its own."""
    if not state.exports.shown:
        return
    beside = floating(42)
    # Not in a picture of the window that is about to be taken.
    alpha = 0.0 if state.exports.settling else imgui.get_style().alpha
    with (
        imgui_ctx.push_style_var(imgui.StyleVar_.alpha, alpha),
        imgui_ctx.begin("Export", True, beside) as window,
    ):
        export_actions.show_exports(state, bool(window.opened))
        if not window:
            return
        _draw_picture_size(state)
        _draw_view_size(state)
        imgui.spacing()
        _draw_progress(state)
        for title, forms in GROUPS:
            imgui.separator_text(title)
            for what, offer in OFFERS.items():
                if offer.form in forms:
                    start = partial(export_actions.export_request, state, what)
                    reason = export_actions.why_not_export(state, what)
                    _draw_row(f"{offer.label}###{what}", offer.text, start, reason)
            if "picture" in forms:
                _draw_row("Window###window", WINDOW_TEXT, lambda: window_actions.save_window(state))


def _draw_row(label: str, text: str, act: Callable[[], object], reason: str = "") -> None:
    """A button and what it does; greyed for a `reason`."""
    button(label, act, reason=reason, width=10)
    imgui.same_line()
    imgui.align_text_to_frame_padding()
    note(text)


def _draw_picture_size(state: AppState) -> None:
    sizing = state.exports.sizing
    now = sizing if sizing.width is None else OTHER_WIDTH
    chosen = choose_row("Panes", now, SCALES, SCALE_TEXT, 8)
    if chosen != now:
        export_actions.choose_sizing(state, chosen)
    if state.exports.sizing.width is not None:
        imgui.same_line()
        width = _pixels("##width", state.exports.sizing.width, "Width of each pane, in pixels.")
        imgui.same_line()
        muted("pixels")
        export_actions.choose_sizing(state, Sizing(width=width))


def _draw_view_size(state: AppState) -> None:
    size = state.exports.view_size
    now = size if size in VIEW_SIZES else OTHER_SIZE
    chosen = choose_row("3D view", now, VIEW_SIZES, VIEW_TEXT, 8)
    if chosen != now:
        export_actions.choose_view_size(state, chosen)
    elif now == OTHER_SIZE and size is not None:
        imgui.same_line()
        width = _pixels("##view width", size[0], "Width in pixels.")
        imgui.same_line()
        imgui.text("×")
        imgui.same_line()
        height = _pixels("##view height", size[1], "Height in pixels.")
        export_actions.choose_view_size(state, (width, height))
    imgui.same_line()
    factor = choose("supersampling", state.exports.supersampling, SAMPLINGS, FACTOR_TEXT, 10)
    export_actions.choose_supersampling(state, factor)


def _pixels(label: str, value: int, text: str) -> int:
    """A number of pixels that is typed; half-typed ones do not count."""
    imgui.set_next_item_width(em(5))
    _, typed = imgui.input_int(label, value, 0, 0)
    explain(text)
    return min(max(typed, LEAST_WIDTH), MOST_WIDTH)


def _draw_progress(state: AppState) -> None:
    under_way = state.exports.under_way
    if under_way is None:
        note(f"Saved to {legible(str(state.places.pictures))}")
        note(REPLAY)
        return
    total, done = max(under_way.steps, 1), state.exports.done
    imgui.progress_bar(done / total, ImVec2(-em(7), 0), state.exports.pace.told(total))
    imgui.same_line()
    button("Cancel", partial(export_actions.cancelled, state), "No file is left incomplete.", width=6)
    # As high as the two lines in its place, so that no button moves away from the pointer.
    imgui.dummy(ImVec2(0, 2 * imgui.get_text_line_height() - imgui.get_frame_height()))
