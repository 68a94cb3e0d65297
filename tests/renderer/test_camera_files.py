from __future__ import annotations

import json
import math
import os
import re
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from renderer.camera import Camera
from renderer.camera_files import CameraFileError, NamedCamera, off_center, read_cameras, splatting_json
from renderer.readers.geometry.poses import pose_matrix

LENS = Camera(500.0, 510.0, 320.0, 240.0, 640, 480)
POINT = np.array([[3.0, -2.0, 40.0]])


def turned(angle: float) -> Camera:
    xyzw = np.array([0.2, math.sin(angle), 0.1, math.cos(angle)])
    return LENS.moved(pose_matrix(np.array([5.0 * angle, -2.0, 1.0]), xyzw))


CAMERAS = [turned(angle) for angle in (0.0, 0.1, 0.4)]


def splatting() -> Any:
    return [
        {
            "id": place, "img_name": f"photo {place}", "width": 640, "height": 480, "fx": 500.0, "fy": 510.0,
            "position": camera.position.tolist(), "rotation": camera.world_from_camera[:3, :3].tolist(),
        }
        for place, camera in enumerate(CAMERAS)
    ]  # fmt: skip


def transforms() -> Any:
    """Cameras that look along their -z, with y up."""
    frames = []
    for place, camera in enumerate(CAMERAS):
        pose = camera.world_from_camera.copy()
        pose[:3, 1:3] *= -1
        frames.append({"file_path": f"./images/photo {place}.png", "transform_matrix": pose.tolist()})
    return {"w": 640, "h": 480, "fl_x": 500.0, "fl_y": 510.0, "frames": frames}


def write_colmap(folder: Path, model: str = "PINHOLE 640 480 500 510 320 240") -> None:
    folder.mkdir(exist_ok=True)
    (folder / "cameras.txt").write_text(f"# Camera list\n7 {model}\n")
    lines = ["# Image list"]
    for place, camera in enumerate(CAMERAS):
        angle = (0.0, 0.1, 0.4)[place]
        w, x, y, z = math.cos(angle), 0.2, math.sin(angle), 0.1
        tx, ty, tz = camera.camera_from_world[:3, 3]
        lines += [
            f"{place + 1} {w} {x} {y} {z} {tx} {ty} {tz} 7 photo {place}.png",
            "",
        ]
    (folder / "images.txt").write_text("\n".join(lines) + "\n")


def same(path: Path) -> None:
    read = read_cameras(path)
    assert [one.name for one in read] == ["photo 0", "photo 1", "photo 2"]
    for one, camera in zip(read, CAMERAS, strict=True):
        assert (one.camera.width, one.camera.height) == (640, 480)
        assert np.allclose(one.camera.project(POINT)[0], camera.project(POINT)[0])
        assert np.allclose(one.camera.position, camera.position)


@pytest.mark.parametrize("content", [splatting(), transforms()])
def test_cameras_of_other_programs_see_the_same(tmp_path: Path, content: Any) -> None:
    (tmp_path / "cameras.json").write_text(json.dumps(content))
    same(tmp_path / "cameras.json")


@settings(max_examples=50)
@given(
    st.tuples(*[st.floats(10, 5000)] * 2),
    st.tuples(*[st.floats(-100, 2000)] * 2),
    st.tuples(*[st.floats(-1, 1)] * 3),
    st.tuples(*[st.floats(-1e4, 1e4)] * 3),
)
def test_what_is_written_sees_the_same(
    tmp_path_factory: pytest.TempPathFactory,
    focal: tuple[float, float],
    center: tuple[float, float],
    turn: tuple[float, float, float],
    place: tuple[float, float, float],
) -> None:
    """With any principal point, pixels that are not square, and far from the origin."""
    lens = Camera(*focal, *center, 641, 333)
    camera = lens.moved(pose_matrix(np.array(place), np.array([*turn, 1.5])))
    path = tmp_path_factory.mktemp("cameras") / "cameras.json"
    path.write_bytes(splatting_json([NamedCamera("one", camera)]))
    (back,) = read_cameras(path)
    assert back.name == "one"
    assert back.camera.moved(np.eye(4)) == lens
    assert np.allclose(back.camera.camera_from_world, camera.camera_from_world, atol=1e-9, rtol=1e-13)


