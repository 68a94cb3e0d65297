"""The planes and the heads, against torch and finite differences."""

from __future__ import annotations

import os
import subprocess
import sys
from dataclasses import replace
from typing import Any

import numba
import numpy as np
import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from renderer.deformation.heads import OFFSETS, PARTS, ROWS, WIDTH, Heads
from renderer.deformation.hexplane import (
    LANES,
    Layout,
    lines_at,
    sample,
    sample_backward,
    time_taps,
    within_box,
)
from renderer.deformation.hexplane_motion import HexplaneMotion
from renderer.gaussians import DynamicGaussians
from renderer.raw_gaussians import RawGaussians
from renderer.train.hexplane_trainer import HexplaneRates, HexplaneTrainer
from renderer.train.rates import Rate

RESOLUTIONS = np.array([[5, 4, 3], [9, 2, 6]], np.int32)
LAYOUT = Layout.of(RESOLUTIONS)
BLOCKS, TIME_ROWS = 2, 4
FEATURES = len(RESOLUTIONS) * BLOCKS * LANES
COUNT = 150


def random_points(dtype: type = np.float64) -> NDArray[Any]:
    points = np.random.default_rng(0).uniform(size=(COUNT, 3))
    points[:3] = [[0, 0, 0], [1, 1, 1], [0, 1, 0.5]]
    return points.astype(dtype)


def random_cells(dtype: type = np.float64) -> tuple[NDArray[Any], NDArray[Any]]:
    rng = np.random.default_rng(1)
    planes = rng.normal(size=(BLOCKS, LAYOUT.n_plane_cells, LANES)).astype(dtype)
    return planes, rng.normal(size=(BLOCKS, LAYOUT.n_line_cells, LANES)).astype(dtype)


def sampled(planes: NDArray[Any], lines: NDArray[Any], points: NDArray[Any]) -> NDArray[Any]:
    features = np.full((len(points), FEATURES), np.nan, planes.dtype)
    sample(planes, lines, LAYOUT.resolutions, LAYOUT.planes, LAYOUT.lines, points, features)
    return features


def sampled_backward(
    planes: NDArray[Any], lines: NDArray[Any], points: NDArray[Any], seen: NDArray[np.bool_], by: NDArray[Any]
) -> tuple[NDArray[Any], NDArray[Any], NDArray[np.bool_]]:
    by_planes, by_lines = np.full_like(planes, np.nan), np.full_like(lines, np.nan)
    touched = np.ones(planes.shape[:2], bool)
    sample_backward(
        planes, lines, LAYOUT.resolutions, LAYOUT.planes, LAYOUT.lines,
        points, seen, by, by_planes, by_lines, touched,
    )  # fmt: skip
    return by_planes, by_lines, touched


def by_torch(planes: torch.Tensor, times: torch.Tensor, points: torch.Tensor, time: float) -> torch.Tensor:
    """Features (N, FEATURES) by grid_sample, time planes included, from the documented layout of cells."""
    names = {
        "x": points[:, 0],
        "y": points[:, 1],
        "z": points[:, 2],
        "t": torch.full_like(points[:, 0], time),
    }
    levels = []
    for level, (x, y, z) in enumerate(RESOLUTIONS.tolist()):
        counts = {"x": x, "y": y, "z": z}
        product = torch.ones(len(points), BLOCKS * LANES, dtype=points.dtype)
        pairs = zip(("xy", "xz", "yz"), LAYOUT.planes[level].tolist(), strict=True)
        grids = [
            (a, b, planes[:, at : at + counts[a] * counts[b]].reshape(BLOCKS, counts[b], counts[a], LANES))
            for (a, b), at in pairs
        ]
        grids += [
            (a, "t", times[:, :, at : at + counts[a]].permute(1, 0, 2, 3))
            for a, at in zip("xyz", LAYOUT.lines[level].tolist(), strict=True)
        ]
        for a, b, grid in grids:
            picture = grid.permute(0, 3, 1, 2).reshape(1, BLOCKS * LANES, *grid.shape[1:3])
            at = torch.stack([names[a], names[b]], dim=1)[None, None] * 2 - 1
            values = torch.nn.functional.grid_sample(picture, at, padding_mode="border", align_corners=True)
            product = product * values[0, :, 0].T
        levels.append(product)
    return torch.cat(levels, dim=1)


