"""The images keep their share of a window that was larger before."""

from __future__ import annotations

import re
from pathlib import Path

import glfw
import pytest
from imgui_bundle import ImVec2, glfw_utils, hello_imgui, imgui

from app.gui.actions import actions, presenting
from app.gui.frame import dockings
from app.gui.state.app_state import AppState
from app.gui.work import kept_layout
from app.gui.work.settings import Places
from assets import phantom_path
from renderer.gaussians import DynamicGaussians
from tests.app.gui.conftest import start_live
from tests.app.gui.driver import Driver, is_settled, wait
from tests.app.gui.test_layouts import kept
from tests.app.gui.test_stills import write_image

Context = imgui.test_engine.TestContext
LARGE, SMALL = (2560, 1900), (1280, 720)


def resize(ctx: Context, size: tuple[int, int]) -> None:
    glfw.set_window_size(glfw_utils.glfw_window_hello_imgui(), *size)
    wait(ctx, lambda: (*imgui.get_main_viewport().size,) == size, "the size")
    ctx.yield_(4)


def show(ctx: Context, state: AppState, path: Path, layout: str) -> None:
    actions.open_path(state, path)
    wait(ctx, lambda: state.source.path == path and is_settled(state), path.name)
    wait(ctx, lambda: hello_imgui.current_layout_name() == layout, "its layout")
    ctx.yield_(6)


def share_below(ctx: Context, state: AppState, model: DynamicGaussians) -> float:
    """That of the 3D view, which appears now."""
    start_live(state, model)
    wait(ctx, lambda: state.scene.view is not None, "the 3D view")
    ctx.yield_(4)
    view, images = (ctx.window_info(f"//{name}").window.size.y for name in ("3D view", "Images"))
    return float(view / (view + images))


def leave(state: AppState) -> None:
    """With nothing that asks whether it is to go on."""
    state.window.closing = "agreed"


@pytest.mark.display
@pytest.mark.parametrize("density", [1, 2])
def test_a_layout_of_a_larger_window_fits_the_next_one(
    places: Places, model: DynamicGaussians, density: int
) -> None:
    def first(ctx: Context, state: AppState) -> None:
        show(ctx, state, phantom_path(), "Default")
        resize(ctx, LARGE)

    def again(ctx: Context, state: AppState) -> None:
        assert imgui.get_main_viewport().size.y < LARGE[1] / 2
        show(ctx, state, phantom_path(), "Default")
        assert share_below(ctx, state, model) == pytest.approx(0.52, abs=0.02)
        leave(state)

    kept(places, first)
    layout = places.config / kept_layout.NAME
    layout.write_text(
        layout.read_text().replace("DpiWindowSizeFactor=1\n", f"DpiWindowSizeFactor={density}\n")
    )
    kept_layout.seal(layout)
    kept(places, again)


@pytest.mark.display
def test_a_window_that_ends_in_a_presentation_leaves_the_images_their_share(
    places: Places, tmp_path: Path
) -> None:
    still, heights = tmp_path / "still.png", list[tuple[float, float]]()
    write_image(still, (64, 48))

    def sizes(ctx: Context, state: AppState) -> None:
        show(ctx, state, still, "Stills")
        if not dockings.is_shown("Notes"):
            dockings.toggle("Notes")
        ctx.yield_(6)
        images, notes = (ctx.window_info(f"//{name}").window.size.y for name in ("Images", "Notes"))
        heights.append((float(images), float(notes)))

    def first(ctx: Context, state: AppState) -> None:
        sizes(ctx, state)
        presenting.show(state, "right")
        ctx.yield_(6)
        leave(state)

    def again(ctx: Context, state: AppState) -> None:
        sizes(ctx, state)
        leave(state)

    kept(places, first)
    kept(places, again)
    assert heights[1] == pytest.approx(heights[0], abs=4)


@pytest.mark.display
def test_a_layout_that_has_squeezed_the_images_already_leaves_them_room(
    places: Places, model: DynamicGaussians
) -> None:
    def first(ctx: Context, state: AppState) -> None:
        show(ctx, state, phantom_path(), "Default")

    def again(ctx: Context, state: AppState) -> None:
        show(ctx, state, phantom_path(), "Default")
        assert share_below(ctx, state, model) == pytest.approx(dockings.MOST, abs=0.02)
        leave(state)

    kept(places, first)
    layout = places.config / kept_layout.NAME
    squeezed, count = re.subn(r"(ID=0x00000006 .*SizeRef=\d+),\d+", r"\1,1169", layout.read_text())
    assert count == 1
    layout.write_text(squeezed)
    kept_layout.seal(layout)
    kept(places, again)


@pytest.mark.display
def test_the_layout_of_other_content_fits_a_window_that_has_changed_meanwhile(
    places: Places, model: DynamicGaussians, still: Path
) -> None:
    def drive(ctx: Context, state: AppState) -> None:
        show(ctx, state, phantom_path(), "Default")
        show(ctx, state, still, "Stills")
        resize(ctx, LARGE)
        show(ctx, state, phantom_path(), "Default")
        assert share_below(ctx, state, model) == pytest.approx(0.52, abs=0.02)
        leave(state)

    kept(places, drive)


@pytest.mark.display
def test_the_images_keep_their_share_after_text_so_large_that_panels_were_arranged_anew(
    places: Places, model: DynamicGaussians
) -> None:
    def drive(ctx: Context, state: AppState) -> None:
        show(ctx, state, phantom_path(), "Default")
        resize(ctx, SMALL)
        for percent in (200, 100):
            actions.choose_text_size(state, percent)
            ctx.yield_(8)
        assert share_below(ctx, state, model) == pytest.approx(0.52, abs=0.02)
        leave(state)

    kept(places, drive)


@pytest.mark.display
def test_controls_keep_their_width_in_a_larger_window_and_leave_room_in_a_smaller_one(places: Places) -> None:
    driver = Driver(places)

    def drive(ctx: Context) -> None:
        def width() -> float:
            return float(ctx.window_info("//Enhancement").window.size.x)

        def move_to(width: float) -> None:
            column = imgui.internal.find_window_by_name("Enhancement").dock_node.parent_node
            imgui.internal.dock_builder_set_node_size(column.id_, ImVec2(width, column.size.y))
            ctx.yield_(4)

        show(ctx, driver.state, phantom_path(), "Default")
        resize(ctx, SMALL)
        before = width()
        resize(ctx, LARGE)
        assert width() == before
        move_to(1200)
        assert width() == 1200
        resize(ctx, SMALL)
        assert width() == pytest.approx(max(1200 / LARGE[0], dockings.MOST) * SMALL[0], abs=1)
        resize(ctx, LARGE)
        move_to(0.6 * LARGE[0])
        resize(ctx, SMALL)
        assert width() == pytest.approx(0.6 * SMALL[0], abs=1)
        leave(driver.state)

    driver.run(drive)
