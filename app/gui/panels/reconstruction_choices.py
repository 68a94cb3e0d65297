"""What the next reconstruction is of and how good it is to be: method, depth, frames, steps and name."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Final, get_args

from imgui_bundle import imgui

from app.enhancement.settable import InputKind
from app.enhancement.setting_words import in_letters, worded
from app.files.legible import named
from app.gui.actions import actions, clip_actions, depth_actions, job_actions
from app.gui.state.app_state import AppState
from app.gui.state.reconstruction import QUALITIES, Reconstruction, expected_seconds, quality_of
from app.gui.style.fields import asks_for_default, declared
from app.gui.style.widgets import NAMES, button, checkbox, choose_row, em, explain, explain_entry, note, row
from app.gui.work.presets import loosely_named
from app.kernels.progress import rounded
from renderer.clip import Clip
from renderer.depth.depth_ways import DepthWay
from renderer.readers.clip_options import FIELD_OF_VIEW, Stereo
from renderer.train.config import Method, TrainConfig

METHODS: Final[dict[Method, str]] = {method: named(method) for method in get_args(Method)}
METHOD_TEXT: Final = (
    "VesselSplat: tissue that moves, the default. Deform3DGS and EndoGaussian: published methods, to compare "
    "with. Static: tissue that does not move, or a single frame."
)
INPUTS: Final[dict[InputKind, str]] = {kind: named(kind) for kind in get_args(InputKind)}
INPUTS_TEXT: Final = (
    "Reconstruct the original frames, or frames enhanced with the settings of the image; both in turn runs "
    "two reconstructions to compare."
)
WAYS: Final[dict[DepthWay, str]] = {
    "measured": "Measured",
    "stereo": "Stereo",
    "motion": "From motion (no scale)",
    "guessed": "Guessed (no scale)",
}
WAYS_TEXT: Final = "Where the first shape comes from."
WAY_TEXTS: Final[dict[DepthWay, str]] = {
    "measured": "Depth maps that come with the clip.",
    "stereo": "Matched between left and right images.",
    "motion": "For a moving camera and mostly still tissue; lengths have no scale.",
    "guessed": "Any video: shapes are coarse, and lengths have no scale.",
}
BASELINE_TEXT: Final = (
    "Distance between the left and right camera in mm: gives lengths a scale. Empty: from the calibration, "
    "where there is one."
)
VIEW_TEXT: Final = "Horizontal field of view of the left camera, in degrees. Empty: 60° is assumed."
LENS_TEXT: Final = (
    "A file with the calibration of the lens, or of both eyes: images are undistorted, and depth from "
    "both eyes is in mm. Files of OpenCV, ROS or Kalibr (.yml, .yaml, .xml, .json), COLMAP's cameras.txt, or "
    "StereoCalibration.ini."
)
DROP_LENS_TEXT: Final = "Show the images as they are stored."
NO_WAY: Final = "Choose…"
POINTS: Final = "Sparse points"
EYES: Final[dict[Stereo, str]] = {
    "auto": "As the video says",
    "off": "One eye",
    "side-by-side": "Left and right halves",
    "top-bottom": "Upper and lower halves",
}
EYES_TEXT: Final = (
    "How the two eyes of a stereo endoscope are arranged in each frame, the left one first. The left eye is "
    "shown, and depth is matched between them."
)
LINK_TEXT: Final = (
    "Follow the image's settings. Off: keep them as they are now, whatever the image is set to."
)
TAKE_TEXT: Final = "Keep the settings that the image has now instead."
NAME_TEXT: Final = "Folder of the run; if empty, the clip's name and the time."
POOLED: Final = "Statistics are pooled over the training frames."


def draw_choices(state: AppState) -> None:
    run = state.runs.reconstruction
    config = run.config
    method = choose_row("Method", config.method, METHODS, METHOD_TEXT)
    if state.source.clip is not None:
        _draw_eyes(state)
        _draw_lens(state, state.source.clip)
        _draw_depth(state, state.source.clip)
    job_actions.choose_input(state, choose_row("Frames", run.input, INPUTS, INPUTS_TEXT))
    if run.input != "original":
        _draw_link(state)
    iterations = _steps(replace(config, iterations=_quality(run)))
    if (method, iterations) != (config.method, config.iterations):
        job_actions.choose_method(state, method, iterations)
    row("Name", "")
    explain_entry(NAME_TEXT)
    _, name = imgui.input_text_with_hint("##name", "automatic", run.name)
    job_actions.name_run(state, name)


def _draw_eyes(state: AppState) -> None:
    if clip_actions.is_video(state):
        chosen = choose_row("Stereo video", state.source.options.stereo, EYES, EYES_TEXT)
        clip_actions.choose_eyes(state, chosen)


def _draw_lens(state: AppState, clip: Clip) -> None:
    if not clip_actions.may_be_calibrated(state):
        return
    row("Lens", LENS_TEXT)
    if clip.calibrated:
        is_given = state.source.options.as_asked.calibration is not None
        imgui.text(f"{'Calibrated' if is_given else 'Found'}, {clip.cameras[0].field_of_view:.0f}° wide")
        imgui.same_line()
        button("Remove###remove lens", partial(clip_actions.drop_calibration, state), DROP_LENS_TEXT)
    else:
        take = clip_actions.choose_calibration
        button("Calibration…", partial(actions.choose_path, state, "file", take, "calibration"), LENS_TEXT)


def _draw_depth(state: AppState, clip: Clip) -> None:
    """What the clip cannot give is greyed and says why."""
    now = depth_actions.chosen_way(state)
    row("Depth", WAYS_TEXT)
    shown = WAYS[now] if now is not None else POINTS if clip.points is not None else NO_WAY
    is_open = imgui.begin_combo("##depth", shown)
    if is_open:
        for way, label in WAYS.items():
            reason = depth_actions.why_not(state, way)
            flags = imgui.SelectableFlags_.disabled if reason else 0
            if imgui.selectable(f"{label}###{way}", way == now, flags)[0]:
                depth_actions.choose_way(state, way)
            explain_entry(reason or WAY_TEXTS[way])
        imgui.end_combo()
    else:
        explain(WAYS_TEXT if now is None else WAY_TEXTS[now])
    if now == "stereo":
        _draw_pair(state, clip)
    if said := depth_actions.said(state):
        _indented(said)


def _draw_pair(state: AppState, clip: Clip) -> None:
    """What the scale of a stereo pair follows from, where its files do not state it."""
    options = state.source.reading
    known = "unknown, in mm" if clip.baseline is None else f"{clip.baseline:.4g} mm, calibrated"
    baseline = "" if options.baseline is None else f"{options.baseline:g} mm"
    row("Baseline", BASELINE_TEXT)
    _typed("##baseline", known, baseline, BASELINE_TEXT, partial(depth_actions.type_baseline, state))
    if not depth_actions.assumes_view(state):
        return
    view = options.field_of_view
    row("View angle", VIEW_TEXT)
    hint, shown = f"unknown, {FIELD_OF_VIEW:g}° assumed", "" if view is None else f"{view:g}°"
    _typed("##view", hint, shown, VIEW_TEXT, partial(depth_actions.type_field_of_view, state))


def _typed(name: str, hint: str, value: str, text: str, take: Callable[[str], None]) -> None:
    """A number that may be empty, taken when the typing ends."""
    flags = imgui.InputTextFlags_.chars_decimal | imgui.InputTextFlags_.auto_select_all
    _, typed = imgui.input_text_with_hint(name, hint, value, flags)
    ended = imgui.is_item_deactivated_after_edit()
    explain(text)
    if ended:
        take(typed)


def _draw_link(state: AppState) -> None:
    """With which settings the frames are enhanced: the image's, or those kept."""
    run, params = state.runs.reconstruction, job_actions.frame_settings(state)
    name = loosely_named(params, state.enhancement.presets)
    kept = run.kept
    text = f"{worded(params)}. In the paper's letters: {in_letters(params)}. {POOLED}"
    row("Settings", LINK_TEXT)
    changed, linked = checkbox("As the image###linked", kept is None)
    explain(LINK_TEXT)
    if changed:
        job_actions.link_settings(state, linked=linked)
    if kept is None:
        _indented(name)
        explain(text)
        return
    _indented(f"{name}, kept from {job_actions.moment(kept)}")
    explain(text)
    imgui.set_cursor_pos_x(imgui.get_cursor_pos_x() + em(NAMES))
    reason = "" if kept.params != state.enhancement.params else "The image has these settings."
    take = partial(job_actions.keep_settings_now, state)
    button("Take the image's now", take, TAKE_TEXT, reason=reason, width=-0.1)


