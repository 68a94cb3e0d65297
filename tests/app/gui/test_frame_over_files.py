"""The frame that lies over the 3D view on screen lies over it in files, and they come again."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from app.exports.make import view_moments, view_pages
from app.exports.records import PanesPicture, ViewVideo
from app.files.image_files import read_image
from app.files.provenance import read_provenance
from app.gui.actions import camera_actions, enhancement_actions, export_actions, second_actions
from app.gui.work.settings import Places
from app.scenes.drawer import Drawer, draw_view
from app.scenes.view_request import ViewRequest
from renderer.clip import ByteImage
from tests.app.gui.exporting import Exporter, same

HEAD = 28
"""Rows of a small page for the caption above its picture."""


@pytest.fixture
def snapped(places: Places, runs: dict[str, Path]) -> Exporter:
    """A run that was trained on enhanced frames, seen through the clip's camera."""
    run = Exporter(places, runs["enhanced"])
    camera_actions.toggle_snap(run.state)
    run.turn(6)
    assert run.state.frame_image is not None
    return run


def alone(run: Exporter) -> tuple[ByteImage, ByteImage]:
    """The reconstruction and the frame, by themselves."""
    state = run.state
    assert state.scene.model is not None
    assert state.frame_image is not None
    (view,) = draw_view(ViewRequest.of_frame(state.scene.model, 0))
    return view.image, state.frame_image.image


@pytest.mark.parametrize("share", [0.0, 0.4, 1.0])
def test_as_much_of_the_frame_as_on_screen(snapped: Exporter, runs: dict[str, Path], share: float) -> None:
    camera_actions.blend(snapped.state, share)
    path = snapped.made("3D view")
    model, frame = alone(snapped)
    wanted = (1 - share) * model + share * frame.astype(float)
    np.testing.assert_allclose(read_image(path)[HEAD : HEAD + 48], wanted, atol=1)
    assert read_provenance(path)["views"][0].get("frame_share", 0.0) == share
    assert ("over it" in read_provenance(path)["views"][0]["caption"]) == (share > 0)
    assert same(path, runs["enhanced"])


def test_white_light_is_white_light_in_the_file(snapped: Exporter, runs: dict[str, Path]) -> None:
    camera_actions.blend(snapped.state, 0.0)
    enhancement_actions.white_light(snapped.state)
    path = snapped.made("3D view")
    np.testing.assert_array_equal(read_image(path)[HEAD : HEAD + 48], alone(snapped)[1])
    assert same(path, runs["enhanced"])


def test_a_size_of_the_file_keeps_the_frame_on_the_tissue(snapped: Exporter) -> None:
    camera_actions.blend(snapped.state, 1.0)
    snapped.state.exports.view_size = (300, 96)
    camera = read_provenance(snapped.made("3D view"))["views"][0]["camera"]
    assert (camera["width"], camera["height"]) == (128, 96)


def test_a_video_has_each_frame_over_its_own_moment(snapped: Exporter, runs: dict[str, Path]) -> None:
    camera_actions.blend(snapped.state, 1.0)
    request = export_actions.export_request(snapped.state, "video through time")
    assert request is not None
    assert isinstance(request.record, ViewVideo)
    assert snapped.state.source.clip is not None
    pages = list(view_pages(view_moments(request.record, request.sources), Drawer()))
    for frame in (0, 7):
        np.testing.assert_array_equal(pages[frame], snapped.state.source.clip.read_image(frame))
    export_actions.cancelled(snapped.state)
    assert same(snapped.made("video through time"), runs["enhanced"])


def test_of_two_views_each_has_its_own_share(snapped: Exporter, runs: dict[str, Path]) -> None:
    state = snapped.state
    second_actions.open_second(state, runs["original"])
    snapped.turn()
    camera_actions.blend(state, 0.0)
    enhancement_actions.white_light(state)
    request = export_actions.shown_request(state)
    assert request is not None
    assert isinstance(request.record, PanesPicture)
    assert [view.frame_share for view in request.record.views] == [1.0, None]
    assert same(snapped.made("3D view"), *runs.values())


def test_a_second_view_with_other_frames_says_that_the_frame_is_not_in_the_file(
    snapped: Exporter, runs: dict[str, Path]
) -> None:
    state = snapped.state
    second_actions.open_second(state, runs["original"])
    snapped.turn()
    shown = state.scene.second.model
    assert shown is not None
    state.scene.second.model = replace(shown, cameras=shown.cameras * 2)
    captions = []
    for kind in ("color", "difference"):
        state.scene.kind = kind
        request = export_actions.shown_request(state)
        assert request is not None
        assert isinstance(request.record, PanesPicture)
        captions.append([str(view.caption) for view in request.record.views])
    assert "frame 50 % over it" in captions[0][0]
    assert captions[0][1].endswith("without the frame over it")
    assert not any("over it" in caption for caption in captions[1])
