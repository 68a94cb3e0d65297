"""The window without its drawing, exporting, and what is looked at in the files."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import cv2

from app.exports.replay.again import replay
from app.gui.actions import actions, export_actions
from app.gui.state.app_state import AppState
from app.gui.state.exports import What
from app.gui.update.channels import Channels
from app.gui.update.update import update
from app.gui.work.settings import Places, Settings
from tests.app.gui.settling import served


def sidecar(path: Path) -> dict[str, Any]:
    """What a file says of itself beside it."""
    facts: dict[str, Any] = json.loads(path.with_name(f"{path.name}.json").read_text())
    return facts


def shape_of(video: Path) -> tuple[int, int, int]:
    """Of its frames."""
    capture = cv2.VideoCapture(str(video))
    _, frame = capture.read()
    capture.release()
    height, width, channels = frame.shape
    return height, width, channels


class Exporter:
    """The window without its drawing."""

    def __init__(self, places: Places, path: Path) -> None:
        self.state, self.channels = AppState(places, Settings(acknowledged=True)), Channels()
        actions.open_path(self.state, path)
        self.turn(8)
        # A view so small that it is drawn in no time.
        self.state.scene.size = (48, 36)

    def turn(self, frames: int = 4) -> None:
        for _ in range(frames):
            update(self.state, self.channels, self.state.window.now + 0.01)
            for channel in served(self.channels):
                channel.run_waiting()

    def rest(self) -> None:
        """Until the statistics of the clip are known, and what is enhanced with them is shown."""
        for _ in range(200):
            self.turn(2)
            wanted = self.state.picture_request
            if wanted is not None and wanted.of_clip != "later" and not self.state.pictures_wait:
                return
        raise AssertionError("expected the statistics of the clip to be known")

    def begin(self, what: What) -> None:
        request = export_actions.export_request(self.state, what)
        assert request is not None
        self.channels.exports.ask(request)

    def made(self, what: What) -> Path:
        """The file, once it is written."""
        before = set(self.state.places.pictures.glob("*"))
        self.begin(what)
        for _ in range(100):
            self.turn(1)
            if self.state.exports.under_way is None:
                break
        assert self.state.window.banner is None
        new = set(self.state.places.pictures.glob("*")) - before
        return next(path for path in new if path.suffix in (".png", ".mp4", ".csv"))


def same(path: Path, *sources: Path) -> bool:
    return replay(path, sources, path.with_name(f"again{path.suffix}")).difference.is_none


def exported(run: Exporter, what: What) -> Path:
    """As the button in the panel does it."""
    before = run.state.exports.count
    export_actions.choose_what(run.state, what)
    export_actions.start(run.state)
    for _ in range(100):
        run.turn(1)
        if run.state.exports.count > before:
            break
    assert run.state.window.banner is None
    assert run.state.exports.last is not None
    return run.state.exports.last
