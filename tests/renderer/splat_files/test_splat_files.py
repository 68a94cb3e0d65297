from __future__ import annotations

import gzip
import struct
import tracemalloc
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from renderer.harmonics import seen_colors
from renderer.ply_elements import read_ply
from renderer.raw_gaussians import RawGaussians, sigmoid
from renderer.splat_files import SplatFile, SplatFileError, inria_ply, read_splats
from renderer.splat_files.y_up import FLIPS
from renderer.splats import RenderMode
from tests.renderer.splat_files.files import (
    NAMES,
    damaged,
    gaussians,
    is_refused,
    packed_ply,
    ply,
    spz,
    word,
    zipped,
)

DATA = Path(__file__).resolve().parents[4] / "shared/data/ply"
DC = 0.28209479


def read(folder: Path, content: bytes, name: str = "a.ply") -> SplatFile:
    path = folder / name
    path.write_bytes(content)
    return read_splats(path)


def fields_of(raw: RawGaussians) -> dict[str, NDArray[np.float32]]:
    values = np.column_stack(
        [raw.means, (raw.colors - 0.5) / DC, raw.opacity_logits, raw.log_scales, raw.quats]
    )
    return dict(zip(NAMES, values.T, strict=True))


def same(one: RawGaussians, other: RawGaussians, colors: float = 3e-7) -> None:
    for name, value in one.arrays().items():
        if name == "colors":
            assert np.allclose(value, other.colors, atol=colors, rtol=0)
        else:
            assert np.array_equal(value, other.arrays()[name]), name


@settings(max_examples=30, deadline=None)
@given(
    st.integers(0, 40),
    st.sampled_from([0, 3, 8, 15]),
    st.sampled_from(["default", "mip"]),
    st.integers(0, 99),
)
def test_what_is_written_comes_back(
    tmp_path_factory: pytest.TempPathFactory, count: int, bands: int, mode: RenderMode, seed: int
) -> None:
    raw = gaussians(count, bands, seed)
    content = inria_ply.ply_bytes(raw, mode, ["made by\na test"])
    back = read(tmp_path_factory.mktemp("ply"), content)
    same(raw, back.raw)
    assert (back.mode, back.notices) == (mode, ())
    again = inria_ply.ply_bytes(back.raw, mode, ["made by\na test"])
    same(back.raw, read(tmp_path_factory.mktemp("ply"), again).raw)


@pytest.mark.parametrize("order", ["<", ">", "="])
@pytest.mark.parametrize("kind", ["f4", "f8"])
def test_fields_come_in_any_order_and_type_among_others(tmp_path: Path, order: str, kind: str) -> None:
    raw = gaussians(20)
    fields = fields_of(raw) | {"nx": np.zeros(20), "confidence": np.ones(20)}
    names = np.random.default_rng(1).permutation(list(fields))
    shuffled = {str(name): fields[str(name)] for name in names}
    same(raw, read(tmp_path, ply(shuffled, order, kind)).raw, colors=1e-6)


def test_harmonics_are_all_of_red_first(tmp_path: Path) -> None:
    rest = {f"f_rest_{place}": np.full(2, float(place)) for place in range(24)}
    harmonics = read(tmp_path, ply(fields_of(gaussians(2)) | rest)).raw.harmonics
    assert np.array_equal(harmonics[1, :, 0], np.arange(8))
    assert np.array_equal(harmonics[0, :, 2], np.arange(16, 24))


def test_of_degree_4_three_are_read_and_it_is_said(tmp_path: Path) -> None:
    rest = {f"f_rest_{place}": np.full(2, float(place)) for place in range(72)}
    got = read(tmp_path, ply(fields_of(gaussians(2)) | rest))
    assert np.array_equal(got.raw.harmonics[1], np.add.outer(range(15), (0, 24, 48)))
    assert got.notices == ("colours by direction are read to degree 3 of 4",)


