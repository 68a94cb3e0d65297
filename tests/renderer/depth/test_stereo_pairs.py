"""Left and right pictures are found in the layouts of the wild, judged, and give depth in known units."""

from __future__ import annotations

import math
import shutil
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
from PIL import Image

from renderer.clip import Clip, ClipError
from renderer.depth import stereo_depth
from renderer.depth.stereo_depth import with_stereo_depth
from renderer.depth.stereo_pairs import (
    eye_folders,
    is_stereo_folder,
    open_stereo_folder,
    right_eye,
    right_name,
    right_pictures,
)
from renderer.readers.image_folders.frames import open_images
from renderer.sources import open_bare, open_case
from tests.renderer.eyes import BASELINE, Eyes, write_eyes

SCARED = Path(__file__).resolve().parents[3] / "../shared/data/scared/d1k1_rectified_pair"
SIZE = {"width": 192, "height": 144, "seed": 41, "noise": 0.5}
FIELD_OF_VIEW = math.degrees(2 * math.atan(0.5 / 0.89))
"""Of the phantom, whose focal length is 0.89 of its width."""

LAYOUTS = {
    "folders": ("left/{:06d}.png", "right/{:06d}.png"),
    "capitals": ("Left/a{:06d}.png", "Right/a{:06d}.png"),
    "scared": ("left_finalpass/frame_data{:06d}.png", "right_finalpass/frame_data{:06d}.png"),
    "both names": ("left/left_{:06d}.png", "right/right_{:06d}.png"),
    "suffix": ("{:06d}_left.png", "{:06d}_right.png"),
    "letter": ("{:06d}l.png", "{:06d}r.png"),
    "letters": ("l/{:06d}.png", "r/{:06d}.png"),
    "img": ("img_left/{:06d}.png", "img_right/{:06d}.png"),
    "kitti": ("image_02/{:06d}.png", "image_03/{:06d}.png"),
}


@pytest.fixture(scope="module")
def written(tmp_path_factory) -> tuple[Path, Eyes]:
    """left/ and right/ with two moments of the phantom."""
    return two_moments(tmp_path_factory.mktemp("pairs") / "clip")


def two_moments(folder: Path) -> tuple[Path, Eyes]:
    return folder, write_eyes(folder, *LAYOUTS["folders"], count=2, **SIZE)[0]


def opened(folder: Path, baseline: float | None = None) -> Clip:
    clip = open_stereo_folder(folder, FIELD_OF_VIEW)
    return with_stereo_depth(clip, right_eye(clip), baseline)


def copied(written: tuple[Path, Eyes], to: Path) -> Path:
    return Path(shutil.copytree(written[0], to / "clip"))


def change(path: Path, by: object) -> None:
    with Image.open(path) as picture:
        pixels = np.asarray(picture)
    Image.fromarray(by(pixels)).save(path)  # type: ignore[operator]


@pytest.mark.parametrize(
    ("left", "right"),
    [
        ("left", "right"),
        ("Left", "Right"),
        ("left.png", "right.png"),
        ("frame_LEFT_03.tif", "frame_RIGHT_03.tif"),
        ("0012l.png", "0012r.png"),
        ("view_L.jpg", "view_R.jpg"),
        ("left_finalpass", "right_finalpass"),
        ("images", "images_right"),
        ("img_left", "img_right"),
        ("l", "r"),
        ("L_003.png", "R_003.png"),
        ("image_02", "image_03"),
        ("cam0", "cam1"),
        ("image_02.png", None),
        ("left_depth", None),
        ("left_disparity_3.png", None),
        ("signal.png", None),
        ("right.png", None),
        ("0012r.png", None),
        ("final", None),
        ("12.png", None),
    ],
)
def test_names(left, right):
    assert right_name(left) == right


