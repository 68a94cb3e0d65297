"""An image saved before the statistics of the clip are known is the one on screen, and comes again."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from app.enhancement.frame_enhancer import PictureMaker
from app.enhancement.methods import EnhancementSettings
from app.exports.comparison_images import OtherMaker
from app.exports.exporting import export
from app.exports.replay.again import replay
from app.gui.actions import actions, comparing, export_actions
from app.gui.actions.export_records import request_of
from app.gui.state.app_state import AppState
from app.gui.state.panes import other_request
from app.gui.work.settings import Places
from enhance import EnhanceParams
from renderer.clip import ByteImage
from tests.app.gui.exporting import Exporter
from tests.app.gui.test_live_saving import holds


@pytest.fixture
def early(places: Places, folder: Path) -> AppState:
    """Three images of three brightnesses, to be enhanced alike; the first is shown."""
    state = Exporter(places, folder).state
    state.enhancement.scope = "clip"
    assert state.picture_request is not None
    assert state.picture_request.of_clip == "later"
    state.picture.pictures = list(PictureMaker().make(state.picture_request))[-1]
    return state


def shown(state: AppState) -> ByteImage:
    assert state.picture.pictures is not None
    assert state.picture.pictures.enhanced is not None
    return state.picture.pictures.enhanced


def saved(state: AppState) -> Path:
    request = export_actions.shown_request(state)
    assert request is not None
    path = list(export(request))[-1].path
    assert path is not None
    return path


def test_what_is_saved_is_what_is_shown(early: AppState, folder: Path, tmp_path: Path) -> None:
    assert early.picture_request is not None
    measured = replace(early.picture_request, of_clip=None)
    assert not np.array_equal(list(PictureMaker().make(measured))[-1].enhanced, shown(early))
    path = saved(early)
    assert holds(path, shown(early))
    assert replay(path, (folder,), tmp_path / "again.png").difference.is_none


def test_a_stored_setting_beside_it_too(early: AppState) -> None:
    stored: EnhancementSettings = EnhanceParams(z=0.3)
    early.enhancement.stored["A"] = stored
    comparing.choose_source(early, "left", "A")
    wanted = other_request(early, "left")
    assert wanted is not None
    (made,) = OtherMaker().make(wanted)
    early.comparing.others["left"] = made
    path = saved(early)
    assert holds(path, made.image)
    assert holds(path, shown(early))


def test_a_video_is_made_with_the_statistics_of_the_clip(early: AppState) -> None:
    actions.seek(early, 0)
    record = request_of(early, "measures of both panes", "x").record
    assert [pane.given for pane in record.panes] == [None, None]  # type: ignore[union-attr]
