"""The guide: its pages, how they are turned, and which of them F1 opens."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from imgui_bundle import imgui

import assets
from app.gui.actions import guide_actions
from app.gui.commands.commands import sections
from app.gui.commands.help_commands import panel_under_pointer
from app.gui.commands.keys import Keyboard
from app.gui.panels import guide
from app.gui.state.app_state import AppState
from app.gui.window import Window
from app.gui.work.settings import Places
from app.gui.work.shipped import Block, Guide, Page, parsed, read_guide
from tests.app.gui.conftest import outside
from tests.app.gui.driver import Driver, wait
from tests.app.gui.ui import Draw, Shown, Ui
from tests.test_words import old_phrases

MOST = 1_500_000
"""Bytes of all that is shipped to be looked at."""


@pytest.fixture
def pages() -> Guide:
    (made,) = read_guide(assets.guide_path())
    return made


@pytest.fixture
def reading(state: AppState, pages: Guide) -> AppState:
    state.guide.shown, state.guide.pages = True, pages
    return state


def keys(state: AppState) -> Draw:
    keyboard = Keyboard()

    def draw() -> None:
        guide.draw_guide(state, Shown())
        keyboard.handle(state, sections(state, outside()))

    return draw


def test_six_pages_each_with_an_image_and_few_words(pages: Guide) -> None:
    assert len(pages.pages) == guide_actions.COUNT
    for page in pages.pages:
        (image,) = (block for block in page.blocks if block.role == "image")
        assert image.text
        assert pages.images[image.name].shape[1] > 300
        words = sum(len(block.text.split()) for block in page.blocks)
        assert 40 < words < 190, page.title
        assert not [said for block in page.blocks for said in old_phrases(block.text)], page.title
    assert len({page.title for page in pages.pages}) == len(pages.pages)


def test_it_needs_no_network_and_little_room() -> None:
    folders = (assets.guide_path(), assets.welcome_path())
    files = [path for folder in folders for path in folder.iterdir()]
    assert {path.suffix for path in files} == {".md", ".jpg"}
    assert sum(path.stat().st_size for path in files) < MOST
    for path in assets.guide_path().glob("*.md"):
        assert not re.search(r"https?:|<", path.read_text(encoding="utf-8"))


def test_every_key_that_a_page_names_does_something(state: AppState, pages: Guide) -> None:
    """Chords with a modifier, which can be nothing else."""
    known = {key for section in sections(state, outside()) for one in section.commands for key in one.keys}
    text = " ".join(block.text for page in pages.pages for block in page.blocks)
    named = set(re.findall(r"(?:(?:Ctrl|Shift)\+)+(?!click)\w+", text))
    assert named
    assert named <= known


def test_the_little_of_markdown_that_pages_need() -> None:
    page = parsed("# Title\n\nTwo\nlines.\n\n![What is seen.](a.jpg)\n\n- one\n  goes on\n- two\n")
    assert page == Page(
        "Title",
        (
            Block("text", "Two lines."),
            Block("image", "What is seen.", "a.jpg"),
            Block("point", "one goes on"),
            Block("point", "two"),
        ),
    )


def test_pages_are_turned_by_keys_and_end_at_both_ends(ui: Ui, reading: AppState) -> None:
    draw, key = keys(reading), imgui.Key
    ui.frame(draw)
    for expected in (1, 2, 3, 4, 5, 5):
        ui.press(draw, key.page_down)
        assert reading.guide.page == expected
    ui.press(draw, key.page_up)
    assert reading.guide.page == 4
    assert reading.timeline.frame_index == 0  # The frames are not stepped.


def test_turning_pages_begins_no_walk_which_escape_would_end_first(ui: Ui, reading: AppState) -> None:
    ui.io.config_flags |= imgui.ConfigFlags_.nav_enable_keyboard
    draw = keys(reading)
    for _ in range(3):
        ui.frame(draw)
    ui.press(draw, imgui.Key.page_down)
    ui.press(draw, imgui.Key.page_down)
    assert reading.guide.page == 2
    ui.press(draw, imgui.Key.escape)
    assert not reading.guide.shown


def test_page_keys_do_nothing_while_the_guide_is_closed(ui: Ui, state: AppState) -> None:
    ui.press(keys(state), imgui.Key.page_down)
    assert state.guide.page == 0


@pytest.mark.parametrize(
    ("panel", "page"),
    [("Enhancement", 1), ("Reconstruction", 3), ("3D view", 4), ("Export", 5), ("Images", 2), ("", 3)],
)
def test_f1_opens_the_page_of_a_panel(state: AppState, panel: str, page: int) -> None:
    """Of none, the page where it was left."""
    state.guide.page = 3
    guide_actions.open_about(state, panel)
    assert (state.guide.shown, state.guide.page) == (True, page)


def test_with_nothing_open_the_pictures_panel_is_about_opening(state: AppState) -> None:
    state.source.clip = None
    guide_actions.open_about(state, "Images")
    assert state.guide.page == 0


def test_every_panel_has_a_page(places: Places) -> None:
    panels = {panel.label for panel in Window(AppState(places))._layout().dockable_windows}
    assert panels <= set(guide_actions.PAGES)
    assert {"Export", "Enhance files and folders"} <= set(guide_actions.PAGES)
    pages = {0, 2, *guide_actions.PAGES.values()}
    assert pages == set(range(guide_actions.COUNT))


def test_f1_looks_at_what_is_under_the_pointer(ui: Ui, state: AppState) -> None:
    names: list[str] = []

    def draw() -> None:
        with_child = imgui.begin_child("inside")
        imgui.end_child()
        names.append(panel_under_pointer() if with_child else "hidden")

    ui.io.add_mouse_pos_event(300, 300)
    for _ in range(3):
        ui.frame(draw)
    assert names[-1] == "panel"


def test_where_it_is_not_shipped_one_line_says_so(tmp_path: Path) -> None:
    with pytest.raises(Exception, match="pages of the guide"):
        list(read_guide(tmp_path))


@pytest.mark.display
def test_the_guide_is_read_in_the_window_by_mouse_and_keyboard(places: Places) -> None:
    driver = Driver(places)
    state, key = driver.state, imgui.Key

    def drive(ctx: imgui.test_engine.TestContext) -> None:
        ctx.mouse_move("//Reconstruction/###start")
        ctx.key_press(key.f1)
        wait(ctx, lambda: state.guide.pages is not None and state.guide.shown, "the guide")
        assert state.guide.page == 3
        ctx.yield_(3)
        ctx.item_click("//Guide/###next")
        ctx.yield_(2)
        assert state.guide.page == 4
        ctx.item_click("//Guide/**/6   Export and reproduce")
        ctx.yield_(2)
        assert state.guide.page == 5
        ctx.key_press(key.page_up)
        ctx.yield_(2)
        assert state.guide.page == 4
        ctx.key_press(key.f1)  # The pointer is on the guide.
        ctx.yield_(2)
        assert not state.guide.shown
        ctx.menu_click("//##MainMenuBar/Help/Guide")
        wait(ctx, lambda: state.guide.shown, "the guide from the menu")
        assert state.guide.page == 4
        ctx.yield_(2)
        ctx.key_press(key.escape)
        wait(ctx, lambda: not state.guide.shown, "its end")

    driver.run(drive)
