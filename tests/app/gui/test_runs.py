"""The runs of the open clip: found on disk, opened, continued; and what a failed one leaves."""

from __future__ import annotations

import math
import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import get_args

import numpy as np
import pytest
from imgui_bundle import imgui

from app.gui.actions import arriving, job_actions, run_actions
from app.gui.panels import runs
from app.gui.panels.reconstruction import draw_reconstruction
from app.gui.panels.runs import draw_runs
from app.gui.state.app_state import AppState
from app.gui.state.run_words import doing
from app.gui.style import theme
from app.gui.update.channels import Channels
from app.gui.update.jobs import start_due
from app.gui.update.update import update
from app.gui.work.beside import BesideRequest, find_models
from app.gui.work.opening import OpenRequest, open_path
from app.gui.work.runs import FoundRuns, ListedRun, RunFinder, RunsRequest
from app.runs.run_folder import RunFolder
from app.runs.run_lock import locked
from app.runs.train_run import TrainRequest, run_training
from app.scenes.scene import Scene
from renderer.gaussians import DynamicGaussians
from renderer.phantom import PhantomParams, write_phantom
from renderer.sources import open_clip
from renderer.train.config import Method, TrainConfig
from renderer.train.events import Evaluated, Finished
from tests.app.gui.conftest import FakeJob, start_live
from tests.app.gui.settling import show_live
from tests.app.gui.ui import Ui

