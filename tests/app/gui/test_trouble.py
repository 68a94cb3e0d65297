"""What goes wrong outside the app: it stays up, says what happened, and loses nothing that was saved."""

from __future__ import annotations

import errno
import os
import shutil
import time
from collections.abc import Callable
from pathlib import Path

import pytest
from imgui_bundle import immapp

from app.files.provenance import read_provenance
from app.gui import window
from app.gui.actions import actions, enhancement_actions, export_actions, job_actions, session_actions
from app.gui.session_file import autosave_path, mended_session
from app.gui.state.app_state import AppState
from app.gui.update.channels import Channels
from app.gui.update.jobs import start_due
from app.gui.update.update import update
from app.gui.work.settings import Places, Settings
from app.runs.job import TrainingJob
from app.runs.run_folder import RunFolder
from assets import phantom_path
from enhance import EnhanceParams
from renderer.train.config import TrainConfig
from tests.app.gui.settling import served

SECONDS = 120.0


class App:
    """The window without its drawing: state, background work done in between."""

    def __init__(self, places: Places, path: Path) -> None:
        self.state, self.channels = AppState(places, Settings(acknowledged=True)), Channels()
        actions.open_path(self.state, path)
        self.turn(6)

    def turn(self, frames: int = 3) -> None:
        for _ in range(frames):
            update(self.state, self.channels, self.state.window.now + 0.6)
            for channel in served(self.channels):
                channel.run_waiting()

    def wait(self, until: Callable[[], bool]) -> None:
        end = time.monotonic() + SECONDS
        while not until():
            assert time.monotonic() < end
            self.turn(1)
            time.sleep(0.02)

    @property
    def works(self) -> bool:
        """Another picture comes when a slider moves."""
        enhancement_actions.set_params(self.state, EnhanceParams(d_factor=0.11))
        self.turn()
        return (
            self.state.picture.pictures is not None
            and self.state.picture.pictures.request == self.state.picture_request
        )

    def save(self) -> None:
        export_actions.save_picture(self.state)
        assert len(self.state.window.wishes) == 1
        self.turn()

    def trouble(self) -> str:
        """The sentence that is shown; dismissed with that."""
        assert self.state.window.banner is not None
        message, self.state.window.banner = self.state.window.banner.message, None
        assert "\n" not in message
        return message


def test_a_full_disk(places: Places, own_clip: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    app = App(places, own_clip)
    app.save()
    (before,) = places.pictures.glob("*.png")
    content = before.read_bytes()
    kept = autosave_path(places.config).read_bytes()

    def full(*_: object) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    with monkeypatch.context() as patch:
        patch.setattr("app.files.atomic.os.fsync", full)
        app.save()
        assert app.trouble().startswith("the image was not saved: No space left on device: clip-")
        session_actions.save_to(app.state, app.state.places.pictures / "a.vesselsplat")
        assert len(app.state.window.wishes) == 1
        app.state.session.notes = "full"
        app.turn()
        assert "No space left on device" in app.trouble()
        actions.remember_recent(app.state, False)
        assert "No space left" in app.state.window.log[-1]
        assert app.works
    assert list(places.pictures.iterdir()) == [before]
    assert (before.read_bytes(), autosave_path(places.config).read_bytes()) == (content, kept)
    app.save()
    assert len(list(places.pictures.glob("*.png"))) == 2


def test_a_clip_deleted_under_the_app(places: Places, own_clip: Path) -> None:
    app = App(places, own_clip)
    app.save()
    shutil.rmtree(own_clip)
    actions.seek(app.state, 7)
    app.turn()
    assert "frame" in app.trouble()
    app.state.session.notes = "gone at frame 8"
    app.turn()
    assert mended_session(autosave_path(places.config))[0].notes == "gone at frame 8"
    app.save()
    app.turn()
    assert app.trouble().startswith("the image was not saved: expected the clip where it was opened, got no ")
    (saved,) = places.pictures.glob("*.png")
    assert read_provenance(saved)["frame"]["index"] == 0
    actions.open_path(app.state, phantom_path())
    app.turn(6)
    assert app.works


@pytest.mark.slow
def test_a_killed_job_leaves_its_last_checkpoint(places: Places, own_clip: Path) -> None:
    app = App(places, own_clip)
    app.state.runs.reconstruction.config = TrainConfig(
        iterations=100_000, n_gaussians=300, checkpoint_every=10
    )
    made: list[TrainingJob] = []

    def make_job(request: object) -> TrainingJob:
        made.append(TrainingJob(request))  # type: ignore[arg-type]
        return made[-1]

    job_actions.start_reconstruction(app.state)

    start_due(app.state, make_job)
    path = app.state.runs.reconstruction.run_path
    assert path is not None
    run = RunFolder(path)
    app.wait(lambda: run.has_checkpoint)
    assert made[0]._process.pid is not None
    os.kill(made[0]._process.pid, 9)
    app.wait(lambda: not app.state.runs.reconstruction.is_alive)
    assert app.state.runs.reconstruction.status == "failed"
    assert "the reconstruction failed" in app.trouble()
    assert job_actions.can_continue(app.state)
    assert run.has_checkpoint
    assert app.works
    opened = App(places, run.path)
    assert opened.state.runs.reconstruction.run_path == run.path
    assert job_actions.can_continue(opened.state)


def test_a_window_that_a_signal_ends_gives_back_what_its_job_shares(
    places: Places, monkeypatch: pytest.MonkeyPatch
) -> None:
    closed: list[bool] = []

    class Job:
        def close(self) -> None:
            closed.append(True)

    def interrupted(*_: object) -> None:
        raise KeyboardInterrupt

    state = AppState(places)
    shown = window.Window(state)
    state.runs.reconstruction.job = Job()  # type: ignore[assignment]
    monkeypatch.setattr(immapp, "run", interrupted)
    with pytest.raises(KeyboardInterrupt):
        shown.run()
    assert closed == [True]
