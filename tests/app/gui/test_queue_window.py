"""Two reconstructions in turn, in the whole window."""

from __future__ import annotations

import json
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import glfw
import pytest
from imgui_bundle import glfw_utils, imgui

from app.gui.actions import actions, job_actions
from app.gui.commands.keys import chord
from app.gui.work.settings import Places
from app.runs.job import Cancelled, Failed, Paused
from app.runs.queue_file import keep_queue, queue_file
from app.runs.run_folder import RunFolder
from app.runs.train_run import TrainRequest, run_training
from assets import phantom_path
from renderer.gaussians import DynamicGaussians
from renderer.train.config import TrainConfig
from renderer.train.events import Evaluated, Finished, Progress, Started
from tests.app.gui.driver import Driver, is_settled, wait


@pytest.mark.display
def test_two_reconstructions_are_queued_watched_and_asked_about(
    places: Places, model: DynamicGaussians
) -> None:
    driver = Driver(places, opens=phantom_path())
    state, jobs = driver.state, driver.jobs

    def drive(ctx: imgui.test_engine.TestContext) -> None:
        wait(ctx, lambda: is_settled(state), "the phantom")
        ctx.set_ref(ctx.window_info("//Reconstruction/choices").id_)
        ctx.combo_click("##Frames/Both in turn")
        ctx.item_click("###linked")
        ctx.set_ref("")
        ctx.yield_(3)
        choices = ctx.window_info("//Reconstruction/choices").window
        assert choices.scroll_max.y > 0  # More than there is room for, and yet the button is in sight.
        start = ctx.item_info("//Reconstruction/###start")
        assert start.rect_clipped.max.y == start.rect_full.max.y
        assert start.rect_full.min.y >= choices.pos.y + choices.size.y
        ctx.item_click("//Reconstruction/###start")
        wait(ctx, lambda: bool(jobs), "the first job")
        assert len(state.runs.queue) == 1
        ctx.window_focus("//Runs")
        ctx.yield_(3)
        jobs[0].inbox = [Started(0, 20, 30, ()), Progress(10, 20, 0.2, 22.0, 1.0, 1.0, 30)]
        jobs[0].inbox += [Evaluated(20, 23.0), Finished(20, 2.0, model)]
        wait(ctx, lambda: len(jobs) == 2, "the second job")
        jobs[1].inbox = [Started(0, 20, 30, ())]
        jobs[1].inbox += [Progress(i, 20, 1.5 / i, 12.0 + i, 1.0, 1.0, 30 + i) for i in range(1, 15)]
        ctx.window_focus("//Reconstruction")
        ctx.yield_(3)
        ctx.item_click("//Reconstruction/###another")
        ctx.yield_(2)
        ctx.item_click("//Reconstruction/**/###start")
        wait(ctx, lambda: len(state.runs.queue) == 2, "two more in the queue")
        ctx.item_click("//Reconstruction/###another")
        ctx.window_focus("//Runs")
        ctx.yield_(2)
        ctx.item_click("//Runs/**/###withdraw")
        wait(ctx, lambda: len(state.runs.queue) == 1, "one of them withdrawn")
        glfw.set_window_should_close(glfw_utils.glfw_window_hello_imgui(), 1)
        wait(ctx, lambda: state.window.closing == "asked", "the question before closing")
        ctx.yield_(3)
        ctx.item_click("//Close VesselSplat?/Stay")
        ctx.yield_(2)
        assert state.window.closing == "no"
        jobs[1].inbox = [Failed("the training process was killed by SIGKILL")]
        wait(ctx, lambda: len(jobs) == 3, "the third job")
        state.window.closing = "agreed"

    driver.run(drive)
    assert [job.told[0] for job in jobs] == ["start"] * 3
    assert jobs[2].told[-1] == "close"


@pytest.mark.display
def test_a_signal_that_ends_the_training_too_starts_none_of_those_that_wait(places: Places) -> None:
    """As a service manager sends it to all processes of the window."""
    driver = Driver(places, opens=phantom_path())
    state, jobs = driver.state, driver.jobs

    def drive(ctx: imgui.test_engine.TestContext) -> None:
        wait(ctx, lambda: is_settled(state), "the phantom")
        job_actions.choose_input(state, "both in turn")
        job_actions.start_reconstruction(state)
        wait(ctx, lambda: bool(jobs), "the first job")
        jobs[0].inbox = [Cancelled()]
        driver.window._has_signal = lambda: True
        ctx.yield_(4)

    with pytest.raises(RuntimeError, match="exited before"):
        driver.run(drive)
    assert len(jobs) == 1
    (waiting,) = json.loads(queue_file(places.config).read_text())
    assert waiting["input"] == "enhanced"


