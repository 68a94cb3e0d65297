"""Images alone are reconstructed from the motion of their camera, up to scale, or refused in one line."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from app.evaluation.evaluate import open_evaluation
from app.runs import structuring
from app.runs.dark_surround import lit_field, lit_part
from app.runs.lens_notice import UNBENT
from app.runs.posing import Posed
from app.runs.run_folder import RunFolder
from app.runs.structuring import structured
from app.runs.train_run import TrainRequest, run_training
from app.runs.trained_clip import run_clip
from renderer.clip import Clip, ClipError
from renderer.phantom import PhantomParams
from renderer.poses.from_motion import FoundStructure, followed_features, structure_of
from renderer.readers.clip_options import ClipOptions
from renderer.readers.lenses.calibration import Calibration, LensCalibration
from renderer.sources import open_clip
from renderer.train.config import TrainConfig
from renderer.train.events import Started, Warned
from tests.app.runs.moving_images import moving_images

CONFIG = TrainConfig(iterations=4, n_gaussians=500)
PARAMS = PhantomParams(n_frames=12, width=160, height=128, seed=5, camera="moving", tissue="static")
RADIUS = 60
"""px, of the round view."""
MOTION = ClipOptions(depth="motion")


@pytest.fixture(scope="module")
def images(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return moving_images(tmp_path_factory.mktemp("moving"), PARAMS)


@pytest.fixture(scope="module")
def round_images(images: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The same through a round view, with a mark in two corners that stays where it is."""
    path = tmp_path_factory.mktemp("round")
    y, x = np.mgrid[:128, :160] + 0.5
    surround = np.hypot(x - 80, y - 64) > RADIUS
    page = np.full((128, 160, 3), 3, np.uint8)
    mark = cv2.resize(np.random.default_rng(0).integers(60, 200, (9, 9), np.uint8), (27, 27))
    page[:27, :27] = page[-27:, :27] = mark[..., None]
    for file in images.iterdir():
        image = cv2.imread(str(file))
        assert image is not None
        cv2.imwrite(str(path / file.name), np.where(surround[..., None], page, image))
    return path


def request_of(path: Path, run: Path, config: TrainConfig = CONFIG, resume: bool = False) -> TrainRequest:
    return TrainRequest(clip_path=path, run_path=run, config=config, clip_options=MOTION, resume=resume)


def test_poses_shape_and_what_is_guessed_are_recorded_and_a_run_resumes_with_them(
    images: Path, tmp_path: Path
) -> None:
    events = run_training(request_of(images, tmp_path / "run"))
    said = [next(event for event in events if isinstance(event, Started))]
    said += [next(events) for _ in range(4)]
    events.close()
    told = [event.message for event in said if isinstance(event, Warned)]
    assert any("lengths have no scale" in message for message in told)
    assert any("field of view is estimated" in message for message in told)
    assert not any("distances are uncertain" in message for message in told)
    before = RunFolder(tmp_path / "run").record()
    poses = before.clip.poses
    assert poses is not None
    assert before.unit == "scene units"
    assert max(each for each in poses.residuals if each is not None) < 1
    assert len({camera.position.tobytes() for camera in before.cameras}) == before.clip.frames
    clip = run_clip(before)
    assert clip.points is not None
    depths = clip.cameras[0].project(clip.points.positions)[1]
    assert 60 < np.median(depths) < 160

    list(run_training(request_of(images, tmp_path / "run", resume=True)))
    assert RunFolder(tmp_path / "run").record() == before
    frames = open_evaluation(tmp_path / "run")
    assert frames.clip.points is not None
    assert frames.clip.cameras == before.cameras


def told(clip: Clip, options: ClipOptions) -> Posed:
    events = structured(clip, CONFIG, options)
    while True:
        try:
            next(events)
        except StopIteration as ended:
            return ended.value  # type: ignore[no-any-return]


@pytest.fixture(scope="module")
def found(images: Path) -> FoundStructure:
    """With a field of view that is assumed."""
    clip = open_clip(images, MOTION)
    return structure_of(clip, followed_features(lit_part(clip)), focal_is_known=False)


@pytest.fixture
def finding(found: FoundStructure, monkeypatch: pytest.MonkeyPatch) -> Callable[..., None]:
    """That is found at once, but for what a test changes of it."""

    def find(**changes: Any) -> None:
        monkeypatch.setattr(structuring, "followed_features", lambda *_: None)
        monkeypatch.setattr(structuring, "structure_of", lambda *_, **__: replace(found, **changes))

    return find


