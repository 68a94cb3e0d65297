"""What a user can do with the second 3D view, as functions on the state."""

from __future__ import annotations

from pathlib import Path

from app.gui.actions import actions
from app.gui.state.app_state import AppState
from app.gui.state.scene import Second
from app.gui.work.background import Failure
from app.gui.work.beside import BesideRequest
from app.gui.work.opening import Opened, OpenRequest
from app.scenes.scene import Scene


def open_second(state: AppState, path: Path) -> None:
    """Ask for a finished run or a file of splats, to be seen beside the first."""
    if state.scene.model is not None:
        state.scene.second.opening = OpenRequest(path.absolute(), state.source.clip_options)
        state.window.banner = None


def offered(state: AppState) -> tuple[Path, ...]:
    """What can be seen beside the first: the clip's runs, and what was opened lately; not what is shown."""
    if state.scene.model is None:
        return ()
    found = state.runs.found
    of_clip = found.runs if found is not None and found.request.clip is state.source.clip else ()
    runs = (run.path for run in of_clip if run.has_model)
    made = state.runs.reconstruction.run_path if state.runs.reconstruction.is_alive else None
    shown = {state.scene.model.path, made}
    if state.scene.second.model is not None:
        shown.add(state.scene.second.model.path)
    return tuple(dict.fromkeys(path for path in (*runs, *state.scene.models) if path not in shown))


def take_models(state: AppState, request: BesideRequest, answer: tuple[Path, ...]) -> None:
    state.scene.models = answer


def take_second(state: AppState, request: OpenRequest, answer: Opened | Failure) -> None:
    """Show what has been opened; what cannot be, or has no reconstruction, is refused: what is beside the
    first stays."""
    if request is not state.scene.second.opening:
        return
    state.scene.second.opening = None
    if isinstance(answer, Failure):
        actions.fail(state, answer.message)
        return
    if answer.model is None:
        actions.fail(state, f"expected a finished run or a splat file beside the first: {request.path}")
    else:
        _show(state, answer.model)


def show_instead(state: AppState, path: Path, shown: Scene) -> None:
    """Beside the model in training; refused where that has no preview yet."""
    if state.scene.model is None:
        waits = "wait for the first preview of the reconstruction in training"
        actions.fail(state, f"{path.name} is shown beside it: {waits}")
        return
    _show(state, shown)
    actions.announce(state, f"{path.name} is shown beside the reconstruction in training")


def _show(state: AppState, shown: Scene) -> None:
    state.scene.second = Second(model=shown)
    if state.scene.model is not None and shown.first != state.scene.model.first:
        actions.say(
            state, f"{shown.name} covers another part of the clip: the same time is a different moment"
        )
    elif state.scene.model is not None and shown.cameras != state.scene.model.cameras:
        actions.say(state, f"{shown.name} is of another clip: the first one's camera may not see it")


def close_second(state: AppState) -> None:
    state.scene.second = Second()