@pytest.mark.parametrize("time", [0.0, 0.4, 1.0])
def test_features_and_their_gradients_are_those_of_grid_sample(time: float) -> None:
    planes, _ = random_cells()
    times = np.random.default_rng(2).normal(size=(TIME_ROWS, BLOCKS, LAYOUT.n_line_cells, LANES))
    points, by = random_points(), np.random.default_rng(3).normal(size=(COUNT, FEATURES))
    leaves = [torch.tensor(planes, requires_grad=True), torch.tensor(times, requires_grad=True)]
    expected = by_torch(leaves[0], leaves[1], torch.tensor(points), time)
    (expected * torch.tensor(by)).sum().backward()
    row, share = time_taps(time, TIME_ROWS)
    lines = (1 - float(share)) * times[row] + float(share) * times[row + 1]
    assert np.allclose(sampled(planes, lines, points), expected.detach().numpy(), atol=1e-5)
    by_planes, by_lines, _ = sampled_backward(planes, lines, points, np.ones(COUNT, bool), by)
    assert leaves[0].grad is not None
    assert leaves[1].grad is not None
    assert np.allclose(by_planes, leaves[0].grad.numpy(), atol=1e-4)
    by_times = np.zeros_like(times)
    by_times[row] += (1 - float(share)) * by_lines
    by_times[row + 1] += float(share) * by_lines
    assert np.allclose(by_times, leaves[1].grad.numpy(), atol=1e-4)


def test_gradients_by_cells_are_the_slopes() -> None:
    """Features are linear in each single cell: differences are exact but for rounding."""
    planes, lines = random_cells()
    points, by = random_points(), np.random.default_rng(3).normal(size=(COUNT, FEATURES))
    seen = np.random.default_rng(4).uniform(size=COUNT) < 0.7
    by_planes, by_lines, touched = sampled_backward(planes, lines, points, seen, by)

    def loss() -> float:
        return float((sampled(planes, lines, points) * by)[seen].sum())

    rng = np.random.default_rng(5)
    for values, slopes in ((planes, by_planes), (lines, by_lines)):
        for _ in range(60):
            cell = tuple(int(rng.integers(size)) for size in values.shape)
            kept = values[cell]
            values[cell] = kept + 1
            ahead = loss()
            values[cell] = kept - 1
            assert slopes[cell] == pytest.approx((ahead - loss()) / 2, abs=1e-9)
            values[cell] = kept
    assert (touched | ~by_planes.any(axis=2)).all()


def test_float32_is_close_to_float64() -> None:
    points = random_points(np.float32)
    exact = sampled(*random_cells(), points.astype(np.float64))
    assert np.abs(sampled(*random_cells(np.float32), points) - exact).max() < 1e-5 * np.abs(exact).max()


def test_gradients_do_not_depend_on_the_number_of_threads() -> None:
    points, seen = random_points(np.float32), np.ones(COUNT, bool)
    by = np.random.default_rng(3).normal(size=(COUNT, FEATURES)).astype(np.float32)
    several = sampled_backward(*random_cells(np.float32), points, seen, by)
    threads = numba.get_num_threads()
    numba.set_num_threads(1)
    try:
        one = sampled_backward(*random_cells(np.float32), points, seen, by)
    finally:
        numba.set_num_threads(threads)
    assert all(a.tobytes() == b.tobytes() for a, b in zip(several, one, strict=True))


@given(st.floats(0, 1), st.integers(2, 70))
def test_rows_span_the_whole_of_time(time: float, rows: int) -> None:
    row, share = time_taps(time, rows)
    assert 0 <= row <= rows - 2
    assert row + float(share) == pytest.approx(time * (rows - 1), abs=1e-5)
    cells = np.arange(rows, dtype=np.float32)[:, None, None, None]
    assert lines_at(cells, time)[0, 0, 0] == pytest.approx(time * (rows - 1), rel=1e-5, abs=1e-5)


def test_the_box_clamps_and_may_be_flat() -> None:
    box = np.array([[-1, 2, 5], [3, 4, 5]], np.float32)
    means = np.array([[1, 3, 5], [-9, 9, 5], [1e30, -1e30, 1e30]], np.float32)
    got = within_box(means, box)
    assert got.tolist() == [[0.5, 0.5, 0], [0, 1, 0], [1, 0, 1]]


def random_heads(dtype: type = np.float64) -> Heads:
    heads = Heads.random(FEATURES, np.random.default_rng(6))
    return Heads(**{name: value.astype(dtype) for name, value in heads.arrays().items()})