def test_a_field_of_view_that_is_stated_is_kept_whatever_it_is(
    images: Path, finding: Callable[..., None]
) -> None:
    clip = open_clip(images, replace(MOTION, field_of_view=60.0))
    stated = told(clip, replace(MOTION, field_of_view=60.0))
    finding()
    assumed = told(clip, MOTION)
    assert stated.clip.cameras[0].fx == clip.cameras[0].fx != assumed.clip.cameras[0].fx
    assert not any("field of view is estimated" in said for said in stated.notices)
    assert any("field of view is estimated" in said for said in assumed.notices)
    assert UNBENT in stated.notices
    assert any(said.startswith(UNBENT) for said in assumed.notices)


def test_of_a_lens_that_is_known_no_guess_is_said(images: Path, finding: Callable[..., None]) -> None:
    lens = LensCalibration(fx=140, fy=140, cx=79.5, cy=63.5, distortion=(-0.1, 0, 0, 0))
    options = replace(MOTION, calibration=Calibration(lens=lens))
    finding()
    notices = told(open_clip(images, options), options).notices
    assert not any(said.startswith(UNBENT) for said in notices)
    assert not any("field of view" in said for said in notices)


def test_uncertain_distances_are_said(images: Path, tmp_path: Path, finding: Callable[..., None]) -> None:
    finding(depth_error=0.12)
    events = run_training(request_of(images, tmp_path / "run"))
    told = next(event for event in events if isinstance(event, Warned) and "uncertain" in event.message)
    events.close()
    assert "a point's depth may be off by some 12 %" in told.message


@pytest.mark.parametrize("moves", [None, "the background moves by 9 % of the image width"])
def test_images_that_hardly_shift_are_said_to(
    images: Path, moves: str | None, finding: Callable[..., None], monkeypatch: pytest.MonkeyPatch
) -> None:
    finding()
    monkeypatch.setattr(structuring, "camera_motion", lambda _: moves)
    said = told(open_clip(images, MOTION), MOTION).notices
    assert any("the camera may be fixed" in each for each in said) == (moves is None)


def test_a_field_of_view_that_is_not_settled_is_said(images: Path, finding: Callable[..., None]) -> None:
    clip = open_clip(images, MOTION)

    def doubts() -> list[str]:
        return [said for said in told(clip, MOTION).notices if "field of view is uncertain" in said]

    finding()
    assert not doubts()
    finding(focal_left=0.08)
    assert "still changed by 8 %" in doubts()[0]


def test_a_camera_that_keeps_its_place_is_refused_and_leaves_no_run(images: Path, tmp_path: Path) -> None:
    first = sorted(images.iterdir())[0]
    (tmp_path / "still").mkdir()
    for index in range(9):
        shutil.copy(first, tmp_path / "still" / f"{index}.png")
    wanted = r"the camera does not move \(--depth brightness estimates it, without a scale\): .*still$"
    with pytest.raises(ClipError, match=wanted):
        list(run_training(request_of(tmp_path / "still", tmp_path / "run")))
    assert not (tmp_path / "run").exists()


def test_what_cannot_be_is_refused_before_frames_are_read(images: Path, tmp_path: Path) -> None:
    with pytest.raises(ClipError, match="got one that has them"):
        list(run_training(request_of(images.parent / "clip", tmp_path / "run")))
    refused = TrainConfig(iterations=4, n_gaussians=500, leave_out=("poses",))
    with pytest.raises(ClipError, match="got them left out"):
        list(run_training(request_of(images, tmp_path / "run", refused)))


def test_what_stays_beside_the_view_is_not_followed(round_images: Path) -> None:
    def beyond(clip: Clip) -> int:
        """How many places of features lie outside the view."""
        parts = followed_features(clip).parts
        places = np.concatenate([sight.places for part in parts for sight in part.sights])
        return int((np.hypot(places[:, 0] - 80, places[:, 1] - 64) > RADIUS).sum())

    clip = open_clip(round_images, MOTION)
    assert beyond(clip) > 100
    assert beyond(lit_part(clip)) == 0


def test_the_rim_of_the_view_stays_where_the_camera_moves_and_is_left_out(
    round_images: Path, tmp_path: Path
) -> None:
    list(run_training(request_of(round_images, tmp_path / "run")))
    field = RunFolder(tmp_path / "run").record().clip.part.field_of_view
    clip = open_clip(round_images, MOTION)
    whole = lit_field(map(clip.read_frame, range(len(clip))))
    assert field is not None
    assert whole is not None
    assert 0 < np.count_nonzero(whole.mask() & ~field.mask()) < 0.1 * np.count_nonzero(whole.mask())
    assert not np.any(field.mask() & ~whole.mask())
