"""Sessions: what comes back is what was there, after a save, a crash, and whatever happened to the file."""

from __future__ import annotations

import errno
import json
import os
import shutil
import signal
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from imgui_bundle import imgui

from app.enhancement.image_mask import PictureMask
from app.errors import UserError
from app.gui.actions import (
    actions,
    clip_actions,
    comparing,
    edit_actions,
    enhancement_actions,
    history_actions,
    recovering,
    session_actions,
)
from app.gui.actions.session_actions import snapshot
from app.gui.session_file import (
    Choice,
    KeptSettings,
    Session,
    UnsavedEdits,
    autosave_path,
    mended_session,
    recoverable,
    write_session,
)
from app.gui.state.app_state import AppState
from app.gui.update.channels import Channels
from app.gui.update.update import update
from app.gui.views.comparison import Comparison
from app.gui.views.picture_view import PictureView
from app.gui.work import writing
from app.gui.work.opening import OpenRequest, open_path
from app.gui.work.settings import Places, Settings
from app.gui.work.writing import SessionRequest
from app.runs.clip_selection import WHOLE
from app.scenes.free_camera import FreeView
from assets import phantom_path
from enhance import EnhanceParams
from enhance.vessel import VesselParams
from renderer.camera_files import NamedCamera
from renderer.camera_path import CameraPath, Keyframe
from renderer.editing.mask import Mask
from renderer.gaussians import DynamicGaussians
from renderer.view_files import Views
from tests.app.gui.driver import Driver, is_settled, wait
from tests.app.gui.kept_session import places_in
from tests.app.gui.settling import served
from tests.app.gui.test_opening import make_run


def turn(state: AppState, channels: Channels, seconds: float = 2.0) -> None:
    """One frame, and the worker's share of it."""
    update(state, channels, state.window.now + seconds)
    for channel in served(channels):
        channel.run_waiting()


def opened_state(places: Places, path: Path) -> tuple[AppState, Channels]:
    state, channels = AppState(places, Settings(acknowledged=True)), Channels()
    actions.open_path(state, path)
    for _ in range(4):
        turn(state, channels)
    return state, channels


@pytest.fixture
def clip_path(tmp_path: Path) -> Path:
    return Path(shutil.copytree(phantom_path(), tmp_path / "clips" / "liver"))


@pytest.fixture
def worked(places: Places, clip_path: Path) -> tuple[AppState, Channels]:
    """A clip is open and much has been set."""
    state, channels = opened_state(places, clip_path)
    assert state.source.clip is not None
    enhancement_actions.set_params(state, EnhanceParams(z=0.25, p=(0.1, 0.2, 0.3)))
    enhancement_actions.settle_params(state)
    enhancement_actions.choose_method(state, VesselParams)
    actions.seek(state, 5)
    actions.toggle_freeze(state)
    actions.seek(state, 9)
    state.enhancement.scope, state.enhancement.pixels, state.enhancement.active = "clip", "tissue", False
    state.picture.view = PictureView(2.5, (0.25, 0.75))
    actions.toggle_link(state)
    state.scene.viewer.free = FreeView.of(state.source.clip.cameras[0]).looked(0.2, 0.1)
    camera = state.source.clip.cameras[0]
    path = CameraPath((Keyframe(0.0, 0.1, camera), Keyframe(1.5, 0.9, camera)))
    state.scene.cameras.views = Views((NamedCamera("from the left", camera),), path, loop=True, unit="mm")
    state.scene.kind, state.scene.viewer.blend = "depth", 0.25
    state.runs.reconstruction.name, state.runs.reconstruction.input = "second try", "enhanced"
    state.runs.reconstruction.kept = KeptSettings(EnhanceParams(d_factor=0.7), "2026-01-02 03:04")
    state.runs.reconstruction.config = replace(state.runs.reconstruction.config, iterations=500)
    state.tuning.choices = (Choice("lift", 0.1, 0.9, 3), Choice())
    clip_actions.trim_here(state, start=True)
    clip_actions.set_mask(state, PictureMask(text=(3, 4, 20, 9)))
    comparing.store(state, "A")
    state.comparing.chosen = Comparison("wipe", "A", "clahe", 0.3, zebra=True)
    state.session.notes = "Zwölf Uhr: ein Gefäß\nunclear"
    return state, channels


