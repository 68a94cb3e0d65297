"""A motion that is no spline, on a page for browsers: sampled as its error asks for, or that is told."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from app.exports.browser.of_scene import browser_model, far_off, page_windows
from app.exports.browser.page import read_page
from app.exports.browser.samples import USUAL, Sampling, sampled
from app.exports.browser.tracks import tracks_of
from app.exports.make import make
from app.exports.records import BrowserModel
from app.exports.sources import Opened
from app.files.stepping import run_to_end
from app.runs.train_run import run_training
from app.scenes.records import SceneRecord
from app.scenes.scene import Scene
from renderer.camera import Camera
from renderer.deformation.fdm import CENTRE, WEIGHT, WIDTH, FlexibleMotion
from renderer.gaussians import DynamicGaussians
from renderer.raw_gaussians import RawGaussians
from renderer.train.config import TrainConfig
from tests.app.conftest import Cli, request_of
from tests.app.exports.test_browser import drawn

FRAMES, BEAT, HEIGHT = 250, 20, 2.0
"""Ten seconds, 75 beats a minute, 2 mm."""
CAMERA = Camera.from_fov(60.0, 640, 512)


def beating(width: float = 4 / FRAMES) -> DynamicGaussians:
    """Two Gaussians, the second of which stays where it is."""
    beats = np.arange(13) * BEAT + 7
    bumps = np.zeros((len(beats), 2, 3, 10), np.float32)
    bumps[:, :, WIDTH] = width
    bumps[:, :, CENTRE] = beats[:, None, None] / FRAMES
    bumps[:, 0, WEIGHT, 0] = HEIGHT
    raw = RawGaussians(
        means=np.float32([[0, 0, 60], [9, 0, 60]]),
        quats=np.float32([[1, 0, 0, 0]] * 2),
        log_scales=np.zeros((2, 3), np.float32),
        opacity_logits=np.float32([2, 2]),
        colors=np.full((2, 3), 0.5, np.float32),
        harmonics=np.zeros((2, 0, 3), np.float32),
    )
    return DynamicGaussians(raw, FlexibleMotion(bumps))


def scene_of(model: DynamicGaussians) -> Scene:
    return Scene(
        name="run", model=model, cameras=(CAMERA,) * FRAMES, distance=60.0, mode="default", unit="mm",
        record=SceneRecord(), iterations=10,
    )  # fmt: skip


def page_error(model: DynamicGaussians, sampling: Sampling | None) -> float:
    """The largest at a frame, of what the page draws by its own rules."""
    tracks = tracks_of(model, sampling)
    pages = (drawn(tracks, at / FRAMES)["means"] for at in range(FRAMES))
    moved = (model.motion.moved(model.raw, at / FRAMES).means for at in range(FRAMES))
    return max(float(np.abs(page - true).max()) for page, true in zip(pages, moved, strict=True))


def test_a_heart_beat_keeps_its_height() -> None:
    model, asked = beating(), Sampling(FRAMES, 0.03, 10_000)
    found = sampled(model, asked)
    assert found.error is not None
    assert found.error <= 0.03
    assert page_error(model, asked) <= 0.03 + 1e-3
    assert page_error(model, None) > 0.5, "at the usual moments"


def test_a_slow_motion_takes_no_more_than_the_usual_moments() -> None:
    slow = beating(width=0.5)
    assert len(sampled(slow, Sampling(FRAMES, 0.03, 10_000)).moments) == USUAL
    assert len(sampled(slow, None).moments) == USUAL


def test_no_more_than_a_sample_at_each_frame_and_none_is_off_there() -> None:
    found = sampled(beating(), Sampling(FRAMES, 0.0, 10_000))
    assert len(found.moments) == FRAMES + 1
    assert found.error == pytest.approx(0, abs=1e-4)
    few = sampled(beating(), Sampling(30, 0.0, 10_000))
    assert len(few.moments) == 31


def test_what_a_page_cannot_hold_is_an_error_that_is_measured() -> None:
    model, asked = beating(), Sampling(FRAMES, 0.03, 60)
    found = sampled(model, asked)
    assert len(found.moments) == 60
    assert found.error == pytest.approx(page_error(model, asked), abs=1e-3)


def written(scene: Scene, path: Path) -> tuple[BrowserModel, str]:
    """What a page says of itself, and all of it."""
    run_to_end(make(browser_model(scene, CAMERA, 25.0), Opened(model=scene), path))
    text = path.read_text()
    facts, _, _ = read_page(text)
    return BrowserModel(**{name: facts[name] for name in facts if name in BrowserModel.__annotations__}), text


def test_the_page_says_how_far_it_is_off(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    scene = scene_of(beating())
    record, text = written(scene, tmp_path / "a.html")
    assert record.tolerance == pytest.approx(0.25 * 60 / CAMERA.fx)
    assert record.error is not None
    assert record.error <= record.tolerance
    assert "an error of up to" not in text
    monkeypatch.setattr("app.exports.browser.of_scene.MOST_VALUES", 2 * 60)
    record, text = written(scene, tmp_path / "b.html")
    assert record.error is not None
    said = f"Reconstruction, shown with an error of up to {record.error:.2g} mm. Grey: what no frame showed"
    assert f"<p>{said}</p>" in text
    assert far_off(record, "mm") == f"shown with an error of up to {record.error:.2g} mm"
    assert page_windows(scene, None, None)[0].tracks.error is None, "as earlier versions sampled"


def test_a_run_of_such_a_motion_is_a_page_that_comes_again(
    clip_path: Path, tmp_path: Path, vesselsplat: Cli, monkeypatch: pytest.MonkeyPatch
) -> None:
    run, page = tmp_path / "run", tmp_path / "a.html"
    config = TrainConfig(method="deform3dgs", iterations=20, n_gaussians=300)
    list(run_training(request_of(clip_path, run, config=config)))
    monkeypatch.setattr("app.exports.browser.of_scene.TOLERANCE", 1e-6)
    assert vesselsplat("export", run, "--html", page).code == 0
    _, scene, _ = read_page(page.read_text())
    assert scene["windows"][0]["tracks"][0]["moments"] == 11
    monkeypatch.undo()
    again = vesselsplat("replay", page, "--source", run)
    assert again.out.rstrip().endswith("identical"), again.error + again.out
