"""SPZ and SOG as they are written: read back by what is tested against files packed by hand."""

from __future__ import annotations

import gzip
import io
import json
import zipfile
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import zstandard
from hypothesis import given, settings
from hypothesis import strategies as st
from PIL import Image

from renderer.raw_gaussians import RawGaussians, sigmoid
from renderer.splat_files import WRITERS, read_splats, write_splats
from renderer.splat_files.grouping import grouped
from renderer.splat_files.morton import morton_order
from renderer.splat_files.sog_writing import sog_bytes
from renderer.splat_files.spz_writing import spz_bytes, spz_streams_bytes
from renderer.splats import RenderMode
from tests.renderer.splat_files.files import gaussians


def back(folder: Path, raw: RawGaussians, suffix: str, mode: RenderMode = "default") -> RawGaussians:
    path = folder / f"a{suffix}"
    write_splats(path, raw, mode)
    file = read_splats(path)
    assert (file.mode, file.notices) == (mode, ())
    return file.raw


def ordered(raw: RawGaussians, like: RawGaussians) -> RawGaussians:
    """In the order of others that are at the same places."""
    away = np.abs(raw.means[None] - like.means[:, None]).sum(axis=2)
    return raw.rows(away.argmin(axis=1))


def turned_alike(one: RawGaussians, other: RawGaussians, atol: float) -> None:
    units = [raw.quats / np.linalg.norm(raw.quats, axis=1, keepdims=True) for raw in (one, other)]
    signs = np.sign((units[0] * units[1]).sum(axis=1, keepdims=True))
    assert np.allclose(units[0] * signs, units[1], atol=atol)


@settings(max_examples=40, deadline=None)
@given(
    count=st.integers(0, 60),
    bands=st.sampled_from([0, 3, 8, 15]),
    mode=st.sampled_from(["default", "mip"]),
    unit=st.sampled_from([0.01, 1.0, 1000.0]),
    seed=st.integers(0, 99),
    ending=st.sampled_from([".spz", ".v4.spz"]),
)
def test_spz_comes_back_to_half_a_step(
    tmp_path_factory: pytest.TempPathFactory,
    count: int,
    bands: int,
    mode: RenderMode,
    unit: float,
    seed: int,
    ending: str,
) -> None:
    raw = gaussians(count, bands, seed)
    raw = replace(
        raw,
        means=np.float32(unit) * raw.means,
        harmonics=np.clip(raw.harmonics, -0.99, 0.99),
        colors=np.clip(raw.colors, -0.4, 1.4),
    )
    got = back(tmp_path_factory.mktemp("spz"), raw, ending, mode)
    assert np.allclose(got.means, raw.means, rtol=0, atol=np.abs(raw.means).max(initial=2) / 4e6 + 5e-7)
    assert np.allclose(got.log_scales, raw.log_scales, atol=0.51 / 16)
    assert np.allclose(sigmoid(got.opacity_logits), sigmoid(raw.opacity_logits), atol=0.51 / 255)
    assert np.allclose(got.colors, raw.colors, atol=0.51 / 255 * 0.2821 / 0.15)
    assert np.allclose(got.harmonics, raw.harmonics, atol=0.51 / 128)
    turned_alike(got, raw, 2e-3)


@settings(max_examples=30, deadline=None)
@given(
    count=st.integers(0, 300),
    bands=st.sampled_from([0, 3, 8, 15]),
    mode=st.sampled_from(["default", "mip"]),
    seed=st.integers(0, 99),
)
def test_sog_comes_back_in_an_order_of_its_own(
    tmp_path_factory: pytest.TempPathFactory, count: int, bands: int, mode: RenderMode, seed: int
) -> None:
    raw = gaussians(count, bands, seed)
    got = back(tmp_path_factory.mktemp("sog"), raw, ".sog", mode)
    assert len(got) == count
    assert got.harmonics.shape == raw.harmonics.shape
    if not count:
        return
    got = ordered(got, raw)
    logs = [np.sign(each.means) * np.log1p(np.abs(each.means)) for each in (got, raw)]
    assert np.allclose(*logs, atol=0.51 * np.ptp(logs[1], axis=0).max() / 65535 + 1e-6)
    # No code lies farther away than those that are evenly spaced.
    assert np.allclose(got.log_scales, raw.log_scales, atol=np.ptp(raw.log_scales) / 255)
    assert np.allclose(got.colors, raw.colors, atol=np.ptp(raw.colors) / 255 + 1e-6)
    if bands:
        assert np.allclose(got.harmonics, raw.harmonics, atol=np.ptp(raw.harmonics) / 255)
        # Most lie far nearer: codes are where the values are.
        even = np.ptp(raw.harmonics) / 255 / np.sqrt(12)
        assert np.sqrt(np.mean((got.harmonics - raw.harmonics) ** 2)) < even
    assert np.allclose(sigmoid(got.opacity_logits), sigmoid(raw.opacity_logits), atol=0.51 / 255)
    turned_alike(got, raw, 8e-3)


