"""What a user can do with named views and the camera path, as functions on the state."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from app.exports.camera_set import CameraSet
from app.files.provenance import stamp
from app.gui.actions import actions
from app.gui.state.app_state import AppState
from app.gui.work.writing import WriteRequest
from app.scenes.clip_speed import FRAMES_PER_SECOND
from app.scenes.free_camera import FreeView
from app.scenes.scene import Scene
from renderer.camera import Camera
from renderer.camera_files import NamedCamera
from renderer.camera_path import CameraPath, Keyframe
from renderer.listing import count
from renderer.view_files import LONGEST, Views, views_json

KEYFRAME_STEP = 2.0
"""Seconds from the last keyframe to one that is added after it."""
LEAST_STEP = 0.01


def present_camera(state: AppState) -> Camera | None:
    """What the 3D view is seen through, with the pixels of the clip's frames."""
    if state.scene.model is None:
        return None
    free = state.scene.viewer.free
    return free.camera if free is not None else state.scene.model.camera_at(state.time)


def go_to(state: AppState, camera: Camera) -> None:
    """The 3D view through a camera; it then turns around what is in the middle of it."""
    if state.scene.model is not None:
        free = FreeView.of(camera)
        state.scene.viewer = replace(state.scene.viewer, free=free, pivot=None, snapped=False, flying=False)


def type_name(state: AppState, name: str) -> None:
    """Change the name that the next saved view will have."""
    state.scene.cameras.name = name


def save_view(state: AppState) -> None:
    """Keep the present view by the name that was typed, or a number."""
    camera, cameras = present_camera(state), state.scene.cameras
    if camera is None:
        return
    taken = {one.name for one in cameras.views.named}
    name = cameras.name.strip()[:LONGEST] or next(
        text for text in (f"View {number}" for number in range(1, len(taken) + 2)) if text not in taken
    )
    cameras.name = ""
    _change(state, named=(*cameras.views.named, NamedCamera(name, camera)))


def rename_view(state: AppState, index: int, name: str) -> None:
    """Rename a view; an empty name changes nothing."""
    named = list(state.scene.cameras.views.named)
    if name.strip():
        named[index] = NamedCamera(name.strip()[:LONGEST], named[index].camera)
        _change(state, named=tuple(named))


def delete_view(state: AppState, index: int) -> None:
    named = state.scene.cameras.views.named
    _change(state, named=named[:index] + named[index + 1 :])


def add_keyframe(state: AppState) -> None:
    """The present view and time at the playhead, or after the end when there is one already."""
    camera, cameras = present_camera(state), state.scene.cameras
    if camera is None:
        return
    path = cameras.views.path
    free = all(abs(key.seconds - cameras.playhead) >= LEAST_STEP for key in path.keyframes)
    seconds = cameras.playhead if free else path.end + KEYFRAME_STEP
    key = Keyframe(seconds, state.time, camera)
    cameras.playhead, cameras.playing = seconds, False
    _change_path(state, sorted((*path.keyframes, key), key=lambda one: one.seconds))


def replace_keyframe(state: AppState, index: int) -> None:
    """The keyframe sees what is seen now."""
    camera = present_camera(state)
    if camera is not None:
        keys = list(state.scene.cameras.views.path.keyframes)
        keys[index] = replace(keys[index], camera=camera, time=state.time)
        _change_path(state, keys)


def move_keyframe(state: AppState, index: int, seconds: float) -> None:
    """To another moment of the path, between its neighbours."""
    keys = list(state.scene.cameras.views.path.keyframes)
    least = keys[index - 1].seconds + LEAST_STEP if index > 0 else 0.0
    most = keys[index + 1].seconds - LEAST_STEP if index + 1 < len(keys) else float("inf")
    keys[index] = replace(keys[index], seconds=max(min(seconds, most), least))
    _change_path(state, keys)


def retime_keyframe(state: AppState, index: int, time: float) -> None:
    """The moment of the clip that it shows, in [0, 1]."""
    keys = list(state.scene.cameras.views.path.keyframes)
    keys[index] = replace(keys[index], time=min(max(time, 0.0), 1.0))
    _change_path(state, keys)


def delete_keyframe(state: AppState, index: int) -> None:
    keys = state.scene.cameras.views.path.keyframes
    _change_path(state, [*keys[:index], *keys[index + 1 :]])


def _change_path(state: AppState, keys: list[Keyframe]) -> None:
    try:
        path = CameraPath(tuple(keys))
    except ValueError as error:
        actions.fail(state, f"the path is unchanged: {error}")
    else:
        _change(state, path=path)


