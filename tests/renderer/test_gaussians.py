"""The dynamic model: evaluation in time, and its file."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from renderer.gaussians import DynamicGaussians, sigmoid
from renderer.splats import Splats


def model(count: int = 7, n_controls: int = 6, n_nodes: int = 4) -> DynamicGaussians:
    rng = np.random.default_rng(0)
    weights = rng.uniform(0.1, 1, (count, 4)).astype(np.float32)
    return DynamicGaussians(
        means=rng.normal(size=(count, 3)).astype(np.float32),
        quats=rng.normal(size=(count, 4)).astype(np.float32),
        log_scales=rng.normal(size=(count, 3)).astype(np.float32),
        opacity_logits=rng.normal(size=count).astype(np.float32),
        colors=rng.uniform(size=(count, 3)).astype(np.float32),
        position_controls=rng.normal(size=(count, n_controls, 3)).astype(np.float32),
        color_controls=rng.normal(size=(count, n_controls, 3)).astype(np.float32),
        node_controls=rng.normal(size=(n_nodes, n_controls, 3)).astype(np.float32),
        node_indices=rng.integers(0, n_nodes, (count, 4)).astype(np.int32),
        node_weights=weights / weights.sum(axis=1, keepdims=True),
    )


def still(moving: DynamicGaussians) -> DynamicGaussians:
    empty = np.zeros((0, 6, 3), np.float32)
    return replace(
        moving,
        position_controls=empty,
        color_controls=empty,
        node_controls=empty,
        node_indices=np.zeros((0, 4), np.int32),
        node_weights=np.zeros((0, 4), np.float32),
    )


def test_static_model_is_the_same_at_all_times() -> None:
    one, other = still(model()).at(0.0), still(model()).at(0.77)
    assert np.array_equal(one.means, other.means)
    assert np.array_equal(one.colors, other.colors)
    assert np.allclose(one.scales, np.exp(model().log_scales))
    assert np.allclose(one.opacities, 1 / (1 + np.exp(-model().opacity_logits)), atol=1e-6)


def test_position_is_base_plus_own_curve_plus_shared_curve() -> None:
    """Against the sum written out with de Boor's recursion in float64."""
    gaussians = model()
    for time in (0.0, 0.31, 0.9999, 1.0):
        shared = np.array([de_boor(controls, time) for controls in gaussians.node_controls])
        own = np.array([de_boor(controls, time) for controls in gaussians.position_controls])
        expected = gaussians.means + own
        for n in range(len(gaussians)):
            expected[n] += gaussians.node_weights[n] @ shared[gaussians.node_indices[n]]
        assert np.allclose(gaussians.at(time).means, expected, atol=1e-5)


def de_boor(controls: np.ndarray, time: float) -> np.ndarray:
    """Cubic B-spline on the uniform knots -3, -2, ... in units of one segment (de Boor 1972)."""
    segments = len(controls) - 3
    x = time * segments
    k = min(int(x), segments - 1)
    points = controls[k : k + 4].astype(np.float64)
    knots = np.arange(-3, 5) + k
    for level in range(1, 4):
        for j in range(3, level - 1, -1):
            low = knots[j]
            alpha = (x - low) / (4 - level)
            points[j] = (1 - alpha) * points[j - 1] + alpha * points[j]
    return points[3]


def test_sigmoid_has_no_overflow() -> None:
    logits = np.array([-1e4, -90, 0, 90, 1e4], np.float32)
    assert sigmoid(logits).tolist() == [0, 0, 0.5, 1, 1]


def test_file_round_trip_is_exact(tmp_path: Path) -> None:
    path = tmp_path / "model.safetensors"
    model().save(path, {"made": "by a test"})
    loaded = DynamicGaussians.load(path)
    for name, value in model().arrays().items():
        assert getattr(loaded, name).tobytes() == value.tobytes(), name


def test_file_that_is_no_model_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "model.safetensors"
    with pytest.raises(ValueError, match="safetensors"):
        DynamicGaussians.load(path)
    path.write_text("not a model")
    with pytest.raises(ValueError, match="safetensors"):
        DynamicGaussians.load(path)
    model().save(path)
    content = path.read_bytes()
    path.write_bytes(content[: len(content) // 2])
    with pytest.raises(ValueError, match="safetensors"):
        DynamicGaussians.load(path)


def test_splats_of_unequal_length_are_refused() -> None:
    good = model().at(0)
    with pytest.raises(ValueError, match=r"Splats\.scales"):
        Splats(good.means, good.quats, good.scales[:3], good.opacities, good.colors)
