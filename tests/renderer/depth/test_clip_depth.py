"""`with_depth` takes depth from where it is told to, and from nowhere else."""

from __future__ import annotations

import shutil

import numpy as np
import pytest
from PIL import Image

from assets import phantom_path
from renderer.clip import Clip, ClipError
from renderer.depth.clip_depth import BY_BRIGHTNESS, BY_MAPS, with_depth
from renderer.depth.stereo_pairs import open_stereo_folder
from renderer.readers.clip_options import ClipOptions, DepthSource
from renderer.readers.data_sets.endonerf import open_endonerf
from renderer.readers.image_folders.frames import open_image, open_images
from renderer.train.trainer import require_depth
from tests.renderer.eyes import BASELINE, write_eyes


@pytest.fixture(scope="module")
def pairs(tmp_path_factory) -> Clip:
    folder = tmp_path_factory.mktemp("pairs")
    write_eyes(folder, "left/{:06d}.png", "right/{:06d}.png", width=192, height=144, seed=41, tools=0)
    return open_stereo_folder(folder, 60)


@pytest.fixture(scope="module")
def measured() -> Clip:
    return open_endonerf(phantom_path())


@pytest.fixture(scope="module")
def pictures() -> Clip:
    return open_images(phantom_path() / "images")


def depth_of(clip: Clip, source: DepthSource, index: int = 0) -> np.ndarray | None:
    return with_depth(clip, ClipOptions(depth=source)).read_frame(index).depth


def test_auto_keeps_what_is_measured(measured):
    assert with_depth(measured, ClipOptions()) is measured
    assert with_depth(measured, ClipOptions(depth="measured")) is measured


def test_auto_never_guesses(pictures):
    clip = with_depth(pictures, ClipOptions())
    assert not clip.has_depth
    assert clip.read_frame(0).depth is None


def test_auto_matches_pairs(pairs):
    clip = with_depth(pairs, ClipOptions(baseline=BASELINE))
    assert (clip.has_depth, clip.unit) == (True, "mm")
    assert "matched" in clip.notices[-1]
    asked = with_depth(pairs, ClipOptions(depth="stereo", baseline=BASELINE))
    depth = clip.read_frame(0).depth
    assert depth is not None
    np.testing.assert_array_equal(depth, asked.read_frame(0).depth)
    assert (depth > 0).mean() > 0.7


def test_auto_says_why_pairs_are_not_matched(pairs, tmp_path):
    for eye, degrees in (("left", 0), ("right", 4)):
        (tmp_path / eye).mkdir()
        with Image.open(pairs.path / eye / "000000.png") as picture:
            picture.rotate(degrees).save(tmp_path / eye / "0.png")
    opened = open_stereo_folder(tmp_path, 60)
    clip = with_depth(opened, ClipOptions())
    assert not clip.has_depth
    assert clip.notices[-1].startswith("no stereo depth: expected a rectified pair")
    why = r"expects depth; no stereo depth: .* rows .* got \d\.\d px .*rectifies them"
    with pytest.raises(ClipError, match=why):
        require_depth(clip)
    with pytest.raises(ClipError, match="rectified"):
        with_depth(opened, ClipOptions(depth="stereo"))


@pytest.mark.parametrize("rows", [5, -3])
def test_rows_that_all_lie_as_far_apart_are_brought_together(pairs, tmp_path, rows):
    """The depth is that of the pair as it was, but for the rows that the right eye did not see."""
    shutil.copytree(pairs.path, tmp_path / "moved")
    for path in (tmp_path / "moved/right").iterdir():
        with Image.open(path) as picture:
            Image.fromarray(np.roll(np.asarray(picture), -rows, axis=0)).save(path)
    clip = with_depth(open_stereo_folder(tmp_path / "moved", 60), ClipOptions(baseline=BASELINE))
    assert f"rows are {abs(rows):.1f} px apart" in clip.notices[-2]
    wanted = with_depth(pairs, ClipOptions(baseline=BASELINE)).read_frame(0).depth
    depth = clip.read_frame(0).depth
    assert wanted is not None
    assert depth is not None
    unseen = slice(None, rows) if rows > 0 else slice(rows, None)
    assert not depth[unseen].any()
    both = (depth > 0) & (wanted > 0)
    assert both.mean() > 0.6
    assert np.median(np.abs(depth[both] / wanted[both] - 1)) < 0.01


def test_brightness_replaces_what_is_there(measured, pictures):
    for clip in (measured, pictures):
        lit = with_depth(clip, ClipOptions(depth="brightness"))
        assert (lit.has_depth, lit.unit, lit.notices[-1]) == (True, "scene units", BY_BRIGHTNESS)
        depth = lit.read_frame(3).depth
        assert depth is not None
        assert np.median(depth[depth > 0]) == pytest.approx(1, abs=0.1)
        np.testing.assert_array_equal(lit.read_image(3), clip.read_image(3))


def test_one_picture_can_be_guessed(pictures):
    picture = open_image(pictures.path / pictures.labels[0])
    depth = depth_of(picture, "brightness")
    assert depth is not None
    assert np.median(depth[depth > 0]) == pytest.approx(1, abs=0.1)


def test_monocular_maps_are_taken_when_asked_for(pictures, tmp_path):
    folder = tmp_path / "images"
    folder.mkdir()
    (tmp_path / "monodepth").mkdir()
    for index in range(2):
        Image.fromarray(pictures.read_image(index)).save(folder / f"{index}.png")
        ramp = np.linspace(100, 200, 320).astype(np.uint8)[None].repeat(256, axis=0)
        Image.fromarray(ramp).save(tmp_path / f"monodepth/{index}.png")
    clip = open_images(folder)
    assert not with_depth(clip, ClipOptions()).has_depth
    mapped = with_depth(clip, ClipOptions(depth="monocular"))
    assert (mapped.unit, mapped.notices[-1]) == ("scene units", BY_MAPS)
    depth = mapped.read_frame(0).depth
    assert depth is not None
    assert (np.diff(depth[0]) <= 0).all()


def test_off_takes_depth_away(measured, pictures):
    clip = with_depth(measured, ClipOptions(depth="off"))
    assert not clip.has_depth
    assert clip.read_frame(0).depth is None
    assert with_depth(pictures, ClipOptions(depth="off")) is pictures


@pytest.mark.parametrize(
    ("source", "said"),
    [("measured", "measured depth"), ("stereo", "right images"), ("monocular", "monodepth or depth_dam")],
)
def test_what_is_not_there_is_refused(pictures, source, said):
    with pytest.raises(ClipError, match=rf"{said}.*images$"):
        with_depth(pictures, ClipOptions(depth=source))


def test_depth_is_worked_out_from_the_frame_not_the_enhanced_picture(pictures):
    plain = with_depth(pictures, ClipOptions(depth="brightness"))
    inverted = plain.with_images(lambda image, frame: 255 - image, "inverted")
    np.testing.assert_array_equal(inverted.read_frame(0).depth, plain.read_frame(0).depth)


def test_an_embedded_clip_is_left_as_it_was(measured):
    """The sources wrap; the clip that was opened stays what it is."""
    before = measured.read_frame(0).depth
    with_depth(measured, ClipOptions(depth="brightness")).read_frame(0)
    np.testing.assert_array_equal(measured.read_frame(0).depth, before)
