"""A clip whose brightness pumps is reconstructed in steady light; others as they were, and both are said."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

from app.commands.described.files import of_run
from app.evaluation.evaluate import open_evaluation
from app.gui.work.omissions import OmissionsRequest
from app.runs.run_folder import RunFolder
from app.runs.steadying import found_exposure
from app.runs.train_run import run_training
from renderer.depth import stereo_depth
from renderer.depth.stereo import disparity
from renderer.phantom import Phantom, PhantomParams, write_phantom
from renderer.sources import open_clip
from renderer.train.config import TrainConfig
from renderer.train.events import Evaluated, Progress, Started, Warned
from tests.app.conftest import request_of
from tests.app.looking import found_omissions
from tests.renderer.eyes import write_eyes

PARAMS = PhantomParams(n_frames=17, width=96, height=72, tools=0, pumping=0.15)
CONFIG = TrainConfig(iterations=60, n_gaussians=900, checkpoint_every=20)
STEADY = "steady"


class Trained(NamedTuple):
    run: RunFolder
    started: Started
    messages: list[str]
    psnr: float


@pytest.fixture(scope="module")
def clips(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    places = {name: tmp_path_factory.mktemp(name) / "clip" for name in ("pumping", STEADY)}
    write_phantom(places["pumping"], PARAMS)
    write_phantom(places[STEADY], replace(PARAMS, pumping=0.0))
    return places


@pytest.fixture(scope="module")
def trained(clips: dict[str, Path], tmp_path_factory: pytest.TempPathFactory) -> Callable[..., Trained]:
    @cache
    def train(clip: str = "pumping", config: TrainConfig = CONFIG) -> Trained:
        run = RunFolder(tmp_path_factory.mktemp("runs") / "run")
        events = list(run_training(request_of(clips[clip], run.path, config=config)))
        (started,) = (event for event in events if isinstance(event, Started))
        messages = [event.message for event in events if isinstance(event, Warned)]
        return Trained(
            run, started, messages, [each for each in events if isinstance(each, Evaluated)][-1].psnr
        )

    return train


WITHOUT = replace(CONFIG, leave_out=("exposure",))


def test_held_out_frames_are_closer_with_gains(trained: Callable[..., Trained]) -> None:
    """60 steps: the further a model is trained, the more the gains are worth."""
    assert trained().psnr > trained(config=WITHOUT).psnr + 1
    assert trained().psnr > trained(STEADY).psnr - 0.5


def test_the_run_records_the_gains_and_measures_by_them(trained: Callable[..., Trained]) -> None:
    record = trained().run.record()
    assert record.exposure is not None
    phantom = Phantom(PARAMS)
    truth = np.log([phantom.gain(index) for index in range(PARAMS.n_frames)])
    errors = np.log(record.exposure.gains) - truth
    assert np.std(errors) < 0.01  # Test frames among them; the phantom breathes.
    evaluation = open_evaluation(trained().run.path)
    measured = [frame.psnr for frame in evaluation.frames()]
    assert np.mean(measured) == pytest.approx(trained().psnr, abs=0.02)
    index = evaluation.indices[0]
    frame = evaluation.trained_clip.read_frame(index)
    assert frame.gain == record.exposure.gains[index]
    assert np.array_equal(frame.image, evaluation.clip.read_frame(index).image)


def test_it_is_said(trained: Callable[..., Trained]) -> None:
    used, without, steady = trained(), trained(config=WITHOUT), trained(STEADY)
    (line,) = (each for each in used.messages if "brightness" in each)
    assert line.endswith("each has a gain, and the model shows all of them in steady light")
    assert not any(each.what == "exposure" for each in used.started.omitted)
    (asked,) = (each for each in without.started.omitted if each.what == "exposure")
    assert (asked.why, asked.part) == ("as requested", None)
    assert without.run.record().exposure is None
    (left,) = (each for each in steady.started.omitted if each.what == "exposure")
    assert left.part == "exposure"
    assert left.why in [f"brightness changes by 0.{digit} % from frame to frame" for digit in range(4)]
    facts = [{fact.name: fact for fact in of_run(each.run.path)} for each in (used, steady, without)]
    assert "steady light" in facts[0]["exposure"].text
    assert facts[1]["exposure"].text.startswith("steady: ")
    assert "exposure" not in facts[2]


def test_the_window_says_so_before(trained: Callable[..., Trained], clips: dict[str, Path]) -> None:
    def exposure(clip: str, config: TrainConfig) -> list[object]:
        told = found_omissions(OmissionsRequest(open_clip(clips[clip]), config))
        return [each for each in told.lines if each.what == "exposure"]

    for clip, config in (("pumping", CONFIG), ("pumping", WITHOUT), (STEADY, CONFIG)):
        said = [each for each in trained(clip, config).started.omitted if each.what == "exposure"]
        assert exposure(clip, config) == said
    (kept,) = exposure(STEADY, replace(CONFIG, keep=("exposure",)))
    assert kept.part == "exposure"  # type: ignore[attr-defined]


def test_a_steady_clip_is_trained_as_without(trained: Callable[..., Trained]) -> None:
    steady, without = trained(STEADY), trained(STEADY, WITHOUT)
    assert steady.run.model_path.read_bytes() == without.run.model_path.read_bytes()


def test_nothing_is_said_of_how_one_frame_changes(clips: dict[str, Path]) -> None:
    one = open_clip(clips["pumping"]).between(0, 0)
    assert found_exposure(one, replace(CONFIG, keep=("exposure",)), lambda done, total: None) is None


def test_the_eyes_of_a_long_clip_are_not_matched_once_more_for_the_gains(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What its first window leaves is read by its images alone."""
    eyes = tmp_path / "eyes"
    write_eyes(eyes, "left/{:06d}.png", "right/{:06d}.png", 84, width=96, height=72, tools=0, pumping=0.15)
    matched = list[bool]()
    monkeypatch.setattr(stereo_depth, "disparity", lambda *pair: (matched.append(True), disparity(*pair))[1])

    def begun(name: str, config: TrainConfig) -> RunFolder:
        matched.clear()
        run = RunFolder(tmp_path / name)
        events = run_training(request_of(eyes, run.path, config=config))
        next(event for event in events if isinstance(event, Started))
        events.close()
        return run

    long = replace(CONFIG, method="static", window_frames=48)
    begun("without", replace(long, leave_out=("exposure",)))
    needed = len(matched)
    found = begun("with", long).record().exposure
    assert found is not None
    assert len(found.gains) == 84
    assert len(matched) == needed
    whole = begun("whole", replace(long, window_frames=400)).record().exposure
    assert whole == found


