"""Long names are shortened to their room, where two that begin alike stay apart, and told whole."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from imgui_bundle import imgui

from app.gui.actions import actions, browse_actions
from app.gui.panels import cameras, file_browser, menus, runs, summary
from app.gui.state.app_state import AppState
from app.gui.state.summary import Item
from app.gui.style.asking import ask_name
from app.gui.work.listing import ListRequest, list_folder
from app.gui.work.runs import FoundRuns, ListedRun
from app.runs.progress_log import TrainingLog
from app.runs.train_run import TrainRequest
from renderer.camera_files import NamedCamera
from renderer.gaussians import DynamicGaussians
from renderer.train.config import TrainConfig
from tests.app.gui.conftest import start_live
from tests.app.gui.ui import Draw, Shown, Ui

LONG = f"case {'of a long operation ' * 8}part "
NAMES = tuple(f"{LONG}{number}" for number in (1, 2))


@pytest.fixture
def drawn(ui: Ui, monkeypatch: pytest.MonkeyPatch) -> Callable[[Draw], list[str]]:
    """All names that two frames show."""

    def show(draw: Draw) -> list[str]:
        shown: list[str] = []
        with monkeypatch.context() as patch:
            for name in ("text_unformatted", "selectable", "text_colored"):
                patch.setattr(imgui, name, _noting(shown, getattr(imgui, name)))
            for _ in range(2):
                ui.frame(draw)
        assert not any(LONG in one for one in shown)
        return [one.split("###")[0] for one in shown if "…" in one]

    return show


def _noting(shown: list[str], draw: Callable[..., Any]) -> Callable[..., Any]:
    def noted(*given: Any, **more: Any) -> Any:
        shown.extend(one for one in given if isinstance(one, str))
        return draw(*given, **more)

    return noted


def test_of_runs_beside_their_psnr(ui: Ui, state: AppState, drawn: Callable[[Draw], list[str]]) -> None:
    state.runs.is_listed = True
    wanted, clip = state.runs_request, state.source.clip
    assert wanted is not None
    assert clip is not None
    listed = []
    for name in NAMES:
        path = state.places.runs / name
        config = TrainConfig(iterations=12)
        request = TrainRequest(clip_path=clip.path, run_path=path, config=config)
        listed.append(ListedRun(path, "", request, "finished", False, 12, 31.5, TrainingLog()))
    state.runs.found = FoundRuns(wanted, tuple(listed), 1)
    names = set(drawn(lambda: runs.draw_runs(state)))
    assert len(names) == 2
    assert all(imgui.calc_text_size(one).x < 900 - imgui.calc_text_size("31.5 dB").x for one in names)


def test_of_files_in_the_dialog(state: AppState, drawn: Callable[[Draw], list[str]], tmp_path: Path) -> None:
    for name in NAMES:
        (tmp_path / f"{name}.png").write_text("")
    actions.choose_path(state, "file", lambda state, path: None)
    assert state.window.choosing is not None
    browse_actions.begin(state, replace(state.window.choosing, start=tmp_path))
    assert state.window.browsing is not None
    browse_actions.take_listing(state, state.window.browsing.request, *list_folder(ListRequest(tmp_path)))
    assert len(set(drawn(lambda: file_browser.draw_browser(state, Shown())))) == 2


def test_of_views(state: AppState, model: DynamicGaussians, drawn: Callable[[Draw], list[str]]) -> None:
    start_live(state, model)
    camera = state.scene.model.cameras[0] if state.scene.model is not None else None
    assert camera is not None
    named = tuple(NamedCamera(name, camera) for name in NAMES)
    state.scene.cameras.views = replace(state.scene.cameras.views, named=named)
    assert len(set(drawn(lambda: cameras.draw_cameras(state)))) == 2


def test_of_images_of_a_case(state: AppState, drawn: Callable[[Draw], list[str]]) -> None:
    state.summary.shown = True
    state.summary.items = tuple(Item(Path(f"{name}.png")) for name in NAMES)
    assert len(set(drawn(lambda: summary.draw_summary(state, Shown())))) == 2


def test_of_what_a_folder_becomes(drawn: Callable[[Draw], list[str]]) -> None:
    name = NAMES[0]
    (said,) = set(drawn(lambda: ask_name("Rename", "Name", "a", lambda typed: None, str, f"Becomes {name}")))
    assert (said[:7], said[-1]) == ("Becomes", "1")


def test_of_the_clip_in_the_status_bar(ui: Ui) -> None:
    said: list[str] = []
    ui.frame(lambda: said.append(menus.fitting([f"{NAMES[0]}  1280×720", "enhanced"], 300.0)))
    assert said[0].startswith("case of a")
    assert said[0].endswith("1  1280×720")
