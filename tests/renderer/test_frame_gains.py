"""Gains of frames: those of a clip that pumps are found, and nothing that a frame may be makes them wild."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
import pytest

from renderer.camera import Camera, FloatArray
from renderer.clip import ByteImage, Frame
from renderer.frame_gains import (
    APART,
    REST,
    exposed,
    jitter,
    log_gain_beside,
    log_gains,
    steadied,
    with_gains,
)
from renderer.phantom import Phantom, PhantomParams
from renderer.train.frames import as_fitted
from tests.renderer.plane import plane_clip

WIDTH, HEIGHT, BROKEN = 64, 48, 5
LENS = Camera.from_fov(60, WIDTH, HEIGHT)
TISSUE = np.ones((HEIGHT, WIDTH), bool)
PUMPING = (1.0, 1.1, 0.92, 1.04, 0.9, 1.08, 0.97, 1.1, 0.93, 1.0, 1.06, 0.9, 1.05, 0.95)


def surface(seed: int = 0) -> FloatArray:
    """(H, W, 3) grey levels of smooth tissue."""
    rough = np.random.default_rng(seed).uniform(-1, 1, (HEIGHT, WIDTH, 1))
    smooth = cv2.GaussianBlur(rough, (0, 0), 3)[..., None]
    return np.asarray(100 + 40 * smooth / np.abs(smooth).max() * np.ones(3))


def frame_of(levels: FloatArray, index: int = 0) -> Frame:
    image = np.clip(np.rint(levels), 0, 255).astype(np.uint8)
    return Frame(index, index / len(PUMPING), image, LENS, TISSUE, TISSUE)


def pumping() -> list[Frame]:
    return [frame_of(gain * surface(), index) for index, gain in enumerate(PUMPING)]


def off(found: FloatArray, sound: list[int]) -> float:
    """How far gains are from the true ones, over the frames that are sound, but for what drifts."""
    errors = (found - np.log(PUMPING))[sound]
    return float(np.std(errors))


@pytest.mark.parametrize("pumped", [0.02, 0.2])
@pytest.mark.parametrize(("camera", "tissue"), [("fixed", "moving"), ("moving", "static")])
def test_what_a_phantom_pumps_by_is_found(camera: str, tissue: str, pumped: float) -> None:
    """Within 0.3 % from frame to frame: the light on what comes and goes as a camera moves drifts slowly."""
    params = PhantomParams(n_frames=24, width=128, height=96, camera=camera, tissue=tissue, pumping=pumped)  # type: ignore[arg-type]
    phantom = Phantom(params)
    truth = np.log([phantom.gain(index) for index in range(24)])
    found = log_gains(phantom.view(index).frame for index in range(24))
    assert jitter(truth) > 0.4 * pumped
    assert jitter(found - truth) < 0.003
    if camera == "fixed":
        assert np.std(found - truth) < 0.02 * (0.2 + pumped)


def test_a_phantom_that_does_not_pump_is_steady() -> None:
    phantom = Phantom(PhantomParams(n_frames=8, width=128, height=96))
    assert [phantom.gain(index) for index in range(8)] == [1.0] * 8
    assert jitter(log_gains(phantom.view(index).frame for index in range(8))) < 0.003


def test_the_same_tissue_gives_its_gains() -> None:
    assert off(log_gains(pumping()), list(range(len(PUMPING)))) < 0.003


def test_they_are_the_least_squares() -> None:
    """Against normal equations that are written out; of a scene that is exact there is one ratio a pair."""
    frames = pumping()
    count, truth = len(frames), np.log([np.median(frame.image / surface()) for frame in frames])
    matrix, right = REST**2 * np.eye(count), np.zeros(count)
    for apart in APART:
        for place in range(count - apart):
            row = np.zeros(count)
            row[place + apart], row[place] = 1, -1
            matrix += np.outer(row, row)
            right += row * (truth[place + apart] - truth[place])
    assert np.abs(log_gains(frames) - np.linalg.solve(matrix, right)).max() < 0.003


BLACK, WHITE = np.zeros((HEIGHT, WIDTH, 3)), np.full((HEIGHT, WIDTH, 3), 255.0)


@pytest.mark.parametrize(
    "levels",
    [BLACK, WHITE, 4 * surface(), 1000 * surface(), 0.01 * surface()],
    ids=["black", "clipped", "four times as bright", "flash", "hardly lit"],
)
def test_a_broken_frame_leaves_those_of_others(levels: FloatArray) -> None:
    frames = pumping()
    frames[BROKEN] = frame_of(levels, BROKEN)
    found = log_gains(frames)
    assert off(found, [place for place in range(len(frames)) if place != BROKEN]) < 0.003
    assert np.isfinite(found).all()
    assert np.abs(found).max() < 0.2


def test_a_flash_that_is_not_clipped_is_found() -> None:
    frames = pumping()
    frames[BROKEN] = frame_of(1.6 * surface(), BROKEN)
    found = log_gains(frames)
    assert found[BROKEN] - found[BROKEN - 1] == pytest.approx(np.log(1.6 / PUMPING[BROKEN - 1]), abs=0.004)
    assert jitter(found) > 0.1


def test_what_nothing_is_known_of_has_no_gain() -> None:
    assert log_gains([]).shape == (0,)
    assert log_gains([frame_of(surface())]).tolist() == [0.0]
    bare = [replace(frame, tissue_mask=~TISSUE) for frame in pumping()]
    assert not log_gains(bare).any()
    assert jitter(np.zeros(3)) == 0
    strange = np.abs(log_gains([frame_of(surface(seed), seed) for seed in range(12)]))
    assert strange.max() < 0.1  # No tissue that two of them share.
    tools = pumping()[0].image.copy()
    tools[:, : WIDTH // 2] = 200
    masked = replace(pumping()[1], image=tools, tissue_mask=np.arange(WIDTH) >= WIDTH // 2 + TISSUE)
    assert np.isfinite(log_gains([pumping()[0], masked])).all()


def test_the_gain_of_another_frame_comes_from_those_beside_it() -> None:
    frames = pumping()
    known = [(frames[place], float(np.log(PUMPING[place]))) for place in (3, 4, 6, 7)]
    assert log_gain_beside(frames[BROKEN], known) == pytest.approx(np.log(PUMPING[BROKEN]), abs=0.003)
    assert log_gain_beside(frame_of(BLACK), known) == 0
    assert log_gain_beside(frames[0], []) == 0


def test_exposing_there_and_back() -> None:
    image: ByteImage = np.arange(256, dtype=np.uint8).repeat(3).reshape(16, 16, 3)
    assert exposed(image, 1.0) is image
    brighter = exposed(image, 1.25)
    assert brighter[0, 4].tolist() == [5, 5, 5]
    assert brighter[-1, -1].tolist() == exposed(image, 0.5)[-1, -1].tolist() == [255] * 3
    back = exposed(brighter, 0.8)
    below = image < 200
    assert np.abs(back[below].astype(int) - image[below]).max() <= 1


def test_training_sees_frames_in_one_exposure_and_a_clip_keeps_their_own() -> None:
    clip = plane_clip()
    gains = [1 + 0.01 * index for index in range(len(clip))]
    own = with_gains(clip, gains)
    part = own.between(2, 4)
    frame = part.read_frame(1)
    assert (frame.index, frame.gain) == (1, gains[3])
    assert np.array_equal(frame.image, clip.read_frame(3).image)
    seen = as_fitted(frame)
    assert seen.gain == 1
    assert np.array_equal(seen.image, exposed(frame.image, 1 / gains[3]))
    assert steadied(clip.read_frame(3)).image is not frame.image
    with pytest.raises(ValueError, match="gains, one a frame, got 2"):
        with_gains(clip, gains[:2])
