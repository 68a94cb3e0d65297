"""What keeps the window from opening is one line; what it can do without, it does without."""

from __future__ import annotations

import ctypes
import os
import signal
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import glfw
import pytest
from imgui_bundle import hello_imgui, imgui, immapp

from app.commands import demo
from app.errors import UserError
from app.gui.actions import actions
from app.gui.frame import dockings, starting
from app.gui.frame.dockings import REPORT
from app.gui.state.app_state import AppState
from app.gui.update.channels import Channels
from app.gui.update.update import update
from app.gui.window import Window
from app.gui.work import kept_layout
from app.gui.work.settings import Places, Settings
from assets import phantom_path
from renderer.view_files import Views, views_json
from tests.app.gui.driver import Driver, is_settled, wait


def broken(*arguments: object) -> None:
    raise RuntimeError("no such display")


def test_a_window_that_cannot_open_is_the_user_s_to_know(
    places: Places, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(immapp, "run", broken)
    with pytest.raises(UserError, match=r"OpenGL 3\.3.*no such display"):
        Window(AppState(places)).run()


def test_an_error_of_an_open_window_stays_a_bug(places: Places, monkeypatch: pytest.MonkeyPatch) -> None:
    window = Window(AppState(places))
    monkeypatch.setattr(window, "_canvas", object())
    monkeypatch.setattr(immapp, "run", broken)
    with pytest.raises(RuntimeError, match="no such display"):
        window.run()


@pytest.mark.skipif(sys.platform != "linux", reason="elsewhere there is always a screen")
def test_a_display_that_is_gone_is_one_line(tmp_path: Path) -> None:
    gone = {"DISPLAY": ":4095", "VESSELSPLAT_CONFIG_DIR": str(tmp_path)}
    environment = {name: value for name, value in os.environ.items() if name != "WAYLAND_DISPLAY"} | gone
    command = [sys.executable, "-m", "app", "gui"]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 2
    assert "Traceback" not in done.stderr
    *_, last = done.stderr.splitlines()
    wanted = "vesselsplat: expected a display with OpenGL 3.3 for the window"
    assert last == f"{wanted}, got none that opens (DISPLAY=:4095)"


@pytest.mark.parametrize(
    ("told", "said"),
    [
        (
            'IM_ASSERT( false && "Failed to create temporary window." ) --- opengl_setup_glfw.cpp:27',
            "one without",
        ),
        ("no such display", "an error: no such display"),
    ],
)
def test_a_display_without_opengl_is_named_in_plain_words(told: str, said: str) -> None:
    assert starting.why_none_opens(RuntimeError(told)).endswith(f"for the window, got {said}")


def test_the_demo_s_results_are_there_without_a_window(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("VESSELSPLAT_CONFIG_DIR", str(tmp_path / "config"))
    monkeypatch.setattr(immapp, "run", broken)
    demo._open(tmp_path / "run")
    assert "no such display" in capsys.readouterr().err


def test_the_layout_is_kept_only_where_it_can_be(places: Places, tmp_path: Path) -> None:
    params = Window(AppState(places)).runner_params()
    assert not params.ini_disable
    assert Path(params.ini_filename).parent == places.config
    (tmp_path / "file").write_text("in the way")
    nowhere = Places(tmp_path / "file", places.runs, places.pictures)
    assert Window(AppState(nowhere)).runner_params().ini_disable


def test_only_a_layout_that_a_window_has_left_is_read_again(places: Places) -> None:
    layout = places.config / kept_layout.NAME
    assert not Window(AppState(places)).runner_params().ini_disable  # There is none yet.
    layout.write_text("[Docking][Data]")
    kept_layout.seal(layout)
    assert not Window(AppState(places)).runner_params().ini_disable
    assert layout.exists()
    for content in (b"[Docking][Data] ", b"", b"\0" * 2_000_000):
        layout.write_bytes(content)
        state = AppState(places)
        assert not Window(state).runner_params().ini_disable
        assert not layout.exists()
        assert layout.with_name("window.ini.damaged").read_bytes() == content
        assert "the standard one is used" in state.window.log[-1]


def test_a_panel_stays_where_it_was_under_its_former_title(places: Places) -> None:
    layout = places.config / kept_layout.NAME
    layout.parent.mkdir(parents=True, exist_ok=True)
    layout.write_text("[Window][Pictures]\nDockId=0x00000005,0\n[Window][Pictures of mine]\n")
    kept_layout.seal(layout)
    for _ in range(2):  # It is sealed again.
        assert kept_layout.put_aside_damaged(layout) == ""
        assert layout.read_text() == "[Window][Images]\nDockId=0x00000005,0\n[Window][Pictures of mine]\n"


@pytest.mark.parametrize(("before", "now"), [("1", 2.0), ("2", 1.0), ("1.5", 1.25)])
def test_panels_keep_their_sizes_on_a_denser_screen(places: Places, before: str, now: float) -> None:
    layout, share = places.config / kept_layout.NAME, now / float(before)
    layout.parent.mkdir(parents=True, exist_ok=True)
    said = (
        "[AppWindow]\nDpiWindowSizeFactor={}\nWindowSize={},{}\n"
        "DockSpace Size={},{} Split=X\nDockNode SizeRef={},{} Split=Y\n"
    )
    sizes = 1200, 720, 1200, 580, 300, 360
    layout.write_text(said.format(before, *sizes))
    kept_layout.seal(layout)
    for _ in range(2):  # Once is enough.
        kept_layout.fit(layout, now)
        scaled = (round(share * size) for size in sizes)
        assert layout.read_text() == said.format(f"{now:g}", *scaled)
        assert kept_layout.put_aside_damaged(layout) == ""


@pytest.mark.display
def test_a_denser_screen_is_noticed_with_the_next_window(places: Places) -> None:
    seen: list[tuple[float, float]] = []
    for density in (1.0, 1.25):
        window = Window(AppState(places, Settings(acknowledged=True)))
        params = window.runner_params()
        params.dpi_aware_params.dpi_window_size_factor = density
        params.app_window_params.window_geometry.size = (900, 560)
        frames: list[float] = []

        def after_frame(params: hello_imgui.RunnerParams = params, frames: list[float] = frames) -> None:
            side = imgui.internal.find_window_by_name("Enhancement")
            frames.append(side.size.x)
            if len(frames) > 8:
                seen.append((imgui.get_style().font_scale_dpi, side.size.x))
                params.app_shall_exit = True

        params.callbacks.before_swap = after_frame
        window.runner_params = lambda params=params: params  # type: ignore[method-assign,misc]
        window.run()
    (font, width), (larger, wider) = seen[0], seen[-1]
    assert larger == pytest.approx(1.25 * font)
    assert wider == pytest.approx(1.25 * width, rel=0.02)


def test_a_window_that_a_signal_closes_keeps_its_layout(
    places: Places, monkeypatch: pytest.MonkeyPatch
) -> None:
    layout = places.config / kept_layout.NAME

    def run(*arguments: object) -> None:
        layout.write_text("[Docking][Data]")
        signal.raise_signal(signal.SIGINT)

    monkeypatch.setattr(immapp, "run", run)
    with pytest.raises(KeyboardInterrupt):
        Window(AppState(places)).run()
    assert kept_layout.put_aside_damaged(layout) == ""


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="a system without such pipes")
def test_a_layout_that_is_a_pipe_hangs_no_window(places: Places) -> None:
    places.config.mkdir(parents=True)
    for name in (kept_layout.NAME, f"{kept_layout.NAME}.sha256"):
        os.mkfifo(places.config / name)
    assert not Window(AppState(places)).runner_params().ini_disable
    assert not (places.config / kept_layout.NAME).exists()


@pytest.mark.display
def test_the_layout_of_one_window_is_that_of_the_next(places: Places) -> None:
    for shown in (False, True):
        window = Window(AppState(places, Settings(acknowledged=True)))
        params = window.runner_params()
        seen: list[bool] = []

        def after_frame(params: hello_imgui.RunnerParams = params, seen: list[bool] = seen) -> None:
            seen.append(dockings.is_shown("Notes"))
            if len(seen) == 3:
                dockings.toggle("Notes")
            params.app_shall_exit = len(seen) > 6

        params.callbacks.before_swap = after_frame
        window.runner_params = lambda params=params: params  # type: ignore[method-assign,misc]
        window.run()
        assert (seen[1], seen[-1]) == (shown, not shown)
    assert list(window.state.window.log) == []


def test_a_report_and_views_are_told_apart_by_what_they_hold(places: Places, tmp_path: Path) -> None:
    state = AppState(places, Settings(acknowledged=True))
    channels = Channels()
    report = Path(__file__).parents[3] / "assets" / "pictures" / "report.json"
    views = tmp_path / "views.json"
    views.write_bytes(views_json(Views(loop=True)))
    for path in (report, views):
        actions.open_path(state, path)
        for _ in range(2):
            update(state, channels, state.window.now + 1)
            channels.opening.run_waiting()
        update(state, channels, state.window.now + 1)
        assert (state.source.opening, state.window.banner) == (None, None)
    assert state.reports.shown is not None
    assert state.window.toast is not None
    assert "0 views from views.json" in state.window.toast.message


@pytest.mark.display
def test_what_is_opened_comes_to_the_front(places: Places) -> None:
    driver = Driver(places)

    def drive(ctx: imgui.test_engine.TestContext) -> None:
        ctx.yield_(3)
        dockings.toggle(REPORT)
        ctx.yield_(3)
        actions.open_path(driver.state, phantom_path())
        wait(ctx, lambda: is_settled(driver.state), "the phantom")
        ctx.yield_(3)
        window = imgui.internal.find_window_by_name("Images")
        assert not window.hidden

    driver.run(drive)


@pytest.mark.parametrize(("user", "told"), [("Jürgen", "JRGEN~1"), ("Jürgen", ""), ("jane", "JANE~1")])
def test_windows_gets_the_folder_of_the_layout_in_english_letters(
    user: str, told: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    class Kernel:
        def GetShortPathNameW(self, name: str, buffer: Any, size: int) -> None:
            buffer.value = name.replace(user, told) if told else ""

    monkeypatch.setattr(sys, "platform", "win32")
    monkeypatch.setattr(ctypes, "windll", SimpleNamespace(kernel32=Kernel()), raising=False)
    layout = Path("/users") / user / "window.ini"
    params = starting.runner(layout, readable=False)
    short = told if not user.isascii() and told else user
    assert params.ini_filename == str(Path("/users") / short / "window.ini")


@pytest.mark.parametrize("density", [1.0, 1.5])
@pytest.mark.parametrize(
    ("screen", "size"),
    [
        ((1080, 1880), (972, 1692)),
        ((1920, 1080), (1632, 918)),
        ((1280, 1024), starting.SIZE),
        ((1366, 768), starting.SIZE),
        (None, starting.SIZE),
    ],
)
def test_the_first_window_has_most_of_the_screen_and_is_upright_where_that_is(
    screen: tuple[int, int] | None, size: tuple[int, int], density: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The runner makes what it is given larger on a dense screen."""
    monkeypatch.setattr(glfw, "init", lambda: screen is not None)
    monkeypatch.setattr(glfw, "get_monitors", lambda: [object()])
    monkeypatch.setattr(glfw, "get_primary_monitor", lambda: None if screen is None else "the first")
    area = tuple(round(density * side) for side in screen or ())
    monkeypatch.setattr(glfw, "get_monitor_workarea", lambda first: (0, 40, *area))
    monkeypatch.setattr(glfw, "get_monitor_content_scale", lambda first: (density, density))
    params = starting.runner(Path("/nowhere/window.ini"), readable=False)
    assert tuple(params.app_window_params.window_geometry.size) == size
