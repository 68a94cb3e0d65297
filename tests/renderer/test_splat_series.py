"""Folders of numbered splat files: which are a series, and what is kept of a long one."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from renderer.deformation.frame_by_frame import FrameByFrame
from renderer.gaussians import DynamicGaussians
from renderer.raw_gaussians import RawGaussians
from renderer.splat_files import WRITERS, SplatFileError, write_splats
from renderer.splat_series import read_series, series_files


def at(x: float, count: int = 5) -> RawGaussians:
    """All at one place."""
    return RawGaussians(
        means=np.tile(np.float32([x, 0, 5]), (count, 1)),
        quats=np.tile(np.float32([1, 0, 0, 0]), (count, 1)),
        log_scales=np.full((count, 3), -1.0, np.float32),
        opacity_logits=np.zeros(count, np.float32),
        colors=np.full((count, 3), 0.5, np.float32),
        harmonics=np.zeros((count, 0, 3), np.float32),
    )


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Twelve moments of 5 to 16 Gaussians, 1 apart, beside what is none of them."""
    for index in range(12):
        write_splats(tmp_path / f"time_{index}.ply", at(float(index), 5 + index))
    write_splats(tmp_path / "input.ply", at(99.0))
    (tmp_path / "readme.txt").write_text("notes")
    return tmp_path


def test_files_are_in_the_order_of_their_numbers(folder: Path) -> None:
    series = read_series(folder)
    assert [raw.means[0, 0] for raw in series.moments] == list(range(12))
    assert [len(raw) for raw in series.moments] == list(range(5, 17))
    (said,) = series.notices
    assert said.endswith("input.ply")
    model = DynamicGaussians(series.moments[0], FrameByFrame(series.moments))
    assert [model.at(time).means[0, 0] for time in (0.0, 0.039, 0.043, 0.5, 1.0)] == [0, 0, 1, 6, 11]


@pytest.mark.parametrize("ending", [*WRITERS, ".V4.SPZ"])
def test_the_number_of_a_moment_is_not_that_of_its_kind(ending: str, tmp_path: Path) -> None:
    for index in range(3):
        write_splats(tmp_path / f"frame-{index:06d}{ending}", at(float(index)))
    assert [path.name[:12] for path in series_files(tmp_path)] == [f"frame-{index:06d}" for index in range(3)]


def test_of_a_long_series_evenly_chosen_moments_are_kept(folder: Path) -> None:
    one = sum(array.nbytes for array in at(0.0, 10).arrays().values())
    series = read_series(folder, most_bytes=5 * one)
    kept = [raw.means[0, 0] for raw in series.moments]
    assert kept[0] == 0
    assert kept[-1] == 11
    assert 4 <= len(kept) <= 6
    assert sum(len(raw) for raw in series.moments) < 75
    assert f"{len(kept)} of 12 moments" in series.notices[0]


def test_what_is_no_series(folder: Path, tmp_path: Path) -> None:
    assert len(series_files(folder)) == 12
    (folder / "frame.png").touch()
    assert series_files(folder) == ()  # Images: a clip with a model beside it.
    (folder / "frame.png").unlink()
    for index in range(1, 12):
        (folder / f"time_{index}.ply").unlink()
    assert series_files(folder) == ()
    with pytest.raises(SplatFileError, match="two or more numbered splat files"):
        read_series(folder)
    assert series_files(tmp_path / "gone") == ()


def test_a_damaged_moment_is_named(folder: Path) -> None:
    (folder / "time_7.ply").write_bytes(b"ply damaged")
    with pytest.raises(SplatFileError, match=r"time_7\.ply"):
        read_series(folder)
