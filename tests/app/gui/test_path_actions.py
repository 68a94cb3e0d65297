from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from app.exports.exporting import export
from app.gui.actions import (
    actions,
    arriving,
    camera_actions,
    clip_actions,
    export_actions,
    path_actions,
    remembered,
)
from app.gui.state.app_state import AppState
from app.gui.state.source import Source
from app.gui.update.channels import Channels
from app.gui.update.update import update
from app.gui.work.opening import Opened
from app.gui.work.settings import Places, load_clips
from renderer.camera import Camera
from renderer.camera_files import NamedCamera, read_cameras, splatting_json
from renderer.camera_path import Keyframe
from renderer.view_files import Views, import_views, read_views, views_json
from tests.app.gui.settling import keep_all


def camera(state: AppState) -> Camera:
    """What the 3D view is drawn through."""
    assert state.view_request is not None
    return state.view_request.camera


def keyframes(state: AppState) -> tuple[Keyframe, ...]:
    return state.scene.cameras.views.path.keyframes


def with_path(state: AppState) -> list[Camera]:
    """Three keyframes at 0, 2 and 4 s."""
    cameras = []
    for frame in (0, 2, 5):
        actions.seek(state, frame)
        camera_actions.turn(state, 0.3, 0.1)
        path_actions.add_keyframe(state)
        cameras.append(camera(state))
    return cameras


def test_a_named_view_is_gone_to_renamed_and_deleted(seen: AppState) -> None:
    camera_actions.turn(seen, 0.4, 0.2)
    kept = camera(seen)
    seen.scene.cameras.name = "  from the left "
    path_actions.save_view(seen)
    camera_actions.reset_view(seen)
    path_actions.save_view(seen)
    path_actions.save_view(seen)
    assert [one.name for one in seen.scene.cameras.views.named] == ["from the left", "View 1", "View 2"]
    path_actions.go_to(seen, seen.scene.cameras.views.named[0].camera)
    assert camera(seen) == kept
    path_actions.rename_view(seen, 0, "from above")
    path_actions.rename_view(seen, 1, "   ")
    path_actions.delete_view(seen, 2)
    assert [one.name for one in seen.scene.cameras.views.named] == ["from above", "View 1"]


def test_a_view_that_was_gone_to_turns_around_what_is_in_its_middle(seen: AppState) -> None:
    camera_actions.turn(seen, 0.4, 0.2)
    camera_actions.pan(seen, 7, 3)
    path_actions.go_to(seen, camera(seen))
    before = camera(seen)
    camera_actions.turn(seen, 0.1, 0.0)
    pivot = np.array([seen.scene.viewer.pivot])
    assert before.project(pivot)[0][0] == pytest.approx((24, 20))
    assert camera(seen).project(pivot)[0][0] == pytest.approx((24, 20))


def test_views_and_path_are_there_again_when_their_clip_is_opened_again(seen: AppState) -> None:
    """Nobody is asked before another clip takes its place."""
    clip = seen.source.clip
    assert clip is not None
    with_path(seen)
    path_actions.save_view(seen)
    made, other = seen.scene.cameras.views, replace(clip, path=clip.path.with_name("other"))
    arriving.show_opened(seen, other.path, Opened(other))
    assert seen.scene.cameras.views == Views()
    arriving.show_opened(seen, clip.path, Opened(clip))
    assert seen.scene.cameras.views == made
    assert not seen.scene.cameras.playing


def test_they_are_there_in_a_window_that_is_opened_later(seen: AppState, places: Places) -> None:
    """Closing asks about none of it, and what a person chose for the clip before stays."""
    clip = seen.source.clip
    assert clip is not None
    actions.seek(seen, 1)
    clip_actions.trim_here(seen, start=True)
    with_path(seen)
    path_actions.save_view(seen)
    remembered.remember(seen)
    clip_actions.keep_reading(seen, replace(seen.source.reading, baseline=4.0))
    keep_all(seen)
    later = AppState(places, source=Source(known=load_clips(places.config)))
    arriving.show_opened(later, clip.path, Opened(clip))
    assert later.scene.cameras.views == seen.scene.cameras.views
    assert later.source.part.trim == (1, 5)
    later.scene.cameras.views = Views()
    remembered.remember(later)
    keep_all(later)
    assert load_clips(places.config)[str(clip.path)].views is None


