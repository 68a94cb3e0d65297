"""The 3D reconstruction: what to run next, and how far the current one is."""

from __future__ import annotations

from dataclasses import replace
from typing import get_args

from imgui_bundle import ImVec2, imgui, imgui_ctx

from app.enhancement.settable import InputKind
from app.files.legible import capital, grouped, legible, named
from app.gui.actions import job_actions, laid_out, run_actions
from app.gui.panels.curves import draw_curves
from app.gui.state.app_state import AppState
from app.gui.state.reconstruction import QUALITIES, Reconstruction, expected_seconds, quality_of
from app.gui.style import theme
from app.gui.style.widgets import (
    button,
    choose_row,
    declared,
    em,
    explain,
    note,
    row,
    seconds,
    slider,
    wants_default,
)
from app.runs.wall_clock import in_all
from enhance import EnhanceParams
from renderer.train.config import Method, TrainConfig
from renderer.train.events import Omission, Preparing

METHODS: tuple[Method, ...] = get_args(Method)
INPUTS: tuple[InputKind, ...] = get_args(InputKind)
STATUS = {
    "none": "",
    "starting": "Starting…",
    "running": "Reconstructing",
    "paused": "Paused",
    "finished": "Finished",
    "failed": "Stopped",
    "cancelled": "Interrupted",
}

FIRST_STEP = "Preparing the first step…"
FIRST_USE = "The first reconstruction on a computer takes up to a minute longer."
"""Its kernels are compiled then."""
PART = (
    "Trim and mask are set below the panes (In, Out, All, Mask). What they leave out is neither "
    "trained on nor evaluated; a run keeps the trim and mask it was started with."
)


def draw_reconstruction(state: AppState) -> None:
    """Choices before, buttons always, progress during and after."""
    run = state.runs.reconstruction
    if run.is_alive:
        _draw_hold(state)
    else:
        if run.status in ("failed", "cancelled"):
            _draw_end(state, run)
        _draw_next(state, run)
    if run.status != "none":
        _draw_status(run)
    draw_curves(run)
    _draw_messages(run)
    if run.is_alive:
        waiting = f" ({len(state.runs.queue)} waiting, see Runs)" if state.runs.queue else ""
        if imgui.tree_node(f"Queue another{waiting}###another"):
            _draw_next(state, run)
            imgui.tree_pop()


def _draw_next(state: AppState, run: Reconstruction) -> None:
    _draw_choices(state, run)
    _draw_part(state)
    imgui.spacing()
    _draw_start(state)
    if not run.is_alive and state.source.clip is not None:
        _draw_omissions(state)


def _draw_choices(state: AppState, run: Reconstruction) -> None:
    config = run.config
    text = declared(TrainConfig, "method").text
    method = choose_row("Method", METHODS.index(config.method), [*map(named, METHODS)], text)
    frames = (
        "Reconstruct the original frames, or frames enhanced with the settings above; both in turn "
        "runs two reconstructions to compare."
    )
    chosen = choose_row("Frames", INPUTS.index(run.input), [*map(named, INPUTS)], frames)
    job_actions.choose_input(state, INPUTS[chosen])
    if run.input != "original":
        about = declared(EnhanceParams, "d_factor")
        row("Colour d", "For the frames to reconstruct; the paper uses 0.5. " + about.text)
        imgui.set_next_item_width(-em(0.1))
        _, d_factor = slider("##run_d", run.d_factor, about, "%.2f", imgui.SliderFlags_.always_clamp)
        job_actions.choose_d_factor(state, d_factor)
    iterations = _steps(replace(config, iterations=_quality(run)))
    if (method, iterations) != (METHODS.index(config.method), config.iterations):
        job_actions.choose_method(state, METHODS[method], iterations)
    row("Name", "Folder of the run; if empty, the clip's name and the time.")
    imgui.set_next_item_width(-em(0.1))
    _, name = imgui.input_text_with_hint("##name", "automatic", run.name)
    job_actions.name_run(state, name)


