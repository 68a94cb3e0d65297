"""What will be left out is told before, and is what training then says; what is kept, training keeps."""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
from imgui_bundle import ImVec2, imgui, imgui_ctx

from app.gui.actions import enhancement_actions, history_actions, job_actions
from app.gui.panels import reconstruction
from app.gui.panels.reconstruction import draw_reconstruction
from app.gui.state.app_state import AppState
from app.gui.update import taking
from app.gui.update.channels import Channels
from app.gui.update.jobs import start_due
from app.gui.update.update import update
from app.gui.work.omissions import Looking, Omissions, OmissionsRequest, find_omissions
from app.runs.train_run import TrainRequest
from renderer.sources import open_clip
from renderer.train.config import Part, TrainConfig
from renderer.train.events import Omission, Started
from renderer.train.training import train
from tests.app.gui.conftest import FakeJob
from tests.app.gui.ui import Ui
from tests.app.looking import found_omissions


def test_it_is_what_training_says_when_it_starts(clip_path: Path) -> None:
    clip = open_clip(clip_path)
    for config in (TrainConfig(iterations=1, n_gaussians=300), TrainConfig(method="static", iterations=1)):
        told = found_omissions(OmissionsRequest(clip, replace(config, iterations=3000)))
        started = next(iter(train(clip, config)))
        assert isinstance(started, Started)
        # Poses and exposure are decided on before training sees the frames.
        later = tuple(each for each in told.omitted if each.part not in ("poses", "exposure"))
        assert later == started.omitted
        assert told.omitted


def test_bars_of_a_moving_clip_are_left_out_as_in_training_which_follows_its_camera(
    unposed: Path, tmp_path: Path
) -> None:
    """Bars of many grey levels: where a camera rests they might be tissue."""
    path = shutil.copytree(unposed, tmp_path / "clip")
    ramp = np.linspace(40, 220, 160)[:, None]
    for image in (path / "images").glob("*.png"):
        pixels = cv2.imread(str(image))
        pixels[:6] = ramp
        cv2.imwrite(str(image), pixels)
    told = found_omissions(OmissionsRequest(open_clip(path), TrainConfig(iterations=1, n_gaussians=300)))
    assert "surround" in {each.part for each in told.omitted}
    assert "poses" not in {each.part for each in told.omitted}


def test_it_is_looked_up_only_when_asked_for_and_not_for_more_iterations(
    state: AppState, clip_path: Path
) -> None:
    state.source.clip, channels = open_clip(clip_path), Channels()
    update(state, channels, 0.1)
    assert channels.omissions.asked is None
    state.runs.asks_for_omissions = True
    update(state, channels, 0.2)
    first = channels.omissions.asked
    assert channels.omissions.run_waiting()
    update(state, channels, 0.3)
    assert isinstance(state.runs.omissions, Omissions)
    state.runs.reconstruction.config = replace(state.runs.reconstruction.config, iterations=500)
    update(state, channels, 0.4)
    assert channels.omissions.asked is first
    state.runs.reconstruction.config = replace(state.runs.reconstruction.config, method="static")
    update(state, channels, 0.5)
    assert channels.omissions.asked != first


def test_each_part_that_can_be_kept_stays_in_when_it_is_and_keeps_its_line(clip_path: Path) -> None:
    clip, config = open_clip(clip_path), TrainConfig()
    before = found_omissions(OmissionsRequest(clip, config))
    parts = [each.part for each in before.lines if each.part is not None]
    assert "harmonics" in parts
    assert not before.kept
    for part in parts:
        kept_config = replace(config, keep=(part,))
        after = found_omissions(OmissionsRequest(clip, kept_config))
        assert part not in [each.part for each in after.omitted]
        assert [each.part for each in after.kept] == [part]
        # More can be left out of what is kept, such as numbers of its curves.
        assert [each.part for each in after.lines if each.part in parts] == parts
        assert after.request.unkept == before.request


def test_what_the_method_or_a_setting_takes_away_cannot_be_kept(clip_path: Path) -> None:
    clip = open_clip(clip_path)
    asked = TrainConfig(method="static", sh_degree=0)
    told = found_omissions(OmissionsRequest(clip, asked))
    parts = {each.what: each.part for each in told.omitted}
    assert parts["harmonics"] is None
    assert parts["deformation"] is None
    without = TrainConfig(leave_out=("deformation", "color_curves"))
    told = found_omissions(OmissionsRequest(clip, without))
    for part in (each.part for each in told.omitted if each.part is not None):
        replace(without, keep=(part,))  # Never both kept and left out.


