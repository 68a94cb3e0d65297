"""Which Gaussians some frame shows: not those behind tissue in all of them, nor those beside all views."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from renderer.camera import BoolArray, Camera
from renderer.deformation.motion import Still
from renderer.gaussians import DynamicGaussians
from renderer.raw_gaussians import RawGaussians
from renderer.shown import looks

CAMERA = Camera.from_fov(60, 96, 72)
NEAR = 0.1


def wall(depth: float, half_width: float, spacing: float = 0.1) -> np.ndarray:
    side = np.arange(-half_width, half_width + 1e-9, spacing)
    x, y = (grid.ravel() for grid in np.meshgrid(side, side))
    return np.stack([x, y, np.full_like(x, depth)], axis=1).astype(np.float32)


def model_of(*means: np.ndarray) -> DynamicGaussians:
    placed = np.concatenate(means)
    count = len(placed)
    raw = RawGaussians(
        means=placed,
        quats=np.tile(np.float32([1, 0, 0, 0]), (count, 1)),
        log_scales=np.full((count, 3), np.log(0.08), np.float32),
        opacity_logits=np.full(count, 3.0, np.float32),
        colors=np.full((count, 3), 0.5, np.float32),
        harmonics=np.zeros((count, 0, 3), np.float32),
    )
    return DynamicGaussians(raw, Still())


def shown(model: DynamicGaussians, *cameras: Camera) -> BoolArray:
    *_, found = looks(model, cameras, NEAR, "default")
    return found


def test_what_lies_behind_tissue_is_not_shown() -> None:
    screen, behind = wall(5.0, 1.0), wall(8.0, 3.0)
    found = shown(model_of(screen, behind), CAMERA)
    assert found[: len(screen)].all()
    across = np.abs(behind[:, :2]).max(axis=1) * 5.0 / 8.0
    of_behind = found[len(screen) :]
    assert not of_behind[across < 0.8].any()
    assert of_behind[across > 1.2].all()
    assert (across > 1.2).sum() > 100


def test_one_frame_that_sees_it_is_enough() -> None:
    screen, hidden = wall(5.0, 1.0), np.float32([[0, 0, 8]])
    model = model_of(screen, hidden)
    aside = CAMERA.moved(np.array([[1.0, 0, 0, -4], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]))
    assert not shown(model, CAMERA)[-1]
    assert shown(model, CAMERA, aside)[-1]


@pytest.mark.parametrize(("place", "seen"), [((0, 0, -3), False), ((40, 0, 8), False), ((0, 0, 8), True)])
def test_what_no_camera_has_in_view_is_not_shown(place: tuple[float, float, float], seen: bool) -> None:
    assert shown(model_of(np.float32([place])), CAMERA)[0] == seen


def test_a_layer_just_behind_fills_the_gaps_of_that_in_front() -> None:
    found = shown(model_of(wall(5.0, 1.0), wall(5.1, 1.0)), CAMERA)
    assert found.all()


def test_a_large_one_at_the_side_of_the_image_is_shown() -> None:
    model = model_of(np.float32([[5.2, 0, 8]]))  # Its centre is beyond the image, as 4.6 is its half width.
    assert not shown(model, CAMERA)[0]
    large = replace(model.raw, log_scales=np.full((1, 3), np.log(0.8), np.float32))
    assert shown(DynamicGaussians(large, Still()), CAMERA)[0]


def test_broken_ones_stop_nothing() -> None:
    model = model_of(wall(5.0, 1.0), np.float32([[np.nan, 0, 5], [0, 0, 0], [0, np.inf, 5]]))
    with np.errstate(invalid="ignore"):
        found = shown(model, CAMERA)
    assert found[:-3].all()
    assert not found[-3:].any()
