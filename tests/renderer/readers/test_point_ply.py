"""Points of PLY files: ascii and binary say the same, and what is none is refused in one line."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from renderer.clip import ClipError
from renderer.readers.geometry.point_ply import read_points

POINTS = np.array([[0.5, -2.0, 3.25], [1e3, 0.0, -0.125], [7.0, 8.0, 9.0]])
COLORS = np.array([[255, 0, 7], [1, 2, 3], [0, 128, 64]], dtype=np.uint8)
REAL = Path(__file__).resolve().parents[3] / "../shared/data/clips/sinus_moving_camera/structure.ply"


def header(layout: str, colors: str = "uchar", count: int = 3) -> bytes:
    properties = [f"property float {name}" for name in "xyz"] + ["property double confidence"]
    properties += [f"property {colors} {name}" for name in ("red", "green", "blue")]
    start = ["ply", f"format {layout} 1.0", "comment of no weight", f"element vertex {count}"]
    rest = ["element face 1", "property list uchar int vertex_indices", "end_header", ""]
    return "\n".join([*start, *properties, *rest]).encode()


def rows(order: str, colors: str = "u1") -> bytes:
    kind = [(name, f"{order}f4") for name in "xyz"] + [("confidence", f"{order}f8")]
    table = np.zeros(3, dtype=kind + [(name, f"{order}{colors}") for name in ("red", "green", "blue")])
    for place, name in enumerate("xyz"):
        table[name] = POINTS[:, place]
    for place, name in enumerate(("red", "green", "blue")):
        table[name] = COLORS[:, place]
    return table.tobytes() + b"\3\0\0\0\0\0\0\0\0\0\0\0\0"


def ascii_rows() -> bytes:
    lines = [" ".join(map(str, [*point, 0.5, *color])) for point, color in zip(POINTS, COLORS, strict=True)]
    return "\n".join([*lines, "3 0 1 2", ""]).encode()


CONTENTS = {
    "ascii": header("ascii") + ascii_rows(),
    "little": header("binary_little_endian") + rows("<"),
    "big": header("binary_big_endian") + rows(">"),
    "windows": header("ascii").replace(b"\n", b"\r\n") + ascii_rows().replace(b"\n", b"\r\n"),
}


@pytest.mark.parametrize("kind", CONTENTS)
def test_every_layout_says_the_same(tmp_path, kind):
    path = tmp_path / "points.ply"
    path.write_bytes(CONTENTS[kind])
    read = read_points(path)
    np.testing.assert_array_equal(read.positions, POINTS)
    np.testing.assert_array_equal(read.colors, COLORS)


@pytest.mark.parametrize("kind", CONTENTS)
def test_what_follows_the_vertices_may_be_anything(tmp_path, kind):
    path = tmp_path / "points.ply"
    for after in (b"property uchar flag", b"property odd flag", b"of nothing"):
        content = CONTENTS[kind].replace(b"property list uchar int vertex_indices", after)
        path.write_bytes(content.replace(b"element face 1", b"element face 99"))
        np.testing.assert_array_equal(read_points(path).positions, POINTS)


def test_points_that_are_not_finite_are_dropped_with_their_colours(tmp_path):
    path = tmp_path / "points.ply"
    path.write_bytes(CONTENTS["ascii"].replace(b"1000.0", b"nan"))
    read = read_points(path)
    np.testing.assert_array_equal(read.positions, POINTS[[0, 2]])
    np.testing.assert_array_equal(read.colors, COLORS[[0, 2]])


def test_colours_of_another_type_are_not_taken_for_bytes(tmp_path):
    path = tmp_path / "points.ply"
    path.write_bytes(header("binary_little_endian", "float") + rows("<", "f4"))
    read = read_points(path)
    np.testing.assert_array_equal(read.positions, POINTS)
    assert read.colors is None


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (b"", "without its header"),
        (b"solid stl", "without its header"),
        (CONTENTS["ascii"][:90], "without its header"),
        (CONTENTS["ascii"].replace(b"format ascii", b"format morse"), "morse"),
        (CONTENTS["ascii"].replace(b"vertex 3", b"vertex many"), "vertex many"),
        (CONTENTS["ascii"].replace(b"element vertex 3", b"element edge 3"), "got edge"),
        (CONTENTS["ascii"].replace(b"float x", b"float u"), "x, y and z"),
        (CONTENTS["ascii"].replace(b"float x", b"list uchar float x"), "of plain numbers"),
        (CONTENTS["ascii"].replace(b"vertex 3", b"vertex 9"), "expected 9 rows"),
        (CONTENTS["ascii"].replace(b"3.25", b"east"), "expected numbers"),
        (CONTENTS["little"][:-60], "cut off"),
    ],
)
def test_what_is_none_is_refused(tmp_path, content, said):
    path = tmp_path / "points.ply"
    path.write_bytes(content)
    with pytest.raises(ClipError, match=said) as caught:
        read_points(path)
    assert str(caught.value).endswith(str(path))


def test_a_missing_file_is_refused(tmp_path):
    with pytest.raises(ClipError, match=r"none\.ply"):
        read_points(tmp_path / "none.ply")


@pytest.mark.data
@pytest.mark.skipif(not REAL.is_file(), reason="the sinus clip is not there")
def test_a_file_with_more_elements():
    points = read_points(REAL)
    assert points.positions.shape == (570, 3)
    assert points.colors is None
    np.testing.assert_allclose(points.positions[0], [-0.51611453, 0.59833932, 1.7286849], rtol=1e-6)
