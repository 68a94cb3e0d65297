"""The dynamic model: evaluation in time, and its file."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from safetensors.numpy import save_file

from renderer.deformation.fdm import FlexibleMotion
from renderer.deformation.spline_motion import SplineMotion
from renderer.gaussians import DynamicGaussians
from renderer.raw_gaussians import RawGaussians, sigmoid
from renderer.splats import Splats
from tests.renderer.windowed import windowed


def model(count: int = 7, n_controls: int = 6, n_nodes: int = 4) -> DynamicGaussians:
    rng = np.random.default_rng(0)
    weights = rng.uniform(0.1, 1, (count, 4)).astype(np.float32)
    raw = RawGaussians(
        means=rng.normal(size=(count, 3)).astype(np.float32),
        quats=rng.normal(size=(count, 4)).astype(np.float32),
        log_scales=rng.normal(size=(count, 3)).astype(np.float32),
        opacity_logits=rng.normal(size=count).astype(np.float32),
        colors=rng.uniform(size=(count, 3)).astype(np.float32),
        harmonics=rng.normal(size=(count, 3, 3)).astype(np.float32),
    )
    motion = SplineMotion(
        position_controls=rng.normal(size=(count, n_controls, 3)).astype(np.float32),
        color_controls=rng.normal(size=(count, n_controls, 3)).astype(np.float32),
        opacity_controls=rng.normal(size=(count, n_controls, 1)).astype(np.float32),
        node_controls=rng.normal(size=(n_nodes, n_controls, 3)).astype(np.float32),
        node_indices=rng.integers(0, n_nodes, (count, 4)).astype(np.int32),
        node_weights=weights / weights.sum(axis=1, keepdims=True),
    )
    return DynamicGaussians(raw, motion)


def still(moving: DynamicGaussians) -> DynamicGaussians:
    """The same with channels that have no rows."""
    empty = np.zeros((0, 6, 3), np.float32)
    motion = SplineMotion(
        position_controls=empty,
        color_controls=empty,
        opacity_controls=empty[..., :1],
        node_controls=empty,
        node_indices=np.zeros((0, 4), np.int32),
        node_weights=np.zeros((0, 4), np.float32),
    )
    return DynamicGaussians(moving.raw, motion)


def test_static_model_is_the_same_at_all_times() -> None:
    one, other = still(model()).at(0.0), still(model()).at(0.77)
    assert np.array_equal(one.means, other.means)
    assert np.array_equal(one.colors, other.colors)
    assert np.allclose(one.scales, np.exp(model().raw.log_scales))
    assert np.allclose(one.opacities, 1 / (1 + np.exp(-model().raw.opacity_logits)), atol=1e-6)


@pytest.mark.parametrize("time", [np.nan, -1.0, 2.0, np.inf, 1.001])
def test_another_time_is_refused(time: float) -> None:
    with pytest.raises(ValueError, match=r"expected a time in \[0, 1\], got "):
        model().at(time)
    assert len(model().at(np.nextafter(1.0, 2.0))) == len(model())


def test_position_is_base_plus_own_curve_plus_shared_curve() -> None:
    """Against the sum written out with de Boor's recursion in float64."""
    gaussians = model()
    motion = gaussians.motion
    assert isinstance(motion, SplineMotion)
    for time in (0.0, 0.31, 0.9999, 1.0):
        shared = np.array([de_boor(controls, time) for controls in motion.node_controls])
        own = np.array([de_boor(controls, time) for controls in motion.position_controls])
        expected = gaussians.means + own
        for n in range(len(gaussians)):
            expected[n] += motion.node_weights[n] @ shared[motion.node_indices[n]]
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


@pytest.mark.parametrize("kind", [np.float32, np.float64])
def test_sigmoid_has_no_overflow(kind: type[np.float32] | type[np.float64]) -> None:
    values = sigmoid(np.array([-1e4, -90, 0, 90, 1e4], kind))
    assert values.tolist() == [0, 0, 0.5, 1, 1]
    assert values.dtype == kind


