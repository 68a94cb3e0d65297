"""Tools that are masked in the window do not count where tissue alone does: on screen and in files."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from app.enhancement.clip_statistics import measured
from app.enhancement.frame_enhancer import PictureMaker, PictureRequest
from app.errors import UserError
from app.exports.exporting import export
from app.exports.make import make
from app.exports.panes import pane_record
from app.exports.records import FrameRecord, PanesPicture
from app.exports.replay.again import replay
from app.exports.sources import Opened
from app.files.records import Source
from app.files.stepping import run_to_end
from app.gui.actions import export_actions, masking_actions
from app.gui.state.app_state import AppState
from app.gui.state.masking import THICKEST
from app.gui.work.settings import Places
from assets import phantom_path
from enhance.vessel import VesselParams
from renderer.clip import Clip
from renderer.sources import open_clip
from tests.app.gui.exporting import Exporter
from tests.app.gui.test_live_saving import holds
from tests.app.gui.test_masking import settle, stroke


@pytest.fixture
def masked(places: Places, folder: Path) -> AppState:
    """With tissue alone counting, and a large tool masked by hand in the first image."""
    run = Exporter(places, folder)
    state = run.state
    masking_actions.toggle(state)
    settle(state, run.channels)
    masking_actions.choose_radius(state, THICKEST)
    stroke(state, (8.0, 8.0), (30.0, 8.0))
    settle(state, run.channels)
    assert state.source.tool_masks is not None
    state.enhancement.pixels, state.enhancement.scope = "tissue", "image"
    assert state.picture_request is not None
    state.picture.pictures = list(PictureMaker().make(state.picture_request))[-1]
    return state


def whole(state: AppState) -> Clip:
    assert state.source.clip is not None
    return state.source.clip


def test_a_masked_tool_is_no_tissue_in_the_statistics(masked: AppState) -> None:
    request, pictures = masked.picture_request, masked.picture.pictures
    assert request is not None
    assert pictures is not None
    assert request.params is not None
    kept = masked.masking.shown
    assert kept is not None
    bare = replace(request, tools=None)
    wanted = list(PictureMaker().make(replace(bare, clip=whole(masked).within(~kept.mask))))[-1]
    before = list(PictureMaker().make(bare))[-1]
    assert pictures.statistics == wanted.statistics != before.statistics
    pooled = replace(request, scope="clip").statistics_request(request.params)
    assert measured(pooled) != measured(replace(pooled, tools=None))


def test_another_stroke_asks_for_the_picture_anew_and_only_where_tissue_counts(masked: AppState) -> None:
    before = masked.picture_request
    stroke(masked, (50.0, 30.0))
    settle(masked)
    assert masked.picture_request != before
    masked.enhancement.pixels = "automatic"
    assert masked.picture_request is not None
    assert masked.picture_request.tools is None


def test_what_is_saved_is_what_is_shown_and_comes_again(
    masked: AppState, folder: Path, tmp_path: Path
) -> None:
    request = export_actions.shown_request(masked)
    assert request is not None
    path = list(export(request))[-1].path
    assert path is not None
    assert masked.picture.pictures is not None
    assert masked.picture.pictures.enhanced is not None
    assert holds(path, masked.picture.pictures.enhanced)
    assert replay(path, (folder,), tmp_path / "again.png").difference.is_none


def test_what_differs_without_the_tools_says_so(tmp_path: Path) -> None:
    """`vessel` takes its noise from the picture, whatever the statistics."""
    clip = open_clip(phantom_path())
    kept = np.ones(clip.read_image(0).shape[:2], bool)
    kept[:, :200] = False
    without = clip.within(kept)
    request = PictureRequest(without, 3, VesselParams(), "image", "tissue")
    shown = list(PictureMaker().make(request))[-1]
    pane = pane_record("Enhanced", request, VesselParams())
    pane = replace(pane, given=shown.statistics, drawn_tools=True)
    record = PanesPicture(source=Source.of(clip.path), frame=FrameRecord(index=3), panes=(pane,))
    run_to_end(make(record, Opened((), without), tmp_path / "one.png"))
    again = replay(tmp_path / "one.png", (clip.path,), tmp_path / "again.png")
    assert not again.difference.is_none
    assert again.reasons == ("made with tools masked in the window, whose masks are in no file",)


def test_a_table_without_the_tools_says_that_it_cannot_be_made_again(
    masked: AppState, folder: Path, tmp_path: Path
) -> None:
    request = export_actions.export_request(masked, "measures of both panes")
    assert request is not None
    path = list(export(request))[-1].path
    assert path is not None
    with pytest.raises(UserError, match=r"tool masks of .* are in no file"):
        replay(path, (folder,), tmp_path / "again.csv")
    assert np.isfinite(np.loadtxt(path, delimiter=",", skiprows=1, usecols=0)).all()
