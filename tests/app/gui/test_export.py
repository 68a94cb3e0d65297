from __future__ import annotations

import json
import shutil
from collections.abc import Generator
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from app.enhancement.frame_enhancer import PictureMaker, PictureRequest, Pictures
from app.enhancement.methods import Params
from app.enhancement.settable import ENHANCED, RENDER
from app.enhancement.setting_words import in_letters, worded
from app.errors import UserError
from app.exports.exporting import Step, export
from app.exports.panes import PaneMaker, pane_record
from app.exports.records import FrameRecord, PanesPicture, Words
from app.exports.sheet import Panel, describe, sheet
from app.exports.sources import Opened
from app.files.provenance import digest, read_provenance, write_png
from app.files.records import Source
from app.gui.actions import actions, arriving, export_actions, job_actions
from app.gui.actions.export_records import sized
from app.gui.state.app_state import AppState
from app.gui.state.exports import What
from app.gui.update.jobs import start_due
from app.gui.work import opening
from app.gui.work.background import Failure
from app.runs.clip_selection import ClipPart
from app.scenes.records import RunSource
from app.scenes.view_request import ViewRequest
from assets import phantom_path
from enhance import EnhanceParams, Statistics
from enhance.vessel import VesselParams
from renderer.clip import Clip
from renderer.gaussians import DynamicGaussians
from tests.app.gui.conftest import SIZE, FakeJob, image_of
from tests.app.gui.saving import asked, saved
from tests.app.gui.scenes import scene_of
from tests.app.gui.settling import show_finished, show_live
from tests.app.gui.test_opening import make_run, opened


def pair(clip: Clip, params: Params) -> Pictures:
    return list(PictureMaker().make(PictureRequest(clip, 2, params)))[-1]


@pytest.mark.parametrize("home", [True, False])
def test_it_is_said_where_a_picture_lies(
    state: AppState, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, home: bool
) -> None:
    monkeypatch.setattr(Path, "home", lambda: tmp_path if home else tmp_path / "elsewhere")
    folder = tmp_path / "Pictures" / "VesselSplat"
    export_actions.take_saved(state, None, Step(1, folder / "clip.png"))
    assert state.window.toast is not None
    said = "Pictures/VesselSplat/" if home else str(folder)
    assert state.window.toast.message == f"saved clip.png in {said}"


def test_the_pixels_are_the_data_s_own(tmp_path: Path, clip: Clip) -> None:
    clip.path.mkdir()
    shown = pair(clip, EnhanceParams())
    path = saved(tmp_path / "out", shown.request)
    page = cv2.cvtColor(cv2.imread(str(path)), cv2.COLOR_BGR2RGB)
    width, height = SIZE
    top = (page.shape[0] - height) // 2
    np.testing.assert_array_equal(page[top : top + height, :width], image_of(2))
    np.testing.assert_array_equal(page[top : top + height, -width:], shown.enhanced)


def test_the_file_says_how_to_make_it_again_and_nothing_private(tmp_path: Path, clip: Clip) -> None:
    clip.path.mkdir()
    shown = pair(clip, EnhanceParams(z=0.25))
    path = saved(tmp_path / "out", shown.request)
    facts = read_provenance(path)
    assert facts["frame"] == {"index": 2, "label": "2.png"}
    assert facts["panes"][1]["params"]["z"] == 0.25
    assert facts["panes"][1]["statistics"]["z"] == 0.25
    assert facts["source"]["name"] == "clip"
    assert "Not a medical device" in facts["notice"]
    assert str(tmp_path) not in json.dumps(facts)


def test_the_3d_view_is_drawn_at_the_frame_s_resolution_or_the_size_asked_for(
    tmp_path: Path, clip: Clip, model: DynamicGaussians
) -> None:
    shown = scene_of(model, clip.cameras, "run-1")
    view = ViewRequest.fitted(shown, 0.5, None, (24, 20))
    path = saved(tmp_path, None, sized(view, None))
    facts = read_provenance(path)["views"][0]
    assert (facts["camera"]["width"], facts["camera"]["height"]) == SIZE
    assert (facts["run"]["name"], facts["time"], facts["iteration"]) == ("run-1", 0.5, 7)
    assert cv2.imread(str(path)).shape[1] == SIZE[0]
    # A wider picture shows more of the sides, nothing less of the middle.
    wide = sized(view, (100, 40)).camera
    assert (wide.width, wide.height, wide.fy) == (100, 40, 2 * view.camera.fy)
    apart = sized(replace(view, kind="difference"), (100, 40)).camera
    assert (apart.width, apart.height) == (48, 40)


