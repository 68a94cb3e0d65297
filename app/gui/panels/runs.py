"""The queue of reconstructions, and those of the open clip on disk."""

from __future__ import annotations

from collections.abc import Callable
from datetime import datetime
from functools import partial

from imgui_bundle import ImVec2, imgui, imgui_ctx
from imgui_bundle import icons_fontawesome_4 as icons

from app.files.legible import as_label, legible, named, to_minute
from app.gui.actions import changing_runs, laid_out, queue_actions, run_actions
from app.gui.panels.reconstruction import CONTINUES, STARTS_OVER, VIEW_MODEL_TEXT
from app.gui.panels.run_measures import draw_run_measures
from app.gui.state.app_state import AppState
from app.gui.state.reconstruction import Waiting
from app.gui.style import theme
from app.gui.style.widgets import beside, button, em, explain, mark_row, muted, note, shortened, toggle
from app.gui.work.runs import ListedRun

BESIDE = "Open beside"
BESIDE_TEXT = "In a second 3D view beside the one shown, with the same camera and time."
PSNR_FINISHED = (
    "PSNR of all held-out frames, as in published results; of training frames where none are held out."
)
PSNR_SO_FAR = "PSNR so far: of up to 4 held-out frames where there are any, else of the training frames."
CLOSE_TEXT = "Shown in the second 3D view: click to close that."
ASLEEP_TEXT = "These were queued when the window was closed. Press Start the queue to run them."


def draw_runs(state: AppState) -> None:
    """What waits, the next one first; below it what lies on disk of the open clip, the newest first."""
    laid_out.list_runs(state)
    if state.runs.queue:
        _draw_queue(state)
        imgui.separator()
    if state.source.clip is None:
        muted("Open a clip to see its reconstructions.")
        return
    found = state.runs.found
    if found is None or found.request.clip is not state.source.clip:
        muted("Looking for reconstructions of this clip…")
        return
    elsewhere = run_actions.shown_from_elsewhere(state)
    if elsewhere is not None:
        muted(f"Open from another folder: {legible(elsewhere.name)}")
        explain(str(elsewhere))
    elif not found.runs:
        muted("No reconstruction of this clip yet.")
    for run in found.runs:
        with imgui_ctx.push_id(run.path.name):
            _draw_near_sight(partial(_draw_run, state, run))
    if found.unreadable:
        folders = "One run folder" if found.unreadable == 1 else f"{found.unreadable} run folders"
        imgui.text_colored(theme.now().warning, f"{folders} cannot be read.")
        explain(str(found.request.folder))


def _draw_queue(state: AppState) -> None:
    imgui.text_unformatted("Queue")
    explain("Reconstructions run one at a time; these start automatically.")
    if not state.runs.reconstruction.is_alive and (reason := queue_actions.why_held(state)):
        note(reason, theme.now().warning)
    if queue_actions.sleeps(state):
        button("Start the queue", partial(queue_actions.wake, state), ASLEEP_TEXT, width=-1.0)
    for place, waiting in enumerate(state.runs.queue):
        with imgui_ctx.push_id(f"queued {place}"):
            _draw_waiting(state, waiting, first=place == 0 and not waiting.asleep)


def _draw_near_sight(draw: Callable[[], None]) -> None:
    """Of what is scrolled farther away than the panel is high, only the height, as it was when last drawn:
    there may be a thousand runs, whose heights differ."""
    heights, key = imgui.get_state_storage(), imgui.get_id("height")
    start, beyond = imgui.get_cursor_screen_pos(), imgui.get_window_height()
    height = heights.get_float(key)
    low, high = ImVec2(start.x, start.y - beyond), ImVec2(start.x + 1, start.y + height + beyond)
    if height and not imgui.is_rect_visible(low, high):
        imgui.dummy(ImVec2(1, height))
        return
    draw()
    heights.set_float(key, imgui.get_cursor_screen_pos().y - start.y - imgui.get_style().item_spacing.y)