@pytest.mark.parametrize("layout", LAYOUTS.values(), ids=LAYOUTS.keys())
def test_layouts_in_the_wild(written, tmp_path, layout):
    """The left pictures are the frames, and each finds its own right one."""
    source = written[0]
    for eye, pattern in zip(("left", "right"), layout, strict=True):
        for index in range(2):
            target = tmp_path / pattern.format(index)
            target.parent.mkdir(exist_ok=True)
            shutil.copy(source / eye / f"{index:06d}.png", target)
    (tmp_path / "notes.txt").write_text("x")
    assert is_stereo_folder(tmp_path)
    clip = open_stereo_folder(tmp_path, FIELD_OF_VIEW)
    assert len(clip) == 2
    assert clip.path == tmp_path
    assert clip.name == tmp_path.name
    rights = right_pictures(clip)
    for index in range(2):
        frame = clip.read_frame(index)
        assert (frame.index, frame.time) == (index, index / 2)
        np.testing.assert_array_equal(frame.image, np.asarray(Image.open(source / f"left/{index:06d}.png")))
        np.testing.assert_array_equal(clip.read_image(index), frame.image)
        assert rights[index].read_bytes() == (source / f"right/{index:06d}.png").read_bytes()


def test_the_left_folder_alone_knows_its_neighbour(written):
    clip = open_images(written[0] / "left")
    assert [path.parent.name for path in right_pictures(clip)] == ["right", "right"]


@pytest.mark.parametrize(
    ("left", "right"),
    [
        ("left_finalpass/{:06d}.png", "right_finalpass/{:06d}.png"),
        ("data/left_finalpass/{:06d}.png", "data/right_finalpass/{:06d}.png"),
        ("video_frames/{:06d}l.png", "video_frames/{:06d}r.png"),
        ("images/{:06d}.png", "images_right/{:06d}.png"),
    ],
)
def test_a_clip_of_another_reader_finds_them_below_its_folder(written, tmp_path, left, right):
    """Keyframes of SCARED, sequences of StereoMIS, EndoNeRF folders."""
    for eye, pattern in (("left", left), ("right", right)):
        for index in range(2):
            target = tmp_path / pattern.format(index)
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(written[0] / eye / f"{index:06d}.png", target)
    labels = tuple(Path(left.format(index)).name for index in range(2))
    clip = replace(open_images(written[0] / "left"), path=tmp_path, labels=labels)
    assert right_pictures(clip) == tuple(tmp_path / right.format(index) for index in range(2))


def test_pictures_of_one_eye_are_no_pairs(written, tmp_path):
    shutil.copytree(written[0] / "left", tmp_path / "left")
    assert not is_stereo_folder(tmp_path)
    assert not is_stereo_folder(tmp_path / "left")
    assert right_pictures(open_images(tmp_path / "left")) == ()


def test_images_of_two_eyes_of_a_patient_are_stills(tmp_path):
    """01L and 01R are called as pairs are but show two scenes: all are frames, none is a right one."""
    for patient in range(2):
        for side, letter in enumerate("LR"):
            seed = 60 + 2 * patient + side
            write_eyes(tmp_path / f"{seed}", *LAYOUTS["folders"], count=1, **{**SIZE, "seed": seed})
            shutil.copy(tmp_path / f"{seed}/left/000000.png", tmp_path / f"0{patient}{letter}.png")
            shutil.rmtree(tmp_path / f"{seed}")
    assert not is_stereo_folder(tmp_path)
    clip = open_case(tmp_path)
    assert clip.labels == ("00L.png", "00R.png", "01L.png", "01R.png")
    assert (clip.has_depth, right_pictures(clip)) == (False, ())


def test_pairs_side_by_side_after_a_black_one_are_still_pairs(written, tmp_path):
    for index in range(3):
        for eye in ("left", "right"):
            shutil.copy(written[0] / eye / f"{min(index, 1):06d}.png", tmp_path / f"{index}_{eye}.png")
    for eye in ("left", "right"):
        change(tmp_path / f"0_{eye}.png", np.zeros_like)
    assert is_stereo_folder(tmp_path)
    assert len(open_stereo_folder(tmp_path, FIELD_OF_VIEW)) == 3


