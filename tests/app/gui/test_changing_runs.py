"""Runs renamed and deleted in the window: after a question, never in training, and what is shown follows."""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path

import pytest
from imgui_bundle import imgui

from app.gui.actions import arriving, changing_runs, job_actions
from app.gui.frame.title import title_of
from app.gui.panels import run_questions
from app.gui.panels.run_questions import held
from app.gui.state.app_state import AppState
from app.gui.state.reconstruction import Waiting
from app.gui.update.channels import Channels
from app.gui.update.jobs import start_due
from app.gui.update.update import update
from app.gui.work.opening import OpenRequest, open_path
from app.gui.work.runs import FoundRuns, ListedRun, RunFinder
from app.gui.work.settings import Places
from app.runs.run_changes import Footprint
from app.runs.run_folder import RunFolder
from app.runs.run_lock import locked
from renderer.gaussians import DynamicGaussians
from renderer.sources import open_clip
from tests.app.gui.conftest import FakeJob
from tests.app.gui.driver import Driver, is_settled, wait
from tests.app.gui.scenes import scene_of
from tests.app.gui.settling import show_live


@pytest.fixture
def listed(state: AppState, tmp_path: Path, clip_path: Path, runs: dict[str, Path]) -> AppState:
    for name in ("one", "two"):
        shutil.copytree(runs["original"], tmp_path / "runs" / name)
    state.places = replace(state.places, runs=tmp_path / "runs")
    state.source.clip = open_clip(clip_path)
    return state


def run_of(state: AppState, name: str) -> ListedRun:
    state.runs.is_listed = True
    assert state.runs_request is not None
    (found,) = RunFinder().find(state.runs_request)
    assert isinstance(found, FoundRuns)
    state.runs.found = found
    return next(run for run in found.runs if run.path.name == name)


def test_the_run_that_is_shown_is_looked_for_though_no_list_is_on_screen(listed: AppState) -> None:
    one = run_of(listed, "one")
    listed.runs.is_listed = False
    assert listed.runs_request is None
    listed.runs.found, listed.runs.reconstruction.request = None, one.request
    assert listed.runs_request is not None
    assert not changing_runs.can_change_shown(listed)
    (listed.runs.found,) = RunFinder().find(listed.runs_request)
    assert listed.runs_request is None
    assert changing_runs.can_change_shown(listed)


def test_a_run_whose_model_is_shown_while_another_starts_waits(
    listed: AppState, model: DynamicGaussians
) -> None:
    one, two = run_of(listed, "one"), run_of(listed, "two")
    assert listed.source.clip is not None
    listed.scene.model = replace(scene_of(model, listed.source.clip.cameras), path=one.path)
    assert changing_runs.why_not_change(listed, one) == ""
    listed.runs.reconstruction.status = "starting"
    assert "until the run in training" in changing_runs.why_not_change(listed, one)
    assert changing_runs.why_not_change(listed, two) == ""


def test_the_title_names_the_run_that_is_seen_and_not_the_one_before(
    listed: AppState, model: DynamicGaussians
) -> None:
    before = run_of(listed, "one").path
    (answer,) = open_path(OpenRequest(before))
    arriving.show_opened(listed, before, answer)
    assert title_of(listed) == "one - VesselSplat"
    job_actions.start_reconstruction(listed)
    start_due(listed, FakeJob)
    now = listed.runs.reconstruction.run_path
    assert now is not None
    now.mkdir()
    shutil.copy(before / "run.json", now)
    show_live(listed, model)
    assert now.name != "one"
    assert title_of(listed) == f"{now.name} - VesselSplat"


def shown_list(state: AppState) -> list[str]:
    """Names in the list as it is drawn: one that was on its way when the clip was opened again is not."""
    found = state.runs.found
    drawn = found is not None and found.request.clip is state.source.clip
    return [run.path.name for run in found.runs] if found is not None and drawn else []


@pytest.mark.usefixtures("bin_files")
def test_only_what_was_agreed_to_is_done(listed: AppState) -> None:
    channels, one = Channels(), run_of(listed, "one")
    for agreed in (False, True):
        changing_runs.ask_delete(listed, one)
        update(listed, channels, 0.1)
        assert channels.footprints.run_waiting()
        update(listed, channels, 0.2)
        question = listed.runs.question
        assert question is not None
        assert question.footprint is not None
        assert question.footprint.size > 10_000
        changing_runs.answer(listed, agreed=agreed)
        assert listed.runs.question is None
        update(listed, channels, 0.3)
        assert channels.changes.run_waiting() == agreed
        assert one.path.exists() != agreed
    update(listed, channels, 0.4)
    assert listed.window.toast is not None
    assert listed.window.toast.message == "moved one to the bin"
    assert listed.runs.found is not None
    assert [run.path.name for run in listed.runs.found.runs] == ["two"]


