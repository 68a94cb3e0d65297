"""What moves out of sight fades there and nowhere else."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from renderer.camera import Camera
from renderer.clip import Frame
from renderer.deformation.spline_motion import SplineMotion
from renderer.gaussians import DynamicGaussians
from renderer.rasterize.cpu import render
from renderer.raw_gaussians import RawGaussians
from renderer.train import fading
from renderer.train.fading import (
    FADES,
    LEAST,
    OUTSIDE,
    ROUNDS,
    SHRED,
    TRACE,
    _shares_beyond,
    _shreds,
    faded_out_of_sight,
)
from renderer.train.frames import MARGIN, TrainFrame, train_frame, unseen_beyond
from tests.renderer.splines import without_nodes

CONTROLS, WIDTH, HEIGHT = 9, 96, 64
FOCAL, DEPTH = 80.0, 10.0
CAMERA = Camera(FOCAL, FOCAL, WIDTH / 2, HEIGHT / 2, WIDTH, HEIGHT)
TIMES = np.linspace(0, 1, 30)
BAR = 48
"""First row of what is burned in, under which nothing is seen."""
STAYS, LEAVES = 0, 1


def frames() -> list[TrainFrame]:
    shown = []
    for index, time in enumerate(TIMES):
        mask = np.ones((HEIGHT, WIDTH), bool)
        mask[BAR:] = False
        image = np.zeros((HEIGHT, WIDTH, 3), np.uint8)
        shown.append(train_frame(Frame(index, float(time), image, CAMERA, mask, mask)))
    return shown


def model(down: float) -> DynamicGaussians:
    """Two small Gaussians on row 32; the second moves by so many rows from the first frame to the last."""
    raw = RawGaussians(
        means=np.float32([[-2, 0, DEPTH], [2, 0, DEPTH]]),
        quats=np.tile(np.float32([1, 0, 0, 0]), (2, 1)),
        log_scales=np.full((2, 3), np.log(0.2), np.float32),
        opacity_logits=np.float32([2, 2]),
        colors=np.full((2, 3), 0.5, np.float32),
        harmonics=np.zeros((2, 0, 3), np.float32),
    )
    positions = np.zeros((2, CONTROLS, 3), np.float32)
    positions[LEAVES, :, 1] = np.linspace(0, down * DEPTH / FOCAL, CONTROLS)
    motion = without_nodes(positions)
    return DynamicGaussians(raw, motion)


def faded(before: DynamicGaussians) -> DynamicGaussians:
    return faded_out_of_sight(before, frames(), hidden(), near=0.1)


def hidden() -> NDArray[np.bool_]:
    mask = np.ones((HEIGHT, WIDTH), bool)
    mask[BAR:] = False
    return unseen_beyond(mask)


def test_it_is_gone_where_nothing_is_seen_and_as_it_was_before() -> None:
    before = model(down=40)
    after = faded(before)
    ways = np.array([[one.at(float(time)).opacities for time in TIMES] for one in (before, after)])
    rows = np.array([before.at(float(time)).means[LEAVES, 1] * FOCAL / DEPTH + HEIGHT / 2 for time in TIMES])
    within, beyond = rows < BAR - 4, rows > BAR + 8
    assert within.sum() > 5
    assert beyond.sum() > 3
    np.testing.assert_array_equal(ways[1, :, STAYS], ways[0, :, STAYS])
    assert ways[1, within, LEAVES].min() > 0.95 * ways[0, 0, LEAVES]
    assert ways[1, beyond, LEAVES].max() < 0.1


def test_it_is_gone_on_a_short_way_out_of_sight() -> None:
    """Between many frames that show it."""
    before = model(down=0)
    motion = before.motion
    assert isinstance(motion, SplineMotion)
    motion.position_controls[LEAVES, CONTROLS // 2, 1] = 36 * DEPTH / FOCAL
    after = faded(before)
    ways = np.array([[one.at(float(time)).opacities[LEAVES] for time in TIMES] for one in (before, after)])
    rows = np.array([before.at(float(time)).means[LEAVES, 1] * FOCAL / DEPTH + HEIGHT / 2 for time in TIMES])
    beyond = rows > BAR + 6
    assert 0 < beyond.sum() < len(TIMES) / 4
    assert ways[1, beyond].max() < 3 * LEAST
    assert ways[1, rows < HEIGHT / 2 + 1].min() > 0.9 * ways[0].max()


def test_the_curve_hardly_swings_between_frames() -> None:
    before = model(down=40)
    after = faded(before)
    for time in np.linspace(0, 1, 301):
        assert (after.at(float(time)).opacities <= 1.06 * before.at(float(time)).opacities).all()


@pytest.mark.parametrize(("outside", "left"), [(OUTSIDE, 0.4), ((2.0, 3.0), 1.0)])
def test_a_knob_out_of_the_edge_fades_though_it_lies_in_its_margin(
    monkeypatch: pytest.MonkeyPatch, outside: tuple[float, float], left: float
) -> None:
    monkeypatch.setattr(fading, "OUTSIDE", outside)
    before = model(down=BAR + 4 - HEIGHT / 2)
    before.raw.log_scales[:] = np.log(0.07)
    assert BAR + 1 < before.at(1.0).means[LEAVES, 1] * FOCAL / DEPTH + HEIGHT / 2 < BAR + MARGIN - 1
    after = faded(before)
    assert after.at(1.0).opacities[LEAVES] <= left * before.at(1.0).opacities[LEAVES]
    assert after.at(0.2).opacities[LEAVES] > 0.9 * before.at(0.2).opacities[LEAVES]
    assert (after is before) == (left == 1)


@pytest.mark.parametrize(("rounds", "left"), [(1, (0.95, 1.0)), (ROUNDS, (0.0, 0.35))])
def test_what_fades_uncovers_what_lay_behind_which_fades_too(
    monkeypatch: pytest.MonkeyPatch, rounds: int, left: tuple[float, float]
) -> None:
    """One behind hangs out of the edge, but there another hides it, of which most is out of sight."""
    monkeypatch.setattr(fading, "ROUNDS", rounds)
    before = model(down=0).rows(np.array([LEAVES, LEAVES]))
    for one, row, depth in ((0, BAR + 5, DEPTH - 1), (1, BAR + 3, DEPTH)):
        before.raw.means[one] = 0, (row - HEIGHT / 2) * depth / FOCAL, depth
    before.raw.log_scales[:] = np.log(np.float32([[0.5], [0.2]]))
    before.raw.opacity_logits[:] = 5
    after = faded(before)
    kept = (after.at(0.5).opacities / before.at(0.5).opacities).tolist()
    assert kept[0] < 0.1
    assert left[0] <= kept[1] <= left[1]


def test_what_stays_in_sight_is_the_same_model() -> None:
    before = model(down=8)
    assert faded(before) is before
    nowhere = np.zeros((HEIGHT, WIDTH), bool)
    away = model(down=28)
    assert faded_out_of_sight(away, frames(), nowhere, near=0.1) is away


def test_what_is_out_of_sight_where_frames_are_missing_alone_fades_there() -> None:
    before = model(down=0)
    assert isinstance(before.motion, SplineMotion)
    before.motion.position_controls[LEAVES, CONTROLS // 2, 1] = 42 * DEPTH / FOCAL
    assert before.at(0.5).means[LEAVES, 1] * FOCAL / DEPTH + HEIGHT / 2 > BAR + 8
    around = [frame for frame in frames() if abs(frame.time - 0.5) > 0.18]
    after = faded_out_of_sight(before, around, hidden(), near=0.1)
    assert after.at(0.5).opacities[LEAVES] < 0.1
    assert after.at(0.2).opacities[LEAVES] > 0.95 * before.at(0.2).opacities[LEAVES]


def test_a_curve_of_opacity_that_is_there_is_kept() -> None:
    before = model(down=28)
    assert isinstance(before.motion, SplineMotion)
    own = np.zeros((2, CONTROLS, 1), np.float32)
    own[STAYS] = 1.5
    after = faded(replace(before, motion=replace(before.motion, opacity_controls=own)))
    assert isinstance(after.motion, SplineMotion)
    np.testing.assert_array_equal(after.motion.opacity_controls[STAYS], own[STAYS])
    assert after.motion.opacity_controls[LEAVES].min() < -3


@pytest.mark.parametrize("down", [0.0, 10.0, 14.0, 18.0, 28.0])
def test_shares_are_those_of_what_is_drawn(down: float) -> None:
    """One Gaussian alone, as it is drawn at the last frame."""
    one = model(down).rows(np.array([LEAVES]))
    beyond = hidden()
    ((share, outside),) = list(
        _shares_beyond(one, [(1.0, ~beyond)], CAMERA, (beyond, beyond), 0.1, "default")
    )
    alpha = render(one.at(1.0), CAMERA, near=0.1).alpha.astype(np.float64)
    wanted = alpha[beyond].sum() / (alpha.sum() + TRACE)
    assert share[0] == pytest.approx(wanted, abs=1e-3)
    assert outside[0] == pytest.approx(wanted, abs=1e-3)
    kept = faded(model(down)).at(1.0).opacities[LEAVES] / model(down).at(1.0).opacities[LEAVES]
    if wanted < min(FADES[0], OUTSIDE[0]):
        assert kept == pytest.approx(1, abs=1e-6)
    if wanted > FADES[1]:
        assert kept < 3 * LEAST


def hidden_frames(shown: float) -> list[TrainFrame]:
    """A tool covers all but the first rows from time `shown` on."""
    made = []
    for index, time in enumerate(TIMES):
        mask = np.ones((HEIGHT, WIDTH), bool)
        mask[8 if time > shown else BAR :] = False
        image = np.zeros((HEIGHT, WIDTH, 3), np.uint8)
        made.append(train_frame(Frame(index, float(time), image, CAMERA, mask, mask)))
    return made


def test_what_hangs_alone_behind_a_tool_fades_there_and_tissue_does_not() -> None:
    """A sheet of Gaussians two pixels apart, and one eighteen beside it."""
    rows, columns = np.mgrid[20:44:2, 20:44:2].reshape(2, -1)
    places = np.append(np.column_stack([columns, rows]), [[60, 32]], axis=0)
    means = np.column_stack([(places - (WIDTH / 2, HEIGHT / 2)) * DEPTH / FOCAL, np.full(len(places), DEPTH)])
    one = model(down=0).rows(np.zeros(len(places), np.int64))
    before = replace(one, raw=replace(one.raw, means=means.astype(np.float32)))
    after = faded_out_of_sight(before, hidden_frames(0.5), hidden(), near=0.1)
    shown, behind = (after.at(time).opacities / before.at(time).opacities for time in (0.1, 0.9))
    np.testing.assert_allclose(shown, 1, atol=0.05)
    np.testing.assert_allclose(behind[:-1], 1, atol=1e-3)
    assert behind[-1] < 0.1


def test_shreds_are_beyond_what_is_as_wide_as_the_disc() -> None:
    solid = np.zeros((60, 60), bool)
    solid[5 : 5 + SHRED - 1, 20:] = True
    solid[30 : 30 + SHRED, :] = True
    shreds = _shreds(solid)
    assert shreds[: 30 - MARGIN].all()
    assert not shreds[30 : 30 + SHRED].any()