def test_heads_and_their_gradients_are_those_of_torch() -> None:
    heads, rng = random_heads(), np.random.default_rng(7)
    features, by = rng.normal(size=(3 * ROWS, FEATURES)), rng.normal(size=(3 * ROWS, OFFSETS))
    offsets, seen = heads.offsets(features)
    leaves = {name: torch.tensor(value, requires_grad=True) for name, value in heads.arrays().items()}
    inputs = torch.tensor(features, requires_grad=True)
    trunk = torch.relu(inputs @ leaves["trunk_weight"] + leaves["trunk_bias"])
    parts = []
    for head, part in enumerate(PARTS):
        own = slice(head * WIDTH, (head + 1) * WIDTH)
        hidden = torch.relu(trunk @ leaves["hidden_weight"][:, own] + leaves["hidden_bias"][own])
        parts.append(hidden @ leaves["output_weight"][:, part] + leaves["output_bias"][part])
    expected = torch.cat(parts, dim=1)
    (expected * torch.tensor(by)).sum().backward()
    assert np.allclose(offsets, expected.detach().numpy(), atol=1e-12)
    gradients, by_features = heads.backward(by, seen)
    assert inputs.grad is not None
    assert np.allclose(by_features, inputs.grad.numpy(), atol=1e-12)
    for name, value in gradients.arrays().items():
        grad = leaves[name].grad
        assert grad is not None
        assert np.allclose(value, grad.numpy(), atol=1e-10), name


def test_heads_do_not_depend_on_the_threads_of_the_matrix_library() -> None:
    code = """if True:
        import hashlib, numpy as np
        from renderer.deformation.heads import OFFSETS, Heads
        rng = np.random.default_rng(0)
        heads = Heads.random(96, rng)
        offsets, seen = heads.offsets(rng.normal(size=(64 * 80, 96)).astype(np.float32))
        gradients, by = heads.backward(offsets, seen)
        digest = hashlib.sha256(by.tobytes())
        for value in gradients.arrays().values():
            digest.update(value.tobytes())
        print(digest.hexdigest())"""
    digests = [
        subprocess.run(
            [sys.executable, "-c", code],
            env=os.environ | {"OPENBLAS_NUM_THREADS": threads, "OMP_NUM_THREADS": threads},
            check=True,
            capture_output=True,
        ).stdout
        for threads in ("1", "4")
    ]
    assert digests[0] == digests[1]


def random_motion(unit: float = 1.0) -> HexplaneMotion:
    rng = np.random.default_rng(8)
    planes = rng.uniform(0.1, 0.5, (BLOCKS, LAYOUT.n_plane_cells, LANES))
    times = rng.uniform(0.5, 1.5, (TIME_ROWS, BLOCKS, LAYOUT.n_line_cells, LANES))
    return HexplaneMotion(
        box=np.array([[-10, -10, 40], [10, 10, 60]], np.float32) * np.float32(unit),
        unit=np.array([unit], np.float32),
        resolutions=RESOLUTIONS,
        plane_cells=planes.astype(np.float32),
        time_cells=times.astype(np.float32),
        heads=random_heads(np.float32),
    )


def random_gaussians(unit: float = 1.0) -> RawGaussians:
    rng = np.random.default_rng(9)
    means = rng.uniform((-12, -12, 38), (12, 12, 62), (COUNT, 3)) * unit
    return RawGaussians(
        means=means.astype(np.float32),
        quats=rng.normal(size=(COUNT, 4)).astype(np.float32),
        log_scales=rng.normal(size=(COUNT, 3)).astype(np.float32),
        opacity_logits=rng.normal(size=COUNT).astype(np.float32),
        colors=rng.uniform(size=(COUNT, 3)).astype(np.float32),
        harmonics=np.zeros((COUNT, 0, 3), np.float32),
    )


def test_motion_changes_position_scale_and_rotation_alone() -> None:
    raw, motion = random_gaussians(), random_motion()
    moved = motion.moved(raw, 0.3)
    assert moved.colors is raw.colors
    assert moved.opacity_logits is raw.opacity_logits
    for name in ("means", "log_scales", "quats"):
        assert (getattr(moved, name) != getattr(raw, name)).any(axis=1).all(), name
    some = np.array([3, 3, 140, 7])
    of_some = motion.rows(some).moved(raw.rows(some), 0.3)
    assert np.allclose(of_some.means, moved.means[some], atol=1e-5)


def test_units_scale_the_offsets_of_positions_alone() -> None:
    metres, millimetres = (random_motion(unit).moved(random_gaussians(unit), 0.7) for unit in (1e-3, 1.0))
    assert np.allclose(1e3 * metres.means, millimetres.means, atol=1e-3)
    assert np.allclose(metres.log_scales, millimetres.log_scales, atol=1e-4)
    assert np.allclose(metres.quats, millimetres.quats, atol=1e-4)