def test_packed_splats_lie_within_their_chunks(tmp_path: Path) -> None:
    """Shares of the bounds, by words packed here; the second chunk has bounds of its own."""
    low = [-1.0, -2.0, -3.0, 4.0, 5.0, 6.0, -5.0, -5.0, -5.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0]
    high = [*np.add(low, 10.0)[:12], 0.5, 0.5, 0.5, 0.7, 0.7, 0.7]
    first = (
        word((0, 1, 0.25), (11, 10, 11)),
        0,
        word((1, 0, 0.5), (11, 10, 11)),
        word((0, 1, 0.2, 0.8), (8,) * 4),
    )
    last = (word((1, 1, 1), (11, 10, 11)), 0, 0, word((0, 0, 0, 1), (8,) * 4))
    raw = read(tmp_path, packed_ply([first] * 256 + [last], low + high)).raw
    assert len(raw) == 257
    assert np.allclose(raw.means[0], (-1, 5, -3 + 9 / 4), atol=9 / 2047)
    assert np.allclose(raw.log_scales[0], (1, -5, -2), atol=6 / 1023)
    assert np.allclose(raw.colors[0], (0, 1, 0.2))
    assert sigmoid(raw.opacity_logits)[0] == pytest.approx(0.8)
    assert np.allclose(raw.means[256], (14, 15, 16))
    assert np.allclose(raw.colors[256], 0.5)
    assert sigmoid(raw.opacity_logits)[256] == 1


@pytest.mark.parametrize("largest", range(4))
def test_packed_rotations_leave_the_largest_part_out(tmp_path: Path, largest: int) -> None:
    quat = np.insert(np.array([0.1, -0.3, 0.5]), largest, 0.8)
    quat /= np.linalg.norm(quat)
    shares = np.delete(quat, largest) / np.sqrt(2) + 0.5
    packed = largest << 30 | word(shares, (10, 10, 10))
    raw = read(tmp_path, packed_ply([(0, packed, 0, 0)], [0.0] * 18)).raw
    assert np.allclose(raw.quats[0], quat, atol=2e-3)


def test_packed_harmonics_span_8(tmp_path: Path) -> None:
    sh = bytes([0, 255, 128, 127, 64, 192, 1, 254, 100])
    raw = read(tmp_path, packed_ply([(0, 0, 0, 0)], [0.0] * 18, sh)).raw
    assert raw.harmonics.shape == (1, 3, 3)
    flat = raw.harmonics[0].T.ravel()
    assert (flat[0], flat[1]) == (-4, 4)
    assert np.allclose(flat, np.array(list(sh)) / 255 * 8 - 4, atol=8 / 255)


def test_records_of_32_bytes(tmp_path: Path) -> None:
    record = struct.pack("<6f8B", 1, 2, 3, 0.5, 0.25, 2, 255, 0, 51, 204, 192, 64, 128, 128)
    raw = read(tmp_path, record * 2, "a.splat").raw
    assert np.array_equal(raw.means, [[1, 2, 3]] * 2)
    assert np.allclose(np.exp(raw.log_scales[0]), (0.5, 0.25, 2))
    assert np.allclose(raw.colors[1], (1, 0, 0.2))
    assert sigmoid(raw.opacity_logits)[0] == pytest.approx(0.8)
    assert np.array_equal(raw.quats[0], (0.5, -0.5, 0, 0))


def test_zipped_splats_of_every_version(tmp_path: Path) -> None:
    """Right, up, back become right, down, forward."""
    fixed = np.array([1.5, -2.25, 3.0])
    whole = b"".join(int(value * 4096).to_bytes(3, "little", signed=True) for value in fixed)
    rest = [bytes([204]), bytes([128, 204, 51]), bytes([160, 176, 144])]
    half = 0.5
    third = 3 << 30 | round(half / np.sqrt(0.5) * 511) << 20  # x of x, y, z; w is left out
    turns = {1: bytes([191, 128, 128]), 2: bytes([191, 128, 128]), 3: struct.pack("<I", third)}
    for version, turn in turns.items():
        positions = fixed.astype("<f2").tobytes() if version == 1 else whole
        got = read(tmp_path, spz(version, 0, [positions, *rest, turn], count=1, flags=version == 3))
        assert got.mode == ("mip" if version == 3 else "default")
        assert np.array_equal(got.raw.means, [[1.5, 2.25, -3.0]])
        assert sigmoid(got.raw.opacity_logits)[0] == pytest.approx(0.8)
        assert np.allclose(
            got.raw.colors[0], 0.5 + DC * (np.array([128, 204, 51]) / 255 - 0.5) / 0.15, atol=1e-6
        )
        assert np.array_equal(got.raw.log_scales, [[0, 1, -1]])
        assert np.allclose(got.raw.quats[0], (np.sqrt(0.75), 0.5, 0, 0), atol=0.01)


