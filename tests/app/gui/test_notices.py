"""What a video is read as, where its image is: one line each, until it has been read."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from imgui_bundle import imgui
from PIL import Image

from app.gui.actions import arriving, clip_actions, depth_actions
from app.gui.panels import compare
from app.gui.state.app_state import AppState
from app.gui.style import widgets
from app.gui.work.depths import DepthRequest
from app.gui.work.opening import Opened, OpenRequest, open_path
from renderer.clip import Clip
from renderer.readers.clip_options import ClipOptions
from tests.app.gui.conftest import make_clip
from tests.app.gui.ui import Ui

SAID = ("interlaced video: deinterlaced, one image per frame", "the frame rate varies")


def test_they_stand_above_the_images_until_they_have_been_read(
    ui: Ui, state: AppState, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    texts: list[str] = []
    note = widgets.note
    monkeypatch.setattr(compare, "note", lambda text, *given: (texts.append(text), note(text, *given)))
    spots: list[tuple[float, float]] = []
    press = widgets.button

    def button(label: str, *given: object, **named: object) -> bool:
        pressed = press(label, *given, **named)  # type: ignore[arg-type]
        if label.endswith("##notices"):
            low, high = imgui.get_item_rect_min(), imgui.get_item_rect_max()
            spots.append(((low.x + high.x) / 2, (low.y + high.y) / 2))
        return pressed

    monkeypatch.setattr(compare, "button", button)
    clip = replace(make_clip(tmp_path / "scope.mp4"), format="video", notices=SAID)
    arriving.show_opened(state, clip.path, Opened(clip, bare=clip, notices=clip.notices))

    def draw() -> None:
        compare._draw_notices(state)

    ui.frame(draw)
    assert texts == ["Interlaced video: deinterlaced, one image per frame.", "The frame rate varies."]
    ui.drag(draw, spots[0], spots[0])
    texts.clear()
    ui.frame(draw)
    assert texts == []
    assert list(state.window.log)[:2] == list(SAID)
    # A warning stands above the images already, and of folders what is left out is for the log.
    warned = Opened(clip, bare=clip, notices=clip.notices, warning=SAID[0])
    assert warned.to_be_read == SAID[1:]
    assert Opened(replace(clip, format="images")).to_be_read == ()


def test_of_one_image_it_is_said_that_it_is_the_first_of_several(tmp_path: Path) -> None:
    path = tmp_path / "moves.png"
    pages = [Image.new("RGB", (32, 24), (200, shade, 90)) for shade in (60, 90, 120)]
    pages[0].save(path, save_all=True, append_images=pages[1:])
    (found,) = open_path(OpenRequest(path))
    assert found.to_be_read == ("of a file with several images only the first is read: moves.png of 3",)


def test_with_another_depth_they_say_what_is_true_of_it(state: AppState, tmp_path: Path) -> None:
    def video(*notices: str) -> Clip:
        return replace(make_clip(tmp_path / "scope.mp4"), format="video", notices=notices)

    def take(clip: Clip, baseline: float) -> None:
        request = DepthRequest(bare, ClipOptions(baseline=baseline))
        state.source.depth_wish = request
        depth_actions.take_depth(state, request, clip)

    bare = video(*SAID)
    unknown = video(*SAID, "with an unknown baseline")
    arriving.show_opened(state, bare.path, Opened(unknown, bare=bare, notices=unknown.notices))
    take(video(*SAID, "4.5 mm apart"), 4.5)
    assert state.source.notices == (*SAID, "4.5 mm apart")
    # Those that have been read do not come back, and what is new is shown.
    clip_actions.dismiss_notices(state)
    take(video(*SAID, "5 mm apart"), 5.0)
    assert state.source.notices == ("5 mm apart",)
    take(replace(bare, format="images"), 5.5)
    assert state.source.notices == ()
