"""What the window enhances, exported as DICOM, read by pydicom."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from pydicom import dcmread

from app.enhancement.enhance_files import Setting
from app.exports.exporting import Enhanced
from app.exports.replay.again import replay
from app.files.dicom.choices import DicomChoices
from app.files.image_files import read_image, write_image
from app.gui.actions import actions, export_actions
from app.gui.actions.export_offers import OFFERS
from app.gui.panels import export
from app.gui.state.app_state import AppState
from app.gui.state.exports import What
from app.gui.work.settings import Places
from enhance import EnhanceParams
from renderer.readers.clip_options import ClipOptions
from renderer.readers.dicom import opening
from renderer.sources import open_case
from tests.app.gui.exporting import Exporter, exported, same
from tests.renderer.readers.dicom_files import VIDEO, labelled, picture, saved, stills, with_pixels

FRAMES = [picture(seed=seed) for seed in range(4)]
STILL: What = "enhanced frame"
CLIP: What = "enhanced clip"


@pytest.fixture
def places(tmp_path: Path) -> Places:
    made = Places(tmp_path / "config", tmp_path / "runs", tmp_path / "pictures")
    for path in vars(made).values():
        path.mkdir()
    return made


@pytest.fixture
def source(tmp_path: Path) -> Path:
    return saved(with_pixels(labelled(VIDEO), np.stack(FRAMES)), tmp_path / "mueller.dcm")


def test_a_frame_of_a_clip_is_a_still_of_nobody_that_comes_again(places: Places, source: Path) -> None:
    run = Exporter(places, source)
    actions.seek(run.state, 2)
    run.turn(6)
    path = exported(run, STILL)
    assert path.name == "enhanced-frame-3.dcm"
    made = dcmread(path)
    assert made.SOPClassUID.name == "VL Endoscopic Image Storage"
    assert list(made.ImageType[:2]) == ["DERIVED", "SECONDARY"]
    assert str(made.PatientName) == "ANONYMOUS^PATIENT"
    assert b"ueller" not in path.read_bytes()
    assert same(path, source)
    run.rest()
    shown = read_image(exported(run, "right pane"))
    own = read_image(path).astype(int)
    # It stands below a caption.
    apart = [np.abs(own - shown[top : top + 48]).max() for top in range(len(shown) - 47)]
    assert min(apart) <= 1


def test_a_clip_is_a_video_and_identity_is_kept_where_it_is_chosen(places: Places, source: Path) -> None:
    run = Exporter(places, source)
    export_actions.choose_dicom(run.state, DicomChoices(keep_identity=True, burned_in=False))
    path = exported(run, CLIP)
    made = dcmread(path)
    assert path.name == "enhanced.dcm"
    assert made.SOPClassUID.name == "Video Endoscopic Image Storage"
    assert (made.NumberOfFrames, str(made.PatientName), made.BurnedInAnnotation) == (4, "Müller^Hanna", "NO")
    assert replay(path, (source,), path.with_name("again.dcm")).difference.is_none


def test_how_it_comes_again_is_true_of_a_file_that_names_no_source(places: Places) -> None:
    state = AppState(places)
    unnamed = [name for name, offer in OFFERS.items() if "--source" in export._replay_text(state, offer)]
    assert unnamed == ["enhanced frame", "enhanced clip"]
    state.exports.dicom = DicomChoices(keep_identity=True)
    assert all("--source" not in export._replay_text(state, offer) for offer in OFFERS.values())


def test_another_setting_makes_another_file(places: Places, tmp_path: Path) -> None:
    run = Exporter(places, saved(stills(picture())["rgb"][0], tmp_path / "one.dcm"))
    first = exported(run, STILL)
    chosen = run.state.enhancement
    chosen.params = replace(chosen.params, strength=0.1)
    second = exported(run, STILL)
    assert second.name == "enhanced-2.dcm"
    assert not np.array_equal(read_image(first), read_image(second))
    assert "Strength 0.10" in dcmread(second).DerivationDescription


def test_what_is_lacking_is_said(
    places: Places, clip_path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    run = Exporter(places, clip_path)
    export_actions.choose_dicom(run.state, DicomChoices(keep_identity=True))
    assert "no patient to keep" in export_actions.why_not_export(run.state, STILL)
    export_actions.choose_dicom(run.state, DicomChoices())
    assert export_actions.why_not_export(run.state, CLIP) == ""
    monkeypatch.setattr(opening, "find_spec", lambda name: None)
    assert "pip install pydicom" in export_actions.why_not_export(run.state, CLIP)
    monkeypatch.undo()
    one = Exporter(places, saved(stills(picture())["rgb"][0], tmp_path / "one.dcm"))
    assert "One image is no video" in export_actions.why_not_export(one.state, CLIP)
    export_actions.choose_dicom(one.state, DicomChoices(keep_identity=True))
    assert export_actions.why_not_export(one.state, STILL) == ""


def test_whether_there_is_a_patient_is_known_of_the_file_as_it_is_now(places: Places, tmp_path: Path) -> None:
    path = tmp_path / "one.png"
    write_image(path, picture(), {})
    choices = DicomChoices(keep_identity=True)
    before = Exporter(places, path)
    export_actions.choose_dicom(before.state, choices)
    assert "no patient to keep" in export_actions.why_not_export(before.state, STILL)
    saved(stills(picture())["rgb"][0], path)
    now = Exporter(places, path)
    export_actions.choose_dicom(now.state, choices)
    assert export_actions.why_not_export(now.state, STILL) == ""


def test_of_a_clip_that_keeps_one_frame_in_several_it_is_the_one_shown(tmp_path: Path) -> None:
    folder = tmp_path / "images"
    folder.mkdir()
    for index in range(7):
        write_image(folder / f"{index:03d}.png", np.full((24, 32, 3), 30 + 20 * index, np.uint8), {})
    clip = open_case(folder, ClipOptions(frame_step=3))
    setting = Setting(
        "paper", EnhanceParams(strength=0), "image", "all", clip_options=ClipOptions(frame_step=3)
    )
    for index, level in enumerate((30, 90, 150)):
        path = tmp_path / f"{index}.dcm"
        list(Enhanced(folder, setting, index, clip.labels[index], len(clip)).written(path))
        assert abs(int(read_image(path)[0, 0, 0]) - level) <= 1
