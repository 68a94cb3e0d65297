"""What a user can do with the next and the running reconstruction, as functions on the state. No ImGui."""

from __future__ import annotations

from dataclasses import replace
from datetime import datetime
from pathlib import Path

from app.enhancement.methods import EnhancementSettings
from app.enhancement.settable import LONGEST_NAME, InputKind
from app.files.legible import to_minute
from app.gui.actions import clip_actions, depth_actions
from app.gui.actions.actions import announce, leave
from app.gui.session_file import KeptSettings
from app.gui.state.app_state import AppState
from app.gui.state.reconstruction import Waiting
from app.gui.views.measurement import Measurement
from app.gui.work.runs import ModelRequest
from app.runs.run_changes import folder_name
from app.runs.run_folder import Input
from app.runs.train_run import TrainRequest
from app.scenes.scene import Scene, Training
from renderer.gaussians import DynamicGaussians
from renderer.train.config import Method, Part


def choose_input(state: AppState, frames: InputKind) -> None:
    """The frames as they are, enhanced, or both in turn."""
    state.runs.reconstruction.input = frames


def frame_settings(state: AppState) -> EnhancementSettings:
    """What frames are enhanced with for it: as the image is, or as it was when they were kept."""
    kept = state.runs.reconstruction.kept
    return state.enhancement.params if kept is None else kept.params


def link_settings(state: AppState, *, linked: bool) -> None:
    """Have the settings follow the image's, or stay as they are now."""
    if linked:
        state.runs.reconstruction.kept = None
    else:
        keep_settings_now(state)


def keep_settings_now(state: AppState) -> None:
    """Those of the image as it is now, whatever it is set to later."""
    state.runs.reconstruction.kept = KeptSettings(state.enhancement.params, to_minute(datetime.now()))


def moment(kept: KeptSettings) -> str:
    """When they were kept, as a person says it: the time of a day, or the day."""
    day, _, time = kept.since.partition(" ")
    return time if day == datetime.now().date().isoformat() else day


def choose_method(state: AppState, method: Method, iterations: int) -> None:
    draft = state.runs.reconstruction
    draft.config = replace(draft.config, method=method, iterations=iterations)


def name_run(state: AppState, name: str) -> None:
    """Folder of the run; empty: the clip's name and the time."""
    state.runs.reconstruction.name = name[:LONGEST_NAME]


def start_reconstruction(state: AppState) -> None:
    """Make what is chosen, in another process: at once, or when its turn comes."""
    if state.source.clip is None:
        return
    state.runs.asked = True
    chosen = state.runs.reconstruction.input
    inputs: tuple[Input, ...] = ("original", "enhanced") if chosen == "both in turn" else (chosen,)
    enqueue(state, tuple(Waiting(state.source.clip, _request(state, each)) for each in inputs))


def keep_part(state: AppState, part: Part, *, kept: bool) -> None:
    """Of the next reconstruction: what its clip does not need stays in all the same, or no longer."""
    draft = state.runs.reconstruction
    others = tuple(other for other in draft.config.keep if other != part)
    draft.config = replace(draft.config, keep=(*others, part) if kept else others)


def _request(state: AppState, frames: Input) -> TrainRequest:
    clip, draft = state.source.clip, state.runs.reconstruction
    assert clip is not None
    return TrainRequest(
        clip_path=clip.path,
        run_path=_run_path(state, f"-{frames}" if draft.input == "both in turn" else ""),
        config=draft.config,
        clip_options=state.source.options,
        part=state.source.training_part,
        input=frames,
        enhance_params=frame_settings(state),
    )


def continue_reconstruction(state: AppState) -> None:
    """Go on with the run that was cut short, as it was begun, whatever has been chosen since."""
    run = state.runs.reconstruction
    clip, request = state.source.clip, run.request
    if can_continue(state) and request is not None:
        # Another clip, or the same one read in another way: the run's own is opened when its turn comes.
        is_open = clip is not None and clip.lies_at(request.clip_path)
        same = is_open and request.clip_options.reads_as(state.source.options)
        enqueue(state, (Waiting(clip if same else None, replace(request, resume=True), run.told),))


def enqueue(state: AppState, waiting: tuple[Waiting, ...]) -> None:
    """Behind those that wait for their turn, before those of an earlier session that nobody has asked for;
    where none is under way the first starts."""

    def go() -> None:
        awake = tuple(each for each in state.runs.queue if not each.asleep)
        asleep = tuple(each for each in state.runs.queue if each.asleep)
        state.runs.queue, state.runs.reconstruction.name = awake + waiting + asleep, ""
        state.runs.starts = True
        if state.runs.reconstruction.is_alive:
            names = " and ".join(each.request.run_path.name for each in waiting)
            announce(state, f"queued {names}: see Runs")
        elif state.runs.ending is not None:
            announce(state, "It starts as soon as the process of the last reconstruction has ended")

    if state.runs.reconstruction.is_alive:
        go()
    else:
        leave(state, go)


