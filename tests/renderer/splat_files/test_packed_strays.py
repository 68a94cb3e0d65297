"""A few stray splats make hardly any others of a compressed PLY coarse, and what is coarse is told."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from renderer import read_splats, write_splats
from renderer.splat_files.morton import morton_order
from renderer.splat_files.packed_writing import clipped
from renderer.splat_files.strays import bounds_without_strays
from tests.renderer.splat_files.files import gaussians
from tests.renderer.splat_files.test_sog_strays import splats

COUNT = 3000


@pytest.mark.parametrize(("name", "value"), [("means", 1e5), ("colors", 1000), ("log_scales", -69)])
def test_only_the_least_opaque_share_the_chunk_of_strays(name: str, value: float, tmp_path: Path) -> None:
    raw = splats().rows(np.arange(COUNT))
    raw.arrays()[name][7] = value
    raw.arrays()[name][9, 1] = value
    path = tmp_path / "a.compressed.ply"
    write_splats(path, raw)
    got = read_splats(path).raw
    tail = COUNT % 256
    assert len(got) == COUNT
    last = got.rows(np.arange(COUNT - tail, COUNT))
    assert np.sort(last.opacity_logits)[-3] < np.quantile(raw.opacity_logits, 0.1), "all but the two strays"
    most = {"means": 10.0, "colors": 2.0, "log_scales": 10.0}[name]
    assert np.abs(got.arrays()[name][: COUNT - tail]).max() < most
    said = clipped(raw)
    assert bool(said) == (name != "log_scales"), "sizes to 4 %"
    for one in said:
        assert one.startswith(f"{tail} of {COUNT} splats are rounded by more than 2 % of the usual range")


def test_an_ordinary_model_has_no_strays_and_nothing_is_told() -> None:
    for raw in (splats(), gaussians(600), gaussians(1), gaussians(0)):
        assert clipped(replace(raw, harmonics=raw.harmonics.clip(-4, 4))) == ()
    low, high = bounds_without_strays(splats().means)
    assert (low == splats().means.min(axis=0)).all()
    assert (high == splats().means.max(axis=0)).all()


def test_a_value_where_most_are_the_same_is_none() -> None:
    flat = np.zeros((100, 3), np.float32)
    flat[0] = 3
    assert [end.tolist() for end in bounds_without_strays(flat)] == [[0, 0, 0], [3, 3, 3]]


def test_harmonics_beyond_4_are_told() -> None:
    raw = gaussians(40, 3)
    raw.harmonics[:] = 0.5
    raw.harmonics[:3, 0, 1] = -9
    assert clipped(raw) == (
        "3 of 360 values of colours by direction are beyond -4 to 4, which compressed PLY does not hold: "
        "they are clipped",
    )


def test_neighbours_stay_neighbours_beside_a_stray() -> None:
    """Of 16 bits of a coordinate over all, a stray would leave most splats a single one."""
    means = np.random.default_rng(3).uniform(0, 1, (4096, 3)).astype(np.float32)
    plain = morton_order(means)
    means[plain[-1]] = 1e9
    assert (morton_order(means)[-1] == plain[-1]).all()
    steps = np.linalg.norm(np.diff(means[morton_order(means)[:-1]], axis=0), axis=1)
    assert np.median(steps) < 0.15