def test_a_run_that_is_cut_short_goes_on_to_the_same_model(
    trained: Callable[..., Trained], clips: dict[str, Path], tmp_path: Path
) -> None:
    """By the gains of its record: with others it would be another run, and is refused."""
    run = RunFolder(tmp_path / "run")
    request = request_of(clips["pumping"], run.path, config=CONFIG)
    events = run_training(request)
    next(event for event in events if isinstance(event, Progress))
    events.close()
    assert not run.is_finished
    list(run_training(replace(request, resume=True)))
    assert run.model_path.read_bytes() == trained().run.model_path.read_bytes()
    assert run.record().exposure == trained().run.record().exposure


def test_a_run_of_an_earlier_version_goes_on_without(clips: dict[str, Path], tmp_path: Path) -> None:
    run = RunFolder(tmp_path / "run")
    request = request_of(clips["pumping"], run.path, config=WITHOUT)
    events = run_training(request)
    next(event for event in events if isinstance(event, Progress))
    events.close()
    told = json.loads(run.record_path.read_text())
    del told["exposure"]
    run.record_path.write_text(json.dumps(told))
    list(run_training(replace(request, resume=True)))
    assert run.is_finished
    assert run.record().exposure is None


def test_a_published_method_is_trained_on_frames_as_they_are(trained: Callable[..., Trained]) -> None:
    run, started, messages, _ = trained(config=replace(CONFIG, method="deform3dgs", iterations=4))
    assert run.record().exposure is None
    assert not any("brightness" in each for each in messages)
    assert not any(each.what == "exposure" for each in started.omitted)
