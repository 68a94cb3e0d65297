"""The commands of the 3D view, its cameras and its path."""

from __future__ import annotations

from functools import partial

from app.gui.actions import actions, camera_actions, export_actions, path_actions, second_actions
from app.gui.commands import recent_commands
from app.gui.commands.command import Command, Needs, Section, has_model, menu
from app.gui.state.app_state import AppState

BLEND_STEP = 0.1
import_views = partial(actions.choose_path, kind="file", take=actions.open_path, purpose="views")
export_cameras = partial(export_actions.choose_what, what="cameras of the clip")
export_path = partial(export_actions.choose_what, what="cameras of the path")


def camera_sections(state: AppState) -> tuple[Section, ...]:
    views = (
        Command("Clip camera", camera_actions.reset_view, ("Shift+C",),
                text="return the 3D view to the clip's camera", applies=has_model,
                synonyms=("reset", "home", "view", "centre", "center")),
        Command("Frame overlay", camera_actions.toggle_snap, ("C",),
                text="3D view from the clip's camera, with its frame over it",
                applies=lambda s: s.has_frames, ticked=lambda s: s.scene.viewer.snapped,
                synonyms=("blend", "snap", "compare")),
        Command("Less of the frame", lambda s: _blend(s, -BLEND_STEP), ("[",),
                applies=_snapped, repeats=True),
        Command("More of the frame", lambda s: _blend(s, BLEND_STEP), ("]",),
                applies=_snapped, repeats=True),
        Command("Next kind of view", camera_actions.next_view, ("N",),
                text="3D view: colour, depth, normals and others", applies=has_model,
                synonyms=("depth", "normals", "opacity", "motion", "ellipsoids", "points", "colour", "map",
                          "heatmap", "render", "rendering")),
        Command("Measure", camera_actions.toggle_measuring, ("M",),
                text="measure between two clicks on the 3D view",
                applies=has_model, refuse=_refuse_measuring, ticked=lambda s: s.scene.viewer.measuring,
                synonyms=("distance", "ruler", "length", "size", "mm", "caliper", "diameter", "width",
                          "measurement", "quantify", "scale")),
        Command("Fly", camera_actions.toggle_flight, ("G",),
                text="fly through the 3D view, or return to orbiting",
                applies=has_model, ticked=lambda s: s.scene.viewer.flying,
                synonyms=("walk", "navigate", "first", "person")),
    )  # fmt: skip
    path = (
        Command("Add this view", path_actions.save_view, ("B",),
                text="add this 3D view under a name", applies=has_model,
                synonyms=("bookmark", "save", "camera")),
        Command("Add a keyframe", path_actions.add_keyframe, ("I",),
                text="add this 3D view to the camera path", applies=has_model,
                synonyms=("animation", "path", "record", "trajectory", "animate", "flythrough", "turntable")),
        Command("Play the path", path_actions.toggle_path, ("L",), text="play the camera path",
                applies=lambda s: len(s.scene.cameras.views.path.keyframes) > 1,
                ticked=lambda s: s.scene.cameras.playing,
                synonyms=("trajectory", "animation", "flythrough")),
    )  # fmt: skip
    files = (
        Command("Import views…", import_views, applies=has_model),
        Command("Save views and path", path_actions.save_views,
                applies=lambda s: bool(s.scene.cameras.views.path.keyframes or s.scene.cameras.views.named)),
        Command("Export the clip's cameras…", export_cameras, applies=has_model),
        Command("Export the path's cameras…", export_path,
                applies=_has_path),
    )  # fmt: skip
    return *menu("Camera", views, path, files), Section("Camera", second_commands(state), "Second view")


def second_commands(state: AppState) -> tuple[Command, ...]:
    """What to see beside the first 3D view."""
    choose = partial(actions.choose_path, take=second_actions.open_second)
    return (
        Command("Run folder beside…", partial(choose, kind="folder", purpose="run"), applies=has_model),
        Command("Splat file beside…", partial(choose, kind="file", purpose="splats"), applies=has_model),
        *recent_commands.beside(state),
        Command("Close the second view", second_actions.close_second,
                applies=lambda s: s.scene.second.model is not None),
    )  # fmt: skip


_has_path = Needs(
    lambda state: "" if state.scene.cameras.views.path.keyframes else "Add a keyframe to the path first."
)
_snapped = Needs(lambda state: "" if state.scene.viewer.snapped else "Turn on the frame overlay first (C).")


def _refuse_measuring(state: AppState) -> None:
    actions.announce(state, camera_actions.NOTHING_TO_MEASURE)


def _blend(state: AppState, by: float) -> None:
    camera_actions.blend(state, state.scene.viewer.blend + by)
