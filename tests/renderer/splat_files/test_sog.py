"""SOG of PlayCanvas: as a folder and as one file, against files packed by the words of the format."""

from __future__ import annotations

import io
import json
import tracemalloc
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from renderer.raw_gaussians import RawGaussians, sigmoid
from renderer.splat_files import SplatFile, SplatFileError, is_named_as_splats, read_splats, whole
from tests.renderer.splat_files.files import damaged, gaussians, is_refused
from tests.renderer.splat_files.sog_files import Files, bundled, picture, sog, webp


def read(folder: Path, files: Files) -> SplatFile:
    (folder / "a.sog").write_bytes(bundled(files))
    return read_splats(folder / "a.sog")


def changed(files: Files, *place: str | int, value: Any) -> Files:
    meta = json.loads(files["meta.json"])
    inner = meta
    for key in place[:-1]:
        inner = inner[key]
    inner[place[-1]] = value
    return {**files, "meta.json": json.dumps(meta).encode()}


def close(one: RawGaussians, other: RawGaussians) -> None:
    """Within half a step of what the format holds."""
    logs = [np.sign(raw.means) * np.log1p(np.abs(raw.means)) for raw in (one, other)]
    assert np.allclose(*logs, atol=0.51 * np.ptp(logs[1], axis=0).max() / 65535 + 1e-6)
    assert np.allclose(one.log_scales, other.log_scales, atol=0.51 * np.ptp(other.log_scales) / 255)
    assert np.allclose(one.colors, other.colors, atol=0.51 * np.ptp(other.colors) / 255 + 1e-3)
    assert np.allclose(sigmoid(one.opacity_logits), sigmoid(other.opacity_logits), atol=0.51 / 255)
    unit = other.quats / np.linalg.norm(other.quats, axis=1, keepdims=True)
    assert np.abs((one.quats * unit).sum(axis=1)).min() > 1 - 1e-4
    assert one.harmonics.shape == other.harmonics.shape
    if other.harmonics.size:
        assert np.allclose(one.harmonics, other.harmonics, atol=0.51 * np.ptp(other.harmonics) / 255)


@pytest.mark.parametrize("bands", [0, 3, 8, 15])
@pytest.mark.parametrize("count", [1, 20, 70])
def test_what_is_packed_comes_back(tmp_path: Path, count: int, bands: int) -> None:
    """Of 70 rows the palette needs a second line."""
    raw = gaussians(count, bands)
    got = read(tmp_path, sog(raw, antialias=bool(bands)))
    close(got.raw, raw)
    assert (got.mode, got.notices) == ("mip" if bands else "default", ())


@pytest.mark.parametrize("kind", ["WEBP", "PNG"])
def test_a_folder_holds_what_an_archive_does(tmp_path: Path, kind: str) -> None:
    raw = gaussians(9, 3)
    files = sog(raw, kind=kind)
    for name, content in files.items():
        (tmp_path / name).write_bytes(content)
    archive = tmp_path / "packed.sog"
    archive.write_bytes(bundled(files, "scene/", zipfile.ZIP_DEFLATED))
    read_back = [read_splats(path).raw.arrays() for path in (tmp_path, tmp_path / "meta.json", archive)]
    for name, value in read_back[0].items():
        assert all(np.array_equal(value, other[name]) for other in read_back), name
    close(read_splats(tmp_path).raw, raw)
    assert is_named_as_splats(tmp_path)
    assert whole(tmp_path / "meta.json") == whole(tmp_path) == tmp_path
    assert whole(archive) == archive


def test_no_splats_are_none(tmp_path: Path) -> None:
    assert len(read(tmp_path, sog(gaussians(0))).raw) == 0


def test_opaque_and_clear_splats_keep_their_colours(tmp_path: Path) -> None:
    """Colours of clear pixels are values like others."""
    raw = gaussians(4)
    raw.opacity_logits[:] = [-90, 90, 0, 1]
    got = read(tmp_path, sog(raw)).raw
    close(got, raw)
    assert np.array_equal(got.splats().opacities[:2], (0, 1))


def test_the_first_code_may_be_missing(tmp_path: Path) -> None:
    """As early converters wrote it: it lies one step before the second."""
    raw = gaussians(30, 3)
    files = sog(raw)
    whole_file = read(tmp_path, files).raw
    for part in ("scales", "sh0", "shN"):
        files = changed(files, part, "codebook", 0, value=None)
    close(read(tmp_path, files).raw, raw)
    assert np.allclose(read(tmp_path, files).raw.log_scales, whole_file.log_scales, atol=0.05)
    broken = changed(sog(raw), "scales", "codebook", 255, value=None)
    got = read(tmp_path, broken)
    assert len(got.raw) < 30
    assert "are left out" in got.notices[0]


def test_rotations_that_name_no_part_are_none(tmp_path: Path) -> None:
    quats = picture([(9, 9, 9, 251), (0, 0, 0, 0), (128, 128, 128, 253)], 5)
    got = read(tmp_path, {**sog(gaussians(3)), "quats.webp": quats})
    assert "2 of 3 splats have no rotation" in got.notices[0]
    assert np.allclose(got.raw.quats, [(1, 0, 0, 0), (1, 0, 0, 0), (0, 1, 0, 0)], atol=0.02)


