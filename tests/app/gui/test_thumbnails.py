"""The menu of presets shows what each makes of the frame on screen."""

from __future__ import annotations

import numpy as np
import pytest
from imgui_bundle import ImVec2, hello_imgui, imgui

from app.enhancement.frame_enhancer import PictureMaker, PictureRequest
from app.gui.panels.enhancement import draw_presets
from app.gui.state.app_state import AppState
from app.gui.style import fonts
from app.gui.update.channels import Channels
from app.gui.update.update import update
from app.gui.update.wishes import thumbnails_wish
from app.gui.views.picture_view import PictureView
from app.gui.work.presets import BUILT_IN
from app.gui.work.thumbnails import SIDE, ThumbnailsRequest, make_thumbnails, smaller
from enhance import EnhanceParams, VesselParams, enhance
from renderer.clip import ByteImage, Clip
from tests.app.gui.ui import Shown, Ui


def test_they_are_small_pictures_of_each_setting(clip: Clip) -> None:
    pictures = list(PictureMaker().make(PictureRequest(clip, 1, EnhanceParams())))[-1]
    (made,) = make_thumbnails(ThumbnailsRequest(pictures, tuple(BUILT_IN.items())))
    assert set(made.images) == set(BUILT_IN)
    height, width = pictures.original.shape[:2]
    factor = min(1.0, SIDE / max(height, width))
    for image in made.images.values():
        assert image.shape == (round(factor * height), round(factor * width), 3)
    looks = {image.tobytes() for image in made.images.values()}
    assert len(looks) >= len(BUILT_IN) - 1  # Paper's automatic d may be 1.
    if factor == 1:
        expected = enhance(pictures.original, smaller(EnhanceParams(), 1.0)).image  # type: ignore[arg-type]
        assert np.array_equal(made.images["Paper"], expected)


def test_windows_shrink_with_the_picture_and_stay_in_their_ranges() -> None:
    assert smaller(EnhanceParams(radii=(4, 16, 64)), 0.25) == EnhanceParams(radii=(1, 4, 16), subsample=1)
    assert smaller(EnhanceParams(radii=(4, 16)), 0.01) == EnhanceParams(radii=(1, 1), subsample=1)
    assert smaller(VesselParams(radius=16), 0.25) == VesselParams(radius=4)
    assert smaller(VesselParams(radius=16), 0.01) == VesselParams(radius=2)


def test_they_are_made_while_the_menu_is_open_and_once(opened: AppState) -> None:
    assert thumbnails_wish(opened) is None
    opened.enhancement.choosing = True
    channels = Channels()
    for _ in range(4):
        update(opened, channels, 0.0)
        while channels.thumbnails.run_waiting():
            pass
    first = opened.enhancement.thumbnails
    assert first is not None
    assert set(first.images) == set(BUILT_IN)
    for _ in range(3):
        update(opened, channels, 1.0)
        assert not channels.thumbnails.run_waiting()


def test_names_with_hashes_are_shown_whole(ui: Ui, opened: AppState, monkeypatch: pytest.MonkeyPatch) -> None:
    own = ui.io.fonts.add_font_from_file_ttf(hello_imgui.asset_file_full_path(fonts.OWN), 15)
    names, shown = ("a##1", "##b", "c###", "d #"), list[float]()
    opened.enhancement.presets = {name: VesselParams(strength=place / 10) for place, name in enumerate(names)}
    opened.enhancement.params = opened.enhancement.presets["##b"]
    combo, line = imgui.begin_combo, imgui.selectable

    def see(label: str) -> None:
        shown.append(imgui.calc_text_size(label, hide_text_after_double_hash=True).x)

    def seen_combo(label: str, preview: str, flags: int) -> bool:
        see(preview)
        return combo(label, preview, flags)

    def seen_line(label: str, chosen: bool, *, size: ImVec2) -> tuple[bool, bool]:
        see(label)
        return line(label, chosen, size=size)

    def draw() -> None:
        imgui.push_font(own, 15)
        shown.clear()
        draw_presets(opened, Shown())
        whole = [imgui.calc_text_size(name).x for name in ("##b", *BUILT_IN, *sorted(names))]
        assert shown in (whole, whole[:1])
        imgui.pop_font()

    monkeypatch.setattr(imgui, "begin_combo", seen_combo)
    monkeypatch.setattr(imgui, "selectable", seen_line)
    ui.frame(draw)
    ui.drag(draw, (300, 20), (300, 20))
    ui.frame(draw)
    assert len(shown) == 1 + len(BUILT_IN) + len(names)


def test_they_have_the_shape_of_the_frame_on_screen(
    ui: Ui, opened: AppState, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Where pixels are not square, as of a box that records PAL."""
    shapes: set[float] = set()
    monkeypatch.setattr(
        "app.gui.panels.enhancement.draw_small", lambda *_, **how: shapes.update(how.values())
    )
    opened.picture.view = PictureView(pixel_aspect=1.5)
    for _ in range(2):
        ui.drag(lambda: draw_presets(opened, Shown()), (300, 20), (300, 20))
    assert shapes == {1.5}


@pytest.mark.parametrize("aside", [0.0, 120.0], ids=["picture", "name"])
def test_a_click_on_picture_or_name_chooses(ui: Ui, opened: AppState, aside: float) -> None:
    assert opened.picture.pictures is not None
    (made,) = make_thumbnails(ThumbnailsRequest(opened.picture.pictures, tuple(BUILT_IN.items())))
    opened.enhancement.thumbnails = made
    spots: dict[str, tuple[float, float]] = {}

    class Spots(Shown):
        def whole(self, slot: str, image: ByteImage) -> imgui.ImTextureRef:
            low, high = imgui.get_item_rect_min(), imgui.get_item_rect_max()
            spots[slot] = ((low.x + high.x) / 2, (low.y + high.y) / 2)
            return super().whole(slot, image)

    def draw() -> None:
        draw_presets(opened, Spots())

    ui.frame(draw)
    ui.drag(draw, (300, 20), (300, 20))
    ui.frame(draw)
    assert opened.enhancement.choosing
    x, y = spots["preset Gentle"]
    ui.drag(draw, (x + aside, y), (x + aside, y))
    ui.frame(draw)
    assert opened.enhancement.params == BUILT_IN["Gentle"]
    assert not opened.enhancement.choosing
