"""What cannot be opened is a line at once; what takes long is said, and stops nothing else."""

from __future__ import annotations

import os
import shutil
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from app.files.provenance import digest
from app.gui.actions import actions, queue_actions
from app.gui.panels.overlays import draw_banner
from app.gui.session_file import Session, SessionSource, write_session
from app.gui.state.app_state import AppState
from app.gui.state.reconstruction import Waiting
from app.gui.update.channels import Channels
from app.gui.update.patience import LONG
from app.gui.update.update import update
from app.gui.work.background import Apart, Channel, Failure, NewestChannel
from app.gui.work.opening import Opened, OpenRequest, open_path
from app.gui.work.settings import Places, Settings
from app.gui.work.writing import SessionRequest, save_session
from app.runs.train_run import TrainRequest
from assets import phantom_path
from renderer.gaussians import DynamicGaussians
from renderer.train.config import TrainConfig
from tests.app.gui.test_opening import make_run
from tests.app.gui.ui import Ui

SECONDS = 10.0
pytestmark = pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="a system without such pipes")
NAMES = (
    "a.vesselsplat", "a.ply", "a.spz", "a.splat", "a.sog", "a.ksplat", "meta.json", "a.json", "a.txt",
    "a.npy", "a.safetensors", "a.mp4", "a.png", "a.jpg", "a.tif", "a.webp", "a", "images.txt",
)  # fmt: skip


def say(error: Exception) -> str:
    return Failure(error).message


def ends(work: Callable[[], object]) -> str:
    """What it says where it does not work; empty where it does."""
    found: list[str] = []

    def run() -> None:
        try:
            work()
            found.append("")
        except Exception as error:
            found.append(say(error))

    thread = threading.Thread(target=run, daemon=True)
    thread.start()
    thread.join(SECONDS)
    assert found, "it hangs"
    return found[0]


def pipe(path: Path) -> None:
    os.mkfifo(path)


def link_to_device(path: Path) -> None:
    path.symlink_to("/dev/zero")


def plug(path: Path) -> None:
    with socket.socket(socket.AF_UNIX) as made:
        made.bind(str(path))


@pytest.mark.parametrize("make", [pipe, link_to_device, plug])
@pytest.mark.parametrize("name", NAMES)
def test_what_is_no_file_is_refused_in_a_line(
    tmp_path: Path, make: Callable[[Path], None], name: str
) -> None:
    make(tmp_path / name)
    said = ends(lambda: list(open_path(OpenRequest(tmp_path / name))))
    assert "\n" not in said
    assert any(f"expected a file, got {kind}" in said for kind in ("a pipe", "a device", "a socket"))
    assert str(tmp_path / name) in said


@pytest.mark.parametrize("make", [pipe, link_to_device, plug])
@pytest.mark.parametrize("name", ["a.mp4", "a.ply", "a"])
@pytest.mark.parametrize("part", ["source", "run"])
def test_nor_is_the_source_of_a_session(
    tmp_path: Path, make: Callable[[Path], None], name: str, part: str
) -> None:
    make(tmp_path / name)
    path = tmp_path / "s.vesselsplat"
    source = SessionSource(name, "0" * 64)
    write_session(path, Session(source=source) if part == "source" else Session(run=source))
    said = ends(lambda: list(open_path(OpenRequest(path))))
    assert (
        "expected a file, got a" if part == "source" else f"expected {name} at its old place {tmp_path} or"
    ) in said


@pytest.mark.parametrize("make", [pipe, link_to_device, plug])
def test_nor_has_it_a_digest(tmp_path: Path, make: Callable[[Path], None]) -> None:
    make(tmp_path / "a")
    assert "expected a file, got a" in ends(lambda: digest(tmp_path / "a"))
    session = Session(source=SessionSource("a"))
    request = SessionRequest(tmp_path / "s.vesselsplat", session, in_passing=False)
    assert "expected a file, got a" in ends(lambda: list(save_session(request)))


@pytest.mark.parametrize(
    "name", ["run.json", "events.jsonl", "edits.json", "model.safetensors", "checkpoint-0000020.safetensors"]
)
def test_a_pipe_within_a_run_hangs_nothing(tmp_path: Path, model: DynamicGaussians, name: str) -> None:
    run = make_run(tmp_path / "run", phantom_path(), model)
    (run.path / name).unlink(missing_ok=True)
    if name.startswith("checkpoint"):
        run.model_path.unlink()
    os.mkfifo(run.path / name)
    assert "\n" not in ends(lambda: list(open_path(OpenRequest(run.path))))


@pytest.mark.parametrize("name", ["poses_bounds.npy", "images", "depth", "masks"])
def test_a_pipe_within_a_clip_hangs_nothing(tmp_path: Path, name: str) -> None:
    clip = Path(shutil.copytree(phantom_path(), tmp_path / "clip"))
    found = clip / name if (clip / name).is_file() else min((clip / name).iterdir())
    found.unlink()
    os.mkfifo(found)
    assert "\n" not in ends(lambda: list(open_path(OpenRequest(clip))))
    assert "\n" not in ends(lambda: digest(clip))


