"""The 3D view in pictures and videos: its kinds, the second one beside it, one scale, made again."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from app.exports.make import steady, view_moments, view_pages
from app.exports.records import ViewVideo
from app.files.image_files import read_image
from app.files.provenance import read_provenance, write_sidecar
from app.files.stepping import run_to_end
from app.gui.actions import actions, camera_actions, export_actions, second_actions
from app.gui.state.exports import What
from app.scenes.backgrounds import BACKGROUNDS, BackgroundName
from app.scenes.drawer import Drawer, draw_view
from app.scenes.free_camera import FreeView
from app.scenes.view_request import FrameImage, FrameRequest, ViewRequest
from renderer.camera_path import CameraPath, Keyframe
from tests.app.gui.exporting import Exporter, same, shape_of, sidecar


def test_the_3d_view_comes_again_as_picture_and_as_videos(run: Exporter) -> None:
    state, run_path = run.state, run.state.runs.reconstruction.run_path
    assert run_path is not None
    assert state.scene.model is not None
    assert "Cameras" in export_actions.why_not_export(state, "video along the path")
    state.exports.view_size = (96, 70)
    state.scene.viewer.free = FreeView.of(state.scene.model.camera_at(0.3)).looked(0.1, 0.02)
    state.scene.kind = "depth"
    run.turn()
    plain = run.made("3D view")
    assert same(plain, run_path)
    state.exports.supersampling = 4
    assert same(fine := run.made("3D view"), run_path)
    assert read_provenance(fine)["views"][0]["supersampling"] == 4
    assert read_image(fine).shape == read_image(plain).shape
    assert not np.array_equal(read_image(fine), read_image(plain))
    state.exports.view_size, state.exports.supersampling = (3840, 2160), 4
    assert "million" in export_actions.why_not_export(state, "3D view")
    state.exports.view_size, state.exports.supersampling = (96, 70), 2
    near, far = (state.scene.model.camera_at(time) for time in (0.0, 0.5))
    path = CameraPath((Keyframe(0.0, 0.0, near), Keyframe(0.4, 0.9, far)))
    state.scene.cameras.views = replace(state.scene.cameras.views, path=path)
    videos: tuple[What, ...] = ("video through time", "video along the path")
    state.scene.kind = "color"
    for what, count in zip(videos, (10, 7), strict=True):
        video = run.made(what)
        capture = cv2.VideoCapture(str(video))
        assert capture.get(cv2.CAP_PROP_FRAME_COUNT) == count
        assert capture.get(cv2.CAP_PROP_FRAME_WIDTH) == 96
        capture.release()
        assert same(video, run_path)


@pytest.mark.parametrize("name", BACKGROUNDS)
def test_what_stands_where_nothing_was_observed_is_exported_and_comes_again(
    run: Exporter, name: BackgroundName
) -> None:
    state, run_path = run.state, run.state.runs.reconstruction.run_path
    assert run_path is not None
    assert state.scene.model is not None
    actions.choose_background(state, name)
    back = -2 * state.scene.model.distance
    state.scene.viewer.free = FreeView.of(state.scene.model.camera_at(0.3)).flown(0, 0, back)
    run.turn()
    image = run.made("3D view")
    assert same(image, run_path)
    said = read_provenance(image)["views"][0]["background"]
    assert (tuple(said) if isinstance(said, list) else said) == BACKGROUNDS[name]


def test_what_lies_beyond_the_frame_is_shown_on_demand_and_comes_again(run: Exporter) -> None:
    state, run_path = run.state, run.state.runs.reconstruction.run_path
    assert run_path is not None
    assert state.scene.model is not None
    back = -2 * state.scene.model.distance
    state.scene.viewer.free = FreeView.of(state.scene.model.camera_at(0.3)).flown(0, 0, back)
    images = []
    for beyond in (False, True):
        assert state.settings.unobserved == beyond
        run.turn()
        image = run.made("3D view")
        assert read_provenance(image)["views"][0]["unobserved"] == beyond
        assert same(image, run_path)
        images.append(read_image(image))
        actions.toggle_unobserved(state)
    assert not np.array_equal(*images)


def test_two_3d_views_stand_beside_each_other_and_come_again(run: Exporter, runs: dict[str, Path]) -> None:
    second_actions.open_second(run.state, runs["enhanced"])
    run.turn()
    assert run.state.scene.second.model is not None
    path = run.made("3D view")
    assert [view["run"]["name"] for view in read_provenance(path)["views"]] == ["original", "enhanced"]
    assert same(path, *runs.values())
    video = run.made("video through time")
    assert same(video, *runs.values())
    assert shape_of(video) == read_image(path).shape  # In colour: the same page at every moment.
    assert [view["run"]["name"] for view in sidecar(video)["views"]] == ["original", "enhanced"]
    one, other = (read_image(path)[:, side] for side in (slice(0, 64), slice(72, 136)))
    assert one.shape == other.shape
    assert not np.array_equal(one, other)


def test_a_video_shows_the_kind_of_view_that_the_window_shows(run: Exporter, runs: dict[str, Path]) -> None:
    state, shapes = run.state, {}
    second_actions.open_second(state, runs["enhanced"])
    run.turn()
    for kind in ("points", "normals", "motion", "depth"):
        state.scene.kind = kind
        video = run.made("video through time")
        assert [view["view"] for view in sidecar(video)["views"]] == [kind, kind]
        assert same(video, *runs.values())
        shapes[kind] = shape_of(video)
    assert shapes["points"] == shapes["normals"]
    assert shapes["depth"][1] > shapes["points"][1]  # With the scale beside each.
    facts = sidecar(video)
    facts["views"][1]["scale"]["high"] *= 2
    write_sidecar(video, facts)
    assert not same(video, *runs.values())


def test_a_video_of_the_difference_is_to_the_frame_of_each_frame(
    run: Exporter, runs: dict[str, Path]
) -> None:
    state = run.state
    state.scene.kind = "difference"
    videos: tuple[What, ...] = ("video through time", "video along the path")
    key = Keyframe(0.0, 0.0, state.scene.model.camera_at(0.0)) if state.scene.model is not None else None
    assert key is not None
    state.scene.cameras.views = replace(state.scene.cameras.views, path=CameraPath((key,)))
    for what in videos:
        assert "difference" in export_actions.why_not_export(state, what)
    camera_actions.toggle_snap(state)
    assert export_actions.why_not_export(state, videos[0]) == ""
    assert "difference" in export_actions.why_not_export(state, videos[1])
    request = export_actions.export_request(state, videos[0])
    assert request is not None
    assert isinstance(request.record, ViewVideo)
    pages = list(view_pages(view_moments(request.record, request.sources), Drawer()))
    assert state.scene.model is not None
    assert state.source.clip is not None
    for frame in (0, 7):
        reference = FrameImage(FrameRequest(state.source.clip, frame), state.source.clip.read_image(frame))
        (view,) = draw_view(ViewRequest.of_frame(state.scene.model, frame).of_kind("difference", reference))
        np.testing.assert_array_equal(pages[frame][:48, :64], view.image)
    export_actions.cancelled(state)
    second_actions.open_second(state, runs["enhanced"])
    run.turn()
    assert same(run.made("3D view"), *runs.values())
    assert same(run.made(videos[0]), *runs.values())


def test_all_moments_of_a_video_have_one_scale(run: Exporter) -> None:
    """That holds what each has by itself, and stands beside every page."""
    state = run.state
    state.scene.kind = "motion"
    request = export_actions.export_request(state, "video through time")
    assert request is not None
    assert isinstance(request.record, ViewVideo)
    wanted = view_moments(request.record, request.sources)
    own = [next(draw_view(views[0])).scale for views in wanted]
    moments = run_to_end(steady(wanted, Drawer()))
    (scale,) = {views[0].scale for views in moments}
    assert scale is not None
    assert [views[0].of_kind("color").camera for views in moments] == [views[0].camera for views in wanted]
    assert scale.high == max(one.high for one in (own[0], own[-1]) if one is not None)
    assert own[0] is not None
    assert own[0].high < scale.high  # Nothing has moved yet.
    pages = list(view_pages(moments, Drawer()))
    bars = [page[:, 64:] for page in pages]
    assert bars[0].size
    for bar in bars:
        np.testing.assert_array_equal(bar, bars[0])
    assert not np.array_equal(pages[0], pages[-1])