def test_zipped_rotations_turn_their_axes_too(tmp_path: Path) -> None:
    """About y and z the other way round; the largest may be any of x, y, z, w."""
    quat = np.array([0.2, 0.7, -0.4, 0.5])  # w x y z
    quat /= np.linalg.norm(quat)
    bits = 0  # What is left of x y z w without x: y z w, the last lowest.
    for value in (quat[2], quat[3], quat[0]):
        bits = bits << 10 | (value < 0) << 9 | round(abs(value) / np.sqrt(0.5) * 511)
    turn = struct.pack("<I", 0 << 30 | bits)
    planes = [bytes(9), bytes([128]), bytes(3), bytes([160] * 3), turn]
    got = read(tmp_path, spz(3, 0, planes, count=1)).raw.quats[0]
    assert np.allclose(got, quat * (1, 1, -1, -1), atol=3e-3)


def test_harmonics_look_the_same_from_the_turned_side() -> None:
    raw = gaussians(30, 15)
    flip = np.array([1, -1, -1], np.float32)
    center = np.array([3.0, -20.0, 40.0])
    seen = seen_colors(raw.means, raw.harmonics, raw.colors, center)
    turned = seen_colors(flip * raw.means, FLIPS[:, None] * raw.harmonics, raw.colors, flip * center)
    assert np.allclose(seen, turned, atol=1e-5)


def test_zipped_harmonics_are_bytes_about_128(tmp_path: Path) -> None:
    planes = [
        bytes(9),
        bytes([128]),
        bytes(3),
        bytes([160] * 3),
        struct.pack("<I", 3 << 30),
        bytes(range(100, 109)),
    ]
    harmonics = read(tmp_path, spz(3, 1, planes, count=1)).raw.harmonics
    expected = (np.arange(100, 109).reshape(3, 3) - 128) / 128 * np.array([-1, -1, 1])[:, None]
    assert np.allclose(harmonics[0], expected)


def test_rows_that_cannot_be_drawn_are_left_out_and_said(tmp_path: Path) -> None:
    raw = gaussians(6, 3)
    raw.means[1, 2] = np.nan
    raw.log_scales[2, 0] = 200.0
    raw.harmonics[3, 0, 0] = np.inf
    raw.quats[4] = 0
    raw.opacity_logits[5] = np.inf
    got = read(tmp_path, inria_ply.ply_bytes(raw))
    assert len(got.raw) == 3
    assert "3 of 6" in got.notices[0]
    assert "1 of 6" in got.notices[1]
    assert np.array_equal(got.raw.quats[1], (1, 0, 0, 0))
    assert got.raw.splats().opacities[2] == 1
    assert all(np.isfinite(value).all() for value in got.raw.arrays().values())


