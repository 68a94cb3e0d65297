"""Many files and folders enhanced with the current settings: which, where to, how far, what failed."""

from __future__ import annotations

from functools import partial

from imgui_bundle import ImVec2, imgui, imgui_ctx
from imgui_bundle import icons_fontawesome_4 as icons

from app.files.legible import in_one_line, legible
from app.gui.actions import actions, batch_actions
from app.gui.panels.overlays import floating_window
from app.gui.state.app_state import AppState
from app.gui.state.choosing import Kind
from app.gui.style import theme
from app.gui.style.widgets import FLAT, button, em, explain, muted, note, row
from app.gui.work.batching import Progressed

TITLE = "Enhance files and folders"
TEXT = (
    "Enhances every image and video in the list, subfolders included, with the current settings into "
    "a new folder of the same structure. The originals are not changed."
)
KINDS: dict[Kind, str] = {
    "folder": "A folder of images, videos or subfolders, or a clip.",
    "file": "One image or one video.",
}
SETTINGS_TEXT = (
    "Set in the Enhancement panel. Stereo video and lens chosen for a clip apply to that clip; masks drawn "
    "on a clip are not used."
)
REMOVE_TEXT = "Remove from the list; no file is touched."
RUNS_TEXT = "Runs in the background; the window stays usable. Each file records how it was made."
SHOW_TEXT = "Open the folder of the results in the system's file manager."
LISTED = 6
"""Lines of a list before it scrolls."""


def draw_batches(state: AppState) -> None:
    """A window of its own."""
    batches = state.batches
    if not batches.shown:
        return
    with floating_window(state, batches, TITLE, 42) as drawn:
        if not drawn:
            return
        note(TEXT)
        imgui.spacing()
        _draw_adding(state)
        _draw_inputs(state)
        imgui.spacing()
        _draw_choices(state)
        imgui.separator()
        _draw_progress(state)
        if batches.progressed is not None:
            _draw_told(batches.progressed)


def _draw_adding(state: AppState) -> None:
    add = partial(actions.choose_path, state, take=batch_actions.add_input, purpose="inputs")
    for kind, text in KINDS.items():
        button(f"{icons.ICON_FA_PLUS}  {kind.capitalize()}…###add {kind}", partial(add, kind), text, width=8)
        imgui.same_line()
    clear, some = partial(batch_actions.clear_inputs, state), bool(state.batches.inputs)
    button("Clear###clear", clear, "Clear the list; no file is touched.", enabled=some, width=6)


def _draw_inputs(state: AppState) -> None:
    inputs = state.batches.inputs
    lines = min(max(len(inputs), 1), LISTED)
    height = lines * imgui.get_text_line_height_with_spacing() + em(1.1)
    with imgui_ctx.begin_child("inputs", ImVec2(0, height), imgui.ChildFlags_.borders | FLAT):
        if not inputs:
            muted("Nothing to enhance yet: add or drop files and folders.")
        for place, path in enumerate(inputs):
            with imgui_ctx.push_id(str(place)):
                remove = partial(batch_actions.remove_input, state, place)
                button(f"{icons.ICON_FA_TRASH}###remove", remove, REMOVE_TEXT, small=True)
                imgui.same_line()
                imgui.text_unformatted(in_one_line(path.name))
                explain(str(path))


def _draw_choices(state: AppState) -> None:
    row("Settings", SETTINGS_TEXT)
    note(batch_actions.summary(state), theme.now().text)
    row("Into", "Each batch goes into a new folder there; nothing is overwritten.")
    choose = partial(actions.choose_path, state, "folder", purpose="results")
    button("Choose…###target", choose, "Choose another folder for the results.")
    imgui.same_line()
    folder = batch_actions.results_folder(state)
    imgui.text_unformatted(f"{legible(folder.name)}/enhanced-…/")
    explain(str(folder))


def _draw_progress(state: AppState) -> None:
    reason, batches = batch_actions.why_not_start(state), state.batches
    if batches.under_way is None:
        start, color = partial(batch_actions.batch_request, state), theme.now().lit
        button("Enhance all###start", start, RUNS_TEXT, reason=reason, color=color, width=-1)
        _draw_written(state)
        return
    step = batches.progressed.step if batches.progressed is not None else None
    if step is None:
        share, said = 0.0, "looking for images…"
    else:
        share = (step.place + (step.done / step.total if step.total else 0.0)) / step.count
        stands = f"{step.done} / {step.total}" if step.total else "preparing…"
        said = f"{step.place} of {step.count} done   {legible(step.name)}: {stands}"
    imgui.progress_bar(min(share, 1.0), ImVec2(-em(7), 0), said)
    imgui.same_line()
    text = "Finished files are kept; no file is left incomplete."
    button("Cancel", partial(batch_actions.cancelled, state), text, width=6)


def _draw_written(state: AppState) -> None:
    """Where the last batch went, and the way to it."""
    written = state.batches.written
    if written is None:
        return
    imgui.align_text_to_frame_padding()
    muted(f"Enhanced into {legible(written.name)}")
    explain(str(written))
    imgui.same_line()
    button("Show in folder###reveal", partial(batch_actions.reveal, state), SHOW_TEXT, width=10)


def _draw_told(progressed: Progressed) -> None:
    failed = tuple(f"{one.name}: {one.reason}" for one in progressed.failed)
    if failed:
        imgui.text_colored(theme.now().warning, f"{len(failed)} could not be enhanced")
        _draw_lines("failed", failed)
    noted = tuple(f"{one.name}: {one.notice}" for one in progressed.noted)
    if noted:
        muted("1 notice" if len(noted) == 1 else f"{len(noted)} notices")
        _draw_lines("noted", noted)


def _draw_lines(name: str, lines: tuple[str, ...]) -> None:
    height = min(len(lines), LISTED) * 2 * imgui.get_text_line_height_with_spacing() + em(1.1)
    with (
        imgui_ctx.begin_child(name, ImVec2(0, height), imgui.ChildFlags_.borders),
        imgui_ctx.push_text_wrap_pos(0),
    ):
        for line in lines:
            imgui.text_unformatted(legible(line))