def test_what_is_kept_reaches_the_job_as_from_the_command_line_and_is_undone(
    state: AppState, clip_path: Path
) -> None:
    state.source.clip = open_clip(clip_path)
    both: tuple[Part, ...] = ("harmonics", "tiles")
    for part in both:
        job_actions.keep_part(state, part, kept=True)
        job_actions.keep_part(state, part, kept=True)
        enhancement_actions.settle_params(state)
    jobs: list[TrainRequest] = []

    def make_job(request: TrainRequest) -> FakeJob:
        jobs.append(request)
        return FakeJob(request)

    job_actions.start_reconstruction(state)

    start_due(state, make_job)
    assert [job.config for job in jobs] == [TrainConfig(keep=both)]
    job_actions.keep_part(state, "tiles", kept=False)
    assert state.runs.reconstruction.config.keep == ("harmonics",)
    assert jobs[0].config.keep == both
    history_actions.undo(state)
    assert state.runs.reconstruction.config.keep == both
    history_actions.undo(state)
    history_actions.undo(state)
    assert state.runs.reconstruction.config == TrainConfig()


def test_what_a_run_left_out_is_explained_where_a_person_unfolds_it(
    ui: Ui, opened: AppState, monkeypatch: pytest.MonkeyPatch
) -> None:
    run, said = opened.runs.reconstruction, list[str]()
    run.status = "running"
    run.started = Started(0, 100, 30, (Omission("tiles", "no tissue to compare with", "24 % of the tiles"),))
    monkeypatch.setattr(reconstruction, "note", lambda text, color=None: said.append(text))
    ui.frame(lambda: draw_reconstruction(opened))
    assert not any("Tiles" in text for text in said)
    fold = imgui.tree_node

    def unfolded(label: str) -> bool:
        imgui.set_next_item_open(True)
        return fold(label)

    monkeypatch.setattr(imgui, "tree_node", unfolded)
    ui.frame(lambda: draw_reconstruction(opened))
    assert "Tiles: no tissue to compare with" in said


def test_how_far_it_is_is_said_meanwhile(
    ui: Ui, opened: AppState, clip_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    opened.source.clip, opened.runs.asks_for_omissions = open_clip(clip_path), True
    said = list[str]()
    monkeypatch.setattr(reconstruction, "muted", said.append)
    monkeypatch.setattr(imgui, "tree_node", lambda label: label == "What will be left out")
    monkeypatch.setattr(imgui, "tree_pop", lambda: None)
    request = opened.omissions_request
    assert request is not None
    steps = find_omissions(request)
    first = next(steps)
    assert isinstance(first, Looking)
    assert (first.frames, first.count) == (1, len(open_clip(clip_path).train_indices))
    taking.take_omissions(opened, request, first)
    assert opened.runs.omissions is None
    ui.frame(lambda: draw_reconstruction(opened))
    assert f"Analysing the clip: 1 of {first.count} frames" in said
    for step in steps:
        taking.take_omissions(opened, request, step)
    said.clear()
    ui.frame(lambda: draw_reconstruction(opened))
    assert opened.runs.omissions is not None
    assert not any("Analysing" in line for line in said)


def test_in_a_low_window_what_unfolds_comes_into_sight(
    ui: Ui, opened: AppState, clip_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    opened.source.clip, tops, height = open_clip(clip_path), list[ImVec2](), 600.0
    fold = imgui.tree_node

    def followed(label: str) -> bool:
        unfolded = fold(label)
        tops.append(imgui.get_item_rect_min())
        return unfolded

    def draw() -> None:
        with imgui_ctx.begin_child("low", ImVec2(320, height)):
            draw_reconstruction(opened)

    monkeypatch.setattr(imgui, "tree_node", followed)
    for _ in range(3):
        ui.frame(draw)
    height = tops[-1].y + 60  # Its line is the last one above the button.
    for _ in range(3):
        ui.frame(draw)
    before = tops[-1]
    ui.drag(draw, (before.x + 30, before.y + 8), (before.x + 30, before.y + 8))
    for _ in range(3):
        ui.frame(draw)
    assert opened.runs.asks_for_omissions
    assert tops[-1].y < before.y - 60
