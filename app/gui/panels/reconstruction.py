"""The 3D reconstruction: what to run next, and how far the current one is."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import partial

import numpy as np
from imgui_bundle import ImVec2, ImVec4, imgui, imgui_ctx, implot
from numpy.typing import NDArray

from app.files.legible import capital, grouped, legible, named, without_flags
from app.gui.actions import job_actions, laid_out, run_actions
from app.gui.panels.reconstruction_choices import draw_choices
from app.gui.panels.run_measures import draw_run_measures
from app.gui.state.app_state import AppState
from app.gui.state.panes import is_undistorted_otherwise
from app.gui.state.reconstruction import Reconstruction
from app.gui.state.run_words import COMPILING, KEEPS, doing, share_done
from app.gui.style import theme
from app.gui.style.widgets import (
    button,
    checkbox,
    em,
    explain,
    explain_entry,
    in_line,
    in_table,
    muted,
    note,
    percent,
    seconds,
)
from app.runs.wall_clock import in_all
from app.scenes.view_kinds import SCENE_UNITS
from renderer.train.events import Evaluated, Omission, Progress

CONTINUES = "From the last checkpoint."
STARTS_OVER = "No checkpoint: starts over."
VIEW_MODEL_TEXT = "The model as last shown, or at the last checkpoint, before the interruption."
AGAIN_TEXT = "Another window or process trains it: shows how far it is now."
LENS_TEXT = (
    "Training has found the lens. The clip is still shown as recorded, the model is of undistorted frames."
)
FIRST_USE = "Once on a computer: about a minute, longer while it is busy."
"""Kernels are compiled then."""
PAUSES = "Pauses are not counted."
WAITS_FOR_EDITS = "Its model is shown when you leave edit mode and the edits are saved or discarded."
PSNR = "Line: training frames, tissue only. Dots: up to 4 held-out frames, at the end all; all their pixels."
DEPTH = "RMS error along z on the same held-out frames, where both the clip and the model have depth."
LOSS = "Mean since the previous point."
COUNT = "Number of Gaussians in the model."
UNFOLDED = 12.0
"""Text heights down that are kept for the list of what will be left out before it is there."""
Line = NDArray[np.float64]
NO_DOTS: Line = np.empty((2, 0))
PART = (
    "Trim and mask are set below the panes (In, Out, All, Mask). What they leave out is neither "
    "trained on nor evaluated; a run keeps the trim and mask it was started with."
)


def draw_reconstruction(state: AppState) -> None:
    """Progress and what came of it, choices, buttons that never scroll out of sight."""
    run = state.runs.reconstruction
    if run.is_alive:
        _draw_hold(state)
        _draw_status(state, run)
        # Above the diagrams, which would move it out of sight.
        waiting = f" ({len(state.runs.queue)} waiting, see Runs)" if state.runs.queue else ""
        if imgui.tree_node(f"Queue another{waiting}###another"):
            _draw_next(state)
            _draw_start(state)
            imgui.tree_pop()
        _draw_curves(run)
        _draw_messages(run)
        return
    room = imgui.get_content_region_avail() - ImVec2(0, imgui.get_frame_height_with_spacing())
    # As high as what is in it, or as there is room above the button.
    imgui.set_next_window_size_constraints(ImVec2(0, 0), ImVec2(room.x, max(room.y, em())))
    with imgui_ctx.begin_child("choices", ImVec2(0, 0), imgui.ChildFlags_.auto_resize_y):
        if imgui.is_window_appearing():
            imgui.set_scroll_y(0)  # What became of a run stands at the top.
        _draw_ended(state, run)
        _draw_next(state)
        if state.source.clip is not None:
            _draw_omissions(state)
        _draw_curves(run)
        _draw_messages(run)
    _draw_start(state)


def _draw_ended(state: AppState, run: Reconstruction) -> None:
    """What became of the run that is shown."""
    if run.status == "none":
        return
    if run.status in ("failed", "cancelled"):
        _draw_end(state, run)
    elif run.status == "elsewhere":
        button("Open again", partial(run_actions.open_again, state), AGAIN_TEXT, width=-1.0)
    _draw_status(state, run)
    if run.status == "finished":
        if is_undistorted_otherwise(state) and not state.shows_other_clip:
            note(LENS_TEXT)
            button("Open with undistorted frames", partial(run_actions.open_again, state), width=-1.0)
        draw_run_measures(state)
    imgui.separator()


def _draw_next(state: AppState) -> None:
    draw_choices(state)
    if (clip := state.source.clip) is not None and (told := state.source.training_part.told(len(clip))):
        frames = told if told.startswith("frames") else f"all frames, {told}"
        note(f"Trains on {frames}", theme.now().warning)
        explain(PART)
    imgui.spacing()


def _draw_start(state: AppState) -> None:
    start, reason = partial(job_actions.start_reconstruction, state), job_actions.why_not_reconstruct(state)
    label, text = "Reconstruct", "Runs in the background; the window stays usable."
    if state.runs.reconstruction.is_alive:
        label = "Add to the queue"
        text = "Starts with the current settings when the runs before it have ended."
    button(f"{label}###start", start, text, reason=reason, color=theme.now().lit, width=-1.0)


def _draw_end(state: AppState, run: Reconstruction) -> None:
    """Of a run that was cut short: why, and what can be done with it."""
    if run.failure:
        note(f"{capital(legible(run.failure))}.", theme.now().danger)
        note(run.way_out)
    if run.saved_nothing:
        return
    kept = CONTINUES if run.has_checkpoint else STARTS_OVER
    reason = run_actions.why_not_view(state, run.run_path, has_checkpoint=run.has_checkpoint)
    ways = (
        ("Continue", job_actions.continue_reconstruction, kept, ""),
        ("View model", run_actions.view_interrupted, VIEW_MODEL_TEXT, reason),
    )
    for (label, act, text, why), width in in_line(ways):
        button(label, partial(act, state), text, reason=why, width=width)


def _draw_hold(state: AppState) -> None:
    run, text = state.runs.reconstruction, "The queue waits meanwhile." if state.runs.queue else ""
    pause = ("Pause###pause", job_actions.pause, text, run.can_pause)
    if run.status == "paused":
        pause = ("Resume###pause", job_actions.resume, text, run.can_resume)
    cancel = ("Cancel", job_actions.cancel, KEEPS, not run.cancelling)
    for (label, act, text, enabled), width in in_line((pause, cancel)):
        button(label, partial(act, state), text, enabled=enabled, width=width)


def _draw_status(state: AppState, run: Reconstruction) -> None:
    progress, words, clip = run.progress, doing(state), state.source.clip
    if run.clip is not None and (clip is None or not clip.lies_at(run.clip.path)):
        note(f"Of another clip: {legible(run.clip.name)}", theme.now().warning)
    note(words, theme.now().text)
    if run.request is not None:
        needs = f"\n{capital(run.planned)}." if run.planned else ""
        explain(f"{named(run.request.config.method)}, {run.request.input} frames: {run.run_path}{needs}")
    if words == COMPILING:
        note(f"{FIRST_USE} {seconds(state.window.now - run.started_at)} so far.")
    if run.status == "starting":
        if run.preparing is not None:
            note(f"{seconds(state.window.now - run.started_at)} so far")
        if run.planned:
            note(capital(run.planned))
    if progress is not None and not run.is_alive:
        _draw_took(progress)
    if job_actions.waits_for_edits(state):
        note(WAITS_FOR_EDITS)
    if run.status != "finished" and (share := share_done(run)) is not None:
        # Not 100 % while there is something left.
        imgui.progress_bar(share, ImVec2(-1, em(1.25)), percent(min(share, 0.99)))
        if progress is not None:
            explain(f"{capital(in_all(progress.wall_seconds, progress.seconds, '.0f'))}. {PAUSES}")


def _draw_took(progress: Progress) -> None:
    """How long the run went on."""
    wall = progress.wall_seconds
    imgui.same_line()
    muted(f"{seconds(progress.seconds)} training" if wall is None else f"{seconds(wall)} in total")
    explain(f"{capital(in_all(wall, progress.seconds, '.0f'))}. {PAUSES}")


def _draw_omissions(state: AppState) -> None:
    """Looked up when it is unfolded: what, and why, before anything is started."""
    laid_out.unfold_omissions(state, imgui.tree_node("What will be left out"))
    if imgui.is_item_toggled_open():
        imgui.set_scroll_here_y(0.0)  # In a low window what unfolds is out of sight else.
    explain_entry("Training leaves out what this clip does not need. Judged on the original frames.")
    if not state.runs.asks_for_omissions:
        return
    found, request = state.runs.omissions, state.omissions_request
    # While a part that was just kept or let go is looked at, the lines stay under the hand.
    if found is None or request is None or found.request.unkept != request.unkept:
        now = state.runs.looking
        done = f": {now.frames} of {now.count} frames" if now is not None and now.request == request else "…"
        muted(f"Analysing the clip{done}")
        imgui.dummy(ImVec2(0, em(UNFOLDED)))
    elif not found.lines:
        muted("Nothing: this clip needs every part.")
    else:
        for omission in in_table("omissions", (None, 0.0), found.lines):
            _draw_omission(state, omission)
    imgui.tree_pop()


def _draw_omission(state: AppState, omission: Omission) -> None:
    imgui.table_next_column()
    imgui.align_text_to_frame_padding()
    note(capital(omission.what), theme.now().text)
    explain(f"Saves {omission.saves}.")
    note(capital(omission.why))
    explain(f"Saves {omission.saves}.")
    imgui.table_next_column()
    if (part := omission.part) is None:
        return
    changed, kept = checkbox(f"Keep###keep {omission.what}", part in state.runs.reconstruction.config.keep)
    explain(f"Train it although {omission.why}: it costs {omission.saves}.")
    if changed:
        job_actions.keep_part(state, part, kept=kept)


def _draw_messages(run: Reconstruction) -> None:
    for warning in run.warnings[-3:]:
        note(capital(legible(without_flags(warning))), theme.now().warning)
    if run.omitted and imgui.tree_node("What is left out###left out"):
        for omission in run.omitted:
            note(f"{capital(omission.what)}: {omission.why}")
            explain(f"Saves {omission.saves}.")
        imgui.tree_pop()


def _draw_curves(run: Reconstruction) -> None:
    """Nothing before the first Progress; no depth where none is measured."""
    if not run.told.progress:
        return
    curve, end, ink = run.told.progress, run.iterations, theme.now()
    now = curve[-1]
    seen = _line([each for each in run.told.evaluated if math.isfinite(each.psnr)], "psnr")
    held_out = f", held out {seen[1, -1]:.1f} dB" if seen.size else ""
    psnr, loss, count = (_line(curve, name) for name in ("psnr", "loss", "n_gaussians"))
    _draw_curve("PSNR", f"{now.psnr:.1f} dB{held_out}", ink.accent, psnr, ".1f", PSNR, end, seen)
    depth = _line([each for each in run.told.evaluated if each.depth_rmse is not None], "depth_rmse")
    if depth.size:
        unit = run.clip.unit if run.clip is not None else SCENE_UNITS
        said = f"{depth[1, -1]:.3g} {unit}"
        _draw_curve("Depth error", said, ink.danger, depth, ".2g", DEPTH, end, depth)
    _draw_curve("Loss", f"{now.loss:.4f}", ink.warning, loss, ".2g", LOSS, end)
    _draw_curve("Gaussians", grouped(now.n_gaussians), ink.shade(0.75), count, ",.0f", COUNT, end)


def _line(events: Sequence[Progress] | Sequence[Evaluated], name: str) -> Line:
    """(2, N): iterations, values."""
    values = [getattr(event, name) for event in events]
    return np.array([[event.iteration for event in events], values], float)


def round_ticks(most: int) -> list[float]:
    """From 0 on, up to five in round steps; none near the end, where half of it would be cut off."""
    steps = (digit * 10**power for power in range(12) for digit in (1, 2, 5))
    step = next(step for step in steps if 5 * step >= most)
    return [float(tick) for tick in range(0, most, step) if tick < 0.95 * most] or [0.0]


def _draw_curve(
    name: str, value: str, color: ImVec4, line: Line, form: str, text: str, most: int, dots: Line = NO_DOTS
) -> None:
    imgui.text_colored(color, name)
    explain(text)
    imgui.same_line()
    muted(value)
    if not implot.begin_plot(f"##{name}", ImVec2(-1, em(4.6)), theme.QUIET_PLOT):
        return
    axis, quiet = implot.ImAxis_, implot.AxisFlags_.no_highlight
    implot.setup_axis(axis.x1, "", quiet)
    implot.setup_axis(axis.y1, "", implot.AxisFlags_.auto_fit | quiet)
    low, high = float(line[1].min()), float(line[1].max())
    # So low a diagram has room for two labels.
    implot.setup_axis_ticks(axis.y1, [low, high], [format(low, form), format(high, form)])
    across = round_ticks(most)
    implot.setup_axis_ticks(axis.x1, across, [grouped(round(tick)) for tick in across])
    implot.setup_axis_limits(axis.x1, 0, max(most, line[0, -1]), implot.Cond_.always)
    implot.plot_line(name, line[0], line[1], implot.Spec(line_color=color, line_weight=em(0.1)))
    if dots.size:
        marks = implot.Spec(marker_fill_color=color, marker_size=em(0.25))
        implot.plot_scatter("held out", dots[0], dots[1], marks)
    implot.end_plot()
