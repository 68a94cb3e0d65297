"""An image saved of a live source is of the frame that was on screen, whatever comes before it is written."""

from __future__ import annotations

import time
from dataclasses import dataclass, field
from pathlib import Path

import cv2
import numpy as np
import pytest

from app.enhancement.methods import MethodEnhancer
from app.exports.exporting import ExportRequest, export
from app.exports.replay.again import replay
from app.gui.actions import export_actions, live_actions
from app.gui.state.app_state import AppState
from app.gui.state.live_words import live_tags
from app.gui.update.live import follow_live
from app.gui.work.settings import Places, Settings
from app.live.address import LiveAddress, LiveInput
from app.live.newest import Newest
from app.live.picture import LivePicture, LiveSetting, LiveStatus, Signal
from app.live.session import Recipient
from app.live.sources.source import Wish
from enhance import LiveStatistics
from renderer.clip import ByteImage


@dataclass
class Shows:
    """A live session that gives the frames that a test puts in."""

    setting: LiveSetting = field(default_factory=lambda: LiveSetting(None))
    recipients: tuple[Recipient, ...] = ()
    pictures: Newest[LivePicture] = field(default_factory=Newest)
    signal: Signal = "live"
    made: int = 0
    enhancer: MethodEnhancer = field(default_factory=lambda: MethodEnhancer(LiveStatistics(half_life=5.0)))
    delays: list[LivePicture] = field(default_factory=list)

    def status(self) -> LiveStatus:
        return LiveStatus(self.signal, "", "", 0.0, self.made, self.made, 0, 0, 0.0, None, None)

    def shown(self, picture: LivePicture, at: float) -> None:
        self.delays.append(picture)

    def end(self) -> None:
        self.signal = "ended"

    def give(self, image: ByteImage) -> None:
        self.made += 1
        params, pixels = self.setting.params, self.setting.pixels
        if params is None:
            self.pictures.put(LivePicture(self.made, 0.0, image, None, self.setting, None, (), 0.0))
            return
        self.enhancer.show(image, pixels=pixels)
        made = self.enhancer.enhance(params)
        enhanced = np.asarray(made.image, np.uint8)
        self.pictures.put(
            LivePicture(self.made, 0.0, image, enhanced, self.setting, made.statistics, made.omitted, 0.0)
        )


def grey(level: int) -> ByteImage:
    """(H, W, 3): a smooth scene of about this level."""
    rows = np.linspace(-30, 30, 40)[:, None, None]
    columns = np.linspace(-20, 20, 48)[None, :, None]
    return np.clip(level + rows + columns + np.array([20, 0, -10]), 0, 255).astype(np.uint8)


@dataclass
class Live:
    """A window that shows it."""

    state: AppState
    session: Shows = field(default_factory=Shows)

    def see(self, image: ByteImage | None = None) -> None:
        if image is not None:
            self.session.give(image)
        follow_live(self.state, lambda source, setting: self.session)  # type: ignore[arg-type, return-value]

    def saved(self) -> ExportRequest:
        time.sleep(0.002)  # Names tell milliseconds apart, which no hand does.
        self.state.window.wishes = ()
        export_actions.save_picture(self.state)
        (request,) = (wish for wish in self.state.window.wishes if isinstance(wish, ExportRequest))
        return request


@pytest.fixture
def live(places: Places) -> Live:
    live = Live(AppState(places, Settings(acknowledged=True)))
    live_actions.go_live(live.state, LiveInput(LiveAddress("device", "0", "scope")), Wish())
    live.see()
    live.see()
    return live


def written(request: ExportRequest) -> Path:
    path = list(export(request))[-1].path
    assert path is not None
    return path


def holds(path: Path, image: ByteImage) -> bool:
    """The image stands somewhere on the page."""
    page = cv2.imread(str(path))[..., ::-1]
    height, width = image.shape[:2]
    places = ((y, x) for y in range(page.shape[0] - height + 1) for x in range(page.shape[1] - width + 1))
    return any(np.array_equal(page[y : y + height, x : x + width], image) for y, x in places)


def shown(live: Live) -> ByteImage:
    pictures = live.state.picture.pictures
    assert pictures is not None
    return pictures.original if pictures.enhanced is None else pictures.enhanced


@pytest.mark.parametrize("active", [False, True])
def test_what_is_saved_is_the_frame_on_screen_and_comes_again(
    live: Live, active: bool, tmp_path: Path
) -> None:
    live.state.enhancement.active = active
    live.see()
    seen: list[tuple[ExportRequest, ByteImage, ByteImage]] = []
    for level in (60, 110, 160):
        live.see(grey(level))
        seen.append((live.saved(), grey(level), shown(live).copy()))
    live.see(grey(200))
    files = [written(request) for request, *_ in seen]
    kept = [path.with_name(path.name.replace("-shown", "")) for path in files]
    assert len({*files, *kept}) == 6
    for number, (path, frame, (_, original, picture)) in enumerate(zip(files, kept, seen, strict=True)):
        assert holds(path, picture)
        assert np.array_equal(cv2.imread(str(frame))[..., ::-1], original)
        replayed = replay(path, (frame,), tmp_path / f"{number}.png")
        assert replayed.difference.is_none, replayed.sentence


def test_thawed_after_its_end_it_shows_the_last_frame_that_came(live: Live) -> None:
    live.state.enhancement.active = False
    live.see()
    live.see(grey(60))
    live_actions.toggle_freeze(live.state)
    live.see(grey(120))
    live.see(grey(180))
    assert live.state.live.unshown is None or live.state.live.unshown.number == 1
    live.session.signal = "ended"
    live.see()
    assert np.array_equal(shown(live), grey(60))
    live_actions.toggle_freeze(live.state)
    live.see()
    assert np.array_equal(shown(live), grey(180))
    assert any("last frame shown" in tag.text for tag in live_tags(live.state.live))
    assert live.session.delays == []
