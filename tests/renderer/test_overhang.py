"""What lies beyond the edge of all frames but for its rim is left out where the camera moves."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from renderer.camera import Camera
from renderer.clip import Frame
from renderer.deformation.motion import Still
from renderer.gaussians import DynamicGaussians
from renderer.rasterize.cpu import render
from renderer.raw_gaussians import RawGaussians
from renderer.train import trainer
from renderer.train.config import Part, TrainConfig
from renderer.train.events import Finished
from renderer.train.frames import TrainFrame, train_frame
from renderer.train.methods import recipe_for
from renderer.train.needs import Needs
from renderer.train.recipe import Recipe
from renderer.train.training import train
from renderer.train.unseen import LEAST, shares_shown, without_overhang
from tests.renderer.plane import plane_clip

WIDTH, HEIGHT, EDGE = 70, 44, 40
"""Tissue is shown left of the column EDGE. The size is no whole number of tiles."""
NEAR = 0.1
UNSEEN: tuple[Part, ...] = ("unseen",)
HAZE = np.float32([-17, -14, 50])


def frames() -> list[TrainFrame]:
    """Of a camera that moves by 4 pixels to the right."""
    mask = np.zeros((HEIGHT, WIDTH), bool)
    mask[:, :EDGE] = True
    shown = []
    for index in range(3):
        pose = np.eye(4)
        pose[0, 3] = index
        camera = Camera(20.0, 20.0, WIDTH / 2, HEIGHT / 2, WIDTH, HEIGHT).moved(pose)
        image = np.zeros((HEIGHT, WIDTH, 3), np.uint8)
        shown.append(train_frame(Frame(index, index / 3, image, camera, mask, mask)))
    return shown


def model(columns: Sequence[float], sizes: Sequence[float], depths: Sequence[float]) -> DynamicGaussians:
    """Round Gaussians in the middle row of the first frame, sizes in its pixels."""
    count, depth = len(columns), np.array(depths)
    across = (np.array(columns) - WIDTH / 2) * depth / 20
    raw = RawGaussians(
        means=np.column_stack([across, np.zeros(count), depth]).astype(np.float32),
        quats=np.tile(np.float32([1, 0, 0, 0]), (count, 1)),
        log_scales=np.repeat(np.log(np.array(sizes) * depth / 20)[:, None], 3, axis=1).astype(np.float32),
        opacity_logits=np.full(count, 6.0, np.float32),
        colors=np.full((count, 3), 0.4, np.float32),
        harmonics=np.zeros((count, 0, 3), np.float32),
    )
    return DynamicGaussians(raw, Still())


@pytest.mark.parametrize(("column", "size"), [(20, 2), (41, 3), (46, 3), (52, 6), (2, 4)])
def test_the_share_is_that_of_its_alpha_in_the_frame_that_shows_most(column: float, size: float) -> None:
    alone, shown = model([column], [size], [5.0]), frames()
    expected = 0.0
    for frame in shown:
        alpha = render(alone.at(frame.time), frame.camera, near=NEAR).alpha.astype(np.float64)
        expected = max(expected, alpha[frame.tissue].sum() / alpha.sum())
    assert float(shares_shown(alone, shown, NEAR)[0]) == pytest.approx(expected, abs=0.01)


def test_a_rim_in_sight_is_too_little_and_what_is_hidden_or_half_seen_stays() -> None:
    """Of five Gaussians the second is the haze, and the last lies behind the first in all frames."""
    whole = model([15, 58, 41, 10, 15], [3, 6, 3, 3, 0.4], [5, 5, 5, 5, 5.2])
    assert (shares_shown(whole, frames(), NEAR) < LEAST).tolist() == [False, True, False, False, False]
    fewer, (omission,) = without_overhang(whole, frames(), NEAR)
    assert np.array_equal(fewer.raw.means, whole.raw.means[[0, 2, 3, 4]])
    assert (omission.part, omission.saves) == ("unseen", "1 of 5 Gaussians")
    assert without_overhang(fewer, frames(), NEAR) == (fewer, ())


@pytest.mark.parametrize(
    ("circle", "keep", "gone"), [(1.0, (), True), (0.0, (), False), (1.0, UNSEEN, False)]
)
def test_a_run_does_so_where_its_camera_moves_unless_it_is_kept(
    monkeypatch: pytest.MonkeyPatch, circle: float, keep: tuple[Part, ...], gone: bool
) -> None:
    """One Gaussian lies under the corner that no frame shows and hangs out of it a little."""
    config = TrainConfig(iterations=2, n_gaussians=60, keep=keep)

    def hanging(config: TrainConfig, needs: Needs) -> Recipe:
        recipe = recipe_for(config, needs)

        def initialize(frames: Sequence[Frame]) -> RawGaussians:
            raw = recipe.initialize(frames)
            raw.means[0], raw.log_scales[0] = HAZE, np.log(3.0)
            return raw

        return replace(recipe, initialize=initialize)

    monkeypatch.setattr(trainer, "recipe_for", hanging)
    *_, last = train(plane_clip(slide=3.0, circle=circle, masked=True), config)
    assert isinstance(last, Finished)
    away = np.linalg.norm(last.model.raw.means - HAZE, axis=1)
    assert (away.min() > 3) == gone
    assert ("Gaussians beyond the edge" in [omission.what for omission in last.omitted]) == gone