MakeFake = Callable[[object], FakeJob]
CONFIG = TrainConfig(iterations=12, n_gaussians=300, checkpoint_every=4, hold_out=True)


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A clip, and the runs of it in folders named after what became of them."""
    folder = tmp_path_factory.mktemp("made")
    clip, runs = folder / "clip", folder / "runs"
    write_phantom(clip, PhantomParams(n_frames=10, width=64, height=48, seed=1), "endonerf")
    list(run_training(TrainRequest(clip_path=clip, run_path=runs / "whole", config=CONFIG)))
    short = TrainRequest(clip_path=clip, run_path=runs / "short", config=CONFIG, input="enhanced")
    list(run_training(short))
    (runs / "short" / "model.safetensors").unlink()
    for path in (runs / "short").glob("checkpoint-*12.safetensors"):
        path.unlink()
    (runs / "damaged").mkdir()
    (runs / "damaged" / "run.json").write_text("{")
    (runs / "no run").mkdir()
    return folder


@pytest.fixture
def folder(made: Path, tmp_path: Path) -> Path:
    shutil.copytree(made, tmp_path / "mine")
    return tmp_path / "mine"


@pytest.fixture
def opened(state: AppState, folder: Path) -> AppState:
    state.places = replace(state.places, runs=folder / "runs")
    state.source.clip = open_clip(folder / "clip")
    return state


def found(state: AppState, finder: RunFinder | None = None) -> FoundRuns:
    state.runs.is_listed = True
    assert state.runs_request is not None
    (answer,) = (finder or RunFinder()).find(state.runs_request)
    state.runs.found = answer
    return answer


def named(state: AppState, name: str) -> ListedRun:
    return next(run for run in found(state).runs if run.path.name == name)


def test_what_is_on_disk_is_found_again_wherever_the_clip_lies_now(opened: AppState) -> None:
    answer = found(opened)
    assert {run.path.name: run.made for run in answer.runs} == {"whole": "finished", "short": "unfinished"}
    assert answer.unreadable == 1
    whole, short = named(opened, "whole"), named(opened, "short")
    assert (whole.request.input, short.request.input) == ("original", "enhanced")
    assert whole.iteration == CONFIG.iterations
    assert short.has_checkpoint
    assert opened.source.clip is not None
    assert short.request.clip_path == opened.source.clip.path  # It was begun elsewhere, with the same bytes.
    logged = [event for event in RunFolder(whole.path).events() if event["event"] == "Evaluated"]
    assert whole.psnr == pytest.approx(logged[-1]["psnr"])
    RunFolder(whole.path).log(Evaluated(CONFIG.iterations, math.nan))  # All that is held out is masked.
    assert named(opened, "whole").psnr is None, "not that of training frames"


def test_a_finished_run_tells_as_many_iterations_as_it_took(opened: AppState, folder: Path) -> None:
    """One method has a stage of its own before."""
    config = replace(CONFIG, method="endogaussian")
    path = folder / "runs" / "staged"
    *_, last = run_training(TrainRequest(clip_path=folder / "clip", run_path=path, config=config))
    assert isinstance(last, Finished)
    listed = named(opened, "staged")
    assert (listed.made, listed.iteration, listed.iterations) == ("finished", 16, 16)
    assert last.iteration == 16


def test_a_run_that_is_opened_through_a_link_is_the_one_that_is_listed(
    opened: AppState, folder: Path
) -> None:
    (folder / "other name").symlink_to(folder / "runs", target_is_directory=True)
    (answer,) = open_path(OpenRequest(folder / "clip" / ".." / "other name" / "whole"))
    whole = named(opened, "whole")
    assert answer.run is not None
    assert answer.run.path == whole.path
    assert answer.run.model is not None
    opened.scene.model = answer.run.model
    assert run_actions.why_not_beside(opened, whole)
    opened.places = replace(opened.places, runs=folder / "other name")
    assert named(opened, "whole").path == whole.path
    (models,) = find_models(BesideRequest((str(folder / "other name" / "whole"),), "none"))
    assert models == (whole.path,)


def test_runs_of_the_clip_behind_a_link_are_listed(
    opened: AppState, folder: Path, made: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """By its place alone: no byte of it tells."""
    monkeypatch.setattr("app.gui.work.runs.digest", lambda path: "")
    (folder / "linked").symlink_to(made / "clip", target_is_directory=True)
    opened.source.clip = open_clip(folder / "linked")
    assert {run.path.name for run in found(opened).runs} == {"whole", "short"}


def test_runs_of_another_clip_are_not_listed(opened: AppState, folder: Path) -> None:
    image_of = next((folder / "clip" / "images").iterdir())
    image_of.write_bytes(image_of.read_bytes() + b"\0")
    assert found(opened).runs == ()


def test_a_run_in_another_process_says_so_and_is_left_alone(
    opened: AppState, make_job: MakeFake, folder: Path
) -> None:
    with locked(folder / "runs" / "short"):
        run = named(opened, "short")
        assert run.made == "training"
        run_actions.continue_run(opened, run)
        start_due(opened, make_job)
    assert opened.runs.reconstruction.job is None
    assert named(opened, "short").made == "unfinished"


def test_a_run_that_is_opened_while_another_window_trains_it_is_no_interrupted_one(
    opened: AppState, folder: Path
) -> None:
    path = folder / "runs" / "short"
    with locked(path):
        (answer,) = open_path(OpenRequest(path))
        arriving.show_opened(opened, path, answer)
        assert doing(opened) == "Training elsewhere"
        assert not job_actions.can_continue(opened)
        assert "short is still in training elsewhere" in opened.window.log
        assert not run_actions.is_as_it_is(opened, named(opened, "short")), "there is more to see"
    run_actions.open_again(opened)
    assert opened.source.opening is not None
    assert opened.source.opening.path == path
    (answer,) = open_path(OpenRequest(path))
    arriving.show_opened(opened, path, answer)
    assert doing(opened) == "Interrupted"
    assert job_actions.can_continue(opened)


def test_looking_again_sees_what_has_changed_alone(opened: AppState, folder: Path) -> None:
    finder = RunFinder()
    before = {run.path.name: run for run in found(opened, finder).runs}
    shutil.rmtree(folder / "runs" / "short")
    (again,) = found(opened, finder).runs
    assert again.path == before["whole"].path
    assert again.request.config is before["whole"].request.config  # Not read anew.


def test_an_unfinished_run_goes_on_as_it_was_begun_and_only_once(
    opened: AppState, make_job: MakeFake
) -> None:
    run = named(opened, "short")
    job_actions.start_reconstruction(opened)
    start_due(opened, make_job)
    run_actions.continue_run(opened, run)
    start_due(opened, make_job)
    run_actions.continue_run(opened, run)
    start_due(opened, make_job)
    (waiting,) = opened.runs.queue
    assert waiting.request == replace(run.request, resume=True)
    assert waiting.request.config == CONFIG
    assert waiting.told == run.told
    events = list(run_training(waiting.request))
    assert RunFolder(run.path).is_finished
    assert events


def test_a_finished_run_opens_in_place_or_beside_the_one_that_is_made(
    opened: AppState, make_job: MakeFake, model: DynamicGaussians
) -> None:
    whole, short = named(opened, "whole"), named(opened, "short")
    run_actions.open_run(opened, short)
    assert opened.source.opening is not None
    assert opened.source.opening.path == short.path
    opened.source.opening = None
    job_actions.start_reconstruction(opened)
    start_due(opened, make_job)
    show_live(opened, model)
    run_actions.open_run(opened, replace(short, has_checkpoint=False))
    assert opened.scene.second.opening is None
    run_actions.open_run(opened, whole)
    assert opened.source.opening is None
    assert opened.scene.second.opening is not None
    assert opened.scene.second.opening.path == whole.path


def test_the_list_is_asked_for_only_while_it_is_on_screen(opened: AppState) -> None:
    channels = Channels()
    update(opened, channels, 0.1)
    assert channels.runs.asked is None
    opened.runs.is_listed = True
    update(opened, channels, 0.2)
    assert isinstance(channels.runs.asked, RunsRequest)
    channels.runs.run_waiting()
    update(opened, channels, 0.3)
    assert opened.runs.found is not None
    assert len(opened.runs.found.runs) == 2


def test_the_list_draws_every_state(ui: Ui, opened: AppState, model: DynamicGaussians) -> None:
    ui.frame(lambda: draw_runs(opened))
    found(opened)
    ui.frame(lambda: draw_runs(opened))
    start_live(opened, model)
    opened.runs.preview = replace(opened.scene.model, name="short") if opened.scene.model else None
    ui.frame(lambda: draw_runs(opened))
    ui.frame(lambda: draw_reconstruction(opened))
    opened.source.clip = None
    ui.frame(lambda: draw_runs(opened))


def test_the_run_in_training_is_named_in_full_ink_and_said_to_be(
    ui: Ui, opened: AppState, model: DynamicGaussians, monkeypatch: pytest.MonkeyPatch
) -> None:
    whole, dimmed, said = named(opened, "whole"), list[bool](), dict[str, imgui.ImVec4]()
    start_live(opened, model)
    monkeypatch.setattr(run_actions, "why_not_open", lambda state, run: "Wait.")
    begin, colored = imgui.begin_disabled, imgui.text_colored
    monkeypatch.setattr(imgui, "begin_disabled", lambda off=True: (dimmed.append(off), begin(off))[1])
    monkeypatch.setattr(
        imgui, "text_colored", lambda ink, text: (said.update({text: ink}), colored(ink, text))
    )
    ui.frame(lambda: runs._draw_run(opened, whole))
    assert dimmed[0]
    assert said["finished"] == theme.now().muted
    opened.runs.reconstruction.request = whole.request
    dimmed.clear()
    ui.frame(lambda: runs._draw_run(opened, whole))
    assert not dimmed[0]
    assert said["training"] == theme.now().accent


def test_of_a_thousand_runs_those_near_sight_are_drawn_and_all_are_scrolled_to(
    ui: Ui, opened: AppState, monkeypatch: pytest.MonkeyPatch
) -> None:
    whole, drawn, ends = named(opened, "whole"), list[str](), list[float]()
    many = tuple(replace(whole, path=whole.path.with_name(f"run {number}")) for number in range(1000))
    assert opened.runs.found is not None
    opened.runs.found = replace(opened.runs.found, runs=many, unreadable=0)
    opened.source.clip = opened.runs.found.request.clip

    def one(state: AppState, run: ListedRun) -> None:
        drawn.append(run.path.name)
        draw_run(state, run)

    def draw(scroll: float = 0.0) -> None:
        imgui.set_scroll_y(scroll)
        draw_runs(opened)
        ends.append(imgui.get_cursor_pos_y())

    draw_run = runs._draw_run
    monkeypatch.setattr(runs, "_draw_run", one)
    for _ in range(3):
        drawn.clear()
        ui.frame(draw)
    assert drawn[0] == "run 0"
    assert 3 < len(drawn) < 40
    for _ in range(2):
        drawn.clear()
        ui.frame(lambda: draw(ends[0]))
    assert drawn[-1] == "run 999"
    assert 3 < len(drawn) < 40
    assert ends == pytest.approx([ends[0]] * len(ends))


def test_a_worded_button_opens_a_finished_run(
    ui: Ui, opened: AppState, monkeypatch: pytest.MonkeyPatch
) -> None:
    acts: list[Callable[[], object]] = []

    def button(label: str, act: Callable[[], object], *_: object, **__: object) -> None:
        acts.extend([act] * label.startswith("Open###"))

    monkeypatch.setattr(runs, "button", button)
    whole = named(opened, "whole")
    ui.frame(lambda: draw_runs(opened))
    (act,) = acts  # Of the unfinished run there is View model.
    act()
    assert opened.source.opening is not None
    assert opened.source.opening.path == whole.path


def kept_model(path: Path) -> Scene:
    """What is shown of a run folder."""
    (answer,) = open_path(OpenRequest(path))
    assert answer.run is not None
    assert answer.run.model is not None
    return answer.run.model


@pytest.mark.parametrize("method", get_args(Method))
def test_the_last_checkpoint_shows_the_model_as_training_left_it(
    folder: Path, tmp_path: Path, method: Method
) -> None:
    """At the end of a run that drops nothing it is the model itself."""
    config = replace(CONFIG, method=method, keep=("unseen", "hidden"))
    run = RunFolder(tmp_path / method)
    list(run_training(TrainRequest(clip_path=folder / "clip", run_path=run.path, config=config)))
    finished = kept_model(run.path)
    run.model_path.unlink()
    shown = kept_model(run.path)
    assert shown.live
    assert shown.iteration == shown.iterations >= config.iterations
    assert not finished.live
    assert (shown.cameras, shown.distance) == (finished.cameras, finished.distance)
    for name, values in finished.model.arrays().items():
        np.testing.assert_array_equal(shown.model.arrays()[name], values, err_msg=name)


def test_a_run_that_was_killed_is_looked_at_and_not_edited(opened: AppState) -> None:
    short = named(opened, "short")
    opened.runs.preview = None  # Another window made it.
    assert not run_actions.why_not_view(opened, short.path, has_checkpoint=short.has_checkpoint)
    run_actions.view_model(opened, short.path)
    channels = Channels()
    for step in range(3):
        update(opened, channels, 0.1 * step)
        channels.opening.run_waiting()
    assert opened.scene.model is not None
    assert (opened.scene.model.live, opened.scene.model.iteration) == (True, 8)
    assert opened.editing.base is None
    assert opened.runs.reconstruction.status == "cancelled"
    assert job_actions.can_continue(opened)


def test_damaged_checkpoints_are_no_model(folder: Path) -> None:
    short = folder / "runs" / "short"
    assert kept_model(short).iteration == 8
    for path in short.glob("checkpoint-*"):
        path.write_bytes(b"x")
    (answer,) = open_path(OpenRequest(short))
    assert answer.run is not None
    assert answer.run.model is None