def _run_path(state: AppState, suffix: str) -> Path:
    """The name the user gave, or the clip's with the time; never one that is taken or promised."""
    assert state.source.clip is not None
    stamp = datetime.now().astimezone().strftime("%Y%m%d-%H%M%S")
    typed = state.runs.reconstruction.name.strip()
    ending = suffix if typed else f"-{stamp}{suffix}"
    base = folder_name(typed or state.source.clip.name, ending) or f"run{ending}"
    path, number = state.places.runs / base, 2
    while path.exists() or state.runs.is_queued(path) or path == state.runs.reconstruction.run_path:
        path, number = state.places.runs / f"{base}-{number}", number + 1
    return path


def pause(state: AppState) -> None:
    if state.runs.reconstruction.can_pause and state.runs.reconstruction.job:
        state.runs.reconstruction.job.pause()


def resume(state: AppState) -> None:
    if state.runs.reconstruction.can_resume and state.runs.reconstruction.job:
        state.runs.reconstruction.job.resume()


def toggle_pause(state: AppState) -> None:
    """Pause the reconstruction, or resume it."""
    pause(state) if state.runs.reconstruction.can_pause else resume(state)


def cancel(state: AppState) -> None:
    run = state.runs.reconstruction
    if run.is_alive and run.job:
        run.cancelling = True
        run.job.cancel()


def show_live_model(state: AppState, model: DynamicGaussians) -> None:
    """Ask for the newest copy of the model that is being trained in the 3D view."""
    job, wish = state.runs.reconstruction, state.runs.model_wish
    if wish is None or wish.model is not model:
        _wish(state, model, Training(job.iteration, job.iterations, live=True))


def show_finished_model(state: AppState, model: DynamicGaussians) -> None:
    job = state.runs.reconstruction
    _wish(state, model, Training(job.iterations, job.iterations, live=False))


def _wish(state: AppState, model: DynamicGaussians, training: Training) -> None:
    job = state.runs.reconstruction
    if job.clip is not None and job.request is not None:
        state.runs.model_wish = ModelRequest(job.request, job.clip, model, training)


def model_wish(state: AppState) -> ModelRequest | None:
    """What is to be shown of the present run or of the last one: nothing while the model of another is
    edited."""
    wish, editing = state.runs.model_wish, state.editing
    is_other = wish is not None and editing.run_path not in (None, wish.run.run_path)
    return None if is_other and editing.is_under_way else wish


def waits_for_edits(state: AppState) -> bool:
    """There is a model to show, in place of one that is edited."""
    return state.runs.model_wish is not None and model_wish(state) is None


def take_model(state: AppState, request: ModelRequest, scene: Scene) -> None:
    """Show it; what something else has taken the place of is dropped."""
    wish, before = model_wish(state), state.scene.model
    if wish is None or wish.run is not request.run:
        return
    if scene.live and before is not None and before.cameras == scene.cameras:
        # A pivot that follows every preview would make the picture wander.
        scene = replace(scene, distance=before.distance)
    state.scene.model = scene
    if scene.live and not state.runs.reconstruction.is_alive:
        state.runs.preview = scene
    if before is not None and before.live and not scene.live and state.scene.viewer.measurement.points:
        state.scene.viewer.measurement = Measurement()
        announce(state, "what was measured is of a preview: measure again on the finished model")


def can_continue(state: AppState) -> bool:
    """A run was cut short, whatever clip is open now."""
    job = state.runs.reconstruction
    return job.request is not None and job.status in ("cancelled", "failed") and not job.saved_nothing


def why_not_reconstruct(state: AppState) -> str:
    """What a reconstruction still lacks, in a sentence; empty when it can start."""
    clip = state.source.clip
    if (none := clip_actions.why_no_clip(state)) or clip is None:
        return none
    if state.source.depth_wish is not None:
        return depth_actions.READING
    why = depth_actions.why_no_depth(state)
    return f"Choose Depth first. {why}" if why and clip.has_one_size else why


def refuse(state: AppState) -> None:
    """Say why nothing can be reconstructed, and bring the panel to the front."""
    announce(state, why_not_reconstruct(state))
    state.runs.asked = True