def test_depth_in_millimetres(written):
    """The baseline, by option or by the clip, gives the phantom's own depth."""
    folder, eyes = written
    clip = opened(folder, BASELINE)
    assert (clip.has_depth, clip.unit) == (True, "mm")
    assert "4.2 mm apart" in clip.notices[-1]
    frame = clip.read_frame(0)
    assert frame.depth is not None
    assert eyes.left.depth is not None
    known = eyes.seen & (frame.depth > 0)
    assert known.sum() > 0.85 * eyes.seen.sum()
    # 0.1 px of a disparity of about 11.
    assert np.median(np.abs(frame.depth[known] / eyes.left.depth[known] - 1)) < 0.01
    calibrated = replace(open_stereo_folder(folder, FIELD_OF_VIEW), unit="mm", baseline=BASELINE)
    same = with_stereo_depth(calibrated, right_eye(calibrated), None)
    np.testing.assert_array_equal(same.read_frame(0).depth, frame.depth)
    assert same.unit == "mm"


def test_without_a_baseline_lengths_are_in_units_of_it(written):
    clip, known = opened(written[0]), opened(written[0], BASELINE)
    assert (clip.has_depth, clip.unit) == (True, "scene units")
    assert "no scale" in clip.notices[-1]
    depth, wanted = clip.read_frame(1).depth, known.read_frame(1).depth
    assert depth is not None
    assert wanted is not None
    np.testing.assert_allclose(BASELINE * depth, wanted, rtol=1e-6)


def test_it_is_said_what_millimetres_rest_on_without_a_calibration(written, tmp_path):
    said = opened(written[0], BASELINE).notices[-1]
    assert "4.2 mm apart; lengths in mm rest on eyes that look in parallel with principal points in" in said
    assert "a field of view of 59 degrees (--calibration FILE" in said
    without = opened(written[0]).notices[-1]
    assert "no scale" in without
    assert "; shapes rest on eyes that look in parallel" in without
    assert "a field of view of 59 degrees (--field-of-view states another)" in without
    calibrated = replace(
        open_stereo_folder(written[0], FIELD_OF_VIEW), unit="mm", baseline=4.2, calibrated=True
    )
    assert with_stereo_depth(calibrated, right_eye(calibrated), None).notices[-1].endswith("4.2 mm apart")
    unknown = with_stereo_depth(replace(calibrated, baseline=None), right_eye(calibrated), None).notices[-1]
    assert "no scale" in unknown
    assert "rest on" not in unknown
    folder = copied(written, tmp_path)
    for index in range(2):
        change(folder / f"right/{index:06d}.png", lambda pixels: np.roll(pixels, 4, axis=0))
    assert "doubtful as their rows are apart" in opened(folder, BASELINE).notices[-1]


def test_strays_are_reported(written, tmp_path):
    for eye in ("left", "right"):
        shutil.copy(written[0] / eye / "000000.png", tmp_path / f"{eye}.png")
    for name in ("occ_left", "other"):
        shutil.copy(written[0] / "left/000000.png", tmp_path / f"{name}.png")
    clip = open_bare(tmp_path)
    assert clip.labels == ("left.png",)
    assert [notice.partition(" (")[0] for notice in clip.notices] == [
        "left out, not part of a stereo pair: other.png",
        "left out, masks beside the images: occ_left.png",
    ]


@pytest.mark.parametrize("damaged", [0, 1])
def test_a_later_pair_that_cannot_be_read_is_passed_over(written, damaged):
    clip = open_stereo_folder(written[0], FIELD_OF_VIEW)
    right = right_eye(clip)

    def read(index):
        if index == damaged:
            raise ClipError("expected an intact image, got a damaged one")
        return right.read(index)

    if damaged == 0:
        with pytest.raises(ClipError, match="got a damaged one"):
            with_stereo_depth(clip, replace(right, read=read), None)
        return
    found = with_stereo_depth(clip, replace(right, read=read), None)
    np.testing.assert_array_equal(found.read_frame(0).depth, opened(written[0]).read_frame(0).depth)


def test_a_few_matches_by_chance_move_no_rows(written, monkeypatch):
    shifts, rng = iter(["first", "second"]), np.random.default_rng(3)
    good = np.stack([np.full(60, 9.0), rng.normal(0, 0.2, 60)], axis=1)
    poor = np.stack([np.full(12, 9.0), np.linspace(-20, 36, 12)], axis=1)
    chosen = {"first": good, "second": poor}
    monkeypatch.setattr(stereo_depth, "feature_shifts", lambda left, right: chosen[next(shifts)])
    assert not any("rows" in notice for notice in opened(written[0]).notices)