def _change(state: AppState, **parts: object) -> None:
    unit = state.scene.model.unit if state.scene.model is not None else state.scene.cameras.views.unit
    try:
        state.scene.cameras.views = replace(state.scene.cameras.views, unit=unit, **parts)  # type: ignore[arg-type]
    except ValueError as error:
        actions.fail(state, str(error))


def set_loop(state: AppState, loop: bool) -> None:
    _change(state, loop=loop)


def toggle_path(state: AppState) -> None:
    """Play the path, from its beginning when it is at its end; or stop."""
    cameras, path = state.scene.cameras, state.scene.cameras.views.path
    if state.scene.model is None or len(path.keyframes) < 2:
        return
    cameras.playing = not cameras.playing
    state.timeline.playing = False
    if cameras.playing and not path.start <= cameras.playhead < path.end:
        cameras.playhead = path.start


def toggle_path_shown(state: AppState) -> None:
    """Draw the path in the 3D view, or not."""
    state.scene.cameras.path_shown = not state.scene.cameras.path_shown


def sees_path(state: AppState) -> bool:
    """Whether the 3D view shows where the path goes: not while it is what the path itself sees."""
    cameras, path = state.scene.cameras, state.scene.cameras.views.path
    if not (cameras.path_shown and path.keyframes) or cameras.playing:
        return False
    return present_camera(state) != path.at(cameras.playhead).camera


def seek_path(state: AppState, seconds: float) -> None:
    """See what the path sees there, at its time of the clip."""
    cameras = state.scene.cameras
    cameras.playhead = seconds
    if cameras.views.path.keyframes:
        key = cameras.views.path.at(seconds)
        go_to(state, key.camera)
        actions.seek_view(state, key.time)


def advance_path(state: AppState, elapsed: float) -> None:
    """On by seconds on the clock; at the end again from the beginning, or still."""
    cameras, path = state.scene.cameras, state.scene.cameras.views.path
    if not cameras.playing:
        return
    if len(path.keyframes) < 2 or state.scene.model is None or state.scene.dragged or state.timeline.playing:
        cameras.playing = False
        return
    seconds = cameras.playhead + elapsed
    if seconds >= path.end and cameras.views.loop:
        seconds = path.start + (seconds - path.start) % (path.end - path.start)
    cameras.playing = seconds < path.end
    seek_path(state, min(seconds, path.end))


def add_views(state: AppState, read: Views, path: Path) -> None:
    """Add the named views of a file, ours or another program's, and take over its path if it has one. They
    are in the scene's unit, of which a file of another program says nothing."""
    now, model = state.scene.cameras.views, state.scene.model
    try:
        added = replace(
            read, named=(*now.named, *read.named), unit=read.unit if model is None else model.unit
        )
    except ValueError as error:
        actions.fail(state, f"{error}: {path}")
        return
    if not read.path.keyframes:
        added = replace(added, path=now.path, loop=now.loop)
    state.scene.cameras.views = added
    keys = f" and a path of {count(len(read.path.keyframes), 'keyframe')}" if read.path.keyframes else ""
    actions.announce(state, f"{count(len(read.named), 'view')}{keys} from {path.name}")
    if model is not None and read.unit not in (Views().unit, model.unit):
        actions.say(state, f"{path.name} is in {read.unit}, this scene in {model.unit}")


def save_views(state: AppState) -> None:
    """All named views and the path, for this app and `vesselsplat export --path`: a JSON file among the
    exports, named after what is open and the time."""
    name = Path(state.scene.model.name).stem if state.scene.model is not None else "vesselsplat"
    path, trouble = state.export_folder / f"{name}-views-{stamp()}.json", "the cameras were not saved"
    content = views_json(state.scene.cameras.views)
    state.window.wishes += (WriteRequest(path, content, trouble, announced=True),)


def clip_cameras(model: Scene) -> CameraSet:
    """That of each frame, for other programs."""
    named = tuple(NamedCamera(f"frame-{at:06d}", one) for at, one in enumerate(model.cameras))
    return CameraSet(named, tuple(map(model.time, range(len(named)))), model.model)


def path_cameras(model: Scene, path: CameraPath) -> CameraSet:
    """Those along a path that has keyframes, in the same way."""
    keys = path.moments(FRAMES_PER_SECOND)
    named = tuple(NamedCamera(f"path-{at:06d}", key.camera) for at, key in enumerate(keys))
    return CameraSet(named, tuple(key.time for key in keys), model.model)