def test_the_bin_is_named_once_it_is_known_that_there_is_one(
    listed: AppState, monkeypatch: pytest.MonkeyPatch, bin_files: Path
) -> None:
    texts: list[str] = []
    monkeypatch.setattr(run_questions, "ask", lambda title, said, replies: texts.extend(said) or "")
    channels = Channels()
    changing_runs.ask_delete(listed, run_of(listed, "one"))
    run_questions.draw_run_question(listed)
    assert run_questions.BIN not in texts
    update(listed, channels, 0.1)
    assert channels.footprints.run_waiting()
    update(listed, channels, 0.2)
    run_questions.draw_run_question(listed)
    assert texts[-1] == run_questions.BIN


def test_past_the_bin_is_said_before(
    listed: AppState, monkeypatch: pytest.MonkeyPatch, bin_files: Path
) -> None:
    bin_files.parent.write_text("in the place of a bin")
    texts: list[str] = []
    monkeypatch.setattr(run_questions, "ask", lambda title, said, replies: texts.extend(said) or "Delete")
    channels, one = Channels(), run_of(listed, "one")
    changing_runs.ask_delete(listed, one)
    update(listed, channels, 0.1)
    assert channels.footprints.run_waiting()
    update(listed, channels, 0.2)
    run_questions.draw_run_question(listed)
    assert texts[-1] == run_questions.FOR_GOOD
    update(listed, channels, 0.3)
    assert channels.changes.run_waiting()
    update(listed, channels, 0.4)
    assert not one.path.exists()
    assert listed.window.toast is not None
    assert listed.window.toast.message == "deleted one"


def test_what_is_in_training_or_queued_is_left_alone(listed: AppState) -> None:
    (listed.places.runs / "one" / "model.safetensors").unlink()
    with locked(listed.places.runs / "one"):
        run = run_of(listed, "one")
        assert "in training" in changing_runs.why_not_change(listed, run)
        changing_runs.ask_delete(listed, run)
        changing_runs.ask_name(listed, run)
    assert listed.runs.question is None
    run = run_of(listed, "one")
    assert changing_runs.why_not_change(listed, run) == ""
    listed.runs.queue = (Waiting(listed.source.clip, run.request),)
    assert "queued" in changing_runs.why_not_change(listed, run)


def test_what_cannot_be_done_is_said(listed: AppState) -> None:
    channels = Channels()
    changing_runs.ask_name(listed, run_of(listed, "one"))
    changing_runs.type_name(listed, "two")
    changing_runs.answer(listed, agreed=True)
    update(listed, channels, 0.1)
    assert channels.changes.run_waiting()
    update(listed, channels, 0.2)
    assert listed.window.banner is not None
    assert (
        "one was not renamed: expected a name that no other run has, got two" in listed.window.banner.message
    )
    assert RunFolder(listed.places.runs / "one").is_finished


def test_a_folder_is_said_in_words() -> None:
    assert held(None) == "Measuring the folder…"
    assert held(Footprint(1, 2_500_000)).startswith("1 file, 2.5 MB")


@pytest.mark.display
@pytest.mark.usefixtures("bin_files")
def test_the_run_that_is_shown_is_renamed_and_deleted_by_mouse_and_keyboard(
    places: Places, runs: dict[str, Path]
) -> None:
    shutil.copytree(runs["original"], places.runs / "first")
    driver = Driver(places, opens=places.runs / "first")
    state = driver.state

    def drive(ctx: imgui.test_engine.TestContext) -> None:
        wait(ctx, lambda: is_settled(state), "the run")
        ctx.window_focus("//Runs")
        wait(ctx, lambda: shown_list(state) == ["first"], "the list")
        ctx.yield_(2)
        ctx.item_click("//Runs/**/###rename")
        wait(ctx, lambda: state.runs.question is not None, "the question")
        ctx.yield_(3)
        ctx.key_press(imgui.Key.mod_ctrl | imgui.Key.a)
        ctx.key_chars("second look")
        ctx.yield_(2)
        ctx.key_press(imgui.Key.enter)
        wait(ctx, lambda: state.source.path == places.runs / "second-look", "the renamed run")
        wait(
            ctx,
            lambda: state.scene.model is not None and state.scene.model.name == "second-look",
            "its model",
        )
        wait(ctx, lambda: shown_list(state) == ["second-look"], "the new list")
        ctx.yield_(2)
        ctx.item_click("//Runs/**/###delete")
        wait(ctx, lambda: state.runs.question is not None, "the question")
        ctx.yield_(3)
        ctx.key_press(imgui.Key.escape)
        wait(ctx, lambda: state.runs.question is None, "no")
        ctx.yield_(3)
        assert (places.runs / "second-look").is_dir()
        ctx.item_click("//Runs/**/###delete")
        wait(ctx, lambda: state.runs.question is not None, "the question")
        ctx.yield_(3)
        ctx.item_click("//Delete the run?/Delete")
        wait(ctx, lambda: state.scene.model is None and is_settled(state), "the clip alone")
        assert not (places.runs / "second-look").exists()
        assert list(places.runs.iterdir()) == []

    driver.run(drive)
