"""SPZ 4: the planes of version 3 in streams of their own."""

from __future__ import annotations

import sys
import tracemalloc
from pathlib import Path

import numpy as np
import pytest
import zstandard

from renderer.splat_files import SplatFile, SplatFileError, read_splats
from tests.renderer.splat_files.files import at, damaged, is_refused, spz, spz_streams


def read(folder: Path, content: bytes) -> SplatFile:
    (folder / "a.spz").write_bytes(content)
    return read_splats(folder / "a.spz")


def planes_of(count: int, functions: int) -> list[bytes]:
    rng = np.random.default_rng(count)
    planes = [rng.bytes(width * count) for width in (9, 1, 3, 3, 4)]
    return [*planes, rng.bytes(3 * functions * count)] if functions else planes


@pytest.mark.parametrize("degree", [0, 1, 2, 3])
@pytest.mark.parametrize("count", [1, 50])
@pytest.mark.parametrize("extra", [b"", b"what a maker adds"])
def test_it_holds_what_version_3_does(tmp_path: Path, count: int, degree: int, extra: bytes) -> None:
    planes = planes_of(count, (0, 3, 8, 15)[degree])
    flags = 1 if count > 1 else 0
    new = read(tmp_path, spz_streams(degree, planes, count=count, flags=flags, extra=extra))
    old = read(tmp_path, spz(3, degree, planes, count=count, flags=flags))
    assert (new.mode, new.notices) == (old.mode, old.notices)
    for name, value in old.raw.arrays().items():
        assert np.array_equal(new.raw.arrays()[name], value), name


def test_of_degree_4_three_are_read_and_it_is_said(tmp_path: Path) -> None:
    planes = planes_of(6, 24)
    got = read(tmp_path, spz_streams(4, planes, count=6))
    assert got.notices[-1] == "colours by direction are read to degree 3 of 4"
    rest = np.frombuffer(planes[-1], np.uint8).reshape(6, 24, 3)[:, :15]
    whole = read(tmp_path, spz(3, 3, [*planes[:-1], rest.tobytes()], count=6))
    assert np.array_equal(got.raw.harmonics, whole.raw.harmonics)


def test_no_splats_are_none(tmp_path: Path) -> None:
    assert len(read(tmp_path, spz_streams(0, [], count=0)).raw) == 0
    assert read(tmp_path, spz_streams(4, [], count=0)).raw.harmonics.shape == (0, 15, 3)


GOOD = spz_streams(1, planes_of(5, 3), count=5)


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (GOOD[:20], "cut off"),
        (GOOD[:-1], "a stream of 45 bytes"),
        (GOOD[:60], "6 streams, got 6 in 60 bytes"),
        (at(GOOD, 4, "I", 5), "version 1 to 4, got version 5: convert it to .ply"),
        (at(GOOD, 8, "I", 4_000_000_000), "5000000"),
        (at(GOOD, 8, "I", 6), "a stream of 54 bytes, got 45"),
        (at(GOOD, 12, "B", 5), "degree 5"),
        (at(GOOD, 13, "B", 40), "with 40"),
        (at(GOOD, 15, "B", 5), "6 streams, got 5"),
        (at(GOOD, 16, "I", 2**32 - 1), "cut off"),
        (at(GOOD, 32, "Q", 2**60), "a stream of 45 bytes"),
        (at(GOOD, 40, "Q", 2**60), "got 1152921504606846976"),
        (at(GOOD, 128, "I", 0), "a damaged file"),
    ],
)
def test_a_bad_file_is_one_line(tmp_path: Path, content: bytes, said: str) -> None:
    with pytest.raises(SplatFileError, match=said) as caught:
        read(tmp_path, content)
    assert "\n" not in str(caught.value)
    assert str(caught.value).endswith("a.spz")


def test_without_its_package_it_is_one_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "zstandard", None)
    with pytest.raises(SplatFileError, match="needs the package zstandard"):
        read(tmp_path, GOOD)


def test_what_a_file_says_of_itself_takes_no_memory(tmp_path: Path) -> None:
    """A stream of 200 MB where 45 bytes belong, and one that is said to be so long."""
    bomb = zstandard.ZstdCompressor().compress(bytes(200_000_000))
    streams = spz_streams(1, planes_of(5, 3), count=5)
    lies = at(streams, 32, "Q", len(bomb))[:128] + bomb
    tracemalloc.start()
    for content in (lies, at(GOOD, 8, "I", 4_999_999)):
        with pytest.raises(SplatFileError):
            read(tmp_path, content)
    _, most = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert most < 1e6


def test_damaged_files_are_read_or_refused(tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    assert 500 < sum(is_refused(read, tmp_path, damaged(GOOD, rng)) for _ in range(3000)) < 3000