def test_what_another_window_keeps_of_the_same_clip_stays(seen: AppState, places: Places) -> None:
    clip = seen.source.clip
    assert clip is not None
    other = AppState(places)
    arriving.show_opened(other, clip.path, Opened(clip))
    path_actions.save_view(seen)
    remembered.remember(seen)
    keep_all(seen)
    actions.seek(other, 1)
    clip_actions.trim_here(other, start=True)
    keep_all(other)
    known = load_clips(places.config)[str(clip.path)]
    assert (known.views, known.trim) == (seen.scene.cameras.views, (1, 5))


def test_those_of_a_session_are_kept_in_its_file_alone(seen: AppState, tmp_path: Path) -> None:
    path_actions.save_view(seen)
    remembered.remember(seen)
    known = seen.source.known
    seen.session.path = tmp_path / "monday.vesselsplat"
    path_actions.save_view(seen)
    remembered.remember(seen)
    assert seen.source.known == known


def test_keyframes_are_the_views_and_times_that_were_shown(seen: AppState) -> None:
    cameras = with_path(seen)
    assert [key.seconds for key in keyframes(seen)] == [0.0, 2.0, 4.0]
    assert [key.time for key in keyframes(seen)] == [0.0, 2 / 6, 5 / 6]
    for key, wanted in zip(keyframes(seen), cameras, strict=True):
        path_actions.seek_path(seen, key.seconds)
        assert camera(seen) == wanted
        assert seen.time == key.time


def test_a_keyframe_is_added_where_the_playhead_is(seen: AppState) -> None:
    with_path(seen)
    path_actions.seek_path(seen, 1.0)
    path_actions.add_keyframe(seen)
    assert [key.seconds for key in keyframes(seen)] == [0.0, 1.0, 2.0, 4.0]


def test_keyframes_move_between_their_neighbours_and_within_the_clip(seen: AppState) -> None:
    with_path(seen)
    path_actions.move_keyframe(seen, 1, 99.0)
    assert 3.9 < keyframes(seen)[1].seconds < 4.0
    path_actions.move_keyframe(seen, 1, -99.0)
    assert 0.0 < keyframes(seen)[1].seconds < 0.1
    path_actions.move_keyframe(seen, 2, 99.0)
    assert keyframes(seen)[2].seconds == 99.0
    path_actions.retime_keyframe(seen, 0, 7.0)
    assert keyframes(seen)[0].time == 1.0
    camera_actions.reset_view(seen)
    path_actions.replace_keyframe(seen, 0)
    assert keyframes(seen)[0].camera == camera(seen)
    path_actions.delete_keyframe(seen, 1)
    assert [key.seconds for key in keyframes(seen)] == [0.0, 99.0]


def test_the_path_plays_to_its_end_or_round_and_round(seen: AppState) -> None:
    with_path(seen)
    path_actions.toggle_path(seen)
    assert (seen.scene.cameras.playing, seen.scene.cameras.playhead) == (True, 0.0)  # It was at its end.
    path_actions.advance_path(seen, 2.5)
    assert camera(seen) == seen.scene.cameras.views.path.at(2.5).camera
    path_actions.advance_path(seen, 2.5)
    assert (seen.scene.cameras.playing, seen.scene.cameras.playhead) == (False, 4.0)
    path_actions.set_loop(seen, True)
    path_actions.toggle_path(seen)
    path_actions.advance_path(seen, 4.5)
    assert seen.scene.cameras.playing
    assert seen.scene.cameras.playhead == pytest.approx(0.5)


MOVES: list[Callable[[AppState], None]] = [
    camera_actions.reset_view,
    camera_actions.toggle_snap,
    lambda state: camera_actions.turn(state, 0.1, 0.1),
    lambda state: camera_actions.zoom(state, 1.1),
]


@pytest.mark.parametrize("move", MOVES)
def test_a_hand_on_the_view_stops_the_path(seen: AppState, move: Callable[[AppState], None]) -> None:
    with_path(seen)
    path_actions.toggle_path(seen)
    path_actions.advance_path(seen, 0.1)
    move(seen)
    after = camera(seen)
    path_actions.advance_path(seen, 0.1)
    assert not seen.scene.cameras.playing
    assert camera(seen) == after


def test_what_is_saved_is_loaded_again(seen: AppState) -> None:
    with_path(seen)
    path_actions.save_view(seen)
    path_actions.set_loop(seen, True)
    saved = seen.scene.cameras.views
    path_actions.save_views(seen)
    keep_all(seen)
    (file,) = seen.places.pictures.glob("*-views-*.json")
    assert read_views(file).unit == "mm"
    assert views_json(read_views(file)) == views_json(saved)
    for index in reversed(range(3)):
        path_actions.delete_keyframe(seen, index)
    path_actions.add_views(seen, import_views(file), file)
    assert seen.scene.cameras.views.path == saved.path
    assert [one.name for one in seen.scene.cameras.views.named] == ["View 1", "View 1"]


