"""A few stray values make no others of a SOG coarse."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from renderer import read_splats, write_splats
from renderer.raw_gaussians import RawGaussians
from renderer.splat_files.morton import morton_order

COUNT = 4000


def splats() -> RawGaussians:
    random = np.random.default_rng(0)
    return RawGaussians(
        means=random.normal(size=(COUNT, 3)).astype(np.float32),
        quats=random.normal(size=(COUNT, 4)).astype(np.float32),
        log_scales=np.log(random.uniform(0.01, 0.1, (COUNT, 3))).astype(np.float32),
        opacity_logits=random.normal(size=COUNT).astype(np.float32),
        colors=random.random((COUNT, 3)).astype(np.float32),
        harmonics=random.normal(0, 0.1, (COUNT, 3, 3)).astype(np.float32),
    )


@pytest.mark.parametrize(
    ("name", "strays"),
    [
        ("colors", [10]),
        ("colors", [1000, 1000, 1000]),
        ("colors", [-400, 30, 1e5]),
        ("log_scales", [-69]),
        ("harmonics", [50, -1000]),
    ],
)
def test_all_others_are_as_near_as_without_and_strays_are_kept(
    name: str, strays: list[float], tmp_path: Path
) -> None:
    def away(raw: RawGaussians) -> NDArray[np.float32]:
        write_splats(tmp_path / "a.sog", raw)
        got = read_splats(tmp_path / "a.sog").raw.arrays()[name]
        own = raw.rows(morton_order(raw.means)).arrays()[name]
        return np.asarray(np.abs(got - own))

    plain, raw = away(splats()), splats()
    raw.arrays()[name].reshape(COUNT, -1)[: len(strays), 0] = strays
    assert np.sqrt(np.mean(away(raw) ** 2)) < 1.5 * np.sqrt(np.mean(plain**2))
    assert away(raw).max() < 0.1
