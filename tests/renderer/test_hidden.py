"""Curves at rest where tissue is hidden, against dense least squares, and on a clip with a hidden half."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from renderer.camera import Camera
from renderer.clip import Frame
from renderer.deformation.spline import spline_taps
from renderer.deformation.spline_motion import SplineMotion
from renderer.gaussians import DynamicGaussians
from renderer.raw_gaussians import RawGaussians
from renderer.train import hidden as hidden_tissue
from renderer.train.frames import TrainFrame, train_frame
from renderer.train.hidden import (
    EDGE,
    GLARE,
    LEAK,
    REST,
    SLACK,
    STRAY,
    _seen_shares,
    smooth_occluded_motion,
)
from tests.renderer.splines import without_nodes

CONTROLS, COUNT, SIDE = 9, 12, 32
CAMERA = Camera(40.0, 40.0, SIDE / 2, SIDE / 2, SIDE, SIDE)
TIMES = np.linspace(0, 1, 30)


def gaussians(rng: np.random.Generator) -> DynamicGaussians:
    """A row of small Gaussians whose colours wander."""
    across = np.linspace(-0.35, 0.35, COUNT) * 10
    raw = RawGaussians(
        means=np.column_stack([across, np.zeros(COUNT), np.full(COUNT, 10.0)]).astype(np.float32),
        quats=np.tile(np.float32([1, 0, 0, 0]), (COUNT, 1)),
        log_scales=np.full((COUNT, 3), np.log(0.2), np.float32),
        opacity_logits=np.full(COUNT, 2.0, np.float32),
        colors=rng.uniform(0.45, 0.5, (COUNT, 3)).astype(np.float32),
        harmonics=np.zeros((COUNT, 0, 3), np.float32),
    )
    positions = np.zeros((COUNT, CONTROLS, 3), np.float32)
    motion = without_nodes(positions, rng.normal(0, 0.3, (COUNT, CONTROLS, 3)).astype(np.float32))
    return DynamicGaussians(raw, motion)


def frames(hidden_after: float, first_column: int = 0) -> list[TrainFrame]:
    """Frames that show the columns from `first_column` on only up to `hidden_after`."""
    shown = []
    for index, time in enumerate(TIMES):
        mask = np.ones((SIDE, SIDE), bool)
        if time > hidden_after:
            mask[:, first_column:] = False
        image = np.zeros((SIDE, SIDE, 3), np.uint8)
        shown.append(train_frame(Frame(index, float(time), image, CAMERA, mask, mask)))
    return shown


def values(model: DynamicGaussians, time: float) -> np.ndarray:
    first, weights = spline_taps(time, CONTROLS)
    motion = model.motion
    assert isinstance(motion, SplineMotion)
    return np.einsum("k,nkc->nc", weights, motion.color_controls[:, first : first + 4])


def test_nothing_changes_where_every_frame_sees_all() -> None:
    model = gaussians(np.random.default_rng(0))
    still, told = smooth_occluded_motion(model, frames(hidden_after=2.0), near=0.1)
    assert still is model
    assert told == ()


def test_what_is_seen_stays_within_the_slack() -> None:
    """The minimum is below what the curves themselves give: at most their roughness times SLACK, and their
    size times REST."""
    model, shown = gaussians(np.random.default_rng(0)), frames(hidden_after=0.6, first_column=SIDE // 2)
    still, _ = smooth_occluded_motion(model, shown, near=0.1)
    assert isinstance(model.motion, SplineMotion)
    roughness = (np.diff(model.motion.color_controls, axis=1) ** 2).sum(axis=(1, 2))
    size = (model.motion.color_controls**2).sum(axis=(1, 2))
    apart = np.zeros(COUNT)
    for frame, (_, seen, _) in zip(shown, list(_seen_shares(model, shown, 0.1)), strict=True):
        change = values(still, frame.time) - values(model, frame.time)
        apart += seen * (change**2).sum(axis=1)
    assert apart.max() > 0
    assert (apart <= SLACK * roughness + REST * size).all()


def test_curves_rest_while_tissue_is_hidden() -> None:
    model = gaussians(np.random.default_rng(1))
    still, told = smooth_occluded_motion(model, frames(hidden_after=0.5, first_column=SIDE // 2), near=0.1)
    assert "motion of hidden tissue" in told[0].what
    hidden = slice(COUNT // 2 + 1, None)
    wandered = np.abs(values(model, 1.0))[hidden].max()
    assert np.abs(values(still, 1.0))[hidden].max() < 0.1 * wandered
    seen = slice(0, COUNT // 2 - 3)  # Farther than EDGE from the mask.
    np.testing.assert_allclose(values(still, 1.0)[seen], values(model, 1.0)[seen], atol=0.05 * wandered)


@pytest.mark.parametrize("glare", [0.95, 0.05])
def test_what_glares_rests_near_the_colours_about_it_and_stays_where_it_is_seen(glare: float) -> None:
    plain, shown = gaussians(np.random.default_rng(1)), frames(hidden_after=0.5, first_column=SIDE // 2)
    colors, at = plain.raw.colors.copy(), [1, COUNT - 2]
    colors[at] = glare
    model = replace(plain, raw=replace(plain.raw, colors=colors))
    still, _ = smooth_occluded_motion(model, shown, near=0.1)
    seen, rested = still.at(1.0).colors[at]
    around = np.median(np.delete(colors, at[1], axis=0), axis=0)
    assert np.abs(rested - around).max() < 2 * GLARE < np.abs(model.at(1.0).colors[at[1]] - around).max()
    np.testing.assert_allclose(seen, model.at(1.0).colors[at[0]], atol=0.02)


def test_tissue_of_one_colour_in_time_and_a_single_gaussian_rest() -> None:
    model, shown = gaussians(np.random.default_rng(1)), frames(hidden_after=0.5, first_column=SIDE // 2)
    assert isinstance(model.motion, SplineMotion)
    of_places = replace(
        model, motion=replace(model.motion, color_controls=np.zeros((0, CONTROLS, 3), np.float32))
    )
    for each in (of_places, model.rows(np.array([COUNT - 1]))):
        still, _ = smooth_occluded_motion(each, shown, near=0.1)
        np.testing.assert_array_equal(still.raw.colors, each.raw.colors)


def test_places_stay_where_they_were_last_seen() -> None:
    """At rest they might come into sight, before tissue that is seen."""
    model = gaussians(np.random.default_rng(4))
    assert isinstance(model.motion, SplineMotion)
    aside = np.full((COUNT, CONTROLS, 3), 0.05, np.float32)
    moved = replace(model, motion=replace(model.motion, position_controls=aside))
    still, _ = smooth_occluded_motion(moved, frames(hidden_after=0.5, first_column=SIDE // 2), near=0.1)
    assert isinstance(still.motion, SplineMotion)
    np.testing.assert_allclose(still.motion.position_controls, aside, atol=1e-5)


def test_curves_are_the_minimiser_of_the_stated_sum(monkeypatch: pytest.MonkeyPatch) -> None:
    rng = np.random.default_rng(2)
    model = gaussians(rng)
    shares = [rng.uniform(0, 1, COUNT).astype(np.float32) for _ in TIMES]
    shares = [share * (rng.uniform(size=COUNT) < 0.3) for share in shares]
    clear = [share * (rng.uniform(size=COUNT) < 0.5).astype(np.float32) for share in shares]
    told = [(share[::-1].copy(), share, some) for share, some in zip(shares, clear, strict=True)]
    monkeypatch.setattr(hidden_tissue, "STRAY", np.float32(10))  # Of others' colours it knows nothing.
    monkeypatch.setattr(hidden_tissue, "_seen_shares", lambda *_: told)
    still, _ = smooth_occluded_motion(model, frames(hidden_after=2.0), near=0.1)
    basis = np.zeros((len(TIMES), CONTROLS))
    for row, time in zip(basis, TIMES, strict=True):
        first, weights = spline_taps(float(time), CONTROLS)
        row[first : first + 4] = weights
    assert isinstance(model.motion, SplineMotion)
    assert isinstance(still.motion, SplineMotion)

    def minimiser(curve: np.ndarray, shares: list[float]) -> np.ndarray:
        root = np.sqrt(shares)[:, None]
        near = ((root * basis) ** 2).sum(axis=0) / (basis**2).sum(axis=0)
        hidden = 1 - np.minimum(near[1:], near[:-1])
        steps = np.sqrt(SLACK) * hidden[:, None] * np.diff(np.eye(CONTROLS), axis=0)
        rests = np.sqrt(REST) * np.diag(1 - near)
        left = np.vstack([root * basis, steps, rests])
        right = np.vstack([root * basis @ curve, np.zeros((2 * CONTROLS - 1, 3))])
        return np.linalg.lstsq(left, right, rcond=None)[0]

    reached = 0
    for n in range(COUNT):
        curve = model.motion.color_controls[n]
        clearly = minimiser(curve, [share[n] for share in clear])
        besides = minimiser(curve - clearly, [share[n] for share in shares])
        reached += np.count_nonzero(np.abs(besides) > LEAK)
        expected = clearly + np.clip(besides, -LEAK, LEAK)
        np.testing.assert_allclose(still.motion.color_controls[n], expected, atol=2e-5)
    assert reached > 0


@pytest.mark.parametrize("stray", [STRAY, np.float32(10)])
@pytest.mark.parametrize("glare", [0.5, -0.4])
def test_a_highlight_that_a_tool_covers_goes_out_with_it(
    monkeypatch: pytest.MonkeyPatch, glare: float, stray: np.float32
) -> None:
    """It is there in all the frames that show its tissue."""
    monkeypatch.setattr(hidden_tissue, "STRAY", stray)
    model, shown, lit = gaussians(np.random.default_rng(8)), frames(hidden_after=0.5), COUNT // 2
    controls = np.zeros((COUNT, CONTROLS, 3), np.float32)
    controls[lit] = glare
    model = replace(model, motion=without_nodes(np.zeros_like(controls), controls))
    still, _ = smooth_occluded_motion(model, shown, near=0.1)

    def apart(of: DynamicGaussians, time: float) -> np.ndarray:
        colors = of.at(time).colors
        return np.asarray(np.abs(colors[lit] - np.median(np.delete(colors, lit, axis=0), axis=0)))

    np.testing.assert_allclose(apart(still, 0.35), apart(model, 0.35), atol=0.02)
    assert (apart(still, 0.8).max() < 1.5 * STRAY) == (stray == STRAY)


@pytest.mark.parametrize(("edge", "ghost"), [(EDGE, False), (0.0, True)])
def test_hidden_tissue_has_the_colour_of_before_not_that_beside_the_tool(
    monkeypatch: pytest.MonkeyPatch, edge: float, ghost: bool
) -> None:
    """A tool comes from the right, and tissue within three pixels of it has its colour."""
    monkeypatch.setattr(hidden_tissue, "EDGE", edge)
    monkeypatch.setattr(hidden_tissue, "STRAY", np.float32(10))  # Of others' colours it knows nothing.
    model, shown = gaussians(np.random.default_rng(5)), []
    motion, tool = model.motion, 1.0
    assert isinstance(motion, SplineMotion)
    columns = CAMERA.project(model.means.astype(np.float64))[0][:, 0]
    reached = np.clip(np.round(SIDE * (1.5 - TIMES)), SIDE // 4, SIDE)
    basis = np.zeros((len(TIMES), CONTROLS))
    for index, (time, column) in enumerate(zip(TIMES, reached, strict=True)):
        mask = np.ones((SIDE, SIDE), bool)
        mask[:, int(column) :] = False
        shown.append(
            train_frame(Frame(index, float(time), np.zeros((SIDE, SIDE, 3), np.uint8), CAMERA, mask, mask))
        )
        first, weights = spline_taps(float(time), CONTROLS)
        basis[index, first : first + 4] = weights
    wanted = tool * (columns[None] > reached[:, None] - 3)
    curves = np.linalg.lstsq(basis, wanted, rcond=None)[0].T[..., None].repeat(3, axis=2)
    model = replace(model, motion=replace(motion, color_controls=curves.astype(np.float32)))
    still, _ = smooth_occluded_motion(model, shown, near=0.1)
    hidden = columns > SIDE * 0.6
    assert 2 < hidden.sum() < COUNT
    assert (np.median(values(still, 1.0)[hidden]) > 0.5 * tool) == ghost
    apart = columns < SIDE * 0.25 - EDGE / 2
    np.testing.assert_allclose(values(still, 0.2)[apart], values(model, 0.2)[apart], atol=0.05)


def test_a_sliver_in_sight_does_not_colour_what_a_tool_hides() -> None:
    """In the second half of the frames a little of the first Gaussian is seen, of the second nothing."""
    model = gaussians(np.random.default_rng(6)).rows(np.array([COUNT - 3, COUNT - 1]))
    motion = without_nodes(np.zeros((2, CONTROLS, 3), np.float32), np.zeros((2, CONTROLS, 3), np.float32))
    motion.color_controls[:, CONTROLS // 2 + 1 :] = -1.0
    scales = np.full((2, 3), np.log(0.7), np.float32)
    model = replace(model, raw=replace(model.raw, log_scales=scales), motion=motion)
    shown = frames(hidden_after=0.5, first_column=18)
    (_, whole, _), *_, (_, sliver, _) = _seen_shares(model, shown, 0.1)
    still, _ = smooth_occluded_motion(model, shown, near=0.1)
    assert 0 < sliver[0] < 0.05 * whole[0]
    assert values(still, 1.0)[0].min() > -0.5
    np.testing.assert_allclose(values(still, 0.2)[0], values(model, 0.2)[0], atol=0.05)


def test_what_shows_through_other_tissue_keeps_about_the_colour_that_it_had_in_sight() -> None:
    """The second one comes in front of the first and lets a few per cent of its light through."""
    model = gaussians(np.random.default_rng(7)).rows(np.array([COUNT // 2, COUNT // 2]))
    positions = np.zeros((2, CONTROLS, 3), np.float32)
    positions[1] = 100, 0, -1
    positions[1, CONTROLS // 2 - 1 :] = 0, 0, -1
    motion = without_nodes(positions, np.zeros((2, CONTROLS, 3), np.float32))
    motion.color_controls[0, CONTROLS // 2 + 2 :] = -1.0
    raw = replace(
        model.raw,
        log_scales=np.full((2, 3), np.log(0.5), np.float32) + np.float32([[0], [2]]),
        opacity_logits=np.float32([3, 8]),
    )
    model, shown = DynamicGaussians(raw, motion), frames(hidden_after=2.0)
    (_, _, before), *_, (_, through, clear) = _seen_shares(model, shown, 0.1)
    still, _ = smooth_occluded_motion(model, shown, near=0.1)
    assert before[0] > 0.9
    assert through[0] > 0.2 > 0.001 > clear[0]
    assert values(model, 1.0)[0].max() == -1
    assert values(still, 1.0)[0].min() > -1.1 * LEAK
    np.testing.assert_allclose(values(still, 0.2)[0], 0, atol=0.02)
    np.testing.assert_allclose(values(still, 1.0)[1], values(model, 1.0)[1], atol=0.02)


def test_what_no_frame_sees_rests() -> None:
    model = gaussians(np.random.default_rng(3))
    motion = model.motion
    assert isinstance(motion, SplineMotion)
    far = replace(model.raw, means=model.raw.means + np.float32([1e4, 0, 0]))
    still, _ = smooth_occluded_motion(DynamicGaussians(far, motion), frames(hidden_after=2.0), near=0.1)
    assert isinstance(still.motion, SplineMotion)
    assert np.abs(still.motion.color_controls).max() < 1e-6
