"""Masks of all frames at once: learned from those by hand, found by a network, or taken from a folder."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from app.gui.actions import actions, closing, masking_actions
from app.gui.panels.masking import draw_masking_question
from app.gui.state.app_state import AppState
from app.gui.update import taking
from app.gui.update.update import update
from app.gui.work.background import Failure
from app.gui.work.masking import KeepMask, MakingRequest, MaskRequest, folder_of, keep_mask, make_all
from app.gui.work.opening import OpenRequest, open_path
from renderer.readers.clip_options import ClipOptions
from renderer.readers.lenses.calibration import Calibration, LensCalibration
from renderer.tools.mask_files import origin_of, write_mask
from tests.app.gui.conftest import SIZE
from tests.app.gui.test_masking import begun, on_disk, settle, shown, stroke
from tests.app.gui.ui import Ui
from tests.renderer.tools.onnx_files import write_convolution


@pytest.fixture
def masking(opened: AppState) -> AppState:
    return begun(opened)


def test_all_other_frames_are_learned_and_those_by_hand_stay(masking: AppState) -> None:
    masking_actions.choose_radius(masking, 4 / SIZE[0])
    stroke(masking, (12.0, 0.0), (12.0, 40.0))
    channels = settle(masking)
    before = on_disk(masking)[0]
    masking_actions.make_all(masking)
    settle(masking, channels)
    assert masking.masking.making is None
    assert masking.masking.report is not None
    assert masking.masking.report.done == 6
    masks = on_disk(masking)
    assert sorted(masks) == list(range(6))
    np.testing.assert_array_equal(masks[0], before)
    assert masking.masking.there is not None
    assert masking.masking.there.frames("by hand") == (0,)
    assert origin_of(masking.masks_folder / "3.png") == "learned"
    # The vessel moves to the right, a pixel a frame; the mask follows what it looks like.
    assert masks[5][:, 14:20].mean() > 0.6
    actions.seek(masking, 5)
    settle(masking, channels)
    assert shown(masking).origin == "learned"
    masking_actions.accept(masking)
    settle(masking, channels)
    assert masking.masking.there.frames("by hand") == (0, 5)


def test_what_is_drawn_while_the_others_are_made_stays(masking: AppState) -> None:
    clip = masking.masks_clip
    assert clip is not None
    made = make_all(MakingRequest(clip, masking.masks_folder))
    while next(made).done < 2:
        pass
    drawn = np.zeros((SIZE[1], SIZE[0]), bool)
    drawn[:5] = True
    list(keep_mask(KeepMask(MaskRequest(clip, masking.masks_folder, 4), drawn)))
    list(made)
    path = masking.masks_folder / "4.png"
    np.testing.assert_array_equal(on_disk(masking)[4], drawn)
    assert (origin_of(path), sorted(on_disk(masking))) == ("by hand", list(range(6)))


def test_masks_of_a_clip_lie_apart_for_each_calibration(masking: AppState) -> None:
    clip = masking.masks_clip
    assert clip is not None
    lens = LensCalibration(fx=500, fy=500, cx=10, cy=10)
    options = [
        ClipOptions(),
        *(ClipOptions(calibration=Calibration(lens=one)) for one in (lens, replace(lens, fx=400))),
    ]
    assert len({folder_of(Path("masks"), clip, one) for one in options}) == 3


def test_masks_of_another_program_are_taken(masking: AppState, tmp_path: Path) -> None:
    given = np.zeros((SIZE[1], SIZE[0]), bool)
    given[:, :7] = True
    (tmp_path / "given").mkdir()
    for name in ("0.png", "00004.png"):
        write_mask(tmp_path / "given" / name, given, "by a model")
    masking_actions.choose_folder(masking)
    assert masking.window.choosing is not None
    masking.window.choosing.then(tmp_path / "given")
    settle(masking)
    assert sorted(on_disk(masking)) == [0, 4]
    assert masking.masking.there is not None
    assert masking.masking.there.frames("from a folder") == (0, 4)
    np.testing.assert_array_equal(shown(masking).mask, given)
    masking_actions.clear_frame(masking)
    settle(masking)
    masking_actions.make_all(masking, tmp_path / "given")
    settle(masking)
    assert (masking.masking.there.frames("by hand"), on_disk(masking)[0].any()) == ((0,), False)
    (tmp_path / "empty").mkdir()
    masking_actions.make_all(masking, tmp_path / "empty")
    settle(masking)
    assert masking.window.banner is not None
    assert "expected masks named as the frames" in masking.window.banner.message
    assert masking.masking.making is None


def test_a_network_masks_the_other_frames_and_a_broken_one_is_named(
    masking: AppState, tmp_path: Path
) -> None:
    pytest.importorskip("onnxruntime")
    stroke(masking, (30.0, 20.0))
    channels = settle(masking)
    before = on_disk(masking)[0]
    # Set where red is low: on the vessel. ImageNet's mean of red is 0.485, its spread 0.229.
    weights, bias = np.array([[-1, 0, 0]], np.float32), np.array([(0.58 - 0.485) / 0.229], np.float32)
    network = write_convolution(tmp_path / "net.onnx", weights, bias)
    masking_actions.make_all(masking, network)
    settle(masking, channels)
    masks = on_disk(masking)
    np.testing.assert_array_equal(masks[0], before)
    assert masks[4][20, 15:18].all()
    assert not masks[4][20, 20:].any()
    # The same values in [0, 1] and its only class named: another bias, and two classes.
    masking_actions.choose_network_values(masking, "unit")
    masking_actions.type_network_tools(masking, "1")
    two = np.array([[0, 0, 0], [-1, 0, 0]], np.float32), np.array([0, 0.58], np.float32)
    masking_actions.make_all(masking, write_convolution(tmp_path / "two.onnx", *two))
    settle(masking, channels)
    assert np.array_equal(on_disk(masking)[4], masks[4])
    masking_actions.type_network_tools(masking, "0, 1")
    masking_actions.make_all(masking, tmp_path / "two.onnx")
    settle(masking, channels)
    assert on_disk(masking)[4].all()
    network.write_text("nothing")
    masking_actions.make_all(masking, network)
    settle(masking, channels)
    assert masking.window.banner is not None
    assert "expected an ONNX network" in masking.window.banner.message


def test_closing_asks_while_masks_are_made_and_another_clip_says_that_they_were_interrupted(
    masking: AppState, folder: Path
) -> None:
    channels = settle(masking)
    assert closing.at_stake(masking) == ""
    masking_actions.make_all(masking)
    assert closing.at_stake(masking) == "Tools are still being masked."
    assert closing.what_is_kept(masking) == "Masks made so far stay."
    for _ in range(3):
        update(masking, channels, 2.0)
        channels.made_masks.run_waiting()
    masking.source.opening = request = OpenRequest(folder)
    (opened,) = open_path(request)
    taking.take_opened(masking, request, opened)
    assert closing.at_stake(masking) == ""
    assert masking.window.toast is not None
    assert masking.window.toast.message == "tool masks of clip were interrupted: those made so far stay"


@pytest.mark.parametrize(("reply", "opens"), [("Stay", False), ("Interrupt", True), ("", False)])
def test_another_clip_is_asked_about_while_masks_are_made(
    masking: AppState, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, reply: str, opens: bool
) -> None:
    monkeypatch.setattr("app.gui.panels.masking.ask", lambda *said, moot: reply)
    masking_actions.make_all(masking)
    actions.open_path(masking, tmp_path / "other")
    assert masking.source.opening is None
    draw_masking_question(masking)
    assert (masking.source.opening is not None) == opens
    assert (masking.masking.leaving is None) == bool(reply)
    assert masking.masking.making is not None  # Until the other clip is there.


def test_the_question_is_moot_once_all_masks_are_there(ui: Ui, masking: AppState, tmp_path: Path) -> None:
    masking_actions.make_all(masking)
    actions.open_path(masking, tmp_path / "other")
    draw = partial(draw_masking_question, masking)
    ui.frame(draw)
    ui.frame(draw)
    masking_actions.stop_making(masking)
    ui.frame(draw)
    assert masking.source.opening is not None
    assert masking.source.opening.path == tmp_path / "other"


def test_a_clip_that_cannot_be_opened_interrupts_nothing(masking: AppState, tmp_path: Path) -> None:
    masking_actions.make_all(masking)
    masking.source.opening = request = OpenRequest(tmp_path / "gone")
    taking.take_opened(masking, request, Failure(OSError("it is gone")))
    assert masking.masking.making is not None
    assert masking.window.banner is not None
    assert masking.window.banner.message == "it is gone"