@pytest.mark.display
def test_what_was_cut_short_before_is_found_and_goes_on(places: Places, clip_path: Path) -> None:
    config = TrainConfig(iterations=8, n_gaussians=300, checkpoint_every=2)
    request = TrainRequest(clip_path=clip_path, run_path=places.runs / "short", config=config)
    steps = run_training(request)
    while not RunFolder(request.run_path).has_checkpoint:
        next(steps)
    steps.close()
    driver = Driver(places, opens=clip_path)
    state, jobs = driver.state, driver.jobs

    def drive(ctx: imgui.test_engine.TestContext) -> None:
        wait(ctx, lambda: is_settled(state), "the clip")
        ctx.window_focus("//Runs")
        wait(ctx, lambda: state.runs.found is not None, "the run")
        ctx.yield_(2)
        ctx.item_click("//Runs/**/Continue")
        wait(ctx, lambda: bool(jobs), "its going on")
        jobs[0].inbox = [Failed("out of memory")]
        wait(ctx, lambda: not state.runs.reconstruction.is_alive, "its end")
        ctx.yield_(2)
        ctx.item_click("//Runs/**/###open")
        wait(ctx, lambda: state.source.path == request.run_path, "the run itself")

    driver.run(drive)
    assert jobs[0].request == replace(request, resume=True)


@pytest.mark.display
def test_what_waited_when_the_last_window_died_is_shown_and_starts_at_a_click(places: Places) -> None:
    dead = subprocess.Popen([sys.executable, "-c", ""])
    dead.wait()
    waited = [
        TrainRequest(
            clip_path=phantom_path(), run_path=places.runs / name, config=TrainConfig(iterations=count)
        )
        for name, count in (("first", 100), ("second", 200))
    ]
    keep_queue(places.config / f"queue-{dead.pid}.json", waited)
    driver = Driver(places)
    state, jobs = driver.state, driver.jobs

    def drive(ctx: imgui.test_engine.TestContext) -> None:
        ctx.window_focus("//Runs")
        ctx.yield_(20)
        assert len(state.runs.queue) == 2
        assert jobs == []
        ctx.item_click("//Runs/Start the queue")
        wait(ctx, lambda: bool(jobs), "the first of them")
        jobs[0].inbox = [Started(0, 100, 30, ())]
        wait(ctx, lambda: state.runs.reconstruction.can_pause, "its start")
        ctx.key_press(chord("Ctrl+P"))
        wait(ctx, lambda: "pause" in jobs[0].told, "the pause")
        jobs[0].inbox = [Paused()]
        wait(ctx, lambda: state.runs.reconstruction.can_resume, "standing still")
        ctx.key_press(chord("Ctrl+P"))
        wait(ctx, lambda: "resume" in jobs[0].told, "going on")
        ctx.key_press(chord("Ctrl+Shift+X"))
        wait(ctx, lambda: "cancel" in jobs[0].told, "its end")
        state.window.closing = "agreed"

    driver.run(drive)
    assert jobs[0].request == waited[0]
    left = json.loads(queue_file(places.config).read_bytes())
    assert [one["config"]["iterations"] for one in left] == [200]  # It is there for the next window.


@pytest.mark.display
def test_a_trim_is_said_before_it_is_trained_on_and_undone_by_its_name(places: Places) -> None:
    driver = Driver(places, opens=phantom_path())
    state, jobs = driver.state, driver.jobs

    def drive(ctx: imgui.test_engine.TestContext) -> None:
        wait(ctx, lambda: is_settled(state), "the phantom")
        actions.seek(state, 3)
        ctx.key_press(chord("Shift+I"))
        wait(ctx, lambda: len(state.enhancement.past) == 2, "the trim as a step")
        ctx.key_press(chord("Ctrl+R"))
        wait(ctx, lambda: bool(jobs), "the job")
        ctx.menu_click("//##MainMenuBar/Image/Undo trim")
        wait(ctx, lambda: state.source.part.trim is None, "the whole clip")
        ctx.key_press(chord("Ctrl+Y"))
        wait(ctx, lambda: state.source.part.trim == (3, 23), "the trim again")
        state.window.closing = "agreed"

    driver.run(drive)
    request = jobs[0].request
    assert isinstance(request, TrainRequest)
    assert request.part.trim == (3, 23)