def test_all_of_it_comes_back(worked: tuple[AppState, Channels], places: Places) -> None:
    state, channels = worked
    session_actions.save_to(state, places.pictures / "liver.vesselsplat")
    *_, request = state.window.wishes
    assert isinstance(request, SessionRequest)
    turn(state, channels)
    turn(state, channels)
    assert state.window.toast is not None
    assert request.path.name in state.window.toast.message
    other, _ = opened_state(places, request.path)
    assert other.window.banner is None
    folder = request.path.parent
    assert snapshot(other, folder) == snapshot(state, folder)
    assert (other.session.path, other.enhancement.params) == (request.path, VesselParams())
    history_actions.undo(other)
    assert other.enhancement.params == EnhanceParams(z=0.25, p=(0.1, 0.2, 0.3))
    written = request.path.read_text(encoding="utf-8")
    assert str(state.source.path) not in written
    assert json.loads(written)["source"]["sha256"] is not None


@pytest.mark.parametrize(("before", "now"), [(True, "tissue"), (False, "all")])
def test_a_session_of_before_has_the_pixels_it_had(tmp_path: Path, before: bool, now: str) -> None:
    path = tmp_path / "before.vesselsplat"
    write_session(path, Session(notes="kept"))
    facts = json.loads(path.read_text())
    del facts["pixels"]
    path.write_text(json.dumps(facts | {"tissue_only": before}))
    session, wrong = mended_session(path)
    assert (session.pixels, session.notes, wrong) == (now, "kept", "")


def test_sources_move_with_the_session(worked: tuple[AppState, Channels], tmp_path: Path) -> None:
    state, _ = worked
    assert state.source.path is not None
    folder = tmp_path / "elsewhere"
    folder.mkdir()
    session_actions.save_to(state, folder / "a.vesselsplat")
    *_, request = state.window.wishes
    assert isinstance(request, SessionRequest)
    list(writing.save_session(request))
    shutil.move(state.source.path, folder / "liver")
    (opened,) = open_path(OpenRequest(request.path))
    assert opened.path == folder / "liver"
    assert opened.notices == ()
    image = next((folder / "liver" / "images").iterdir())
    image.write_bytes(image.read_bytes() + b"\0")
    (opened,) = open_path(OpenRequest(request.path))
    assert "has changed" in opened.notices[-1]
    shutil.rmtree(folder / "liver")
    with pytest.raises(UserError, match="liver"):
        list(open_path(OpenRequest(request.path)))


def test_a_session_with_a_run_opens_the_run(places: Places, clip_path: Path, model: DynamicGaussians) -> None:
    run = make_run(places.runs / "first", clip_path, model)
    state, _ = opened_state(places, run.path)
    path = places.pictures / "b.vesselsplat"
    write_session(path, snapshot(state, path.parent))
    other, _ = opened_state(places, path)
    assert other.runs.reconstruction.run_path == run.path
    assert other.scene.model is not None


@pytest.mark.parametrize("content", [b"", b"{", b"[]", b'{"params": {"z": 7}}', b"\xff\xfe"])
def test_a_damaged_session_is_a_sentence_and_is_kept(places: Places, content: bytes) -> None:
    path = places.pictures / "c.vesselsplat"
    path.parent.mkdir(parents=True)
    path.write_bytes(content)
    state, _ = opened_state(places, path)
    assert state.window.banner is not None
    assert "c.vesselsplat.broken" in state.window.banner.message
    assert "\n" not in state.window.banner.message
    assert not path.exists()
    assert path.with_name("c.vesselsplat.broken").read_bytes() == content
    assert state.source.opening is None