def _draw_part(state: AppState) -> None:
    """What of the clip it will be of, where that is not all of it."""
    told = "" if state.source.clip is None else state.source.training_part.told(len(state.source.clip))
    if told:
        note(f"Trains on {told}", theme.now().warning)
        explain(PART)


def _quality(run: Reconstruction) -> int:
    """The iterations that are chosen by a word, and what they will take where that is known."""
    now, names = quality_of(run.config.iterations), [*QUALITIES]
    choices = names if now in names else [*names, now]
    steps = ", ".join(f"{name.lower()} {count}" for name, count in QUALITIES.items())
    text = f"Number of iterations: {steps}. More are slower and better."
    took = expected_seconds(run)
    if took is not None:
        text += f" About {seconds(took)} at the speed of the run shown."
    shown = [f"{name}, about {seconds(took)}" if took and name == now else name for name in choices]
    index = choose_row("Quality", choices.index(now), shown, text)
    return QUALITIES.get(choices[index], run.config.iterations)


def _steps(config: TrainConfig) -> int:
    about = declared(TrainConfig, "iterations")
    text = about.text or "Training steps; more are slower and better."
    row("Iterations", text)
    imgui.set_next_item_width(-em(0.1))
    changed, value = imgui.input_int("##iterations", config.iterations, 100, 1000)
    explain(text)
    if wants_default("iterations"):
        return int(about.default)
    return int(min(max(value, about.lo), about.hi)) if changed else config.iterations


def _draw_start(state: AppState) -> None:
    run = state.runs.reconstruction
    reason = job_actions.why_not_reconstruct(state)
    with imgui_ctx.push_style_color(imgui.Col_.button, theme.now().lit):
        start = lambda: job_actions.start_reconstruction(state)  # noqa: E731
        label = "Add to the queue" if run.is_alive else "Reconstruct"
        button(f"{label}###start", start, enabled=not reason, width=-1.0)
    soon = "Starts with the current settings when the runs before it have ended." if run.is_alive else ""
    explain(reason or soon or "Runs in the background; the window stays usable.")
    if reason and state.source.clip is not None:
        note(reason)


def _draw_end(state: AppState, run: Reconstruction) -> None:
    """Of a run that was cut short: why, and what can be done with it."""
    if run.failure:
        note(f"{capital(legible(run.failure))}.", theme.now().danger)
        note(run.way_out)
    half = (imgui.get_content_region_avail().x / em() - 0.5) / 2
    onward = lambda: job_actions.continue_reconstruction(state)  # noqa: E731
    again = job_actions.can_continue(state)
    button("Continue", onward, enabled=again, width=half)
    explain(
        "From the run's last checkpoint."
        if again
        else "It can continue only on its own clip: open that first."
    )
    imgui.same_line(0, em(0.5))
    reason = run_actions.why_not_look(state, run.run_path, has_checkpoint=run.has_checkpoint)
    button("View model", lambda: run_actions.look_at_present(state), enabled=not reason, width=half)
    explain(reason or "The model as last shown, or at the last checkpoint, before the interruption.")
    imgui.separator()


def _draw_hold(state: AppState) -> None:
    run = state.runs.reconstruction
    half = (imgui.get_content_region_avail().x / em() - 0.5) / 2
    if run.status == "paused":
        button("Resume###pause", lambda: job_actions.resume(state), enabled=run.can_resume, width=half)
    else:
        button("Pause###pause", lambda: job_actions.pause(state), enabled=run.can_pause, width=half)
    explain("Paused; the queue waits.")
    imgui.same_line(0, em(0.5))
    button("Cancel", lambda: job_actions.cancel(state), width=half)
    explain("The last checkpoint is kept: Continue resumes from it.")