def test_two_pictures_never_take_the_same_name(tmp_path: Path, clip: Clip) -> None:
    clip.path.mkdir()
    shown = pair(clip, None)
    paths = {saved(tmp_path, shown.request) for _ in range(5)}
    assert len(paths) == 5


@pytest.mark.parametrize(("words", "starts"), [("method", "Paper · "), ("interface", "Brightness ")])
def test_a_caption_names_its_method_and_those_of_before_come_again(
    clip: Clip, words: Words, starts: str
) -> None:
    pane = replace(pane_record("Enhanced", PictureRequest(clip, 0, None), EnhanceParams()), words=words)
    record = PanesPicture(source=Source(name="c", sha256="0"), frame=FrameRecord(index=0), panes=(pane,))
    (made,) = PaneMaker(record, Opened((), clip)).made(0)
    assert made.panel.label.startswith(f"Enhanced   {starts}")


def test_a_page_of_vessels_is_made_again_with_what_was_measured(clip: Clip) -> None:
    pane = pane_record("Enhanced", PictureRequest(clip, 0, None), VesselParams())
    source = Source(name="c", sha256="0")

    def made(told: Statistics | None) -> Statistics:
        record = PanesPicture(source=source, panes=(replace(pane, statistics=told),))
        (one,) = PaneMaker(record, Opened((), clip)).made(0)
        assert one.statistics is not None
        return one.statistics

    other = replace(made(None), redness=0.01, bright_level=70.0)
    assert made(other) == other
    assert made(replace(other, field=None)) == made(None)


def test_captions_fit_over_small_pictures() -> None:
    small = np.zeros((8, 8, 3), np.uint8)
    page = sheet([Panel("A caption much longer than its picture", small), Panel("B", small)])
    assert page.shape[1] == 24


def test_the_description_tells_automatic_from_chosen(clip: Clip) -> None:
    text = describe(pair(clip, EnhanceParams(z=0.25)))
    assert text.startswith("Paper · Brightness 0.75 · Detail auto ")
    assert " · Colour auto 0.50" in text
    assert describe(pair(clip, None)) == ""
    assert worded(EnhanceParams(z=0.25)) == "Brightness 0.75 · Detail auto · Colour auto"
    chosen = EnhanceParams(z=0.25, p=(0.4, 0.5, 0.4), d_factor=1.0)
    assert (
        describe(pair(clip, chosen))
        == f"Paper · {worded(chosen)}"
        == "Paper · Brightness 0.75 · Detail 0.40/0.50 · Colour 0.50"
    )
    vessel = VesselParams(strength=1.5)
    assert (
        describe(pair(clip, vessel))
        == worded(vessel)
        == "Vessel · Strength 1.50 · Brightening 0.25 · Colour 0.59"
    )
    assert worded(replace(vessel, contrast=1)).startswith(
        "Vessel · Strength 1.50 · Contrast 1.00 · Brightening"
    )
    assert in_letters(chosen) == "z 0.25 · P 0.40/0.50 · d 1.00"


def test_a_folder_that_cannot_be_written_is_one_line(tmp_path: Path, state: AppState, clip: Clip) -> None:
    (tmp_path / "file").write_text("in the way")
    clip.path.mkdir()
    request = asked(tmp_path / "file" / "deep", pair(clip, None).request)
    with pytest.raises(Exception, match="file") as caught:
        list(export(request))
    actions.fail(state, str(caught.value))
    assert state.window.banner is not None
    assert "\n" not in state.window.banner.message


def test_why_an_export_failed_is_not_said_of_another_kind_nor_of_another_clip(
    state: AppState, clip: Clip
) -> None:
    def fails() -> None:
        state.exports.failure = "No space left on device: clip.mp4"

    export_actions.choose_what(state, "video of both panes")
    fails()
    export_actions.choose_what(state, "video of both panes")
    assert state.exports.failure
    export_actions.choose_what(state, "both panes")
    assert not state.exports.failure
    fails()
    arriving.show_opened(state, clip.path, opening.Opened(clip))
    assert not state.exports.failure


def test_a_run_s_view_names_its_own_clip_whatever_is_open(
    tmp_path: Path, clip: Clip, model: DynamicGaussians
) -> None:
    run = make_run(tmp_path / "run-1", phantom_path(), model)
    shown = opened(run.path).run
    assert shown is not None
    assert shown.model is not None
    clip.path.mkdir()
    view = ViewRequest.fitted(shown.model, 0.5, None, (24, 20))
    path = saved(tmp_path / "out", pair(clip, None).request, view)
    facts = read_provenance(path)
    assert facts["source"]["name"] == clip.name
    record = run.record()
    assert facts["views"][0]["clip"] == {"name": "phantom", "sha256": record.clip.sha256}
    assert facts["views"][0]["run"] == {"name": "run-1", "model_sha256": digest(run.model_path)}
    assert (facts["views"][0]["input"], facts["views"][0]["config"]["method"]) == ("enhanced", "vesselsplat")
    assert facts["views"][0]["near"] == view.near > 0
    assert str(tmp_path) not in json.dumps(facts)
    assert str(phantom_path()) not in json.dumps(facts)


