""".ksplat of GaussianSplats3D, against files packed by the words of the format."""

from __future__ import annotations

import tracemalloc
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from renderer.raw_gaussians import RawGaussians, sigmoid
from renderer.splat_files import SplatFile, SplatFileError, read_splats
from tests.renderer.splat_files.files import at, damaged, gaussians, is_refused
from tests.renderer.splat_files.ksplat_files import head, ksplat


def scene(count: int, bands: int = 0, seed: int = 0) -> RawGaussians:
    """Near enough to one another for buckets of 8."""
    raw = gaussians(count, bands, seed)
    return replace(raw, means=raw.means / 100)


def read(folder: Path, content: bytes) -> SplatFile:
    (folder / "a.ksplat").write_bytes(content)
    return read_splats(folder / "a.ksplat")


def close(one: RawGaussians, other: RawGaussians, level: int, rest: float = 3.0) -> None:
    half = 0 if level == 0 else 1e-3
    assert np.allclose(one.means, other.means, atol=2e-4 if level else 0, rtol=0)
    assert np.allclose(one.log_scales, other.log_scales, atol=1e-6 + half)
    assert np.allclose(one.quats, other.quats, atol=1e-6, rtol=half)
    assert np.allclose(one.colors, np.clip(other.colors, 0, 1), atol=0.51 / 255)
    assert np.allclose(sigmoid(one.opacity_logits), sigmoid(other.opacity_logits), atol=0.51 / 255)
    assert one.harmonics.shape == other.harmonics.shape
    step = (0, 1e-3, 0.51 * rest / 255)[level]
    assert np.allclose(one.harmonics, np.clip(other.harmonics, -1.5, 1.5), atol=step)


@pytest.mark.parametrize("bands", [0, 3, 8, 15])
@pytest.mark.parametrize("level", [0, 1, 2])
@pytest.mark.parametrize("count", [1, 4, 23])
def test_what_is_packed_comes_back(tmp_path: Path, count: int, level: int, bands: int) -> None:
    """In full buckets alone, in one that is not full, and in both."""
    raw = scene(count, bands)
    raw = replace(raw, harmonics=np.clip(raw.harmonics, -1.4, 1.4))
    got = read(tmp_path, ksplat(raw, level=level))
    close(got.raw, raw, level)
    assert got.notices == ()


@pytest.mark.parametrize("level", [0, 1, 2])
def test_sections_of_several_degrees_follow_one_another(tmp_path: Path, level: int) -> None:
    """With room for splats that are not there, as while a file is loaded."""
    parts = [scene(9, 3, 1), scene(6, 8, 2), scene(3, 0, 3)]
    got = read(tmp_path, ksplat(*parts, level=level, room=5)).raw
    assert len(got) == 18
    start = 0
    for part in parts:
        rows = got.rows(np.arange(start, start + len(part)))
        close(rows, part.of_degree(2), level)
        start += len(part)


def test_a_file_may_have_ranges_of_its_own(tmp_path: Path) -> None:
    raw = scene(10, 3)
    raw = replace(raw, harmonics=np.clip(raw.harmonics, -0.2, 0.9))
    got = read(tmp_path, ksplat(raw, level=2, rest=(-0.25, 1.0), whole=20000)).raw
    close(got, raw, 2, rest=1.25)


GOOD = ksplat(scene(9, 3), level=1)
FIRST = 4096


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (b"short", "a header of 4096 bytes, got 5"),
        (bytes(4096), "got version 0.0 and level 0: convert it"),
        (at(GOOD, 0, "B", 1), "got version 1.1"),
        (at(GOOD, 20, "H", 3), "level 3"),
        (at(GOOD, 4, "I", 2**32 - 1), "headers of 4294967295 sections"),
        (at(GOOD, 16, "I", 4_000_000_000), "5000000"),
        (at(GOOD, 16, "I", 8), "expected 8 splats, got 9"),
        (head(0, 0, 0), "expected sections"),
        (at(GOOD, FIRST, "I", 10), "up to 9 splats"),
        (at(GOOD, FIRST + 40, "H", 4), "degree 4"),
        (at(GOOD, FIRST + 4, "I", 2**32 - 1), "cut off"),
        (at(GOOD, FIRST + 12, "I", 2**32 - 1), "cut off"),
        (at(GOOD, FIRST + 20, "H", 16), "centres of 12 bytes, got 16"),
        (at(GOOD, FIRST + 36, "I", 2**31), "cut off"),
        (at(GOOD, FIRST + 12, "I", 2), "buckets for 9 splats, got 2"),
        (GOOD[:-1], "cut off"),
        (b"\x89PNG\r\n\x1a\n" + bytes(88), "a PNG image"),
    ],
)
def test_a_bad_file_is_one_line(tmp_path: Path, content: bytes, said: str) -> None:
    with pytest.raises(SplatFileError, match=said) as caught:
        read(tmp_path, content)
    assert "\n" not in str(caught.value)
    assert str(caught.value).endswith("a.ksplat")


def test_splats_without_size_are_left_out_and_said(tmp_path: Path) -> None:
    raw = scene(5)
    raw.log_scales[2] = -40
    got = read(tmp_path, ksplat(raw, level=1))
    assert len(got.raw) == 4
    assert "1 of 5" in got.notices[0]


def test_what_a_file_says_of_itself_takes_no_memory(tmp_path: Path) -> None:
    lies = at(at(GOOD, FIRST + 8, "I", 2**32 - 1), FIRST + 32, "I", 2**32 - 1)
    tracemalloc.start()
    for content in (lies, at(GOOD, FIRST + 12, "I", 2**31), at(GOOD, 16, "I", 5_000_000)):
        try:
            read(tmp_path, content)
        except SplatFileError:
            continue
    _, most = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert most < 1e6


@pytest.mark.parametrize("level", [0, 1, 2])
def test_damaged_files_are_read_or_refused(tmp_path: Path, level: int) -> None:
    """Bytes that say nothing are left alone: most of the headers are."""
    rng = np.random.default_rng(level)
    whole = ksplat(scene(9, 3), scene(4), level=level)
    told = [*range(44), *range(4096, 4138), *range(5120, 5162), *range(6144, len(whole))]
    refused = 0
    for case in range(1000):
        bent = bytearray(whole)
        for place in rng.choice(told[:128] if case % 3 else told, 3):
            bent[place] = rng.integers(256)
        content = damaged(bytes(bent), rng) if case % 5 == 0 else bytes(bent)
        refused += is_refused(read, tmp_path, content)
    assert 300 < refused < 1000