@settings(max_examples=30, deadline=None)
@given(
    count=st.integers(0, 600),
    bands=st.sampled_from([0, 3, 8, 15]),
    mode=st.sampled_from(["default", "mip"]),
    seed=st.integers(0, 99),
)
def test_packed_ply_comes_back_to_half_a_step_of_its_chunks(
    tmp_path_factory: pytest.TempPathFactory, count: int, bands: int, mode: RenderMode, seed: int
) -> None:
    raw = gaussians(count, bands, seed)
    got = back(tmp_path_factory.mktemp("packed"), raw, ".compressed.ply", mode)
    assert len(got) == count
    assert got.harmonics.shape == raw.harmonics.shape
    if not count:
        return
    got = ordered(got, raw)
    for one, other, most in (
        (got.means, raw.means, (2047, 1023, 2047)),
        (got.log_scales, raw.log_scales, (2047, 1023, 2047)),
        (got.colors, raw.colors, (255, 255, 255)),
    ):
        half = 0.51 * np.ptp(other, axis=0) / most
        assert (np.abs(one - other) <= half + 2e-5).all()
    assert np.allclose(sigmoid(got.opacity_logits), sigmoid(raw.opacity_logits), atol=0.51 / 255)
    assert np.allclose(got.harmonics, raw.harmonics, atol=0.51 / 32 + 1e-6)
    turned_alike(got, raw, 2e-3)


def test_packed_splats_that_are_near_share_narrow_chunks(tmp_path: Path) -> None:
    """Two clouds, in turn in the file, would else share every chunk: 20 apart, 11 bits tell 0.01."""
    raw = gaussians(1024)
    means = raw.means / 500 + np.where(np.arange(1024)[:, None] % 2, np.float32(20), np.float32(0))
    raw = replace(raw, means=means)
    got = ordered(back(tmp_path, raw, ".compressed.ply"), raw)
    assert np.abs(got.means - raw.means).max() < 1e-3


@pytest.mark.parametrize("suffix", [".spz", ".v4.spz", ".sog"])
def test_what_was_read_is_written_the_same_again(tmp_path: Path, suffix: str) -> None:
    """Nothing drifts, and a file holds no time."""
    raw = gaussians(200, 3)
    raw = replace(raw, harmonics=np.clip(raw.harmonics, -0.99, 0.99), colors=np.clip(raw.colors, -0.4, 1.4))
    first = WRITERS[suffix](raw, "default")
    assert first == WRITERS[suffix](raw, "default")
    (tmp_path / f"a{suffix}").write_bytes(first)
    once = read_splats(tmp_path / f"a{suffix}").raw
    twice = back(tmp_path, once, suffix)
    for name, value in once.arrays().items():
        assert np.allclose(value, twice.arrays()[name], rtol=1e-5, atol=1e-2 if name == "means" else 5e-3), (
            name
        )


def test_the_header_of_spz_is_that_of_version_3() -> None:
    content = gzip.decompress(spz_bytes(gaussians(3, 8), "mip"))
    assert content[:4] == b"NGSP"
    assert tuple(np.frombuffer(content[4:12], "<u4")) == (3, 3)
    assert (content[12], content[14], content[15]) == (2, 1, 0)
    assert len(content) == 16 + 3 * (9 + 1 + 3 + 3 + 4 + 24)


def test_spz_of_version_4_holds_the_planes_of_version_3() -> None:
    raw = gaussians(40, 8)
    content = spz_streams_bytes(raw, "mip")
    assert tuple(np.frombuffer(content[4:12], "<u4")) == (4, 40)
    assert (content[12], content[14]) == (2, 1)
    count, place = content[15], int.from_bytes(content[16:20], "little")
    sizes = np.frombuffer(content[place : place + 16 * count], "<u8").reshape(-1, 2)
    planes, start = b"", place + 16 * count
    for zipped, whole in sizes.tolist():
        plane = zstandard.ZstdDecompressor().decompress(content[start : start + zipped])
        assert len(plane) == whole
        planes, start = planes + plane, start + zipped
    assert start == len(content)
    assert planes == gzip.decompress(spz_bytes(raw, "mip"))[16:]


