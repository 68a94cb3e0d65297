"""A step's pictures through torch against those of the kernels: loss, every gradient, and whole runs.

On the processor both draw with the same rasteriser; with gsplat's in test_rasterize_cuda.py.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import torch

from renderer.camera import Camera
from renderer.clip import Frame
from renderer.rasterize import rasterize
from renderer.rasterize.cuda import Drawn
from renderer.raw_gaussians import FIELDS, RawGaussians
from renderer.splats import RenderMode
from renderer.torch_train.card import trouble
from renderer.torch_train.gradient_backend import TorchBackend
from renderer.train.config import Method
from renderer.train.events import Evaluated, Finished
from renderer.train.frames import TrainFrame, halved, train_frame
from renderer.train.gradient_backend import CpuBackend, GradientBackend
from renderer.train.losses import LossWeights
from renderer.train.methods import recipe_for
from renderer.train.model import TrainModel
from renderer.train.training import train
from tests.renderer.scenes import turned_camera
from tests.renderer.sheet import SMALL, moving_sheet, needs_of
from tests.renderer.test_densify import blobs

WEIGHTS = {
    "vesselsplat": LossWeights(opacity=0.3, depth=0.2),
    "deform3dgs": LossWeights(inverse_depth=0.5),
    "endogaussian": LossWeights(inverse_depth=0.5, image_variation=0.3, inverse_depth_variation=2.0),
    "color": LossWeights(color=0.7),
}


def kernels_draw(*values: Any, near: float, mode: RenderMode) -> Drawn:
    """The numba rasteriser as a torch function."""
    centers = torch.zeros((1, len(values[0]), 2))
    return Drawn(rasterize(*values, backend="cpu", near=near, mode=mode), centers)


def through_torch() -> TorchBackend:
    return TorchBackend("cpu", kernels_draw)


def noisy_frame(camera: Camera, *, guess: bool = False) -> TrainFrame:
    """Noise with a tool, half of which hides what other frames show, and holes in its depth; no whole number
    of tiles."""
    rng = np.random.default_rng(5)
    shape = camera.height, camera.width
    image = rng.integers(0, 256, (*shape, 3), dtype=np.uint8)
    tissue = np.ones(shape, bool)
    tissue[: shape[0] // 3, shape[1] // 2 :] = False
    depth = (50 + 5 * np.sin(np.arange(shape[1]) / 7) + rng.normal(0, 0.2, shape)).astype(np.float32)
    depth[:, ::9] = 0
    frame = Frame(0, 0.3, image, camera, tissue, tissue, depth, depth_is_guess=guess)
    shown = tissue.copy()
    shown[:, : 3 * shape[1] // 4] = True
    return train_frame(frame, ~shown, shown)


def with_harmonics(raw: RawGaussians, bands: int) -> RawGaussians:
    harmonics = np.random.default_rng(1).normal(0, 0.2, (len(raw), bands, 3))
    return replace(raw, harmonics=harmonics.astype(np.float32))


def before(camera: Camera, raw: RawGaussians) -> RawGaussians:
    """The same Gaussians as `camera` sees them, made for one at the origin."""
    pose = camera.world_from_camera
    return replace(raw, means=(raw.means @ pose[:3, :3].T + pose[:3, 3]).astype(np.float32))


@pytest.mark.parametrize("weights", WEIGHTS.values(), ids=WEIGHTS)
@pytest.mark.parametrize("guess", [False, True], ids=["measured", "guessed"])
@pytest.mark.parametrize(
    ("bands", "mode"), [(0, "default"), (3, "default"), (8, "default"), (15, "default"), (3, "mip")]
)
def test_loss_and_every_gradient(weights: LossWeights, guess: bool, bands: int, mode: RenderMode) -> None:
    camera = turned_camera(75, 50)
    raw = with_harmonics(blobs(400), bands)
    # At many depths, or neighbours' depths would differ by rounding alone, whose sign is anyone's.
    raw = replace(raw, means=raw.means * np.linspace(0.9, 1.1, len(raw), dtype=np.float32)[:, None])
    raw = before(camera, raw)
    frame = noisy_frame(camera, guess=guess)
    one, other = (
        pictures.loss_and_gradients(raw, frame, weights, 50.0, every_tile=False, mode=mode)
        for pictures in (CpuBackend(), through_torch())
    )
    assert other.measured.loss == pytest.approx(one.measured.loss, rel=1e-5)
    assert other.measured.squared_error == pytest.approx(one.measured.squared_error, rel=1e-5)
    for name in FIELDS:
        expected, got = getattr(one.by, name), getattr(other.by, name)
        assert got.shape == expected.shape
        if expected.size:
            assert np.abs(expected).max() > 0
            assert np.linalg.norm(got - expected) < 1e-3 * np.linalg.norm(expected), name
    # Those that reach no pixel to be compared have no gradient; kernels know of tiles alone.
    assert not (other.seen & ~one.seen).any()
    assert np.count_nonzero(other.seen) > 0.7 * np.count_nonzero(one.seen)


def test_gradients_that_are_no_numbers_are_seen_and_so_left_out() -> None:
    raw = blobs(50)
    raw.colors[7] = np.nan
    slopes = through_torch().loss_and_gradients(
        raw, noisy_frame(turned_camera(40, 30)), LossWeights(), 50.0, every_tile=True
    )
    assert slopes.by.colors.dtype == np.float32
    assert np.isfinite(slopes.by.means[~slopes.seen]).all()


def losses(method: Method, pictures: GradientBackend, steps: int = 40) -> tuple[np.ndarray, TrainModel]:
    """Of the first steps of a run, half of them at half resolution, and the model after them."""
    clip = moving_sheet()
    frames = [clip.read_frame(index) for index in (0, 2, 3, 4, 6)]
    views = [train_frame(frame) for frame in frames]
    small = [halved(view) for view in views]
    config = replace(SMALL, method=method, iterations=steps)
    recipe = recipe_for(config, needs_of(clip, config))
    raw = recipe.initialize(frames)
    model = TrainModel(raw, recipe.make_trainer(raw, frames, 50.0), recipe, 50.0, pictures)
    return np.array(
        [
            model.step((small if step < steps // 2 else views)[step % len(views)], step).loss
            for step in range(steps)
        ]
    ), model


@pytest.mark.parametrize("method", ["vesselsplat", "static", "deform3dgs", "endogaussian"])
def test_every_method_learns_alike(method: Method) -> None:
    kernels, _ = losses(method, CpuBackend())
    torch_, _ = losses(method, through_torch())
    assert kernels[-5:].mean() < kernels[:5].mean()
    assert np.allclose(torch_, kernels, rtol=0.02)
    assert np.allclose(torch_[:3], kernels[:3], rtol=1e-4)


def test_a_run_ends_alike() -> None:
    """The whole generator: events, checkpoints' shapes, what is left out, the held-out PSNR."""
    ends = []
    for pictures in (None, through_torch()):
        events = list(train(moving_sheet(), replace(SMALL, iterations=150), pictures=pictures))
        finished = events[-1]
        assert isinstance(finished, Finished)
        told = [event.psnr for event in events if isinstance(event, Evaluated)]
        ends.append((finished, told[-1]))
    (first, psnr), (second, other) = ends
    assert psnr > 24
    assert other == pytest.approx(psnr, abs=0.3)
    assert set(first.model.arrays()) == set(second.model.arrays())


@pytest.mark.skipif(torch.cuda.is_available(), reason="there is a card")
def test_a_missing_card_is_told_in_one_line() -> None:
    said = trouble()
    assert said is not None
    assert "finds no GPU" in said
    assert "\n" not in said