def test_saved_in_passing_after_each_change_and_only_then(worked: tuple[AppState, Channels]) -> None:
    state, channels = worked
    path = autosave_path(state.places.config)
    turn(state, channels)
    assert mended_session(path)[0].notes == state.session.notes
    path.unlink()
    turn(state, channels)
    assert not path.exists()  # Nothing has changed.
    enhancement_actions.set_params(state, VesselParams(lift=0.3))
    turn(state, channels)
    assert mended_session(path)[0].params == VesselParams(lift=0.3)
    recovering.end(state)
    assert not path.exists()


def test_what_a_dead_process_left_is_found_and_kept_until_taken_up(
    worked: tuple[AppState, Channels], places: Places
) -> None:
    state, channels = worked
    turn(state, channels)
    own = autosave_path(places.config)
    assert recoverable(places.config) is None  # Its process lives.
    dead = subprocess.Popen([sys.executable, "-c", ""])
    dead.wait()
    left = own.with_name(f"autosave-{dead.pid}.vesselsplat")
    own.rename(left)
    os.utime(left, (1_700_000_000, 1_700_000_000))
    later = AppState(places, Settings(acknowledged=True))
    recovering.offer_recovery(later)
    assert later.session.recoverable == left
    assert later.session.recoverable_since.startswith("2023-11-1")  # The day depends on where one is.
    recovering.recover(later)
    channels = Channels()
    for _ in range(4):
        turn(later, channels)
    assert snapshot(later, places.config) == snapshot(state, places.config)
    assert (left.exists(), own.exists()) == (False, True)
    assert not any("autosave" in recent for recent in later.settings.recent)
    own.rename(left)
    recovering.offer_recovery(later)
    second = AppState(places, Settings(acknowledged=True))
    recovering.offer_recovery(second)
    recovering.decline(later)
    recovering.recover(second)
    assert "in another window" in str(second.window.banner)
    assert later.session.recoverable is second.session.recoverable is recoverable(places.config) is None
    assert mended_session(places.config / "declined.vesselsplat")[0].notes == state.session.notes


def test_a_full_disk_is_told_once_and_costs_nothing_saved(
    worked: tuple[AppState, Channels], monkeypatch: pytest.MonkeyPatch
) -> None:
    state, channels = worked
    turn(state, channels)
    path = autosave_path(state.places.config)
    before = path.read_bytes()

    def full(*_: object) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(path))

    with monkeypatch.context() as patch:
        patch.setattr("app.files.atomic.os.fsync", full)
        state.session.notes = "more"
        turn(state, channels)
        turn(state, channels)
        assert state.window.banner is not None
        assert "No space left on device" in state.window.banner.message
        state.window.banner = None
        turn(state, channels)
        turn(state, channels)
        assert state.window.banner is None
        assert path.read_bytes() == before
    turn(state, channels)
    turn(state, channels)
    assert mended_session(path)[0].notes == "more"


def test_numbers_that_are_none_are_refused(tmp_path: Path) -> None:
    write_session(tmp_path / "d.vesselsplat", Session(frame=3))
    text = (tmp_path / "d.vesselsplat").read_text().replace('"frame": 3', '"frame": "x"')
    (tmp_path / "d.vesselsplat").write_text(text)
    with pytest.raises(UserError, match="frame"):
        mended_session(tmp_path / "d.vesselsplat")[0]  # And nothing to open in it.


def test_trim_and_mask_come_back_also_where_paths_are_not_remembered(
    worked: tuple[AppState, Channels], places: Places
) -> None:
    state, _ = worked
    path = places.pictures / "m.vesselsplat"
    write_session(path, snapshot(state, path.parent))
    (places.config / "clips.json").unlink(missing_ok=True)
    other, _ = opened_state(places, path)
    assert other.source.part == state.source.part != WHOLE


