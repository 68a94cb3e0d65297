"""About: version, licences, what is copied into a bug report, the folder of the log."""

from __future__ import annotations

import getpass
import platform
from dataclasses import replace
from importlib.metadata import Distribution, distribution, requires
from pathlib import Path

import pytest
from imgui_bundle import imgui

from app.files.provenance import version
from app.gui.actions.about_actions import open_log_folder
from app.gui.panels.about import COPY, LOGS, draw_about
from app.gui.state.app_state import AppState
from app.gui.update.channels import Channels
from app.gui.update.update import update
from app.gui.work.about import About, licence_of, read_about
from app.gui.work.revealing import RevealRequest
from app.gui.work.settings import Places, Settings
from tests.app.gui.driver import Driver, wait
from tests.app.gui.ui import Ui


@pytest.fixture
def facts() -> About:
    (made,) = read_about("OpenGL here is llvmpipe.")
    return made


def test_version_purpose_and_licences_are_the_package_s_own(facts: About) -> None:
    assert facts.version == version()
    assert facts.licence == "Apache-2.0"
    assert "vessels" in facts.purpose
    names = {package.name.lower() for package in facts.packages}
    needed = {one for one in requires("vesselsplat") or () if "extra" not in one and one != "torch"}
    assert needed <= names
    assert {"roboto", "font awesome"} <= names
    assert all(package.licence for package in facts.packages)


def test_a_bug_report_names_the_machine_but_nobody(facts: About) -> None:
    for told in (version(), platform.python_version(), "llvmpipe", "numba"):
        assert told in facts.report
    assert str(Path.home()) not in facts.report
    assert not {platform.node(), getpass.getuser()} & set(facts.report.split())


@pytest.mark.parametrize(
    ("lines", "licence"),
    [
        ("License-Expression: MIT", "MIT"),
        ("Classifier: License :: OSI Approved :: BSD License", "BSD License"),
        ("License: Copyright of somebody\n  and many lines of text", "see its own files"),
        ("", "see its own files"),
    ],
)
def test_a_licence_is_told_in_short(tmp_path: Path, lines: str, licence: str) -> None:
    (tmp_path / "some-1.0.dist-info").mkdir()
    metadata = f"Metadata-Version: 2.1\nName: some\nVersion: 1.0\n{lines}\n"
    (tmp_path / "some-1.0.dist-info" / "METADATA").write_text(metadata)
    (found,) = Distribution.discover(path=[str(tmp_path)])
    assert licence_of(found) == licence


def test_of_a_package_that_is_there_the_licence_is_known() -> None:
    assert "BSD" in licence_of(distribution("numpy"))


def test_the_folder_of_the_log_is_shown_by_the_desktop(state: AppState) -> None:
    open_log_folder(state)
    (wish,) = state.window.wishes
    assert isinstance(wish, RevealRequest)
    assert wish.path == state.places.logs


def test_it_is_drawn_and_copied_and_left(ui: Ui, state: AppState, facts: About) -> None:
    copied: list[str] = []
    state.about.shown, state.about.facts = True, facts
    for _ in range(3):
        ui.frame(lambda: draw_about(state, copied.append))
    assert state.about.shown
    window = imgui.internal.find_window_by_name("About VesselSplat")
    assert window.pos.y >= 0
    assert window.pos.y + window.size.y <= ui.io.display_size.y


def test_facts_are_read_once_and_only_when_asked_for(state: AppState) -> None:
    channels = Channels()
    for shown, there in ((False, False), (True, True)):
        state.about.shown = shown
        for _ in range(2):
            update(state, channels, 0.0)
            channels.about.run_waiting()
        update(state, channels, 0.0)
        assert (state.about.facts is not None) == there


@pytest.mark.display
def test_about_in_the_window(places: Places, monkeypatch: pytest.MonkeyPatch) -> None:
    opened: list[Path] = []
    driver = Driver(places)
    state = driver.state

    def drive(ctx: imgui.test_engine.TestContext) -> None:
        ctx.menu_click("//##MainMenuBar/Help/About VesselSplat")
        wait(ctx, lambda: state.about.facts is not None, "the facts")
        ctx.yield_(3)
        ctx.item_click(f"//About VesselSplat/{COPY}")
        ctx.yield_(2)
        assert imgui.get_clipboard_text() == state.about.facts.report  # type: ignore[union-attr]
        channel = driver.window._channels.reveals
        monkeypatch.setattr(channel, "_work", lambda wanted: opened.append(wanted.path) or iter(()))
        ctx.item_click(f"//About VesselSplat/{LOGS}")
        wait(ctx, lambda: bool(opened), "the folder")
        ctx.key_press(imgui.Key.escape)
        wait(ctx, lambda: not state.about.shown, "its end")

    driver.run(drive)
    assert opened == [places.logs]
    assert state.settings == replace(Settings(acknowledged=True), method=state.settings.method)