def _draw_run(state: AppState, run: ListedRun) -> None:
    config, shown = run.request.config, state.runs.reconstruction.run_path == run.path
    reason = run_actions.why_not_open(state, run)
    right = imgui.get_cursor_pos_x() + imgui.get_content_region_avail().x
    # The one in training is shown already: its name stays as legible as that of any that is shown.
    imgui.begin_disabled(bool(reason) and not run_actions.is_present(state, run))
    psnr = f"{run.psnr:.1f} dB" if run.psnr is not None else ""
    left = right - imgui.calc_text_size(psnr).x
    name = shortened(legible(run.path.name), left - em(0.5) - imgui.get_cursor_pos_x())
    if imgui.selectable(f"{as_label(name)}###open", shown)[0]:
        run_actions.open_run(state, run)
    if shown:
        mark_row()
    lit = shown or imgui.is_item_hovered()
    imgui.end_disabled()
    how = "Open it beside the one in training: " if state.runs.reconstruction.is_alive else "Open "
    part = f" Trained on {said}." if (said := run.request.part.told()) else ""
    opens = f"{how}{run.path}.{part}"
    if imgui.get_mouse_pos().x < imgui.get_window_pos().x + left:
        explain(reason or opens)
    if run.psnr is not None:
        imgui.same_line(left)
        imgui.text_colored(theme.now().text if lit else theme.now().accent, psnr)
        explain(PSNR_FINISHED if run.made == "finished" else PSNR_SO_FAR)
    finished, steps = run.made == "finished", f"{run.iterations:,}"
    steps = f"{steps} iterations" if finished else f"{run.iteration:,} of {steps}"
    muted(f"{named(config.method)} · {run.request.input} frames · ")
    imgui.same_line(0, 0)
    in_training = run_actions.is_in_training(state, run)
    imgui.text_colored(theme.now().accent if in_training else theme.now().muted, _made(state, run))
    muted(f"{_when(run.created)} · {steps}")
    if run.made != "unfinished":  # Of that, there is View model.
        why = reason or ("It is shown already." if shown and run_actions.is_as_it_is(state, run) else "")
        button("Open###open run", partial(run_actions.open_run, state, run), opens, reason=why)
        beside(BESIDE, 0.3)
    _draw_beside(state, run)
    _draw_changes(state, run)
    if run.made == "unfinished" and not run_actions.is_present(state, run):
        _draw_unfinished(state, run)
    if shown:
        draw_run_measures(state)
    imgui.spacing()


def _draw_beside(state: AppState, run: ListedRun) -> None:
    shown, reason = run_actions.is_beside(state, run), run_actions.why_not_beside(state, run)
    label, act = f"{BESIDE}###beside", partial(run_actions.toggle_beside, state, run)
    toggle(label, act, CLOSE_TEXT if shown else BESIDE_TEXT, on=shown, reason=reason)


def _draw_changes(state: AppState, run: ListedRun) -> None:
    """Rename and delete, beside the button before."""
    reason = changing_runs.why_not_change(state, run)
    for label, act, text in (
        (f"{icons.ICON_FA_EDIT}###rename", changing_runs.ask_name, "Rename the run."),
        (f"{icons.ICON_FA_TRASH}###delete", changing_runs.ask_delete, "Delete the run, after a question."),
    ):
        beside(label, 0.3)
        button(label, partial(act, state, run), text, reason=reason)


def _draw_unfinished(state: AppState, run: ListedRun) -> None:
    """Beside the button before, as far as there is room."""
    kept = CONTINUES if run.has_checkpoint else STARTS_OVER
    reason = run_actions.why_not_continue(state, run)
    beside("Continue")
    button("Continue", partial(run_actions.continue_run, state, run), kept, reason=reason)
    beside("View model")
    reason = run_actions.why_not_view(state, run.path, has_checkpoint=run.has_checkpoint)
    button("View model", partial(run_actions.view_model, state, run.path), VIEW_MODEL_TEXT, reason=reason)


def _made(state: AppState, run: ListedRun) -> str:
    if run.made == "training" and not run_actions.is_present(state, run):
        return "training elsewhere"
    return "training" if run_actions.is_present(state, run) else run.made


def _when(created: str) -> str:
    """In the hours of this place."""
    try:
        return to_minute(datetime.fromisoformat(created))
    except (ValueError, OverflowError):
        return legible(created)


def _draw_waiting(state: AppState, waiting: Waiting, *, first: bool) -> None:
    request = waiting.request
    imgui.align_text_to_frame_padding()
    end = imgui.get_content_region_avail().x - 2 * (imgui.get_frame_height() + em(0.3))
    ink = theme.now().muted if waiting.asleep else theme.now().text
    room = end - imgui.get_cursor_pos_x() - em(0.3)
    imgui.text_colored(ink, shortened(legible(request.run_path.name), room))
    since = " Queued in an earlier session." if waiting.asleep else ""
    explain(f"{legible(waiting.clip_name)}: {request.run_path}.{since}")
    imgui.same_line(end)
    front, remove = partial(queue_actions.to_front, state, waiting), "Remove from the queue."
    text = "Move to the front of the queue."
    button(f"{icons.ICON_FA_ARROW_UP}###to front", front, text, enabled=not first)
    imgui.same_line(0, em(0.3))
    button(f"{icons.ICON_FA_TIMES}###withdraw", partial(queue_actions.withdraw, state, waiting), remove)
    method, steps = named(request.config.method), request.config.iterations
    muted(f"{method} · {request.input} frames · {steps:,} iterations")