def test_a_principal_point_off_the_middle_is_told() -> None:
    middle = NamedCamera("middle", LENS)
    assert off_center([]) is None
    assert off_center([middle]) is None
    said = off_center([middle, NamedCamera("off", replace(LENS, cx=LENS.cx + 3.0, cy=LENS.cy - 4.0))])
    assert said is not None
    assert "up to 5.00 px" in said


def test_so_do_those_of_colmap(tmp_path: Path) -> None:
    write_colmap(tmp_path / "sparse")
    same(tmp_path / "sparse")


WRITES_THEM = """
import sys
from pathlib import Path
from renderer.camera_files import NamedCamera
from renderer.colmap_text import write_colmap
from tests.renderer.scenes import random_splats
from tests.renderer.test_camera_files import CAMERAS
write_colmap(Path(sys.argv[1]), [NamedCamera("M\\xfcller \\u80c3", CAMERAS[0])], random_splats(2, CAMERAS[0]))
"""


def test_names_of_any_alphabet_are_written_whatever_the_system_writes(tmp_path: Path) -> None:
    environment = os.environ | {"LC_ALL": "C", "PYTHONCOERCECLOCALE": "0", "PYTHONUTF8": "0"}
    command = [sys.executable, "-c", WRITES_THEM, str(tmp_path)]
    subprocess.run(command, env=environment, cwd=Path(__file__).parents[2], check=True)
    assert [one.name for one in read_cameras(tmp_path)] == ["M\u00fcller \u80c3"]


def test_an_angle_gives_the_focal_length(tmp_path: Path) -> None:
    content = {"camera_angle_x": math.pi / 2, "w": 200, "h": 100, "frames": transforms()["frames"][:1]}
    (tmp_path / "t.json").write_text(json.dumps(content))
    camera = read_cameras(tmp_path / "t.json")[0].camera
    assert (camera.fx, camera.fy, camera.cx, camera.cy) == pytest.approx((100, 100, 100, 50))


@pytest.mark.parametrize(
    ("lens", "focals"),
    [
        ({"camera_angle_x": 1.0, "camera_angle_y": 0.6}, (100 / math.tan(0.5), 50 / math.tan(0.3))),
        ({"fl_x": 90.0, "camera_angle_y": 0.6}, (90.0, 50 / math.tan(0.3))),
        ({"camera_angle_x": 1.0, "fl_x": 90.0, "fl_y": 80.0, "camera_angle_y": 0.6}, (90.0, 80.0)),
        ({"camera_angle_y": 0.6}, (50 / math.tan(0.3), 50 / math.tan(0.3))),
    ],
)
def test_each_axis_has_its_own_focal_length(
    tmp_path: Path, lens: dict[str, float], focals: tuple[float, float]
) -> None:
    content = lens | {"w": 200, "h": 100, "frames": transforms()["frames"][:1]}
    (tmp_path / "t.json").write_text(json.dumps(content))
    camera = read_cameras(tmp_path / "t.json")[0].camera
    assert (camera.fx, camera.fy) == pytest.approx(focals)


@pytest.mark.parametrize("model", ["OPENCV", "SIMPLE_RADIAL", "PINHOLE", "perspective", None])
def test_a_model_whose_distortion_is_0_is_a_pinhole(tmp_path: Path, model: str | None) -> None:
    (tmp_path / "t.json").write_text(json.dumps(transforms() | {"camera_model": model, "k1": 0, "k2": 0}))
    same(tmp_path / "t.json")


@pytest.mark.parametrize(
    ("lens", "said"),
    [
        ({"camera_model": "OPENCV_FISHEYE", "k1": 0, "k2": 0}, "OPENCV_FISHEYE, where PINHOLE is needed"),
        ({"camera_model": "EQUIRECTANGULAR"}, "EQUIRECTANGULAR, where PINHOLE is needed"),
        ({"camera_model": "OPENCV", "is_fisheye": True}, "fisheye, where PINHOLE is needed"),
    ],
)
def test_a_lens_that_is_no_pinhole_is_refused_also_without_distortion(
    tmp_path: Path, lens: dict[str, object], said: str
) -> None:
    (tmp_path / "t.json").write_text(json.dumps(transforms() | lens))
    with pytest.raises(CameraFileError, match=said):
        read_cameras(tmp_path / "t.json")