def test_cameras_of_other_programs_are_named_views(seen: AppState, tmp_path: Path) -> None:
    with_path(seen)
    path = seen.scene.cameras.views.path
    file = tmp_path / "cameras.json"
    turned = path.keyframes[1].camera
    file.write_bytes(splatting_json([NamedCamera("photo 7", turned)]))
    path_actions.add_views(seen, import_views(file), file)
    (one,) = seen.scene.cameras.views.named
    assert one.name == "photo 7"
    assert one.camera.camera_from_world == pytest.approx(turned.camera_from_world, abs=1e-6)
    assert seen.scene.cameras.views.unit == "mm"
    assert seen.scene.cameras.views.path == path


def test_the_clip_s_and_the_path_s_cameras_are_exported(seen: AppState) -> None:
    with_path(seen)
    files = []
    for what in ("cameras of the clip", "cameras of the path"):
        request = export_actions.export_request(seen, what)
        assert request is not None
        *_, last = export(request)
        export_actions.take_step(seen, request, last)
        assert last.path is not None
        files.append(last.path)
    assert [file.suffix for file in files] == [".json", ".json"]
    clip, path = (read_cameras(file) for file in files)
    assert seen.source.clip is not None
    assert [one.camera.camera_from_world.tolist() for one in clip] == [
        one.camera_from_world.tolist() for one in seen.source.clip.cameras
    ]
    assert len(path) == 4 * 15 + 1
    wanted = seen.scene.cameras.views.path.at(1.0).camera.position
    assert path[15].camera.position == pytest.approx(wanted, abs=1e-6)


@pytest.mark.parametrize("content", [b"{}", b"[", b"", views_json(Views()).replace(b"1", b"x", 1)])
def test_a_file_that_is_none_is_one_line_and_changes_nothing(
    seen: AppState, tmp_path: Path, content: bytes
) -> None:
    with_path(seen)
    before = seen.scene.cameras.views
    file = tmp_path / "bad.json"
    file.write_bytes(content)
    actions.open_path(seen, file)
    channels = Channels()
    for step in range(3):
        update(seen, channels, 0.1 * step)
        channels.opening.run_waiting()
    assert seen.source.opening is None
    assert seen.window.banner is not None
    assert str(file) in seen.window.banner.message
    assert "\n" not in seen.window.banner.message
    assert seen.scene.cameras.views is before


def test_a_folder_that_cannot_be_written_is_one_line(seen: AppState) -> None:
    with_path(seen)
    seen.places.pictures.write_text("in the way")
    path_actions.save_views(seen)
    keep_all(seen)
    assert seen.window.banner is not None
    assert "not saved" in seen.window.banner.message


def test_the_views_of_a_scene_go_with_it(seen: AppState, tmp_path: Path) -> None:
    with_path(seen)
    assert seen.source.clip is not None
    arriving.show_opened(seen, seen.source.clip.path, Opened(seen.source.clip))  # Again the same clip.
    assert keyframes(seen)
    arriving.show_opened(seen, tmp_path / "splats.ply", Opened(None))
    assert seen.scene.cameras.views == Views()


def test_without_a_reconstruction_there_is_nothing_to_keep(state: AppState) -> None:
    for act in (path_actions.save_view, path_actions.add_keyframe, path_actions.toggle_path):
        act(state)
    assert export_actions.export_request(state, "cameras of the clip") is None
    keep_all(state)
    assert json.loads(views_json(state.scene.cameras.views))["views"] == []
    assert not state.places.pictures.exists()


def test_the_path_is_shown_but_for_what_it_sees_itself(seen: AppState) -> None:
    assert not path_actions.sees_path(seen)
    with_path(seen)
    assert not path_actions.sees_path(seen)  # The last keyframe is what is seen.
    camera_actions.turn(seen, 0.1, 0.0)
    assert path_actions.sees_path(seen)
    path_actions.seek_path(seen, 1.3)
    assert not path_actions.sees_path(seen)
    camera_actions.reset_view(seen)
    assert path_actions.sees_path(seen)
    path_actions.toggle_path(seen)
    assert not path_actions.sees_path(seen)
    path_actions.toggle_path(seen)
    path_actions.toggle_path_shown(seen)
    assert not path_actions.sees_path(seen)