def _indented(text: str) -> None:
    """A quiet line below a control."""
    imgui.indent(em(NAMES))
    note(text)
    imgui.unindent(em(NAMES))


def _quality(run: Reconstruction) -> int:
    """The iterations that are chosen by a word, and what each would take where that is known."""
    now = quality_of(run.config.iterations)
    offered = QUALITIES | {now: run.config.iterations}
    took = {name: expected_seconds(run, count) for name, count in offered.items()}
    shown = {name: f"{name}, {rounded(each)}" if each else name for name, each in took.items()}
    steps = ", ".join(f"{name.lower()} {count}" for name, count in QUALITIES.items())
    text = f"Number of iterations: {steps}. More are slower and better."
    if took[now] is not None:
        text += " Times are at the speed of the run shown."
    return QUALITIES.get(choose_row("Quality", now, shown, text), run.config.iterations)


def _steps(config: TrainConfig) -> int:
    about = declared(TrainConfig, "iterations")
    text = about.text or "Training iterations; more are slower and better."
    row("Iterations", "")
    explain_entry(text)
    changed, value = imgui.input_int("##iterations", config.iterations, 100, 1000)
    explain_entry(text)
    if asks_for_default("iterations"):
        return int(about.default)
    return int(min(max(value, about.lo), about.hi)) if changed else config.iterations