def test_maps_of_both_eyes_are_no_eyes(written, tmp_path):
    """depth_left/ sorts before left/."""
    folder = copied(written, tmp_path)
    for eye in ("left", "right"):
        shutil.copytree(folder / eye, folder / f"depth_{eye}")
    assert [path.name for path in eye_folders(folder)] == ["left", "right"]
    np.testing.assert_array_equal(
        open_stereo_folder(folder, FIELD_OF_VIEW).read_image(0),
        np.asarray(Image.open(written[0] / "left/000000.png")),
    )


def test_swapped_eyes_are_refused(written, tmp_path):
    shutil.copytree(written[0] / "left", tmp_path / "right")
    shutil.copytree(written[0] / "right", tmp_path / "left")
    told = r"got 000000.png and 000000.png swapped, the right one shows objects \d+ px farther right: "
    with pytest.raises(ClipError, match=told):
        opened(tmp_path)


def test_eyes_that_are_swapped_later_are_named(written, tmp_path):
    folder = copied(written, tmp_path)
    left, right = (folder / eye / "000001.png" for eye in ("left", "right"))
    pixels = left.read_bytes()
    shutil.copy(right, left)
    right.write_bytes(pixels)
    clip = opened(folder)
    assert "swapped in 000001.png" in clip.notices[-2]
    assert [bool(clip.read_frame(index).depth.any()) for index in range(2)] == [True, False]
    assert not any("swapped" in notice for notice in opened(written[0]).notices)


def test_one_eye_twice_is_refused_as_that(written, tmp_path):
    for eye in ("left", "right"):
        shutil.copytree(written[0] / "left", tmp_path / eye)
    change(tmp_path / "right/000000.png", lambda pixels: np.minimum(pixels, 254) + 1)
    with pytest.raises(ClipError, match="got the same image twice"):
        opened(tmp_path)


def test_pictures_of_two_scenes_are_refused(written, tmp_path):
    folder = copied(written, tmp_path)
    for name in ("000000.png", "000001.png"):
        change(folder / "right" / name, lambda pixels: np.full_like(pixels, 90))
    told = r"0 features in common in the best of 2 pairs looked at \(\d+ are needed\): "
    with pytest.raises(ClipError, match=told):
        opened(folder)


def test_a_first_pair_that_shows_too_little_is_judged_by_the_others(written, tmp_path):
    folder = copied(written, tmp_path)
    for eye in ("left", "right"):
        change(folder / eye / "000000.png", lambda pixels: cv2.GaussianBlur(pixels, (0, 0), 12))
    clip, sharp = opened(folder), opened(written[0])
    np.testing.assert_array_equal(clip.read_frame(1).depth, sharp.read_frame(1).depth)


def test_what_does_not_pair_is_refused(written, tmp_path):
    folder = copied(written, tmp_path)
    (folder / "right/000001.png").unlink()
    with pytest.raises(ClipError, match=r"1 right images for 2 left ones, none for 000001\.png"):
        opened(folder)
    shutil.copy(folder / "right/000000.png", folder / "right/000001.png")
    for name in ("000000.png", "000001.png"):
        change(folder / "right" / name, lambda pixels: pixels[:-1])
    with pytest.raises(ClipError, match="192x144 as the left one, got 192x143"):
        opened(folder)


def test_a_moving_camera_needs_the_baseline(written):
    clip = open_stereo_folder(written[0], FIELD_OF_VIEW)
    moved = np.eye(4)
    moved[0, 3] = 1
    moving = replace(clip, cameras=(clip.cameras[0], clip.cameras[0].moved(moved)))
    with pytest.raises(ClipError, match="--baseline"):
        with_stereo_depth(moving, right_eye(moving), None)
    assert with_stereo_depth(moving, right_eye(moving), BASELINE).unit == "mm"


@pytest.mark.data
@pytest.mark.skipif(not SCARED.is_dir(), reason="the SCARED pair is not there")
def test_a_real_pair_opens():
    clip = opened(SCARED)
    assert (len(clip), clip.labels, clip.unit) == (1, ("left.png",), "scene units")
    depth = clip.read_frame(0).depth
    assert depth is not None
    assert (depth > 0).mean() > 0.7
    spread = np.percentile(depth[depth > 0], [1, 99])
    assert spread[1] < 3 * spread[0]