def test_opening_needs_no_numba(tmp_path: Path, model: DynamicGaussians) -> None:
    """So that it may go on beside the worker: two thread pools of numba never meet."""
    run = make_run(tmp_path / "run", phantom_path(), model)
    write_session(tmp_path / "s.vesselsplat", Session(run=SessionSource("run", "0")))
    code = (
        "import sys; from pathlib import Path; from numba import threading_layer\n"
        "from app.gui.work.opening import OpenRequest, open_path\n"
        "for name in sys.argv[1:]: list(open_path(OpenRequest(Path(name))))\n"
        "try: threading_layer()\n"
        "except ValueError: sys.exit(0)\n"
        "sys.exit('numba has worked')"
    )
    paths = [run.path, tmp_path / "s.vesselsplat", phantom_path()]
    subprocess.run([sys.executable, "-c", code, *map(str, paths)], check=True, timeout=120)


class Hanging:
    """Opens what is not called "gone", which takes until it is let go."""

    def __init__(self) -> None:
        self.let_go = threading.Event()
        self.went_on = threading.Event()

    def open(self, request: OpenRequest) -> Iterator[Opened]:
        if request.path.name == "gone":
            self.let_go.wait(60)
            self.went_on.set()
            yield Opened(None)
        else:
            yield from open_path(request)


@pytest.fixture
def hanging() -> Iterator[Hanging]:
    made = Hanging()
    yield made
    made.let_go.set()


def wait(until: Callable[[], bool], what: str) -> None:
    end = time.monotonic() + SECONDS
    while not until():
        assert time.monotonic() < end, f"waited for {what}"
        time.sleep(0.005)


def test_an_opening_that_hangs_stops_no_other(
    hanging: Hanging, places: Places, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("app.gui.update.channels.open_path", hanging.open)
    state, channels = AppState(places, Settings(acknowledged=True)), Channels()
    apart = Apart(channels.opening, lambda: None)
    actions.open_path(state, Path("/mnt/gone"))
    update(state, channels, 0.0)
    update(state, channels, LONG - 1)
    assert state.window.banner is None
    update(state, channels, LONG + 1)
    assert state.window.banner is not None
    assert "still waiting for /mnt/gone after 30 s" in state.window.banner.message
    assert state.window.banner.can_stop
    state.window.banner = None
    update(state, channels, LONG + 2)
    assert state.window.banner is None  # It has been said, and dismissed.

    def opened() -> bool:
        update(state, channels, state.window.now + 0.01)
        return state.source.clip is not None

    actions.open_path(state, phantom_path())
    wait(opened, "the phantom")
    assert state.source.opening is None
    clip = state.source.clip
    hanging.let_go.set()
    assert hanging.went_on.wait(SECONDS)
    apart.close()
    update(state, channels, state.window.now + 0.01)
    assert state.source.clip is clip  # The late answer is of no use.
    assert state.source.path == phantom_path()


def test_a_late_answer_never_takes_the_place_of_the_awaited_one(hanging: Hanging) -> None:
    channel: Channel[OpenRequest, Opened] = NewestChannel(hanging.open)
    apart = Apart(channel, lambda: None)
    channel.ask(OpenRequest(Path("gone")))
    second = OpenRequest(phantom_path())
    channel.ask(second)
    channel.wait(SECONDS)
    hanging.let_go.set()
    assert hanging.went_on.wait(SECONDS)
    apart.close()
    taken = channel.take()
    assert taken is not None
    assert taken[0] is second
    assert channel.take() is None


def test_what_was_said_goes_when_the_answer_comes_or_is_given_up(
    hanging: Hanging, places: Places, ui: Ui, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("app.gui.update.channels.open_path", hanging.open)
    for given_up in (True, False):
        hanging.let_go.clear()
        state, channels = AppState(places, Settings(acknowledged=True)), Channels()
        apart = Apart(channels.opening, lambda: None)
        actions.open_path(state, Path("/mnt/gone"))
        for now in (0.0, LONG + 1):
            update(state, channels, now)
        ui.frame(lambda state=state: draw_banner(state))
        assert state.window.banner is not None
        if given_up:
            actions.stop_opening(state)
            assert "stopped waiting for" in state.window.log[-1]
        hanging.let_go.set()
        apart.close()
        for _ in range(2):
            update(state, channels, state.window.now + 1)
        assert (state.source.opening, state.window.banner) == (None, None)
        assert (state.source.path is None) == given_up


def test_the_clip_of_a_reconstruction_that_waits_is_waited_for_in_words(
    places: Places, tmp_path: Path
) -> None:
    state, channels = AppState(places, Settings(acknowledged=True)), Channels()
    request = TrainRequest(clip_path=tmp_path / "clip", run_path=tmp_path / "first", config=TrainConfig())
    state.runs.queue = (Waiting(None, request),)
    for now in (0.0, LONG + 1):
        update(state, channels, now)  # Nobody serves the channel: as where the drive does not answer.
    assert state.window.banner is not None
    assert "first waits for its clip" in state.window.banner.message
    assert not state.window.banner.can_stop
    queue_actions.empty(state)
    update(state, channels, LONG + 2)
    assert state.window.banner is None


def test_a_hung_opener_does_not_keep_the_window_from_closing(hanging: Hanging) -> None:
    channel: Channel[OpenRequest, Opened] = NewestChannel(hanging.open)
    apart = Apart(channel, lambda: None)
    channel.ask(OpenRequest(Path("gone")))
    began = time.monotonic()
    apart.close(0.2)
    assert time.monotonic() - began < 2
