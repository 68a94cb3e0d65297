"""Many files and folders enhanced from the window: by the present setting, beside sliders, whole or not."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from imgui_bundle import imgui

from app.enhancement.enhance_files import enhance_into
from app.exports.replay.again import replay
from app.files.image_files import read_image
from app.files.image_series import Series
from app.files.legible import located
from app.files.provenance import read_provenance
from app.gui.actions import actions, batch_actions, closing, enhancement_actions
from app.gui.commands.keys import chord
from app.gui.panels.batches import draw_batches
from app.gui.state.app_state import AppState
from app.gui.state.choosing import QUESTIONS
from app.gui.update.channels import Channels
from app.gui.update.update import update
from app.gui.work.background import Worker
from app.gui.work.revealing import RevealRequest
from app.gui.work.settings import KnownClip, Places, Settings
from assets import phantom_path
from enhance import EnhanceParams, enhance
from enhance.vessel import VesselParams
from renderer.readers.clip_options import ClipOptions
from renderer.sources import open_clip
from tests.app.conftest import tissue
from tests.app.enhancement.test_batch import files, write_avi
from tests.app.gui.driver import Driver, is_settled, wait
from tests.app.gui.settling import served
from tests.app.gui.ui import Ui


@pytest.fixture
def case(tmp_path: Path) -> Path:
    """A video and a folder of three pictures."""
    root = tmp_path / "case"
    (root / "stills").mkdir(parents=True)
    for index in range(3):
        cv2.imwrite(str(root / f"stills/{index}.png"), tissue(index))
    write_avi(root / "scope.avi")
    return root


def write_cut(path: Path) -> None:
    write_avi(path, 60)
    path.write_bytes(path.read_bytes()[: int(0.6 * path.stat().st_size)])


class Person:
    """The window without its drawing."""

    def __init__(self, places: Places) -> None:
        self.state, self.channels = AppState(places, Settings(acknowledged=True)), Channels()

    def turn(self, frames: int = 1) -> None:
        for _ in range(frames):
            for channel in served(self.channels):
                channel.run_waiting()
            update(self.state, self.channels, self.state.window.now + 0.01)

    def begin(self, *inputs: Path) -> Path:
        """The folder that the results come into."""
        for path in inputs:
            batch_actions.add_input(self.state, path)
        request = batch_actions.batch_request(self.state)
        assert request is not None
        self.channels.batches.ask(request)
        return request.output

    def finish(self) -> None:
        for _ in range(100):
            self.turn()
            if self.state.batches.under_way is None:
                return
        raise AssertionError("the batch never ended")


def test_the_present_setting_is_used_and_every_file_comes_again(
    places: Places, case: Path, tmp_path: Path
) -> None:
    person = Person(places)
    assert batch_actions.why_not_start(person.state) == "Add files or folders first."
    enhancement_actions.set_params(person.state, EnhanceParams(d_factor=0.3))
    assert "Colour 0.77" in batch_actions.summary(person.state)
    output = person.begin(case)
    enhancement_actions.set_params(person.state, EnhanceParams(d_factor=4.0))  # Too late for this batch.
    assert person.state.is_busy
    person.finish()
    assert files(output) == {"scope.mp4", "scope.mp4.json", *(f"stills/{index}.png" for index in range(3))}
    expected = enhance(read_image(case / "stills/1.png"), EnhanceParams(d_factor=0.3)).image
    np.testing.assert_array_equal(read_image(output / "stills/1.png"), expected)
    assert person.state.window.toast is not None
    assert "2 of 2 enhanced" in person.state.window.toast.message
    batch_actions.reveal(person.state)
    assert [wish.path for wish in person.state.window.wishes if isinstance(wish, RevealRequest)] == [output]
    person.state.window.wishes = ()
    for name, source in (("scope.mp4", case), ("stills/2.png", case / "stills")):
        again = tmp_path / f"again{Path(name).suffix}"
        assert replay(output / name, (source,), again).difference.is_none
    assert person.begin(case) != output


def test_scope_and_tissue_are_those_of_the_panel(places: Places, case: Path) -> None:
    person = Person(places)
    enhancement_actions.set_params(person.state, VesselParams())
    person.state.enhancement.scope, person.state.enhancement.pixels = "clip", "tissue"
    output = person.begin(case / "stills", case / "scope.avi")
    person.finish()
    facts = read_provenance(output / "stills/0.png")
    assert (facts["method"], facts["pixels"], facts["statistics"]["scope"]) == ("vessel", "tissue", "clip")
    assert (output / "scope.mp4").is_file()


def test_a_video_of_both_eyes_is_read_as_was_said_at_the_start_or_chosen_for_it(
    places: Places, case: Path
) -> None:
    write_avi(case / "other.avi")
    person = Person(places)
    source = person.state.source
    source.known = {
        str(case / "scope.avi"): KnownClip(stereo="side-by-side"),
        str(case / "other.avi"): KnownClip(stereo="top-bottom"),
    }
    output = person.begin(case)
    person.finish()
    assert [open_clip(output / name).size for name in ("scope.mp4", "other.mp4")] == [(32, 48), (64, 24)]
    source.clip_options = ClipOptions(stereo="side-by-side", frame_step=2)
    output = person.begin(case / "other.avi")
    person.finish()
    clip = open_clip(output / "case/other.mp4")
    assert (clip.size, len(clip)) == ((32, 48), 4)


def test_pictures_are_served_meanwhile_and_cancel_keeps_what_is_whole(places: Places, case: Path) -> None:
    person = Person(places)
    actions.open_path(person.state, phantom_path())
    person.turn(4)
    output = person.begin(case)
    for _ in range(50):
        person.turn()
        now = person.state.batches.progressed
        if now is not None and now.step.place == 1 and now.step.done == 1:
            break
    enhancement_actions.set_params(person.state, EnhanceParams(z=0.4))
    person.turn(2)
    assert person.state.picture.pictures is not None
    assert person.state.picture.pictures.request == person.state.picture_request
    assert person.state.batches.under_way is not None
    person.channels.batches.want(None)
    batch_actions.cancelled(person.state)
    person.turn(2)
    assert person.state.batches.written == output
    assert files(output) == {"scope.mp4", "scope.mp4.json"}
    assert not list(output.rglob("*.partial"))


def test_a_folder_is_named_only_with_something_in_it(places: Places, case: Path) -> None:
    person = Person(places)
    (case / "broken.mp4").write_bytes(b"no video")
    output = person.begin(case / "broken.mp4", case / "stills")
    for _ in range(50):
        person.turn()
        now = person.state.batches.progressed
        if now is not None and now.failed:
            break
    assert person.state.batches.under_way is not None
    person.channels.batches.want(None)
    batch_actions.cancelled(person.state)
    person.turn(2)
    assert not output.exists()
    assert person.state.batches.written is None


def test_a_batch_that_is_cancelled_at_once_leaves_no_folder(places: Places, case: Path) -> None:
    person = Person(places)
    output = person.begin(case)
    for _ in range(50):
        person.turn()
        if output.exists():
            break
    assert output.is_dir()
    person.channels.batches.want(None)
    batch_actions.cancelled(person.state)
    person.turn(2)
    assert not output.exists()


def test_closing_meanwhile_is_asked_about(places: Places, case: Path) -> None:
    person = Person(places)
    assert closing.may_close(person.state)
    person.begin(case)
    assert not closing.may_close(person.state)
    assert "enhanced" in closing.at_stake(person.state)
    assert "Finished files are kept" in closing.what_is_kept(person.state)
    person.finish()
    assert not closing.at_stake(person.state)


def test_failures_are_told_at_the_end(places: Places, case: Path, ui: Ui) -> None:
    person = Person(places)
    (case / "stills/1.png").write_bytes(b"no picture")
    (case / "broken.mp4").write_bytes(b"no video")
    write_cut(case / "scope.avi")
    output = person.begin(case)
    person.finish()
    assert files(output) == {"scope.mp4", "scope.mp4.json", "stills/0.png", "stills/2.png"}
    assert person.state.window.banner is not None
    assert "2 of 3 enhanced" in person.state.window.banner.message
    losses = "1 could not be enhanced; 1 image could not be read; not all of it could be read"
    assert losses in person.state.window.banner.message
    assert person.state.batches.progressed is not None
    failed = person.state.batches.progressed.failed
    assert [one.name for one in failed] == ["case/broken.mp4", "case/stills/1.png"]
    assert person.state.batches.shown
    ui.frame(lambda: draw_batches(person.state))
    ui.frame(lambda: draw_batches(person.state))


def test_of_one_folder_it_is_told_what_it_lacks_not_how_many_folders_came(places: Places, case: Path) -> None:
    person = Person(places)
    (case / "stills/1.png").write_bytes(b"no picture")
    output = person.begin(case / "stills")
    person.finish()
    assert person.state.window.banner is not None
    said = f"enhanced into {located(output)}; 1 image could not be read: see the list"
    assert person.state.window.banner.message == said
    other = Person(places)
    other.begin(case / "stills/1.png")
    other.finish()
    assert other.state.window.banner is not None
    assert other.state.window.banner.message.startswith("nothing was enhanced; 1 could not be enhanced")


def test_what_was_moved_away_before_its_turn_fails_alone(places: Places, case: Path) -> None:
    person = Person(places)
    output = person.begin(case / "stills/0.png", case / "scope.avi", case / "stills/1.png")
    for name in ("stills/0.png", "scope.avi"):
        (case / name).unlink()
    person.finish()
    assert files(output) == {"1.png"}
    now, banner = person.state.batches.progressed, person.state.window.banner
    assert now is not None
    assert banner is not None
    assert [(one.name, "no such file" in one.reason) for one in now.failed] == [
        ("0.png", True),
        ("scope.avi", True),
    ]
    assert "1 of 3 enhanced" in banner.message


def test_what_is_said_of_what_was_written_is_listed_and_a_loss_stands_out(
    places: Places, case: Path, ui: Ui
) -> None:
    person = Person(places)
    (case / "stills/notes.txt").write_text("no image")
    person.begin(case)
    person.finish()
    state = person.state
    assert state.window.toast is not None
    assert "2 of 2 enhanced" in state.window.toast.message
    assert "notices" in state.window.toast.message
    assert not state.batches.shown
    assert "case/stills: left out, not images: notes.txt" in state.window.log
    write_cut(case / "cut.avi")
    person.begin(case)
    person.finish()
    assert state.window.banner is not None
    assert "3 of 3 enhanced" in state.window.banner.message
    assert "not all of it could be read" in state.window.banner.message
    assert state.batches.shown
    assert state.batches.progressed is not None
    assert any(one.name == "case/cut.avi" and one.is_loss for one in state.batches.progressed.noted)
    ui.frame(lambda: draw_batches(state))


def test_a_video_with_a_damaged_middle_is_a_loss(places: Places, case: Path) -> None:
    write_avi(case / "scope.avi", 60)
    content = bytearray((case / "scope.avi").read_bytes())
    middle = len(content) // 2
    content[middle : middle + 3000] = bytes(index * 37 % 256 for index in range(3000))
    (case / "scope.avi").write_bytes(content)
    person = Person(places)
    person.begin(case)
    person.finish()
    assert person.state.batches.progressed is not None
    noted = person.state.batches.progressed.noted
    assert [note.is_loss for note in noted if note.notice.startswith("stopped after")] == [True]


def test_a_batch_that_stops_says_what_is_there(
    places: Places, case: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def of_folders(output: Path, series: Series, *others: Any) -> Any:
        if not series.is_video:
            raise RuntimeError("unforeseen")
        return enhance_into(output, series, *others)

    person = Person(places)
    monkeypatch.setattr("app.enhancement.batch.enhance_into", of_folders)
    output = person.begin(case / "scope.avi", case / "stills")
    while person.channels.batches.run_waiting():  # All of it between two frames of the window.
        pass
    person.finish()
    assert person.state.window.banner is not None
    assert "1 of 2 enhanced" in person.state.window.banner.message
    assert "stopped: unforeseen" in person.state.window.banner.message
    assert person.state.batches.written == output


def test_the_settings_are_all_in_sight(ui: Ui, places: Places) -> None:
    person = Person(places)
    person.state.enhancement.params = VesselParams()
    person.state.batches.shown = True
    for _ in range(4):
        ui.frame(lambda: draw_batches(person.state))
    window = imgui.internal.find_window_by_name("Enhance files and folders")
    assert window.content_size.x <= window.size.x - 2 * window.window_padding.x


def test_nothing_to_enhance_is_a_sentence(places: Places, tmp_path: Path) -> None:
    person = Person(places)
    (tmp_path / "empty").mkdir()
    person.begin(tmp_path / "empty")
    person.finish()
    assert person.state.window.banner is not None
    assert "found none in empty" in person.state.window.banner.message
    assert not places.pictures.exists()


def test_closing_the_window_leaves_nothing_half_written(places: Places, case: Path) -> None:
    person = Person(places)
    write_avi(case / "scope.avi", 300)
    worker = Worker((person.channels.batches,), lambda: None)
    output = person.begin(case)
    end = time.monotonic() + 30
    while not any(case.parent.rglob("*.partial*")):
        assert time.monotonic() < end
        time.sleep(0.002)
    worker.close(10)
    assert not list(case.parent.rglob("*.partial*"))
    assert not output.exists() or files(output) == set()


@pytest.mark.display
def test_from_the_key_to_the_files(places: Places, case: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("app.gui.frame.dialogs.has_desktop_dialogs", lambda: False)
    driver = Driver(places, opens=phantom_path())
    state = driver.state

    def drive(ctx: imgui.test_engine.TestContext) -> None:
        wait(ctx, lambda: is_settled(state), "the phantom")
        ctx.key_press(chord("Ctrl+Shift+B"))
        ctx.yield_(2)
        ctx.item_click("//Enhance files and folders/###add folder")
        wait(ctx, lambda: state.window.browsing is not None, "the dialog")
        ctx.yield_(3)
        ctx.key_chars_replace(str(case))
        ctx.yield_(2)
        ctx.item_click(f"//{QUESTIONS['inputs'].title}/###choose")
        wait(ctx, lambda: state.batches.inputs == (case,), "the chosen folder")
        batch_actions.add_input(state, case / "scope.avi")
        ctx.yield_(2)
        inputs = ctx.window_info("//Enhance files and folders/inputs")
        ctx.set_ref(inputs.id_)
        ctx.item_click("1/###remove")
        ctx.set_ref("")
        assert state.batches.inputs == (case,)
        ctx.item_click("//Enhance files and folders/###start")
        wait(ctx, lambda: state.batches.progressed is not None, "the first step")
        wait(ctx, lambda: state.batches.under_way is None, "its end")

    driver.run(drive)
    (output,) = places.pictures.glob("enhanced-*")
    assert len(files(output)) == 5
