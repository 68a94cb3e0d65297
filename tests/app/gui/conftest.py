"""A clip without files, a model, and a job that says what the test makes it say."""

from __future__ import annotations

import shutil
import signal
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

import cv2
import numpy as np
import pytest
from imgui_bundle import imgui

from app.enhancement.frame_enhancer import PictureMaker
from app.gui.actions import job_actions
from app.gui.commands.command import WindowServices
from app.gui.state.app_state import AppState
from app.gui.state.source import Source
from app.gui.update.channels import Channels
from app.gui.update.jobs import start_due
from app.gui.work.settings import Places, Settings
from renderer.camera import Camera
from renderer.clip import ByteImage, Clip, Frame
from renderer.deformation.motion import Still
from renderer.gaussians import DynamicGaussians
from renderer.raw_gaussians import RawGaussians
from tests.app.gui.chooser import Chooser
from tests.app.gui.exporting import Exporter
from tests.app.gui.settling import show_live
from tests.app.gui.ui import Ui

SIZE = (48, 40)


def image_of(index: int) -> ByteImage:
    """(H, W, 3): red tissue with a dark vertical vessel that is further right in each frame."""
    image = np.zeros((SIZE[1], SIZE[0], 3), np.uint8)
    image[...] = (190, 120, 100)
    image[:, 10 + index : 14 + index] = (110, 60, 60)
    return image


def make_clip(path: Path, count: int = 6, *, has_depth: bool = True) -> Clip:
    camera = Camera.from_fov(60.0, *SIZE)
    mask = np.ones((SIZE[1], SIZE[0]), dtype=bool)
    depth = np.full(mask.shape, 50.0, np.float32)

    def read_frame(index: int) -> Frame:
        return Frame(index, index / count, image_of(index), camera, mask, mask, depth if has_depth else None)

    return Clip(
        name=path.name,
        path=path,
        format="images",
        cameras=(camera,) * count,
        read_frame=read_frame,
        read_image=image_of,
        labels=tuple(f"{index}.png" for index in range(count)),
        has_depth=has_depth,
        unit="mm",
        frames_per_second=10.0,
    )


def make_model(count: int = 30) -> DynamicGaussians:
    """A static sheet of Gaussians 50 before the camera."""
    rng = np.random.default_rng(0)
    means = np.stack([*rng.uniform(-20, 20, (2, count)), np.full(count, 50.0)], axis=1).astype(np.float32)
    raw = RawGaussians(
        means=means,
        quats=np.tile(np.float32([1, 0, 0, 0]), (count, 1)),
        log_scales=np.full((count, 3), np.log(4.0), np.float32),
        opacity_logits=np.full(count, 2.0, np.float32),
        colors=np.full((count, 3), 0.5, np.float32),
        harmonics=np.zeros((count, 0, 3), np.float32),
    )
    return DynamicGaussians(raw, Still())


@dataclass
class FakeJob:
    """Says the events put into `inbox`; remembers what it was told."""

    request: object = None
    inbox: list[object] = field(default_factory=list)
    told: list[str] = field(default_factory=list)
    model: DynamicGaussians | None = None
    has_gone: bool = True

    def start(self) -> None:
        self.told.append("start")

    def poll(self) -> list[object]:
        events, self.inbox = self.inbox, []
        return events

    def latest_model(self) -> DynamicGaussians | None:
        return self.model

    def pause(self) -> None:
        self.told.append("pause")

    def resume(self) -> None:
        self.told.append("resume")

    def cancel(self) -> None:
        self.told.append("cancel")

    def close(self) -> None:
        self.told.append("close")


def outside(**doing: Callable[[], None]) -> WindowServices:
    """Nothing is done outside the state but what is named."""
    nothing = {name: lambda *given: None for name in WindowServices.__dataclass_fields__}
    return WindowServices(**nothing | {"panel_shown": lambda name: False} | doing)  # type: ignore[arg-type]


@pytest.fixture(autouse=True)
def broken_pipes_stay_errors() -> Iterator[None]:
    """The test engine takes over SIGPIPE, so that a later test's write to a dead process would end pytest."""
    yield
    if hasattr(signal, "SIGPIPE"):
        signal.signal(signal.SIGPIPE, signal.SIG_IGN)


@pytest.fixture
def places(tmp_path: Path) -> Places:
    return Places(tmp_path / "config", tmp_path / "runs", tmp_path / "pictures")


@pytest.fixture
def clip(tmp_path: Path) -> Clip:
    return make_clip(tmp_path / "clip")


@pytest.fixture
def still(tmp_path: Path) -> Path:
    path = tmp_path / "still.png"
    cv2.imwrite(str(path), np.full((96, 128, 3), (60, 80, 160), np.uint8))
    return path


@pytest.fixture
def own_clip(clip_path: Path, tmp_path: Path) -> Path:
    """One on disk that a test may change."""
    return Path(shutil.copytree(clip_path, tmp_path / "clip"))


@pytest.fixture
def state(places: Places, clip: Clip) -> AppState:
    """With a clip open and the notice read."""
    return AppState(places, Settings(acknowledged=True), Source(clip=clip))


@pytest.fixture
def model() -> DynamicGaussians:
    return make_model()


@pytest.fixture
def make_job() -> Callable[[object], FakeJob]:
    return FakeJob


@pytest.fixture
def run(places: Places, runs: dict[str, Path]) -> Exporter:
    """A run and its clip are open."""
    return Exporter(places, runs["original"])


@pytest.fixture
def ui() -> Iterator[Ui]:
    made = Ui()
    yield made
    made.close()


@pytest.fixture
def case(tmp_path: Path) -> Path:
    """A folder with clips and files, for the file dialog."""
    inside = tmp_path / "case"
    for name in ("b clip", "A clip", ".hidden"):
        (inside / name).mkdir(parents=True)
    for name in ("10.png", "2.png", "notes.txt", ".DS_Store", "scope.mp4"):
        (inside / name).write_text("")
    return inside


@pytest.fixture
def chooser(ui: Ui, places: Places, monkeypatch: pytest.MonkeyPatch) -> Chooser:
    """Where no program of the desktop asks in the window's place."""
    monkeypatch.setattr(sys, "platform", "linux")
    monkeypatch.setattr(shutil, "which", lambda name: None)
    ui.io.config_flags |= imgui.ConfigFlags_.nav_enable_keyboard
    return Chooser(ui, AppState(places, Settings(acknowledged=True)))


@pytest.fixture
def channels() -> Channels:
    return Channels()


@pytest.fixture
def opened(state: AppState) -> AppState:
    """With both pictures made."""
    assert state.picture_request is not None
    state.picture.pictures = list(PictureMaker().make(state.picture_request))[-1]
    return state


@pytest.fixture
def seen(state: AppState, model: DynamicGaussians) -> AppState:
    """A reconstruction on screen, through the clip's camera and as large as its frames."""
    start_live(state, model)
    state.scene.size = SIZE
    return state


def start_live(state: AppState, model: DynamicGaussians) -> None:
    job_actions.start_reconstruction(state)
    start_due(state, FakeJob)
    show_live(state, model)
