"""Raw pairs and images with their calibration: depth in mm as it is, and images as a flat lens shows them."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
from PIL import Image
from pydantic import TypeAdapter

from renderer import ClipError, ClipOptions, PhantomParams, open_clip
from renderer.phantom import write_phantom
from renderer.readers.image_folders.frames import is_seen_by_assumption
from renderer.readers.lenses.calibration import Calibration
from renderer.readers.lenses.calibration_files import read_calibration
from tests.renderer.raw_eyes import EYES, LEFT, RIGHT, SHIFT, SIZE, TURN, Seen, raw_pairs, write_calibration
from tests.renderer.readers.numbered import encoded

COUNT = 2


@pytest.fixture(scope="module")
def pairs() -> list[tuple[np.ndarray, np.ndarray]]:
    return raw_pairs(COUNT)


@pytest.fixture
def folder(tmp_path: Path, pairs: list[tuple[np.ndarray, np.ndarray]]) -> Path:
    for number, eye in enumerate(("left", "right")):
        (tmp_path / "clip" / eye).mkdir(parents=True)
        for at, pair in enumerate(pairs):
            Image.fromarray(pair[number]).save(tmp_path / "clip" / eye / f"{at}.png")
    return tmp_path / "clip"


def rectified_pose() -> np.ndarray:
    """Of the left eye, whose raw camera is the world."""
    lenses = LEFT.matrix, LEFT.coefficients, RIGHT.matrix, RIGHT.coefficients
    pose = np.eye(4)
    pose[:3, :3] = cv2.stereoRectify(
        *lenses, SIZE, TURN, np.array(SHIFT)[:, None], flags=cv2.CALIB_ZERO_DISPARITY, alpha=0
    )[0]
    return pose


def test_depth_of_raw_pairs_is_in_mm(folder):
    """Without the calibration it has no scale, and the surface is bent."""
    clip = open_clip(folder, ClipOptions(calibration=EYES))
    frame = clip.read_frame(1)
    truth = Seen(clip.cameras[0].moved(rectified_pose()), COUNT).view(1).frame
    known = frame.depth > 0
    assert clip.unit == "mm"
    assert known.mean() > 0.8
    assert np.median(np.abs(frame.depth - truth.depth)[known]) < 0.4
    assert np.abs(frame.image.astype(int) - truth.image).mean() < 4
    assert open_clip(folder).unit == "scene units"


def test_one_eye_is_undistorted_and_keeps_its_place(folder, pairs):
    clip = open_clip(_alone(folder), ClipOptions(calibration=Calibration(lens=LEFT)))
    truth = Seen(clip.cameras[0], COUNT).view(0).frame
    off = np.abs(clip.read_image(0).astype(int) - truth.image).mean()
    assert off < 4
    assert np.abs(pairs[0][0].astype(int) - truth.image).mean() > 2 * off
    np.testing.assert_array_equal(clip.read_frame(0).image, clip.read_image(0))
    assert clip.read_frame(0).tissue_mask.all()
    assert not is_seen_by_assumption(clip)
    assert not clip.has_depth


def test_masks_of_a_part_stay_masks(folder):
    clip = open_clip(_alone(folder), ClipOptions(calibration=EYES))
    assert clip.within(np.zeros(SIZE[::-1], bool)).read_frame(0).tissue_mask.sum() == 0


def test_options_with_a_calibration_go_to_json_and_back(folder, tmp_path):
    options = ClipOptions(calibration=write_calibration(tmp_path / "eyes.json"))
    assert options.calibration == replace(EYES) == read_calibration(tmp_path / "eyes.json")
    adapter = TypeAdapter(ClipOptions)
    assert adapter.validate_json(adapter.dump_json(options)) == options


def test_text_in_a_record_is_no_file_to_read(tmp_path):
    path = write_calibration(tmp_path / "eyes.json")
    with pytest.raises(ValueError, match="calibration"):
        TypeAdapter(ClipOptions).validate_python({"calibration": str(path)})


def _endonerf(folder: Path) -> Path:
    write_phantom(folder.parent / "endonerf", PhantomParams(n_frames=2, width=32, height=24))
    return folder.parent / "endonerf"


def _alone(folder: Path, size: tuple[int, int] = SIZE) -> Path:
    """The left images at that size, with no right ones beside them."""
    (folder.parent / "alone").mkdir()
    for path in (folder / "left").iterdir():
        Image.open(path).resize(size).save(folder.parent / "alone" / path.name)
    return folder.parent / "alone"


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (_endonerf, "without a calibration of its own"),
        (lambda folder: _alone(folder, (320, 240)), "got one of 320x256, the images are 320x240"),
        (lambda folder: _alone(folder, (640, 256)), "the images are 640x256: "),
    ],
)
def test_what_does_not_fit_is_refused_in_a_line(folder, change, said):
    path = change(folder)
    with pytest.raises(ClipError, match=said) as caught:
        open_clip(path, ClipOptions(calibration=EYES))
    assert str(caught.value).endswith(f": {path}")
    assert "\n" not in str(caught.value)


def test_squeezed_eyes_of_a_video_are_those_of_the_calibration(tmp_path, pairs):
    """As cables carry both in one image of usual shape."""
    video = encoded(tmp_path / "a.mp4", [cv2.resize(np.hstack(pair), SIZE) for pair in pairs])
    with pytest.raises(ClipError, match=r"the images are 320x512; if a frame holds both eyes: .* top-bottom"):
        open_clip(
            encoded(tmp_path / "b.mp4", [np.vstack(pair) for pair in pairs]), ClipOptions(calibration=EYES)
        )
    clip = open_clip(video, ClipOptions(calibration=EYES, stereo="side-by-side"))
    frame = clip.read_frame(1)
    truth = Seen(clip.cameras[0].moved(rectified_pose()), COUNT).view(1).frame
    known = frame.depth > 0
    assert clip.size == (160, 256)
    assert clip.cameras[0].fy == pytest.approx(2 * clip.cameras[0].fx)
    assert known.mean() > 0.8
    assert np.median(np.abs(frame.depth - truth.depth)[known]) < 1.0


def test_a_pair_needs_the_calibration_of_both_eyes(folder):
    with pytest.raises(ClipError, match="both eyes"):
        open_clip(folder, ClipOptions(calibration=Calibration(lens=LEFT)))