def test_a_pose_that_mirrors_is_refused(tmp_path: Path) -> None:
    nerf, gaussian = transforms(), splatting()
    nerf["frames"][1]["transform_matrix"] = np.diag([-1.0, 1, 1, 1]).tolist()
    gaussian[1]["rotation"] = np.diag([1.0, 1, -1]).tolist()
    own = CAMERAS[0].to_json() | {"camera_from_world": np.diag([1.0, -1, 1, 1]).tolist()}
    for content in (nerf, gaussian, own):
        (tmp_path / "t.json").write_text(json.dumps(content))
        with pytest.raises(CameraFileError, match=r"expected a rotation .*, got one that mirrors"):
            read_cameras(tmp_path / "t.json")


def test_one_camera_of_our_own(tmp_path: Path) -> None:
    (tmp_path / "view.json").write_text(json.dumps(CAMERAS[1].to_json()))
    (one,) = read_cameras(tmp_path / "view.json")
    assert (one.name, one.camera) == ("view", CAMERAS[1])


@pytest.mark.parametrize(
    "text",
    [
        "", "[]", "{}", "3", "[3]", "[{}]", '{"frames": []}', '{"frames": 3}', '{"frames": [{}]}', "nonsense",
        json.dumps([splatting()[0] | {"rotation": [[0] * 3] * 3}]), json.dumps([splatting()[0] | {"fx": -1}]),
        json.dumps([splatting()[0] | {"position": [1, 2]}]), json.dumps([splatting()[0] | {"width": "wide"}]),
        json.dumps([splatting()[0] | {"position": [1, 2, float("nan")]}]),
        json.dumps([splatting()[0] | {"width": float("inf")}]),
        json.dumps({"camera_angle_x": 0, "w": 64, "h": 48, "frames": transforms()["frames"]}),
        json.dumps(transforms() | {"k1": -0.1}), json.dumps(transforms() | {"k1": 0, "p2": 0.01}),
    ],
)  # fmt: skip
def test_what_is_none_is_one_line(tmp_path: Path, text: str) -> None:
    path = tmp_path / "cameras.json"
    path.write_text(text)
    with pytest.raises(CameraFileError) as caught:
        read_cameras(path)
    assert "\n" not in str(caught.value)
    assert str(path) in str(caught.value)


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (
            [splatting()[0] | {"width": 127.9}],
            "expected a whole number of pixels as width, got 127.9 in camera 0",
        ),
        ([splatting()[0] | {"width": "128"}], "expected a whole number of pixels as width, got '128'"),
        (CAMERAS[0].to_json() | {"height": True}, "expected a whole number of pixels as height, got True: "),
        ([splatting()[0], 3], "expected a camera or several, got 3 in camera 1: "),
        ([splatting()[0], splatting()[0] | {"fx": None}], "null as fx, where a number is needed in camera 1"),
        ([splatting()[0] | {"rotation": [[1, 0], [0]]}], "as rotation, where 3 times 3 numbers are needed"),
        ({"frames": 3}, "got 3 as frames, where a list is needed"),
        ({"frames": [3]}, "got 3 in camera 0"),
        (None, "expected a camera or several, got null: "),
        (
            {"camera_angle_x": 0, "w": 64, "h": 48, "frames": [{"file_path": "a"}]},
            "got 0 as camera_angle_x, where radians between 0 and pi are needed in camera 0",
        ),
    ],
)
def test_what_is_wrong_is_told_in_words_with_its_camera(tmp_path: Path, content: Any, said: str) -> None:
    path = tmp_path / "cameras.json"
    path.write_text(json.dumps(content))
    with pytest.raises(CameraFileError, match=re.escape(said)):
        read_cameras(path)


def test_another_text_is_told_as_such(tmp_path: Path) -> None:
    (tmp_path / "cameras.json").write_text("hello")
    with pytest.raises(CameraFileError, match=r"a camera or several, got text that is no JSON \(.*\): "):
        read_cameras(tmp_path / "cameras.json")


def test_distorted_or_missing_colmap_cameras_are_refused(tmp_path: Path) -> None:
    write_colmap(tmp_path, "OPENCV 640 480 500 510 320 240 0.1 0 0 0")
    with pytest.raises(CameraFileError, match="OPENCV"):
        read_cameras(tmp_path)
    (tmp_path / "cameras.txt").unlink()
    with pytest.raises(CameraFileError, match=r"cannot read the camera file, No such .*cameras\.txt$"):
        read_cameras(tmp_path)


def test_bytes_that_are_no_text_are_said_to_be_that(tmp_path: Path) -> None:
    path = tmp_path / "camera.json"
    path.write_bytes(b"\xff\xd8\xff\xe0")
    with pytest.raises(CameraFileError, match="expected text in UTF-8"):
        read_cameras(path)
