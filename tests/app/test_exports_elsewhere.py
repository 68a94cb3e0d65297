"""PLY, SPZ and SOG as another program reads them, which knows the published formats alone."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from app.scenes.scene import open_scene
from renderer.raw_gaussians import RawGaussians, sigmoid
from renderer.rotations import matrix, unit_quats
from renderer.splat_files import write_splats
from tests.app.conftest import Cli
from tests.renderer.splat_files.files import gaussians
from tests.renderer.splat_files.plain_readers import (
    CONSTANT,
    RIGHT_DOWN_FORWARD,
    PlainSplat,
    functions,
    ply_splats,
    sog_splats,
    spz_splats,
)

READERS: dict[str, Callable[[bytes], list[PlainSplat]]] = {
    ".ply": ply_splats,
    ".spz": spz_splats,
    ".v4.spz": spz_splats,
    ".sog": sog_splats,
}
FLAGS = {".ply": "--ply", ".spz": "--spz", ".v4.spz": "--spz4", ".sog": "--sog"}
DIRECTIONS = ((1.0, 0.0, 0.0), (0.0, 0.6, 0.8), (-0.48, 0.64, -0.6), (0.36, -0.48, 0.8))


def same(read: list[PlainSplat], raw: RawGaussians, suffix: str) -> None:
    """To what each format rounds; SOG has an order of its own."""
    places = np.array([one.place for one in read])
    assert len(read) == len(raw)
    away = np.abs(places[None] - raw.means[:, None].astype(np.float64)).sum(axis=2)
    order = away.argmin(axis=1)
    assert sorted(order) == list(range(len(raw)))
    if suffix != ".sog":
        assert list(order) == list(range(len(raw)))
    read = [read[place] for place in order]
    span = np.abs(raw.means).max()
    tolerance = {".ply": 1e-6, ".sog": 2e-4}.get(suffix, 1e-6) * span
    assert np.allclose([one.place for one in read], raw.means, rtol=0, atol=tolerance)
    turned = matrix(unit_quats(raw.quats).T.astype(np.float64)).transpose(2, 0, 1)
    sized = turned * np.exp(raw.log_scales.astype(np.float64))[:, None, :]
    covariances = sized @ sized.transpose(0, 2, 1)
    largest = np.abs(covariances).max(axis=(1, 2), keepdims=True)
    apart = np.abs(np.array([one.covariance for one in read]) - covariances) / largest
    assert apart.max() < (1e-5 if suffix == ".ply" else 0.08)
    assert np.allclose([one.opacity for one in read], sigmoid(raw.opacity_logits), atol=0.51 / 255)
    for direction in DIRECTIONS:
        colors = [one.color(direction) for one in read]
        assert np.allclose(colors, seen(raw, direction), atol=1e-5 if suffix == ".ply" else 0.04)


def seen(raw: RawGaussians, direction: tuple[float, float, float]) -> np.ndarray:
    """(N, 3) colours along a direction."""
    base = ((raw.colors.astype(np.float64) - 0.5) / CONSTANT)[:, None]
    coefficients = np.concatenate([base, raw.harmonics], axis=1)
    values = np.array(functions(*direction))[: coefficients.shape[1]]
    return 0.5 + np.einsum("k,nkc->nc", values, coefficients)


@pytest.mark.parametrize("suffix", READERS)
@pytest.mark.parametrize("bands", [0, 3, 8, 15])
def test_splats_are_where_and_what_they_were(tmp_path: Path, suffix: str, bands: int) -> None:
    raw = gaussians(120, bands, seed=2)
    raw.harmonics[:] = raw.harmonics.clip(-0.99, 0.99)
    path = tmp_path / f"a{suffix}"
    write_splats(path, raw)
    same(READERS[suffix](path.read_bytes()), raw, suffix)


@pytest.mark.parametrize("suffix", READERS)
def test_an_export_of_a_run_is_its_model_at_that_frame(
    runs: dict[str, Path], tmp_path: Path, vesselsplat: Cli, suffix: str
) -> None:
    call = vesselsplat("export", runs["original"], FLAGS[suffix], tmp_path / "out", "--frames", 4)
    assert (call.code, call.error) == (0, "")
    scene = open_scene(runs["original"])
    raw = scene.model.motion.moved(scene.model.raw, scene.time(4))
    same(READERS[suffix]((tmp_path / "out" / f"frame-000004{suffix}").read_bytes()), raw, suffix)


def test_the_readers_tell_axes_apart() -> None:
    """A splat that is turned and coloured by direction is not the same in the other axes."""
    one = PlainSplat(
        (1, 2, 3), (0.9, 0.1, 0.3, 0.3), (1, 2, 4), 0.5, [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)],
        RIGHT_DOWN_FORWARD,
    )  # fmt: skip
    other = PlainSplat(one.position, one.quat, one.sizes, one.opacity, one.coefficients, (1, -1, -1))
    assert other.place == (1, -2, -3)
    assert not np.allclose(one.covariance, other.covariance)
    assert not np.allclose(one.color(DIRECTIONS[2]), other.color(DIRECTIONS[2]))