def test_the_list_of_sog_says_what_is_there() -> None:
    with zipfile.ZipFile(io.BytesIO(sog_bytes(gaussians(70, 3)))) as archive:
        said = json.loads(archive.read("meta.json"))
        sizes = {
            name: Image.open(io.BytesIO(archive.read(name))).size
            for name in archive.namelist()
            if name.endswith(".webp")
        }
        assert b"VP8L" in archive.read("sh0.webp")[:40]
    assert (said["version"], said["count"], said["antialias"]) == (2, 70, False)
    assert said["shN"]["bands"] == 1
    assert said["shN"]["count"] <= 70
    assert sizes.pop("shN_centroids.webp") == (64 * 3, 2)
    assert set(sizes.values()) == {(12, 8)}
    codes = np.array(said["scales"]["codebook"])
    assert len(codes) == 256
    assert (np.diff(codes) >= 0).all()


def test_splats_of_one_kind_take_one_row_of_the_palette() -> None:
    """As those of models whose harmonics are zeros."""
    raw = replace(gaussians(500), harmonics=np.zeros((500, 15, 3), np.float32))
    with zipfile.ZipFile(io.BytesIO(sog_bytes(raw))) as archive:
        assert json.loads(archive.read("meta.json"))["shN"]["count"] == 1


def test_of_more_colours_by_direction_than_sog_takes_those_alike_become_one(tmp_path: Path) -> None:
    many = replace(gaussians(70_000), harmonics=np.zeros((70_000, 3, 3), np.float32))
    many.harmonics[:, :, 0] = np.random.default_rng(0).uniform(-1, 1, (70_000, 3))
    write_splats(tmp_path / "a.sog", many)
    got = read_splats(tmp_path / "a.sog").raw
    own = many.rows(morton_order(many.means))
    away = got.harmonics - own.harmonics
    # 65,536 even cells of the cube are 0.05 wide; codes are 0.008 apart.
    assert np.sqrt(np.mean(away[:, :, 0] ** 2)) < 0.01
    assert np.abs(away).max() < 0.1
    assert np.abs(away[:, :, 1:]).max() < 1e-5


def test_groups_are_of_rows_that_are_alike() -> None:
    rng = np.random.default_rng(0)
    kinds = rng.uniform(-1, 1, (40, 9)).astype(np.float32)
    kind = rng.integers(0, 40, 2000)
    means, group = grouped(kinds[kind], 40)
    assert len(means) == 40
    assert np.allclose(means[group], kinds[kind], atol=1e-6)
    rows = kinds[kind] + rng.normal(0, 0.01, (2000, 9)).astype(np.float32)
    means, group = grouped(rows, 200)
    assert len(means) == group.max() + 1 == 200
    assert np.sqrt(np.mean((means[group] - rows) ** 2)) < 0.012
    assert len(grouped(rows[:0], 7)[0]) == 0


def test_what_a_format_cannot_hold_is_one_line(tmp_path: Path) -> None:
    far = gaussians(2)
    far.means[0, 1] = 1e9
    with pytest.raises(ValueError, match=r"nearer than 8388608 for SPZ, got 2 as far as 1e\+09"):
        write_splats(tmp_path / "a.spz", far)
    with pytest.raises(ValueError, match=r"\.ply, \.v4\.spz, \.spz, \.sog"):
        write_splats(tmp_path / "a.splat", far)
    assert not list(tmp_path.iterdir())


def test_splats_without_rotation_are_written_unrotated(tmp_path: Path) -> None:
    raw = replace(gaussians(4), quats=np.zeros((4, 4), np.float32))
    for suffix in (".spz", ".sog"):
        quats = np.abs(back(tmp_path, raw, suffix).quats)
        # An SPZ file has w last.
        assert np.allclose(quats[:, 0], 1, atol=0.01) or suffix == ".spz"
        assert np.allclose(np.linalg.norm(quats, axis=1), 1, atol=1e-3)


@pytest.mark.parametrize("ending", list(WRITERS))
@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("means", np.nan),
        ("means", 1e20),
        ("log_scales", -np.inf),
        ("log_scales", np.inf),
        ("opacity_logits", np.nan),
        ("colors", np.inf),
        ("harmonics", np.nan),
    ],
)
def test_a_splat_that_cannot_be_drawn_is_named_and_nothing_is_written(
    tmp_path: Path, ending: str, name: str, value: float
) -> None:
    raw = gaussians(4, 3)
    getattr(raw, name)[2] = value
    with pytest.raises(ValueError, match="got 1 of 4 without, the first in row 2"):
        write_splats(tmp_path / f"a{ending}", raw)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("ending", list(WRITERS))
def test_opacities_of_0_and_1_are_written(tmp_path: Path, ending: str) -> None:
    raw = replace(gaussians(2), opacity_logits=np.float32([-np.inf, np.inf]))
    assert sorted(np.rint(sigmoid(back(tmp_path, raw, ending).opacity_logits))) == [0, 1]


def test_an_unknown_mode_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="mode must be default or mip, got 'nope'"):
        write_splats(tmp_path / "a.ply", gaussians(3), "nope")  # type: ignore[arg-type]
    assert not any(tmp_path.iterdir())