GOOD = sog(gaussians(3, 3))
TIFF = io.BytesIO()
Image.new("RGB", (5, 5)).save(TIFF, "TIFF")


@pytest.mark.parametrize(
    ("files", "said"),
    [
        (changed(GOOD, "version", value=3), "version 2, got 3: convert it to .ply"),
        ({**GOOD, "meta.json": b'{"means": {"shape": [3]}, "sh0": {}}'}, "version 2, got 1: convert"),
        ({**GOOD, "meta.json": b'{"lodLevels": 2}'}, "one level of detail"),
        ({**GOOD, "meta.json": b"{"}, "damaged JSON"),
        ({**GOOD, "meta.json": b"[]"}, "version 2, got None"),
        ({**GOOD, "meta.json": b" " * (1 << 21)}, "at most 1048576 bytes"),
        (changed(GOOD, "count", value=-1), "count"),
        (changed(GOOD, "count", value=4_000_000_000), "5000000"),
        (changed(GOOD, "count", value=26), "means_l.webp of 26|quats.webp of 26"),
        (changed(GOOD, "means", "mins", value=[0, 0]), "means.mins"),
        (changed(GOOD, "means", "mins", value=[0, 0, "1"]), "means.mins"),
        (changed(GOOD, "scales", "codebook", value=[0.0] * 255), "scales.codebook"),
        (changed(GOOD, "sh0", value=None), "sh0"),
        (changed(GOOD, "shN", "bands", value=4), "shN.bands"),
        (changed(GOOD, "shN", "bands", value=2), "to be 512 pixels wide|shN_centroids.webp of 512"),
        (changed(GOOD, "shN", "count", value=2), "a palette of 2, got 2"),
        (changed(GOOD, "shN", "count", value=99), "shN_centroids.webp of 384"),
        (changed(GOOD, "quats", "files", 0, value="../quats.webp"), "beside the list"),
        (changed(GOOD, "quats", "files", 0, value="c:\\quats.webp"), "beside the list"),
        (changed(GOOD, "quats", "files", 0, value=""), "beside the list"),
        (changed(GOOD, "quats", "files", 0, value="other.webp"), "other.webp in the archive, got none"),
        ({**GOOD, "sh0.webp": GOOD["sh0.webp"][:-9]}, "sh0.webp, got a damaged file"),
        ({**GOOD, "sh0.webp": b"no image"}, "sh0.webp, got a damaged file"),
        ({**GOOD, "sh0.webp": TIFF.getvalue()}, "sh0.webp, got a damaged file"),
        ({**GOOD, "sh0.webp": webp(np.zeros((5, 5), np.uint8), "PNG")}, "RGB or RGBA"),
        ({**GOOD, "sh0.webp": webp(np.zeros((300, 300, 4), np.uint8))}, "got 90000 of"),
    ],
)
def test_a_bad_file_is_one_line(tmp_path: Path, files: Files, said: str) -> None:
    with pytest.raises(SplatFileError, match=said) as caught:
        read(tmp_path, files)
    assert "\n" not in str(caught.value)
    assert str(caught.value).endswith("a.sog")


def test_a_folder_that_lacks_a_file_is_one_line(tmp_path: Path) -> None:
    for name, content in GOOD.items():
        (tmp_path / name).write_bytes(content)
    (tmp_path / "scales.webp").unlink()
    with pytest.raises(SplatFileError, match=r"expected scales\.webp beside it"):
        read_splats(tmp_path)


def test_what_a_file_says_of_itself_takes_no_memory(tmp_path: Path) -> None:
    """Pictures of 64 million pixels, a list of 100 MB, and more splats than pixels."""
    image = io.BytesIO()
    Image.new("RGBA", (8000, 8000)).save(image, "WEBP", lossless=True, quality=0, method=0)
    huge = {**GOOD, "quats.webp": image.getvalue()}
    (tmp_path / "list.sog").write_bytes(
        bundled({**GOOD, "meta.json": b" " * 100_000_000}, packing=zipfile.ZIP_DEFLATED)
    )
    tracemalloc.start()
    for files in (huge, changed(GOOD, "count", value=5_000_000)):
        with pytest.raises(SplatFileError):
            read(tmp_path, files)
    with pytest.raises(SplatFileError):
        read_splats(tmp_path / "list.sog")
    _, most = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert most < 8e6


def test_damaged_files_are_read_or_refused(tmp_path: Path) -> None:
    """The archive itself, and each of its files."""
    rng = np.random.default_rng(0)
    archive = bundled(GOOD)
    refused = 0
    for case in range(1000):
        name = list(GOOD)[case % len(GOOD)]
        bent = damaged(archive, rng) if case % 3 == 0 else bundled({**GOOD, name: damaged(GOOD[name], rng)})
        (tmp_path / "a.sog").write_bytes(bent)
        refused += is_refused(read_splats, tmp_path / "a.sog")
    assert 300 < refused < 1000