GOOD = inria_ply.ply_bytes(gaussians(3, 3))
PACKED = packed_ply([(1, 2, 3, 4)] * 3, [0.0] * 18, bytes(27))
ZIPPED = spz(2, 1, [bytes(9), bytes(1), bytes(3), bytes(3), bytes(3), bytes(9)], count=1)


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (b"", "an empty file"),
        (b"solid stl", "another kind"),
        (b"ply", "without its header"),
        (GOOD[:200], "without its header"),
        (GOOD.replace(b"element", b"comment " + bytes(1 << 20) + b"\nelement"), "in its first 1048576 bytes"),
        (GOOD[:-5], "cut off"),
        (GOOD.replace(b"vertex 3", b"vertex 99999999999999"), "cut off"),
        (GOOD.replace(b"vertex 3", b"vertex -3"), "its number"),
        (GOOD.replace(b"vertex", b"edge"), "expected vertices"),
        (GOOD.replace(b"f_dc_1", b"f_dd_1"), "f_dc_1"),
        (GOOD.replace(b"f_rest_8", b"f_rest_9"), "f_rest_0 and on"),
        (GOOD.replace(b"float rot_3", b"list uchar float rot_3"), "expected vertices"),
        (
            GOOD.replace(b"element", b"element a 0\nproperty list uchar int i\nelement", 1),
            "vertices of numbers before any element with lists, got none",
        ),
        (PACKED.replace(b"min_x", b"min_u"), "min_x"),
        (PACKED.replace(b"packed_scale", b"packet_scale"), "packed_scale"),
        (packed_ply([(1, 2, 3, 4)] * 257, [0.0] * 18), "a chunk for each 256"),
        (ZIPPED[:-12], "cut off"),
        (gzip.compress(b"NGSP" + bytes(3), mtime=0), "cut off"),
        (spz(9, 0, [], count=0), "version"),
        (spz(2, 0, [bytes(19)], count=4_000_000_000), "10000000"),
        (spz(2, 7, [bytes(19)], count=1), "degree"),
        (b"\x1f\x8bnonsense", "damaged"),
        (gzip.compress(GOOD, mtime=0), "an uncompressed PLY file, got a gzip file: unzip it"),
        (gzip.compress(bytes(99), mtime=0), "another gzip file"),
        (zipped("scene/point_cloud.ply"), "a zip archive: unpack it first and open point_cloud.ply"),
        (zipped("readme.txt"), "a zip archive: unpack it first"),
        (
            zipped("meta.json", "means_l.webp"),
            "a SOG of version 2, got 1: convert it to .ply with SuperSplat",
        ),
        (b"PK\x03\x04 and so on", "a damaged zip archive"),
        (
            b"NGSP" + struct.pack("<IIBBBBI", 5, 9, 3, 12, 0, 6, 32) + bytes(64),
            "version 5: convert it to .ply",
        ),
        (b"\x89PNG\r\n\x1a\n" + bytes(88), "a PNG image"),
        (b"\xff\xd8\xff\xe0" + bytes(92), "a JPEG image"),
        (b"RIFF\0\0\0\0WEBP" + bytes(84), "a WebP image"),
        (b"version https://git-lfs.github.com/spec/v1\n", "a Git LFS pointer"),
        (b"<!DOCTYPE html>", "a web page"),
    ],
)
def test_a_bad_file_is_one_line(tmp_path: Path, content: bytes, said: str) -> None:
    with pytest.raises(SplatFileError, match=said) as caught:
        read(tmp_path, content)
    assert "\n" not in str(caught.value)
    assert str(caught.value).endswith("a.ply")


@pytest.mark.parametrize("content", [GOOD, PACKED, ply(fields_of(gaussians(3)), "=")])
def test_what_comes_after_the_last_splat_is_told(tmp_path: Path, content: bytes) -> None:
    assert read(tmp_path, content + (b"\n" if b"ascii" in content else b"")).notices == ()
    got = read(tmp_path, content + b"\n9 9")
    count = 3 if b"ascii" in content else 4
    assert got.notices == (f"{count} bytes after the last of 3 splats are ignored",)
    assert len(got.raw) == 3
    with pytest.raises(SplatFileError, match="cut off"):
        read(tmp_path, content[:-40])


def test_the_line_that_ends_a_header_may_end_in_blanks(tmp_path: Path) -> None:
    assert len(read(tmp_path, GOOD.replace(b"end_header", b"end_header \t")).raw) == len(
        read(tmp_path, GOOD).raw
    )


def test_a_header_may_be_long_and_its_lines_end_as_on_windows(tmp_path: Path) -> None:
    long = GOOD.replace(b"element", b"comment " + b"x" * 500_000 + b"\nelement")
    same(read(tmp_path, GOOD).raw, read(tmp_path, long).raw)
    text = ply(fields_of(gaussians(3)), "=")
    same(read(tmp_path, text).raw, read(tmp_path, text.replace(b"\n", b"\r\n") + b"\r\n\r\n").raw)


@pytest.mark.parametrize("bands", [0, 3, 8, 15])
@pytest.mark.parametrize("degree", [0, 1, 2, 3])
def test_a_degree_fills_up_with_zeros_and_loses_no_colour(bands: int, degree: int) -> None:
    raw, wanted = gaussians(7, bands), [0, 3, 8, 15][degree]
    if wanted < bands:
        with pytest.raises(ValueError, match=f"degree {[0, 3, 8, 15].index(bands)}"):
            raw.of_degree(degree)
        raw.harmonics[:, wanted:] = 0
    got = raw.of_degree(degree)
    fields = read_ply(inria_ply.ply_bytes(got)).elements[0].fields
    assert [name for name in fields if "f_rest" in name] == [f"f_rest_{place}" for place in range(3 * wanted)]
    least = min(bands, wanted)
    assert np.array_equal(got.harmonics[:, :least], raw.harmonics[:, :least])
    assert not got.harmonics[:, least:].any()