def test_a_model_comes_back_from_its_file(tmp_path: Any) -> None:
    model = DynamicGaussians(random_gaussians(), random_motion())
    model.save(tmp_path / "model.safetensors")
    read = DynamicGaussians.load(tmp_path / "model.safetensors")
    assert isinstance(read.motion, HexplaneMotion)
    assert read.at(0.6).means.tobytes() == model.at(0.6).means.tobytes()


def trainer(cells: float, heads: float) -> HexplaneTrainer:
    rates = HexplaneRates(cells=Rate.constant(cells), heads=Rate.constant(heads))
    return HexplaneTrainer(random_motion(), rates)


def by_moved(raw: RawGaussians, scale: float = 1.0) -> RawGaussians:
    """Gradients by the moved values, as random as they are constant."""
    rng = np.random.default_rng(10)
    random = {
        name: (scale * rng.normal(size=value.shape)).astype(np.float32)
        for name, value in raw.arrays().items()
    }
    return RawGaussians(**random)


def test_the_trainer_takes_the_slopes_of_the_whole_motion() -> None:
    """Adam's first moments after one step are a tenth of the gradient; differences along random lines."""
    raw = random_gaussians()
    by, seen = by_moved(raw), np.random.default_rng(11).uniform(size=COUNT) < 0.8
    training = trainer(0.0, 0.0)
    training.moved(raw, 0.4)
    training.update(0.4, by, seen, 0)
    arrays = training.motion.arrays()

    def loss(name: str, value: NDArray[Any]) -> float:
        moved = HexplaneMotion.from_arrays(arrays | {name: value.astype(np.float32)}).moved(raw, 0.4)
        pairs = ((getattr(by, key), getattr(moved, key)) for key in ("means", "log_scales", "quats"))
        return float(sum((a.astype(np.float64) * b)[seen].sum() for a, b in pairs))

    rng = np.random.default_rng(12)
    for name in HexplaneMotion.NAMES[3:]:
        gradient = 10 * training.state()[f"first.{name}"].astype(np.float64)
        away = rng.normal(size=gradient.shape)
        line = gradient / np.linalg.norm(gradient) + away / np.linalg.norm(away)
        ahead, behind = (loss(name, arrays[name] + step * line) for step in (2e-3, -2e-3))
        assert (gradient * line).sum() == pytest.approx((ahead - behind) / 4e-3, rel=0.03), name


def test_only_the_two_rows_of_the_time_and_cells_near_what_is_seen_move() -> None:
    raw, training = random_gaussians(), trainer(1e-2, 1e-2)
    before = {name: value.copy() for name, value in training.motion.arrays().items()}
    seen = np.zeros(COUNT, bool)
    seen[5] = True
    training.moved(raw, 0.5)
    training.update(
        0.5, replace(by_moved(raw), means=np.full((COUNT, 3), np.nan, np.float32)), ~seen & seen, 0
    )
    assert all(np.array_equal(before[name], value) for name, value in training.motion.arrays().items())
    training.moved(raw, 0.5)
    training.update(0.5, by_moved(raw), seen, 1)
    after = training.motion.arrays()
    moved_rows = (after["time_cells"] != before["time_cells"]).any(axis=(1, 2, 3))
    assert moved_rows.tolist() == [False, True, True, False]
    cells = (after["plane_cells"] != before["plane_cells"]).any(axis=2)
    assert 0 < cells[0].sum() <= len(RESOLUTIONS) * 3 * 4
    assert np.array_equal(after["box"], before["box"])


def test_training_fits_a_motion_in_space_and_time() -> None:
    """Points of two halves go different ways over time; least squares on their positions."""
    raw, training = random_gaussians(), trainer(2e-2, 2e-3)
    seen = np.ones(COUNT, bool)
    side = np.sign(raw.means[:, :1])

    def target(time: float) -> NDArray[np.float32]:
        return raw.means + side * np.float32(np.sin(3 * time)) * np.array([0, 1.5, 0.5], np.float32)

    def error() -> float:
        apart = [np.abs(training.motion.moved(raw, t).means - target(t)).mean() for t in (0.0, 0.33, 0.8)]
        return float(np.mean(apart))

    nothing, rng = by_moved(raw, 0.0), np.random.default_rng(13)
    start = error()
    for step in range(300):
        time = float(rng.uniform())
        moved = training.moved(raw, time)
        training.update(time, replace(nothing, means=moved.means - target(time)), seen, step)
    assert error() < 0.2 * start