def test_unsaved_edits_come_back_unsaved(places: Places, clip_path: Path, model: DynamicGaussians) -> None:
    run = make_run(places.runs / "first", clip_path, model)
    state, channels = opened_state(places, run.path)
    edit_actions.toggle(state)
    for name in ("deleted", "hidden"):
        mask = Mask.of(np.arange(len(model)) % 5 == (1 if name == "deleted" else 2))
        edit_actions.change(state, lambda edits, mask=mask: edits.selecting(mask, "replace"))
        (edit_actions.delete if name == "deleted" else edit_actions.hide)(state)
    edits = state.editing.edits
    assert state.editing.is_unsaved
    path = places.pictures / "e.vesselsplat"
    write_session(path, snapshot(state, path.parent))
    other, channels = opened_state(places, path)
    turn(other, channels)
    assert (other.editing.edits.deleted, other.editing.edits.hidden) == (edits.deleted, edits.hidden)
    assert other.editing.is_unsaved
    assert not run.edits_path.exists()
    assert other.scene.model is not None
    assert len(other.scene.model.model) == len(edits.visible) < len(model)
    assert snapshot(other, path.parent).edits == snapshot(state, path.parent).edits
    edit_actions.toggle(other)
    edit_actions.undo(other)
    assert not other.editing.is_unsaved
    assert snapshot(other, path.parent).edits is None


def test_unsaved_edits_of_another_model_are_left_out_and_said(
    places: Places, clip_path: Path, model: DynamicGaussians
) -> None:
    run = make_run(places.runs / "first", clip_path, model)
    state, _ = opened_state(places, run.path)
    for edits in (UnsavedEdits(len(model) + 1, "", ""), UnsavedEdits(len(model), "?", "")):
        state.window.banner = None
        session_actions.restore(state, replace(snapshot(state, places.config), edits=edits))
        assert state.window.banner is not None
        assert "not restored" in state.window.banner.message
        assert not state.editing.is_unsaved


def test_of_a_damaged_session_all_that_can_be_read_comes_back(
    worked: tuple[AppState, Channels], places: Places
) -> None:
    state, _ = worked
    path = places.pictures / "n.vesselsplat"
    write_session(path, snapshot(state, path.parent))
    told = json.loads(path.read_text())
    told["params"], told["blend"], told["of tomorrow"] = {"z": 7}, "much", 3
    del told["part"]
    path.write_text(json.dumps(told))
    before = path.read_bytes()
    other, _ = opened_state(places, path)
    assert (other.session.notes, other.enhancement.scope, other.timeline.frame_index) == (
        state.session.notes,
        state.enhancement.scope,
        state.timeline.frame_index,
    )
    assert other.enhancement.params == EnhanceParams()
    assert other.window.banner is not None
    assert "blend, params" in other.window.banner.message
    assert "n.vesselsplat.broken" in other.window.banner.message
    assert "\n" not in other.window.banner.message
    assert path.with_name("n.vesselsplat.broken").read_bytes() == before
    assert path.exists()


def test_a_frame_beyond_the_clip_is_its_last(places: Places, clip_path: Path) -> None:
    state, _ = opened_state(places, clip_path)
    session_actions.restore(state, Session(frame=999, frozen=999))
    assert state.source.clip is not None
    assert state.timeline.frame_index == state.timeline.frozen_index == len(state.source.clip) - 1


@pytest.mark.display
@pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="a system that kills otherwise")
def test_a_killed_window_is_restored_by_the_next(tmp_path: Path) -> None:
    killed = subprocess.Popen(
        [sys.executable, "-m", "tests.app.gui.kept_session", str(tmp_path)], stdout=subprocess.PIPE, text=True
    )
    assert killed.stdout is not None
    try:
        assert any(line.endswith("kept\n") for line in killed.stdout)
    finally:
        killed.kill()
        killed.wait()
        killed.stdout.close()
    places = places_in(tmp_path)
    driver = Driver(places)
    state = driver.state
    recovering.offer_recovery(state)
    assert state.session.recoverable is not None
    expected = mended_session(state.session.recoverable)[0]

    def drive(ctx: imgui.test_engine.TestContext) -> None:
        ctx.item_click("//An earlier session ended unexpectedly/Restore")
        wait(ctx, lambda: is_settled(state), "the session")

    driver.run(drive)
    assert replace(snapshot(state, places.config), saved=expected.saved, version=expected.version) == expected
    assert state.enhancement.params == EnhanceParams(d_factor=1.5)
    assert list(places.config.glob("autosave-*")) == []  # This window was closed as it should.
