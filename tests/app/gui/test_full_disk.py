"""A disk of a few MB that really fills up, under each of the user's folders in turn.

What was saved before stays whole, what could not be saved is said in a sentence, and all works again once
there is room.
"""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path

import pytest

from app.files.legible import located
from app.gui.actions import actions, clip_actions, export_actions, job_actions, preset_actions
from app.gui.actions.export_offers import OFFERS
from app.gui.session_file import autosave_path, mended_session
from app.gui.update.jobs import start_due
from app.gui.work.presets import load_presets, presets_file
from app.gui.work.settings import Places, load_settings
from app.runs.job import TrainingJob
from app.runs.run_folder import RunFolder
from renderer.train.config import TrainConfig
from tests.app.gui.settling import keep_all
from tests.app.gui.test_trouble import App

MEGABYTES = 4
NO_SPACE = "No space left on device"


@dataclass(frozen=True)
class Disk:
    """A file system of its own."""

    path: Path

    def fill(self) -> None:
        """To the last byte."""
        with (self.path / "junk").open("ab", buffering=0) as file:
            for size in (1 << 16, 1 << 10, 1):
                with suppress(OSError):
                    while file.write(bytes(size)):
                        pass

    def free(self) -> None:
        (self.path / "junk").unlink()

    def folder(self, name: str) -> Path:
        made = self.path / name
        made.mkdir()
        return made


@pytest.fixture
def disk(tmp_path: Path) -> Iterator[Disk]:
    place = tmp_path / "disk"
    place.mkdir()
    mount = ["mount", "-t", "tmpfs", "-o", f"size={MEGABYTES}m", "tmpfs", str(place)]
    if (
        not sys.platform.startswith("linux")
        or subprocess.run(mount, capture_output=True, check=False).returncode
    ):
        pytest.skip("mounting a small file system is not permitted here")
    yield Disk(place)
    subprocess.run(["umount", "--lazy", str(place)], check=True)


def contents(folder: Path) -> dict[str, bytes]:
    """Every file in it, also hidden ones."""
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def test_under_the_pictures(disk: Disk, places: Places, own_clip: Path) -> None:
    app = App(replace(places, pictures=disk.folder("pictures")), own_clip)
    app.save()
    before = contents(app.state.places.pictures)
    disk.fill()
    app.save()
    (earlier,) = app.state.places.pictures.glob("*.png")
    folder = located(app.state.places.pictures)
    why = f"{NO_SPACE}: {earlier.stem}-2.png in {folder}"
    assert app.trouble() == f"the image was not saved: {why}"
    # The panel no longer shows the file before as if it were this one.
    assert app.state.exports.last is None
    assert app.state.exports.failure == why
    for what in OFFERS:
        request = export_actions.export_request(app.state, what)
        if request is None:
            continue
        app.channels.exports.ask(request)
        app.wait(lambda: app.state.exports.under_way is None)
        assert app.state.exports.last is None
        assert app.trouble() == f"the export failed: {app.state.exports.failure}"
        assert contents(app.state.places.pictures) == before
    assert app.works
    disk.free()
    app.save()
    assert len(contents(app.state.places.pictures)) == len(before) + 1


def test_under_the_settings(disk: Disk, places: Places, own_clip: Path) -> None:
    config = disk.folder("config")
    app = App(replace(places, config=config), own_clip)
    state = app.state
    actions.choose_theme(state, "light")
    preset_actions.keep(state, "mine")
    keep_all(state)
    state.session.notes = "before"
    app.turn()
    app.turn()
    before = contents(config)
    assert mended_session(autosave_path(config))[0].notes == "before"

    disk.fill()
    actions.choose_theme(state, "dark")
    keep_all(state)
    assert NO_SPACE in state.window.log[-1]
    preset_actions.keep(state, "another")
    keep_all(state)
    assert NO_SPACE in app.trouble()
    clip_actions.trim_here(state, start=False)
    keep_all(state)
    assert NO_SPACE in state.window.log[-1]
    state.window.banner = None
    state.session.notes = "while it is full"
    app.turn()
    assert NO_SPACE in app.trouble()
    app.turn()
    assert state.window.banner is None  # The same trouble is told once.
    assert app.works
    assert contents(config) == before
    assert load_settings(state.places.settings_file).theme == "light"
    assert list(load_presets(presets_file(state.places))[0]) == ["mine"]

    disk.free()
    app.turn()
    app.turn()
    assert mended_session(autosave_path(config))[0].notes == "while it is full"


@pytest.mark.slow
def test_under_the_runs(disk: Disk, places: Places, own_clip: Path) -> None:
    """Training ends with a sentence at what it cannot write, and goes on when there is room."""
    app = App(replace(places, runs=disk.folder("runs")), own_clip)
    state = app.state
    state.runs.reconstruction.config = TrainConfig(iterations=400, n_gaussians=300, checkpoint_every=20)
    job_actions.start_reconstruction(state)
    start_due(state, TrainingJob)
    path = state.runs.reconstruction.run_path
    assert path is not None
    run = RunFolder(path)
    app.wait(lambda: run.has_checkpoint)
    job_actions.pause(state)
    app.wait(lambda: state.runs.reconstruction.status == "paused")
    disk.fill()
    job_actions.resume(state)
    app.wait(lambda: not state.runs.reconstruction.is_alive)
    assert state.runs.reconstruction.status == "failed"
    said = app.trouble()
    assert said.startswith("the reconstruction failed: ")
    assert NO_SPACE in said
    assert "Errno" not in said
    assert run.has_checkpoint
    assert app.works
    assert job_actions.can_continue(state)

    def go_on() -> None:
        app.wait(lambda: state.runs.ending is None)
        job_actions.continue_reconstruction(state)
        start_due(state, TrainingJob)
        app.wait(lambda: not state.runs.reconstruction.is_alive)

    go_on()
    assert "of free disk" in app.trouble()

    disk.free()
    assert job_actions.can_continue(state)
    go_on()
    assert state.runs.reconstruction.status == "finished"
    assert run.is_finished
