"""The first page: what was opened lately with small images, what to open, and how it fits."""

from __future__ import annotations

import shutil
import time
from collections.abc import Callable, Mapping
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import platformdirs
import pytest
from imgui_bundle import ImVec2, imgui

import assets
from app.files.image_files import read_image
from app.gui.actions import actions
from app.gui.panels import welcome
from app.gui.panels.overlays import BANNER, draw_banner
from app.gui.panels.welcome import SAMPLES, draw_welcome
from app.gui.session_file import SUFFIX, Session, SessionSource, write_session
from app.gui.state.app_state import AppState
from app.gui.style import widgets
from app.gui.style.widgets import end_of, shortened
from app.gui.update.channels import Channels
from app.gui.update.update import update
from app.gui.update.wishes import recents_wish
from app.gui.work.recents import SIDE, Recent, RecentsRequest, find_recents
from app.gui.work.settings import Places, Settings
from assets import phantom_path
from tests.app.gui.driver import Driver, wait
from tests.app.gui.ui import Draw, Shown, Ui
from tests.renderer.readers.numbered import encoded


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return tmp_path / "recent"


def found(folder: Path, *paths: Path) -> Mapping[str, Recent]:
    """When all images are there."""
    return list(find_recents(RecentsRequest(tuple(map(str, paths)), folder)))[-1]


