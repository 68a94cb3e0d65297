"""Structure from motion: cameras and sparse points agree with each other, and on real pictures with these."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
import pytest
from PIL import Image

from renderer.camera import Camera
from renderer.clip import ByteImage, Clip
from renderer.sources import open_clip
from tests.renderer.small_clip import COUNT, LENS, points_of, read_all, refusal, small_frames

SINUS = Path(__file__).resolve().parents[3] / "../shared/data/clips/sinus_moving_camera"
FIRST = 4584
STEP = 0.02  # rad from frame to frame


def pose_text(number: int, camera: Camera) -> str:
    angle = -STEP * number / 2  # World from camera turns the y axis back.
    quaternion = {"x": 0.0, "y": 3 * np.sin(angle), "z": 0.0, "w": 3 * np.cos(angle)}
    lines = [f"  poses[{number}]: ", "    position: "]
    lines += [f"      {axis}: {value}" for axis, value in zip("xyz", camera.position, strict=True)]
    return "\n".join([*lines, "    orientation: ", *(f"      {axis}: {q}" for axis, q in quaternion.items())])


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return write_structure_from_motion(tmp_path / "sequence")


def write_structure_from_motion(path: Path) -> Path:
    path.mkdir()
    frames = small_frames(angle=STEP)
    for frame in frames:
        Image.fromarray(frame.image).save(path / f"{FIRST + frame.index:08d}.png")
    poses = [pose_text(frame.index, frame.camera) for frame in frames]
    (path / "motion.yaml").write_text("\n".join(["header: ", "  seq: 0", "poses[]:", *poses]))
    lens = (LENS.fx, LENS.fy, LENS.cx - 0.5, LENS.cy - 0.5)
    (path / "camera_intrinsics_per_view").write_text("".join(f"{number}\n" for number in lens))
    numbers = "".join(f"{FIRST + frame.index}\n" for frame in frames)
    (path / "visible_view_indexes").write_text(numbers)
    mask = np.zeros((LENS.height, LENS.width), dtype=np.uint8)
    mask[4:44, 6:58] = 250
    Image.fromarray(mask).save(path / "undistorted_mask.bmp")
    points = points_of(frames[0])[::50]
    head = f"ply\nformat ascii 1.0\nelement vertex {len(points)}\n"
    head += "".join(f"property double {axis}\n" for axis in "xyz") + "end_header\n"
    (path / "structure.ply").write_text(head + "".join(f"{x!r} {y!r} {z!r}\n" for x, y, z in points.tolist()))
    return path


def test_cameras_points_and_mask_come_back(folder):
    clip = open_clip(folder)
    truth = small_frames(angle=STEP)
    assert (len(clip), clip.format, clip.unit) == (COUNT, "structure-from-motion", "scene units")
    assert not clip.has_depth
    assert not clip.camera_is_fixed
    assert clip.points is not None
    np.testing.assert_array_equal(clip.points.positions, points_of(truth[0])[::50])
    for frame, wanted in zip(read_all(folder), truth, strict=True):
        np.testing.assert_array_equal(frame.image, wanted.image)
        assert frame.tissue_mask.sum() == 40 * 52
        assert frame.tissue_mask[4:44, 6:58].all()
        np.testing.assert_allclose(frame.camera.camera_from_world, wanted.camera.camera_from_world, atol=1e-9)
        lens = (frame.camera.fx, frame.camera.fy, frame.camera.cx, frame.camera.cy)
        assert lens == (LENS.fx, LENS.fy, LENS.cx, LENS.cy)
    places, depth = clip.cameras[0].project(clip.points.positions)
    columns, rows = np.floor(places).astype(int).T
    np.testing.assert_allclose(depth, truth[0].depth[rows, columns])


def test_points_stay_with_a_clip_of_fewer_frames(folder):
    clip = open_clip(folder).every(3)
    assert clip.labels == tuple(f"{FIRST + index:08d}.png" for index in (0, 3, 6, 9))
    assert clip.points is not None


def test_views_without_a_pose_are_left_out_and_said(folder):
    Image.new("RGB", (LENS.width, LENS.height)).save(folder / "00009999.png")
    clip = open_clip(folder)
    assert len(clip) == COUNT
    assert "00009999.png" in "".join(clip.notices)


def test_every_view_may_have_its_own_intrinsics(folder):
    rows = [[50 + index, 51 + index, 30, 20] for index in range(COUNT)]
    np.savetxt(folder / "camera_intrinsics_per_view", np.ravel(rows))
    assert [camera.fx for camera in open_clip(folder).cameras] == [50 + index for index in range(COUNT)]


def test_three_numbers_are_one_focal_length_and_the_principal_point(folder):
    whole = [camera.intrinsics for camera in open_clip(folder).cameras]
    for rows in ([55, LENS.cx - 0.5, LENS.cy - 0.5], COUNT * [[55, LENS.cx - 0.5, LENS.cy - 0.5]]):
        np.savetxt(folder / "camera_intrinsics_per_view", np.ravel(rows))
        np.testing.assert_array_equal([camera.intrinsics for camera in open_clip(folder).cameras], whole)
        np.savetxt(folder / "camera_intrinsics_per_view", np.atleast_2d(rows))
        np.testing.assert_array_equal([camera.intrinsics for camera in open_clip(folder).cameras], whole)
    (folder / "camera_intrinsics_per_view").write_text("0 32 24\n")
    assert "above 0" in refusal(folder)


def test_without_a_mask_every_pixel_is_tissue(folder):
    (folder / "undistorted_mask.bmp").unlink()
    clip = open_clip(folder)
    assert clip.read_frame(0).tissue_mask.all()
    assert "undistorted_mask" in "".join(clip.notices)


def test_a_mask_beside_the_light_gives_way_to_it(folder):
    """A round field of view; its mask is kept where it lies there, narrower or not, but not displaced."""
    rows, columns = np.mgrid[: LENS.height, : LENS.width]
    lit = (columns - 36) ** 2 + (rows - 26) ** 2 < 18**2
    for path in folder.glob("0*.png"):
        image = np.maximum(np.asarray(Image.open(path)), 60)
        image[~lit] = 7
        Image.fromarray(image).save(path)

    def opened(across: int, down: int, radius: int) -> Clip:
        mask = (columns - 36 - across) ** 2 + (rows - 26 - down) ** 2 < radius**2
        Image.fromarray(mask.astype(np.uint8) * 255).save(folder / "undistorted_mask.bmp")
        return open_clip(folder)

    for radius in (14, 18, 21):
        clip = opened(0, 0, radius)
        assert not [said for said in clip.notices if "match the images" in said]
        assert clip.read_frame(0).tissue_mask.sum() == pytest.approx(np.pi * radius**2, rel=0.03)
    clip = opened(-9, -5, 18)
    assert "undistorted_mask.bmp does not match the images" in "".join(clip.notices)
    seen = clip.read_frame(0).tissue_mask
    assert not (seen & ~lit).any()
    assert seen[(columns - 36) ** 2 + (rows - 26) ** 2 < (18 - 1.5 - LENS.width / 120) ** 2].all()


def test_what_does_not_agree_is_refused(folder, tmp_path):
    def rewrite(name: str, old: str, new: str) -> Callable[[Path], object]:
        return lambda path: (path / name).write_text((path / name).read_text().replace(old, new))

    x_of_pose_2 = small_frames(angle=STEP)[2].camera.position[0]
    broken: dict[str, Callable[[Path], object]] = {
        "got none of 4587": lambda path: (path / "00004587.png").unlink(),
        "structure.ply": lambda path: (path / "structure.ply").unlink(),
        "visible_view_indexes": lambda path: (path / "visible_view_indexes").unlink(),
        "poses 0 to 9": rewrite("motion.yaml", "poses[3]:", "poses[33]:"),
        "pose 2": rewrite("motion.yaml", f"x: {x_of_pose_2}", "x: 1e999"),
        "fx, fy, cx, cy": lambda path: (path / "camera_intrinsics_per_view").write_text("1\n2\n3\n4\n5\n"),
        "as many numbers": rewrite("camera_intrinsics_per_view", "55.0", "wide"),
        "each once": rewrite("visible_view_indexes", "4585", "4584"),
        "64x48": lambda path: Image.new("L", (9, 9)).save(path / "undistorted_mask.bmp"),
    }
    for number, (said, damage) in enumerate(broken.items()):
        copy = tmp_path / f"copy{number}"
        shutil.copytree(folder, copy)
        damage(copy)
        assert said in refusal(copy)


def agreement(one: ByteImage, places: np.ndarray, other: ByteImage, others: np.ndarray) -> float:
    """Median correlation of 15x15 patches at `places` of one picture with those at `others` of another."""
    patches = []
    for image, centres in ((one, places), (other, others)):
        grey = cv2.cvtColor(image, cv2.COLOR_RGB2GRAY).astype(np.float32)
        found = [cv2.getRectSubPix(grey, (15, 15), (float(x) - 0.5, float(y) - 0.5)) for x, y in centres]
        flat = np.stack(found).reshape(len(found), -1)
        flat -= flat.mean(axis=1, keepdims=True)
        patches.append(flat / np.maximum(np.linalg.norm(flat, axis=1, keepdims=True), 1e-6))
    return float(np.median((patches[0] * patches[1]).sum(axis=1)))


def visible_points(clip: Clip, points: np.ndarray) -> list[np.ndarray]:
    """Which points each frame was used to triangulate, by view_indexes_per_point."""
    found = np.zeros((len(clip), len(points)), dtype=bool)
    point = -1
    for word in (SINUS / "view_indexes_per_point").read_text().split():
        if word == "-1":
            point += 1
        else:
            found[int(word) - FIRST, point] = True
    return list(found)


@pytest.mark.data
@pytest.mark.skipif(not SINUS.is_dir(), reason="the sinus clip is not there")
def test_the_sinus_clip():
    clip = open_clip(SINUS)
    assert (len(clip), clip.size, clip.format) == (35, (1920, 1080), "structure-from-motion")
    assert clip.points is not None
    points = clip.points.positions
    visible = visible_points(clip, points)
    frame = clip.read_frame(0)
    mask = frame.tissue_mask
    assert 0.3 < mask.mean() < 0.5
    # The mask in the folder lies 130 px beside the pictures.
    assert "does not match the images" in "".join(clip.notices)
    assert np.mean(frame.image.max(axis=2)[mask] > 30) > 0.98
    inside, right, wrong = [], [], []
    for index in range(0, 30, 6):
        seen = points[visible[index]]
        places, depth = clip.cameras[index].project(seen)
        assert (depth > 0).all()
        columns, rows = np.floor(places).astype(int).T
        fits = (columns >= 0) & (columns < 1920) & (rows >= 0) & (rows < 1080)
        inside.append(np.mean(fits & mask[rows.clip(0, 1079), columns.clip(0, 1919)]))
        one, other = clip.read_image(index), clip.read_image(index + 5)
        right.append(agreement(one, places, other, clip.cameras[index + 5].project(seen)[0]))
        elsewhere = clip.cameras[(index + 20) % 35].project(seen)[0]
        wrong.append(agreement(one, places, other, elsewhere))
    assert np.mean(inside) > 0.9  # The mask covers 0.39 of the picture.
    assert np.mean(right) > 0.45 > 0.3 > np.mean(wrong)
