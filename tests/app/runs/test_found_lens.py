"""A lens that training finds undistorts the images of that very run, whatever is done with it afterwards."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from app.commands.described.files import of_run
from app.errors import UserError
from app.evaluation.evaluate import open_evaluation
from app.gui.work.opened_run import request_of
from app.runs import structuring
from app.runs.clip_selection import ClipPart
from app.runs.posing import Posed
from app.runs.run_folder import RunFolder
from app.runs.structuring import UNDISTORTED, structured
from app.runs.train_run import TrainRequest, run_training
from app.runs.trained_clip import run_clip
from app.scenes.scene import open_scene
from enhance import EnhanceParams
from renderer.clip import Clip
from renderer.phantom import PhantomParams
from renderer.poses.distortion import Distortion
from renderer.poses.from_motion import FoundStructure, followed_features, structure_of
from renderer.poses.search import PosesError
from renderer.readers.clip_options import ClipOptions
from renderer.readers.lenses.calibration import Calibration, LensCalibration
from renderer.sources import open_clip
from renderer.train.config import TrainConfig
from renderer.train.events import Progress, Started, TrainEvent, Warned
from tests.app.conftest import Cli
from tests.app.runs.moving_images import moving_images

CONFIG = TrainConfig(iterations=6, n_gaussians=300, checkpoint_every=2)
LEFT_OUT = replace(CONFIG, leave_out=("lens",))
PARAMS = PhantomParams(n_frames=12, width=96, height=80, seed=5, camera="moving", tissue="static", tools=0)
MOTION = ClipOptions(depth="motion")
K1, DEVIATION = -0.2, 0.004
SAID = "images are undistorted: the lens bends straight lines"
Find = Callable[..., None]


@pytest.fixture(scope="module")
def images(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return moving_images(tmp_path_factory.mktemp("moving"), PARAMS)


@pytest.fixture(scope="module")
def found(images: Path) -> FoundStructure:
    clip = open_clip(images, MOTION)
    structure = structure_of(clip, followed_features(clip), focal_is_known=True)
    lens = structure.poses.cameras[0]
    return replace(structure, distortion=Distortion(K1, DEVIATION, lens, 1.0))


@pytest.fixture
def finding(found: FoundStructure, monkeypatch: pytest.MonkeyPatch) -> Find:
    """As if its lens were bent; `again` is what is found once it is undistorted, in place of the same."""

    def find(again: FoundStructure | Exception = found, **changes: Any) -> None:
        told = replace(found, distortion=replace(found.distortion, **changes))  # type: ignore[type-var]

        def structure(*_: object, focal_is_known: bool, **__: object) -> FoundStructure:
            if focal_is_known and isinstance(again, Exception):
                raise again
            return again if focal_is_known and isinstance(again, FoundStructure) else told

        monkeypatch.setattr(structuring, "followed_features", lambda *_: None)
        monkeypatch.setattr(structuring, "structure_of", structure)

    return find


def request_of_images(path: Path, run: Path, **changes: Any) -> TrainRequest:
    asked = TrainRequest(clip_path=path, run_path=run, config=CONFIG, clip_options=MOTION)
    return replace(asked, **changes)


def through(clip: Clip, config: TrainConfig = CONFIG, *, drawn_on: bool = False) -> Posed:
    events = structured(clip, config, MOTION, drawn_on=drawn_on)
    while True:
        try:
            next(events)
        except StopIteration as ended:
            return ended.value  # type: ignore[no-any-return]


def cut_short(request: TrainRequest) -> None:
    """After the first iterations, as where its process is killed: what is written then stays."""
    events = run_training(request)
    next(event for event in events if isinstance(event, Progress))
    events.close()


def test_images_are_undistorted_where_the_lens_is_found(images: Path, finding: Find) -> None:
    finding()
    posed = through(open_clip(images, MOTION))
    assert posed.lens is not None
    assert posed.lens.lens.distortion == (K1, 0, 0, 0)
    assert posed.lens.found is not None
    assert posed.lens.found.deviation == DEVIATION
    said = [each for each in posed.notices if each.startswith(SAID)]
    assert len(said) == 1
    assert "k1 = -0.200, standard deviation 0.004" in said[0]
    assert not any("--calibration" in each for each in posed.notices)
    straight = open_clip(images, replace(MOTION, calibration=posed.lens))
    assert np.array_equal(posed.clip.read_frame(3).image, straight.read_frame(3).image)
    assert said[0] in straight.notices


def test_they_stay_as_they_are_where_that_is_wanted(images: Path, finding: Find) -> None:
    finding()
    clip = open_clip(images, MOTION)
    refused, drawn_on = through(clip, LEFT_OUT), through(clip, drawn_on=True)
    for posed in (refused, drawn_on):
        assert posed.lens is None
        assert posed.clip.cameras[0].fx == pytest.approx(clip.cameras[0].fx)
        assert any("--calibration lens.json undistorts" in each for each in posed.notices)
    assert refused.omitted == (UNDISTORTED,)
    assert drawn_on.omitted == ()


def test_they_stay_as_they_are_where_less_would_be_found(
    images: Path, finding: Find, found: FoundStructure
) -> None:
    clip, poses = open_clip(images, MOTION), found.poses
    fewer = replace(poses, cameras=poses.cameras[:-1], residuals=poses.residuals[:-1])
    for again in (replace(found, poses=fewer), PosesError("the camera does not move")):
        finding(again)
        assert through(clip).lens is None


@pytest.mark.parametrize("changes", [{"k1": 0.01}, {"rigid": 0.6}, {"deviation": 0.1}])
def test_they_stay_as_they_are_where_nothing_is_certain(
    images: Path, finding: Find, changes: dict[str, float]
) -> None:
    finding(**changes)
    posed = through(open_clip(images, MOTION), LEFT_OUT)
    assert posed.lens is None
    assert posed.omitted == ()
    assert posed.notices == through(open_clip(images, MOTION)).notices


def test_a_run_keeps_the_lens_and_resumes_to_the_same_bits(
    images: Path, tmp_path: Path, finding: Find
) -> None:
    finding()
    whole = RunFolder(tmp_path / "whole")
    told = list[TrainEvent](run_training(request_of_images(images, whole.path)))
    assert sum(isinstance(event, Warned) and event.message.startswith(SAID) for event in told) == 1
    kept = json.loads(whole.record_path.read_bytes())["clip"]["options"]["calibration"]
    assert kept["lens"]["distortion"] == [K1, 0, 0, 0]
    assert kept["found"] == {"by": "camera motion", "deviation": DEVIATION}
    for name, options in (("asked", MOTION), ("recorded", whole.record().clip.options)):
        run = RunFolder(tmp_path / name)
        cut_short(request_of_images(images, run.path))
        again = request_of_images(images, run.path, clip_options=options, resume=True)
        said = list(run_training(again))
        assert any(isinstance(event, Started) and event.iteration > 0 for event in said)
        assert run.model_path.read_bytes() == whole.model_path.read_bytes()
        assert replace(run.record(), created="") == replace(whole.record(), created="")


def test_what_is_read_again_is_what_was_trained_on(images: Path, tmp_path: Path, finding: Find) -> None:
    finding()
    run = RunFolder(tmp_path / "run")
    list(run_training(request_of_images(images, run.path)))
    record, seen = run.record(), through(open_clip(images, MOTION)).clip
    for clip in (run_clip(record), open_evaluation(run.path).clip):
        assert clip.calibrated
        assert np.array_equal(clip.read_frame(1).image, seen.read_frame(1).image)
        assert clip.cameras == seen.cameras == record.cameras
    lens = next(fact for fact in of_run(run.path) if fact.name == "lens")
    assert "k1 = -0.200, standard deviation 0.004" in str(lens.text)
    source = open_scene(run.path).record.clip
    assert source is not None
    assert source.calibration is not None
    assert source.calibration == record.clip.options.calibration
    assert request_of(run, record).clip_options.reads_as(MOTION)


def test_a_run_with_another_lens_is_not_that_run(images: Path, tmp_path: Path, finding: Find) -> None:
    finding()
    cut_short(request_of_images(images, tmp_path / "run"))
    lens = LensCalibration(fx=90, fy=90, cx=47.5, cy=39.5, distortion=(-0.1, 0, 0, 0))
    given = replace(MOTION, calibration=Calibration(lens=lens))
    assert not given.reads_as(MOTION)
    asked = request_of_images(images, tmp_path / "run", clip_options=given, resume=True)
    with pytest.raises(UserError, match="expected the run's calibration None, got"):
        list(run_training(asked))


def test_a_run_of_before_goes_on_without_one(
    images: Path, tmp_path: Path, finding: Find, monkeypatch: pytest.MonkeyPatch
) -> None:
    finding()
    run = RunFolder(tmp_path / "run")
    with monkeypatch.context() as before:
        before.setattr(structuring, "found_lens", lambda *_: None)
        cut_short(request_of_images(images, run.path))
    list(run_training(request_of_images(images, run.path, resume=True)))
    assert run.record().clip.options == MOTION
    assert not run_clip(run.record()).calibrated


def test_images_that_are_masked_by_hand_stay_as_they_are(images: Path, tmp_path: Path, finding: Find) -> None:
    finding()
    part = ClipPart()
    part = replace(part, mask=replace(part.mask, text=(0, 0, 12, 9)))
    enhanced = request_of_images(images, tmp_path / "run", part=part, input="enhanced")
    list(run_training(replace(enhanced, enhance_params=EnhanceParams(d_factor=0.5))))
    assert RunFolder(tmp_path / "run").record().clip.options == MOTION


def test_it_is_not_compared_with_a_run_on_images_as_they_are(
    images: Path, tmp_path: Path, finding: Find, vesselsplat: Cli
) -> None:
    finding()
    list(run_training(request_of_images(images, tmp_path / "run")))
    list(run_training(request_of_images(images, tmp_path / "bent", config=LEFT_OUT)))
    call = vesselsplat("evaluate", tmp_path / "run", "--against", tmp_path / "bent")
    assert call.code == 2
    assert "expected a run on frames that were read in the same way" in call.error