def test_file_round_trip_is_exact(tmp_path: Path) -> None:
    path = tmp_path / "model.safetensors"
    model().save(path, {"made": "by a test"})
    loaded = DynamicGaussians.load(path)
    assert list(loaded.arrays()) == list(model().arrays())
    for name, value in model().arrays().items():
        assert loaded.arrays()[name].tobytes() == value.tobytes(), name


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"means": np.zeros((7, 3))}, "expected means of float32, got float64"),
        ({"colors": np.full((7, 3), np.nan, np.float32)}, "expected finite values in colors, got 21 others"),
        ({"quats": np.ones((6, 4), np.float32)}, "expected quats of shape 7 4, got 6 4"),
    ],
)
def test_what_could_not_be_opened_is_not_saved(
    change: dict[str, np.ndarray], said: str, tmp_path: Path
) -> None:
    path = tmp_path / "model.safetensors"
    model().save(path)
    before = path.read_bytes()
    with pytest.raises(ValueError, match=said):
        replace(model(), raw=replace(model().raw, **change)).save(path)
    with pytest.raises(TypeError):
        model().save(path, {"fps": 25})  # type: ignore[dict-item]
    assert {one.name: one.read_bytes() for one in tmp_path.iterdir()} == {path.name: before}


def test_paths_are_texts_too_and_views_of_arrays_are_saved(tmp_path: Path) -> None:
    raw = model().raw
    shown = replace(raw, means=np.asfortranarray(raw.means), quats=np.repeat(raw.quats, 2, axis=1)[:, ::2])
    replace(model(), raw=shown).save(str(tmp_path / "model.safetensors"))
    found = DynamicGaussians.load(str(tmp_path / "model.safetensors"))
    assert np.array_equal(found.raw.means, raw.means)
    assert np.array_equal(found.raw.quats, raw.quats)


def test_colour_and_opacity_follow_their_curves() -> None:
    """Against de Boor's recursion in float64."""
    gaussians = model()
    motion = gaussians.motion
    assert isinstance(motion, SplineMotion)
    logits = gaussians.raw.opacity_logits + de_boor_all(motion.opacity_controls, 0.4)[:, 0]
    colors = gaussians.raw.colors + de_boor_all(motion.color_controls, 0.4)
    assert np.allclose(gaussians.at(0.4).opacities, 1 / (1 + np.exp(-logits)), atol=1e-6)
    assert np.allclose(gaussians.at(0.4).colors, colors, atol=1e-6)


def de_boor_all(controls: np.ndarray, time: float) -> np.ndarray:
    return np.array([de_boor(one, time) for one in controls])


def test_chosen_rows_are_the_chosen_splats() -> None:
    index = np.array([3, 3, 0, 6])
    some, every = model().rows(index).at(0.6), model().at(0.6)
    for name in ("means", "quats", "scales", "opacities", "colors", "harmonics"):
        assert np.array_equal(getattr(some, name), getattr(every, name)[index]), name


@pytest.mark.parametrize("count", [3, 6, 8])
def test_a_motion_of_other_gaussians_is_refused(count: int) -> None:
    """Before a kernel writes beyond their arrays."""
    moving, bumps = model(count).motion, FlexibleMotion.at_rest(count, 2, 0.1)
    for motion in (moving, bumps):
        with pytest.raises(ValueError, match=f"expected a motion of 7 Gaussians, got one of {count}"):
            DynamicGaussians(model().raw, motion).at(0.5)


def test_a_motion_in_windows_of_other_gaussians_is_refused() -> None:
    whole = windowed(20, (0, 11, model()), (8, 19, model(5)))
    with pytest.raises(ValueError, match="expected a motion of 7 Gaussians, got one of 12"):
        replace(whole, raw=model().raw).at(0.1)


@pytest.mark.parametrize("whole", [model(12), windowed(20, (0, 11, model()), (8, 19, model(5)))])
def test_rows_are_chosen_by_bools_and_from_the_end_too(whole: DynamicGaussians) -> None:
    index = np.array([1, 4, 9, 11])
    wanted = [whole.rows(index).at(time).means for time in (0.1, 0.475, 0.9)]
    assert len(wanted[1]) == 4
    for other in (np.isin(np.arange(12), index), index - 12):
        found = [whole.rows(other).at(time).means for time in (0.1, 0.475, 0.9)]
        assert all(np.array_equal(*pair) for pair in zip(found, wanted, strict=True))


def test_files_of_old_still_open(tmp_path: Path) -> None:
    """Without harmonics and without a curve of opacity, and with channels that have no rows."""
    path = tmp_path / "model.safetensors"
    arrays = still(model()).arrays()
    save_file({name: value for name, value in arrays.items() if name not in NEW}, path)
    old, new = DynamicGaussians.load(path).at(0.3), still(model()).at(0.3)
    assert np.array_equal(old.means, new.means)
    assert np.array_equal(old.opacities, new.opacities)
    assert old.harmonics.shape == (len(old), 0, 3)


NEW = ("harmonics", "opacity_controls")


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