def test_a_folder_or_nothing_is_one_line(tmp_path: Path) -> None:
    for path in (tmp_path, tmp_path / "none.ply"):
        with pytest.raises(SplatFileError, match="expected a splat file"):
            read_splats(path)
    with pytest.raises(SplatFileError, match="32 bytes"):
        read(tmp_path, bytes(33), "a.splat")


def test_what_a_file_says_of_itself_takes_no_memory(tmp_path: Path) -> None:
    """Headers that ask for gigabytes, and a few bytes that unzip to 200 MB."""
    bomb = gzip.compress(struct.pack("<IIIBBBB", 0x5053474E, 2, 1, 0, 12, 0, 0) + bytes(200_000_000), 1)
    lies = GOOD.replace(b"vertex 3", b"vertex 999999999999")
    text = ply(fields_of(gaussians(2)), "=").replace(b"vertex 2", b"vertex 999999999999")
    tracemalloc.start()
    for content in (bomb, lies, text):
        try:
            read(tmp_path, content)
        except SplatFileError:
            continue
    _, most = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert most < 5e6


def test_damaged_files_are_read_or_refused(tmp_path: Path) -> None:
    """10,000 of them: bytes changed, cut out or doubled, most of them in the header."""
    rng = np.random.default_rng(0)
    text = ply(fields_of(gaussians(3)), "=")
    kinds = [(GOOD, "a.ply"), (text, "a.ply"), (PACKED, "a.ply"), (ZIPPED, "a.ply"), (bytes(96), "a.splat")]
    unzipped = gzip.decompress(ZIPPED)
    refused = 0
    for case in range(10_000):
        content, name = kinds[case % len(kinds)]
        bent = damaged(unzipped if content is ZIPPED and case % 2 else content, rng)
        if content is ZIPPED and case % 2:
            bent = gzip.compress(bent, 1)
        refused += is_refused(read, tmp_path, bent, name)
    assert 1000 < refused < 9900


@pytest.mark.data
@pytest.mark.skipif(not DATA.is_dir(), reason="no shared data")
@pytest.mark.parametrize(
    ("name", "count", "bands"),
    [
        ("guitar.compressed.ply", 90854, 0),
        ("minimal-v3.spz", 4, 0),
        ("minimal.splat", 4, 0),
        ("minimal_ascii.ply", 3, 0),
        ("minimal_binary.ply", 3, 0),
        ("playcanvas-chunked.ply", 64, 15),
        ("splatapult-16.ply", 16, 15),
        ("train-1000.ply", 1000, 15),
    ],
)
def test_files_of_other_programs_open(name: str, count: int, bands: int) -> None:
    got = read_splats(DATA / name)
    assert (len(got.raw), got.raw.harmonics.shape[1], got.notices) == (count, bands, ())


@pytest.mark.data
@pytest.mark.skipif(not DATA.is_dir(), reason="no shared data")
def test_the_same_splats_in_two_formats_agree() -> None:
    one, other = (read_splats(DATA / name).raw for name in ("minimal_ascii.ply", "minimal_binary.ply"))
    same(one, other)
    one, other = (read_splats(DATA / name).raw for name in ("minimal.splat", "minimal-v3.spz"))
    assert np.array_equal(one.means, other.means)
    assert np.allclose(one.colors, other.colors, atol=2e-3)
    assert np.allclose(one.log_scales, other.log_scales, atol=1 / 32)
    assert np.array_equal(one.opacity_logits, other.opacity_logits)


def test_what_was_read_can_be_drawn(tmp_path: Path) -> None:
    raw = replace(gaussians(5), quats=np.zeros((5, 4), np.float32))
    splats = read(tmp_path, inria_ply.ply_bytes(raw)).raw.splats()
    assert len(splats) == 5