def test_a_clip_has_a_small_image_that_is_kept(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    image = found(folder, phantom_path())[str(phantom_path())].image
    assert image is not None
    assert max(image.shape[:2]) <= SIDE
    frame = read_image(phantom_path() / "images" / "frame-000012.color.png")
    assert abs(float(image.mean()) - float(frame[..., :3].mean())) < 3
    (kept,) = folder.glob("*.jpg")
    # A second time nothing is opened.
    monkeypatch.setattr("app.gui.work.recents.open_case", None)
    again = found(folder, phantom_path())[str(phantom_path())].image
    assert again is not None
    assert np.abs(again.astype(int) - image).mean() < 3
    assert [kept] == list(folder.glob("*.jpg"))


def test_a_video_whose_pixels_are_not_square_has_an_image_in_its_shape(folder: Path, tmp_path: Path) -> None:
    """As of a box that records PAL: 540x576 for 4:3."""
    frames = [np.full((576, 540, 3), 90, np.uint8)] * 3
    video = encoded(tmp_path / "pal.mp4", frames, aspect=Fraction(64, 45))
    image = found(folder, video)[str(video)].image
    assert image is not None
    assert image.shape[:2] == (240, 320)


def test_a_video_with_a_damaged_middle_has_an_image_of_its_beginning(folder: Path, tmp_path: Path) -> None:
    video, parts = tmp_path / "changes.ts", []
    for name, shape in (("a.ts", (48, 64, 3)), ("b.ts", (80, 96, 3))):
        part = encoded(tmp_path / name, [np.full(shape, 90, np.uint8)] * 6)
        parts.append(part.read_bytes())
    video.write_bytes(b"".join(parts))
    image = found(folder, video)[str(video)].image
    assert image is not None
    assert image.shape == (48, 64, 3)


def test_a_clip_that_has_changed_gets_another_image(folder: Path, tmp_path: Path) -> None:
    frames, still = phantom_path() / "images", tmp_path / "still.png"
    shutil.copy(frames / "frame-000000.color.png", still)
    found(folder, still)
    before = {file.name for file in folder.glob("*.jpg")}
    still.write_bytes((frames / "frame-000009.color.png").read_bytes())
    found(folder, still)
    after = {file.name for file in folder.glob("*.jpg")}
    assert len(after) == 1
    assert after != before


def test_a_case_of_several_sizes_has_one_too(folder: Path, tmp_path: Path) -> None:
    case, frame = tmp_path / "case", cv2.imread(str(phantom_path() / "images" / "frame-000000.color.png"))
    case.mkdir()
    for number, size in enumerate(((64, 48), (48, 64), (40, 40))):
        cv2.imwrite(str(case / f"{number}.png"), cv2.resize(frame, size))
    image = found(folder, case)[str(case)].image
    assert image is not None
    assert image.shape == (64, 48, 3)


def test_runs_and_sessions_show_their_clip(folder: Path, runs: dict[str, Path], tmp_path: Path) -> None:
    saved = tmp_path / f"case{SUFFIX}"
    write_session(saved, replace(Session(), source=SessionSource(str(phantom_path()))))
    (tmp_path / "notes.txt").write_text("no image")
    table = found(folder, runs["original"], saved, tmp_path / "notes.txt")
    assert table[str(runs["original"])].kind == "run"
    assert table[str(runs["original"])].image is not None
    assert table[str(saved)].image is not None
    assert table[str(tmp_path / "notes.txt")].image is None


def test_what_is_gone_is_said_first_and_what_is_damaged_has_no_image(folder: Path, tmp_path: Path) -> None:
    damaged, gone = tmp_path / "damaged.mp4", tmp_path / "gone.mp4"
    damaged.write_bytes(b"no video")
    first = next(iter(find_recents(RecentsRequest((str(damaged), str(gone)), folder))))
    assert [first[str(path)].missing for path in (damaged, gone)] == [False, True]
    assert found(folder, damaged, gone)[str(damaged)].image is None


def test_a_place_that_cannot_be_looked_at_takes_no_image_from_the_others(folder: Path) -> None:
    closed = Path("/", 300 * "x")  # As a folder of another user, for whoever may look into all of them.
    table = found(folder, closed, phantom_path())
    assert (table[str(closed)].kind, table[str(closed)].missing) == ("clip", True)
    assert table[str(phantom_path())].image is not None


def test_session_files_that_cannot_be_read_stay_as_they_are(folder: Path, tmp_path: Path) -> None:
    newer, unsynced, notes = (tmp_path / f"{name}{SUFFIX}" for name in ("newer", "unsynced", "notes"))
    contents = {newer: b'{"schema": 2}', unsynced: b"", notes: b'{"notes": "all there is", "frame": -5}'}
    for path, content in contents.items():
        path.write_bytes(content)
    assert not any(recent.missing or recent.image for recent in found(folder, *contents).values())
    assert {path: path.read_bytes() for path in tmp_path.iterdir() if path.is_file()} == contents


def test_a_damaged_image_is_made_anew_and_a_full_disk_is_no_trouble(folder: Path, tmp_path: Path) -> None:
    found(folder, phantom_path())
    (kept,) = folder.glob("*.jpg")
    kept.write_bytes(b"damaged")
    assert found(folder, phantom_path())[str(phantom_path())].image is not None
    assert kept.stat().st_size > 100
    (tmp_path / "file").write_text("in the way")
    assert found(tmp_path / "file", phantom_path())[str(phantom_path())].image is not None


def test_images_of_what_is_not_remembered_go(places: Places) -> None:
    state, channels = AppState(places, Settings(recent=(str(phantom_path()),))), Channels()

    def turn() -> None:
        update(state, channels, 1.0)
        while channels.recents.run_waiting():
            pass

    turn()
    assert len(list(places.thumbnails.glob("*.jpg"))) == 1
    state.settings = state.settings.remembering(False)
    turn()
    assert not list(places.thumbnails.glob("*.jpg"))


def test_they_are_wished_for_on_the_first_page_alone(state: AppState) -> None:
    state.settings = replace(state.settings, recent=("/clips/a",))
    assert recents_wish(state) is None  # A clip is open.
    state.source.clip = None
    assert recents_wish(state) == RecentsRequest(("/clips/a",), state.places.thumbnails)


def test_what_is_gone_cannot_be_opened_and_the_rest_can(ui: Ui, state: AppState, tmp_path: Path) -> None:
    state.source.clip = None
    paths = (str(tmp_path / "gone.mp4"), str(phantom_path()))
    state.settings = replace(state.settings, recent=paths)
    state.welcome.recents = found(tmp_path / "recent", *map(Path, paths))
    shown, spots = Shown(), {}

    def draw() -> None:
        spots.clear()
        draw_welcome(state, shown)

    for place, path in enumerate(paths):
        ui.frame(draw)
        at = _middle(ui, draw, f"recent {place}")
        ui.drag(draw, at, at)
        opening = state.source.opening
        assert (None if opening is None else str(opening.path)) == (path if place else None)
    assert "recent 1" in shown.images
    assert "recent 0" not in shown.images


def _middle(ui: Ui, draw: Draw, item: str) -> tuple[float, float]:
    """Where an item lies, found by moving over the page."""
    for y in range(10, 700, 24):
        for x in range(10, 900, 40):
            ui.io.add_mouse_pos_event(x, y)
            ui.frame(draw)
            if imgui.get_current_context().hovered_id_previous_frame == _id(item):
                return float(x), float(y)
    raise AssertionError(f"no {item}")


def _id(item: str) -> int:
    window = imgui.internal.find_window_by_name("panel")
    return int(window.get_id(item))


@pytest.mark.parametrize("size", [(1260, 700), (900, 560), (560, 400), (300, 260)])
@pytest.mark.parametrize("recent", [0, 8])
def test_it_fits_and_nothing_reaches_over_the_edge(
    ui: Ui, state: AppState, size: tuple[int, int], recent: int
) -> None:
    """In width always; in height it scrolls where there is too little."""
    state.source.clip = None
    state.settings = replace(state.settings, recent=tuple(f"/cases/a long name {n}" for n in range(recent)))
    state.welcome.samples = {name: np.zeros((30, 48, 3), np.uint8) for name, *_ in SAMPLES}
    reached: list[tuple[float, float]] = []

    def draw() -> None:
        with_child = imgui.begin_child("middle", ImVec2(*size))
        assert with_child
        draw_welcome(state, Shown())
        window = imgui.internal.get_current_window()
        reached[:] = [(window.content_size.x, window.content_size.y)]
        imgui.end_child()

    for _ in range(3):
        ui.frame(draw)
    assert reached[0][0] <= size[0] + 1
    if size[1] >= 560:
        assert reached[0][1] <= size[1]


@pytest.mark.parametrize("width", [880, 1700])
def test_an_error_lies_above_the_title_and_all_is_in_the_middle(
    ui: Ui, state: AppState, monkeypatch: pytest.MonkeyPatch, width: float
) -> None:
    state.source.clip = None
    actions.fail(state, "expected a video, got a damaged one: " + "case/" * 60)
    ui.io.display_size = ImVec2(width, 560)
    lines: list[tuple[ImVec2, ImVec2]] = []

    def centered(text: str, *rest: Any) -> None:
        original(text, *rest)
        lines.append((imgui.get_item_rect_min(), imgui.get_item_rect_max()))

    original = widgets.centered
    monkeypatch.setattr(welcome, "centered", centered)

    def draw() -> None:
        lines.clear()
        imgui.begin_child("middle", ImVec2(width - 16, 540))
        draw_welcome(state, Shown())
        imgui.end_child()
        draw_banner(state)

    for _ in range(4):
        ui.frame(draw)
    banner = imgui.internal.find_window_by_name(BANNER)
    assert banner.size.y > 2 * imgui.get_font_size()
    assert lines[0][0].y >= banner.pos.y + banner.size.y
    middles = [(low.x + high.x) / 2 for low, high in lines]
    assert len(lines) == 3  # Title, icon, and what to drop.
    assert max(middles) - min(middles) < 2


def test_a_long_name_keeps_both_ends(ui: Ui) -> None:
    texts: list[str] = []
    ui.frame(lambda: texts.append(shortened("case 2024-11-03 right kidney 0017.mp4", 120)))
    assert texts[0].startswith("case")
    assert texts[0].endswith(".mp4")
    assert "…" in texts[0]


@pytest.mark.parametrize("short", [shortened, end_of])
def test_as_much_stays_as_there_is_room_for(ui: Ui, short: Callable[[str, float], str]) -> None:
    name, kept = "case 2024-11-03 right kidney 0017.mp4", set[int]()

    def draw() -> None:
        dots, whole = (round(imgui.calc_text_size(text).x) for text in ("…", name))
        for room in range(dots + 1, whole):
            text = short(name, room)
            assert imgui.calc_text_size(text).x <= room
            kept.add(len(text) - 1)

    ui.frame(draw)
    # A letter more in place of the dots may be narrower than these.
    assert kept >= set(range(1, len(name) - 2))


def test_they_lie_in_the_cache_folder_of_the_user(places: Places, monkeypatch: pytest.MonkeyPatch) -> None:
    """Those of settings elsewhere lie beside these, so that neither clears the other's."""
    for name in ("CONFIG", "RUNS", "PICTURES"):
        monkeypatch.delenv(f"VESSELSPLAT_{name}_DIR", raising=False)
    assert Places.of_user().thumbnails.parent == platformdirs.user_cache_path("vesselsplat", False)
    assert places.thumbnails.parent == places.config


def test_images_of_what_the_program_does_ship_with_it() -> None:
    names = {path.name for path in assets.welcome_path().glob("*.jpg")}
    assert names == {name for name, *_ in SAMPLES}


@pytest.mark.display
def test_the_first_page_leads_from_an_empty_window_to_the_built_in_clip(
    places: Places, tmp_path: Path
) -> None:
    still = tmp_path / "still.png"
    shutil.copy(phantom_path() / "images" / "frame-000003.color.png", still)
    driver = Driver(places, Settings(acknowledged=True, recent=(str(still), "/gone.mp4")))
    state = driver.state

    def drive(ctx: imgui.test_engine.TestContext) -> None:
        wait(ctx, lambda: len(state.welcome.samples) == len(SAMPLES), "the images of the page")

        def is_there() -> bool:
            recents = state.welcome.recents
            return str(still) in recents and recents[str(still)].image is not None

        wait(ctx, is_there, "the image of the recent case")
        began = time.monotonic()
        ctx.item_click("//Images/**/recent 0")
        wait(ctx, lambda: state.source.path == still, "the recent case")
        assert time.monotonic() - began < 10

    driver.run(drive)
    assert len(list(places.thumbnails.glob("*.jpg"))) == 1