def status_of(run: Reconstruction) -> str:
    """What it is at, in a word or two."""
    return FIRST_STEP if run.status == "running" and run.progress is None else STATUS[run.status]


def _draw_status(run: Reconstruction) -> None:
    progress = run.progress
    imgui.text_unformatted(status_of(run))
    if run.request is not None:
        needs = f"\n{capital(run.planned)}." if run.planned else ""
        explain(f"{named(run.request.config.method)}, {run.request.input} frames: {run.run_path}{needs}")
    if progress is None:
        if run.is_alive and run.preparing is not None:
            _draw_preparing(run.preparing)
            note(capital(run.planned))
        elif run.status == "running":
            note(FIRST_USE)
        return
    left = f", {seconds(progress.seconds_left)} left" if run.is_alive else ""
    imgui.same_line()
    wall = progress.wall_seconds
    shown = f"{seconds(progress.seconds)} training" if wall is None else f"{seconds(wall)} in total"
    imgui.text_colored(theme.now().muted, f"{shown}{left}")
    explain(f"{capital(in_all(wall, progress.seconds, '.0f'))}. Pauses are not counted.")
    done = f"{grouped(progress.iteration)} / {grouped(progress.iterations)}"
    imgui.progress_bar(progress.iteration / progress.iterations, ImVec2(-1, em(1.25)), done)


def _draw_preparing(stage: Preparing) -> None:
    """What is done before the first step, and how far it is where that is known."""
    left = "" if stage.seconds_left is None else f", {seconds(stage.seconds_left)} left"
    note(f"{capital(stage.stage)}, {seconds(stage.seconds)}{left}")
    if stage.total:
        done = f"{grouped(stage.done)} / {grouped(stage.total)}"
        imgui.progress_bar(stage.done / stage.total, ImVec2(-1, em(1.25)), done)


def _draw_omissions(state: AppState) -> None:
    """Looked up when it is unfolded: what, and why, before anything is started."""
    laid_out.unfold_omissions(state, imgui.tree_node("What will be left out"))
    explain("Training leaves out what this clip does not need. Judged on the original frames.")
    if not state.runs.asks_for_omissions:
        return
    found, request = state.runs.omissions, state.omissions_request
    # While a part that was just kept or let go is looked at, the lines stay under the hand.
    if found is None or request is None or found.request.unkept != request.unkept:
        imgui.text_colored(theme.now().muted, "Analysing the clip…")
    elif not found.lines:
        imgui.text_colored(theme.now().muted, "Nothing: this clip needs every part.")
    else:
        with imgui_ctx.begin_table("omissions", 2) as table:
            if table:
                imgui.table_setup_column("what", imgui.TableColumnFlags_.width_stretch)
                imgui.table_setup_column("keep", imgui.TableColumnFlags_.width_fixed)
                for omission in found.lines:
                    _draw_omission(state, omission)
    imgui.tree_pop()


def _draw_omission(state: AppState, omission: Omission) -> None:
    imgui.table_next_column()
    imgui.align_text_to_frame_padding()
    imgui.text_unformatted(capital(omission.what))
    explain(f"Saves {omission.saves}.")
    note(capital(omission.why))
    explain(f"Saves {omission.saves}.")
    imgui.table_next_column()
    if (part := omission.part) is None:
        return
    changed, kept = imgui.checkbox(f"Keep###keep {part}", part in state.runs.reconstruction.config.keep)
    explain(f"Train it although {omission.why}: it costs {omission.saves}.")
    if changed:
        job_actions.keep_part(state, part, kept=kept)


def _draw_messages(run: Reconstruction) -> None:
    with imgui_ctx.push_text_wrap_pos(0):
        for warning in run.warnings[-3:]:
            imgui.text_colored(theme.now().warning, capital(legible(warning)))
        for omission in run.omitted:
            imgui.text_colored(theme.now().muted, f"Left out: {omission.what}")
            explain(f"{omission.why} Saves {omission.saves}.")
