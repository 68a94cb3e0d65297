from __future__ import annotations

import copy
import json
from pathlib import Path
from typing import Any

import pytest

from renderer.camera import Camera
from renderer.camera_files import CameraFileError, NamedCamera
from renderer.view_files import Views, read_views, views_json
from tests.renderer.test_camera_path import PATH

VIEWS = Views((NamedCamera("vessel, from the left", PATH.keyframes[1].camera),), PATH, loop=True, unit="mm")


def test_what_is_written_is_read_to_the_last_bit(tmp_path: Path) -> None:
    file = tmp_path / "views.json"
    file.write_bytes(views_json(VIEWS))
    read = read_views(file)
    assert read.path == VIEWS.path
    assert (read.loop, read.unit) == (True, "mm")
    assert [(one.name, one.camera) for one in read.named] == [(one.name, one.camera) for one in VIEWS.named]
    assert views_json(read) == views_json(VIEWS)


def test_an_empty_one_is_one_too(tmp_path: Path) -> None:
    file = tmp_path / "views.json"
    file.write_bytes(views_json(Views()))
    assert read_views(file) == Views()


CAMERA = Camera(1, 1, 1, 1, 2, 2).to_json()
FAULTS: dict[str, tuple[tuple[str | int, ...], Any, str]] = {
    "another format": (("format",), "something", "format"),
    "a later version": (("version",), 2, "version 1, got 2"),
    "no views": (("views",), None, '"views"'),
    "views that are a number": (("views",), 3, "list"),
    "a view without a name": (("views", 0, "name"), None, "views[0]"),
    "a lens of 0": (("views", 0, "camera"), CAMERA | {"fx": 0}, "views[0]"),
    "a pose of one row": (("path", "keyframes", 2, "camera", "camera_from_world"), [1], "keyframes[2]"),
    "a word for a time": (("path", "keyframes", 1, "time"), "now", "keyframes[1]"),
    "a truth for a time": (("path", "keyframes", 1, "time"), True, "keyframes[1]"),
    "a time after the end": (("path", "keyframes", 1, "time"), 1.5, "keyframes[1]"),
    "seconds that run back": (("path", "keyframes", 1, "seconds"), 99, "keyframe 2"),
    "a keyframe that is none": (("path", "keyframes", 3), [], "keyframes[3]"),
    "no units": (("units",), None, "units"),
}


@pytest.mark.parametrize(("place", "value", "words"), FAULTS.values(), ids=FAULTS)
def test_a_fault_is_one_line_with_its_place_and_the_file(
    tmp_path: Path, place: tuple[str | int, ...], value: Any, words: str
) -> None:
    content = copy.deepcopy(json.loads(views_json(VIEWS)))
    inner = content
    for step in place[:-1]:
        inner = inner[step]
    inner[place[-1]] = value
    file = tmp_path / "views.json"
    file.write_text(json.dumps(content))
    with pytest.raises(CameraFileError) as caught:
        read_views(file)
    line = str(caught.value)
    assert words in line
    assert "expected" in line or "must" in line or "needs" in line
    assert str(file) in line
    assert "\n" not in line


@pytest.mark.parametrize("text", ["", "[", "3", "[" * 100_000, '"a"', '{"format": NaN}'])
def test_what_is_no_such_file_is_refused(tmp_path: Path, text: str) -> None:
    file = tmp_path / "views.json"
    file.write_text(text)
    with pytest.raises(CameraFileError, match=r"expected.*views\.json"):
        read_views(file)
    with pytest.raises(CameraFileError, match="nothing"):
        read_views(tmp_path / "nothing.json")
