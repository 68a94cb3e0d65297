"""Single images: a folder of several sizes as one case, and the images beside one that is open."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from imgui_bundle import icons_fontawesome_4 as icons
from imgui_bundle import imgui
from PIL import Image

from app.gui.actions import (
    actions,
    clip_actions,
    depth_actions,
    enhancement_actions,
    export_actions,
    job_actions,
)
from app.gui.actions.export_lacks import ONE_IMAGE
from app.gui.actions.export_names import default_name
from app.gui.commands.commands import sections
from app.gui.commands.keys import chord
from app.gui.panels.timeline import in_folder
from app.gui.state.exports import What
from app.gui.state.panes import pane
from app.gui.work.neighbours import Neighbours
from app.gui.work.settings import Places
from app.gui.work.strip import CROSS, DAMAGED, GROUND, HEIGHT, StripRequest, make_strip
from enhance import EnhanceParams
from renderer.clip import ClipError
from renderer.sources import open_case, open_clip
from tests.app.gui.conftest import outside
from tests.app.gui.driver import Driver, is_settled, wait
from tests.app.gui.test_reconstruction_choices import opened, turn

SIZES = {"view.png": (80, 40), "1.png": (60, 40), "2.png": (40, 60), "10.jpg": (48, 48)}
"""In their order."""


def write_image(path: Path, size: tuple[int, int]) -> None:
    pixels = np.full((size[1], size[0], 3), (180, 110, 90), np.uint8)
    pixels[:, size[0] // 2 :] = (120, 60, 50)
    Image.fromarray(pixels).save(path)


@pytest.fixture
def case(tmp_path: Path) -> Path:
    """Four images of several sizes, and two files that are none, one of them a mask by its name."""
    folder = tmp_path / "case"
    folder.mkdir()
    for name, size in SIZES.items():
        write_image(folder / name, size)
    (folder / "3.png").write_text("no image")
    write_image(folder / "1_mask.png", (60, 40))
    return folder


def test_a_folder_of_several_sizes_is_a_case(places: Places, case: Path) -> None:
    state, channels = opened(places, case)
    clip = state.source.clip
    assert clip is not None
    assert clip.labels == tuple(SIZES)
    assert state.window.banner is not None
    assert state.window.banner.message == "left out, not readable: 3.png"
    enhancement_actions.set_params(state, EnhanceParams(z=0.3))
    for name, size in SIZES.items():
        turn(state, channels)
        shown = state.picture.pictures
        assert shown is not None
        assert clip.labels[shown.request.frame_index] == name
        assert shown.request.params == EnhanceParams(z=0.3)  # One setting for all.
        assert shown.enhanced is not None
        assert shown.original.shape == shown.enhanced.shape == (size[1], size[0], 3)
        actions.step(state, 1)


def test_it_is_not_trained_on_and_makes_no_video(places: Places, case: Path) -> None:
    state, channels = opened(places, case)
    turn(state, channels)
    said = "The images differ in size, so they are no recording to reconstruct."
    assert job_actions.why_not_reconstruct(state) == depth_actions.said(state) == said
    for way in ("measured", "stereo", "guessed"):
        assert depth_actions.why_not(state, way) == said  # type: ignore[arg-type]
    assert "differ in size" in export_actions.why_not_export(state, "video of both panes")
    (case / "3.png").unlink()
    with pytest.raises(ClipError, match="one size"):
        open_clip(case)


def test_small_images_keep_their_shape(case: Path) -> None:
    clip = open_case(case)
    *_, strip = make_strip(StripRequest(clip, 4))
    width = strip.image.shape[1] // 4
    for place, (columns, rows) in enumerate(SIZES.values()):
        tile = strip.image[:, place * width : (place + 1) * width]
        covered = tile.max(axis=2) > 50
        scale = min(HEIGHT / rows, width / columns)
        assert covered.any(axis=0).sum() == pytest.approx(columns * scale, abs=1)
        assert covered.any(axis=1).sum() == pytest.approx(rows * scale, abs=1)


def test_a_damaged_still_stands_out_in_the_strip(case: Path) -> None:
    clip = open_case(case)
    (case / "2.png").write_bytes(b"damaged")
    *_, strip = make_strip(StripRequest(clip, 4))
    width = strip.image.shape[1] // 4
    tiles = [strip.image[:, place * width : (place + 1) * width] for place in range(4)]
    (damaged,) = (tile for tile in tiles if (tile == DAMAGED).all(axis=2).mean() > 0.5)
    assert damaged.min() - GROUND > 50  # From edge to edge.
    assert damaged.max() == CROSS


def test_a_damaged_still_is_not_said_to_be_updating(places: Places, case: Path) -> None:
    state, channels = opened(places, case)
    turn(state, channels)
    (case / "2.png").write_bytes(b"damaged")
    for index, said in ((2, True), (1, False)):
        actions.seek(state, index)
        turn(state, channels)
        assert state.picture.pictures is not None
        tags = " | ".join(tag.text for tag in pane(state, state.picture.pictures, "right").tags)
        assert ("FRAME 3 CANNOT BE READ" in tags) == said
        assert "UPDATING" not in tags
        assert (state.picture.pictures.request.frame_index == index) != said


def test_of_one_size_it_is_a_recording_as_ever(tmp_path: Path) -> None:
    for name in ("1.png", "2.png"):
        write_image(tmp_path / name, (40, 30))
    assert open_case(tmp_path).why_no_depth == ""
    (tmp_path / "2.png").write_text("no image")
    with pytest.raises(ClipError, match=r"2\.png"):
        open_case(tmp_path)


def test_what_is_on_and_back() -> None:
    a, b, c = (Path(name) for name in "abc")
    found = Neighbours((a, b, c))
    assert found.onward(a, 1) == (b, c)
    assert found.onward(a, 10) == (c,)
    assert found.onward(c, -1) == (b, a)
    assert found.onward(b, -10) == (a,)
    assert found.onward(c, 1) == found.onward(a, -1) == found.onward(Path("d"), 1) == ()
    assert found.from_end(a, last=True) == (c, b)
    assert found.from_end(c, last=False) == (a, b)
    assert found.from_end(c, last=True) == found.from_end(a, last=False) == ()
    assert found.from_end(Path("d"), last=True) == ()


def test_a_single_image_is_no_video_and_nothing_of_it_is_numbered_or_trimmed(
    places: Places, case: Path
) -> None:
    state, channels = opened(places, case / "2.png")
    turn(state, channels)
    whats: tuple[What, ...] = ("video of the panes", "video of the right pane", "video of both panes")
    for what in whats:
        assert export_actions.why_not_export(state, what) == ONE_IMAGE
    assert default_name(state, "measures of both panes") == "2-measures"
    assert clip_actions.why_not_trimmed(state) == "A single image has no other frames."
    trims = [one for part in sections(state, outside()) for one in part.commands if "trim" in one.synonyms]
    assert [one.applies(state) for one in trims] == [False, False]


def test_a_single_image_gives_way_to_the_next_in_its_folder(places: Places, case: Path) -> None:
    state, channels = opened(places, case / "2.png")
    turn(state, channels)
    assert in_folder(state) == "3 of 5 in this folder"
    recent = state.settings.recent
    enhancement_actions.set_params(state, EnhanceParams(z=0.3))
    actions.step(state, 1)  # Past 3.png.
    turn(state, channels)
    assert state.source.path == case / "10.jpg"
    assert in_folder(state) == "5 of 5 in this folder"
    assert state.window.banner is not None
    assert state.window.banner.message == "passed over, not readable: 3.png"
    assert state.enhancement.params == EnhanceParams(z=0.3)
    assert state.settings.recent == recent
    actions.step(state, -10)
    turn(state, channels)
    assert state.source.path == case / "view.png"
    actions.step(state, -1)
    assert state.source.opening is None
    for last, name in ((True, "10.jpg"), (True, "10.jpg"), (False, "view.png")):
        actions.go_to_end(state, last=last)
        turn(state, channels)
        assert state.source.path == case / name


def test_an_image_alone_in_its_folder_has_none_beside_it(places: Places, tmp_path: Path) -> None:
    write_image(tmp_path / "one.png", (40, 30))
    state, channels = opened(places, tmp_path / "one.png")
    turn(state, channels)
    assert in_folder(state) == ""
    actions.step(state, 1)
    assert state.source.opening is None


@pytest.mark.display
def test_arrows_go_through_a_folder(places: Places, case: Path) -> None:
    driver = Driver(places, opens=case / "1.png")
    state = driver.state

    def at(name: str) -> bool:
        return state.source.path == case / name and is_settled(state) and state.source.place is not None

    def drive(ctx: imgui.test_engine.TestContext) -> None:
        wait(ctx, lambda: at("1.png"), "the first image")
        ctx.key_press(chord("Right"))
        wait(ctx, lambda: at("2.png"), "the second one")
        ctx.item_click(f"//**/{icons.ICON_FA_STEP_FORWARD}##on")
        wait(ctx, lambda: at("10.jpg"), "the one past what is no image")
        ctx.key_press(chord("Left"))
        wait(ctx, lambda: at("2.png"), "the second one again")

    driver.run(drive)