def test_a_model_of_this_session_knows_its_run(state: AppState, model: DynamicGaussians) -> None:
    job_actions.start_reconstruction(state)
    start_due(state, FakeJob)
    path = state.runs.reconstruction.run_path
    assert path is not None
    run = make_run(path, phantom_path(), None)
    show_live(state, model)
    assert state.scene.model is not None
    assert state.scene.model.record.run == RunSource(name=path.name, model_sha256=None)
    run.save_model(model)
    show_finished(state, model)
    assert state.scene.model.record.run == RunSource(name=path.name, model_sha256=digest(run.model_path))


@pytest.mark.parametrize(("words", "said"), [("method", "frame 3"), ("interface", "frame 3"), (None, "2")])
def test_frames_without_a_name_count_from_one_in_captions(clip: Clip, words: Words | None, said: str) -> None:
    """In files before 0.2.0 they counted from 0, and are reproduced so."""
    video = replace(clip, labels=tuple(map(str, range(len(clip)))))
    frame = PictureRequest(video, 2, None)
    pane = replace(pane_record("Original", frame), words=words)
    source = Source(name="clip", sha256="0")
    record = PanesPicture(source=source, frame=FrameRecord(index=2), panes=(pane,))
    (made,) = PaneMaker(record, Opened((), video)).made(2)
    assert made.panel.label == f"Original   {said}"


@pytest.mark.parametrize("what", ["video of both panes", "measures of both panes"])
def test_measuring_the_clip_can_be_given_up_after_each_frame(state: AppState, clip: Clip, what: What) -> None:
    write_png(clip.path / "0.png", clip.read_image(0), {})
    state.enhancement.scope = "clip"
    request = export_actions.export_request(state, what)
    assert request is not None
    assert request.sources.measured is None
    steps = export(request)
    assert isinstance(steps, Generator)
    assert [next(steps).done for _ in clip.labels] == [0] * len(clip)
    steps.close()
    assert not list(state.places.pictures.glob("*"))


def test_a_folder_that_vanishes_ends_the_export_with_the_next_frame(state: AppState, clip: Clip) -> None:
    """As of a stick that is unplugged: also where the file is written at the end."""
    write_png(clip.path / "0.png", clip.read_image(0), {})
    state.enhancement.scope = "clip"
    request = export_actions.export_request(state, "measures of both panes")
    assert request is not None
    request.folder.mkdir()
    steps = export(request)
    next(steps)
    shutil.rmtree(request.folder)
    with pytest.raises(UserError, match="expected the folder to stay") as caught:
        next(steps)
    export_actions.take_step(state, request, Failure(caught.value))
    assert state.exports.under_way is None
    assert state.window.banner is not None
    assert state.window.banner.message.endswith(f"got it gone: {request.folder}")


@pytest.mark.parametrize("what", ["video of both panes", "measures of both panes"])
def test_a_reconstruction_of_some_frames_is_not_set_beside_others(
    state: AppState, clip: Clip, model: DynamicGaussians, what: What
) -> None:
    state.scene.model, state.scene.size = replace(scene_of(model, clip.cameras[2:4]), first=2), (48, 40)
    state.comparing.chosen = replace(state.comparing.chosen, right=RENDER)
    state.timeline.frame_index = 2
    assert "covers frames 3 to 4: set In and Out" in export_actions.why_not_export(state, what)
    assert export_actions.why_not_export(state, "both panes") == ""
    state.source.part = ClipPart(trim=(2, 3))
    assert export_actions.why_not_export(state, what) == ""


def test_a_3d_view_that_is_hidden_is_told_from_none(
    state: AppState, clip: Clip, model: DynamicGaussians
) -> None:
    assert "no 3D model yet" in export_actions.why_not_export(state, "3D view")
    state.scene.model = scene_of(model, clip.cameras)
    assert "is hidden: bring its tab" in export_actions.why_not_export(state, "3D view")
    state.scene.size = (48, 40)
    assert export_actions.why_not_export(state, "3D view") == ""


def test_a_difference_of_two_sides_that_show_the_same_is_one(state: AppState) -> None:
    state.comparing.chosen = replace(state.comparing.chosen, mode="difference", left=ENHANCED, right=ENHANCED)
    request = export_actions.export_request(state, "panes as shown")
    assert isinstance(request.record, PanesPicture)
    assert (request.record.arrangement.mode, len(request.record.panes)) == ("difference", 2)
