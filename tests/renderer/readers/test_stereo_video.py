"""Videos whose frames hold both eyes: known by what they say or by the option, split, and matched."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from renderer.clip import ClipError
from renderer.depth.depth_ways import depth_ways
from renderer.readers.clip_options import ClipOptions, StereoLayout
from renderer.readers.video_decoding.stereo_layout import eye_aspect, likely_layout
from renderer.readers.video_header import read_video_header
from renderer.sources import open_bare, open_clip, require_depth_source
from tests.renderer.eyes import BASELINE, Eyes, look
from tests.renderer.readers.numbered import encoded

SIZE = {"width": 192, "height": 144, "seed": 41, "noise": 0.5, "n_frames": 2}
FIELD_OF_VIEW = math.degrees(2 * math.atan(0.5 / 0.89))
AXES: dict[StereoLayout, int] = {"side-by-side": 1, "top-bottom": 0}
PACKING = {"side-by-side": 3, "top-bottom": 4}
"""As H.264 numbers them."""


@pytest.fixture(scope="module")
def moments() -> list[Eyes]:
    return [look(index, **SIZE) for index in range(2)]


def film(path: Path, moments: list[Eyes], layout: StereoLayout, *, told: bool) -> Path:
    pictures = [np.concatenate((one.left.image, one.right.image), axis=AXES[layout]) for one in moments]
    options = {"qp": "0"} | ({"x264-params": f"frame-packing={PACKING[layout]}"} if told else {})
    return encoded(path, pictures, options=options, pixels="yuv444p")


@pytest.mark.parametrize("decoder", ["PyAV", "OpenCV alone"])
@pytest.mark.parametrize("layout", AXES)
def test_depth_is_that_of_the_scene(tmp_path, monkeypatch, moments, layout: StereoLayout, decoder) -> None:
    if decoder == "OpenCV alone":
        monkeypatch.setattr("renderer.readers.video.has_pyav", lambda: False)
    path = film(tmp_path / "a.mp4", moments, layout, told=decoder == "PyAV")
    stereo = "auto" if decoder == "PyAV" else layout
    options = ClipOptions(stereo=stereo, field_of_view=FIELD_OF_VIEW, baseline=BASELINE)
    require_depth_source(path, options)
    clip = open_clip(path, options)
    assert (clip.format, clip.size, len(clip)) == ("video", (192, 144), 2)
    assert (clip.depth_origin, clip.unit, clip.pixel_aspect) == ("stereo", "mm", 1.0)
    assert any("left eye" in said for said in clip.notices)
    second = clip.every(1).between(1, 1)
    assert second.read_right is not None
    assert np.abs(second.read_right(0).astype(int) - moments[1].right.image).mean() < 2
    for read in (second.read_frame, second.read_image, second.read_right):
        with pytest.raises(IndexError, match="expected a frame from 0 to 0, got 1"):
            read(1)
    truth = moments[1]
    frame = clip.read_frame(1)
    np.testing.assert_array_equal(clip.read_frame(-1).depth, frame.depth)
    assert frame.depth is not None
    assert np.abs(frame.image.astype(int) - truth.left.image).mean() < 2
    known = truth.seen & (frame.depth > 0)
    assert known.sum() > 0.8 * truth.seen.sum()
    apart = np.abs(frame.camera.fx * BASELINE / frame.depth[known] - truth.disparity[known])
    assert np.median(apart) < 0.3


def test_what_a_video_says_is_overruled_on_request(tmp_path, moments) -> None:
    path = film(tmp_path / "a.mp4", moments, "top-bottom", told=True)
    assert read_video_header(path).stereo == "top-bottom"
    bare = open_bare(path)
    assert depth_ways(bare, ClipOptions()).why_not["stereo"] == ""
    whole = open_clip(path, ClipOptions(stereo="off"))
    assert (whole.size, whole.has_depth, whole.read_right) == ((192, 288), False, None)
    with pytest.raises(ClipError, match="a video has none"):
        require_depth_source(path, ClipOptions(stereo="off"))
    wrong = open_clip(path, ClipOptions(stereo="side-by-side"))
    assert not wrong.has_depth
    assert "no stereo depth" in wrong.why_no_depth
    assert "frame 0" not in wrong.why_no_depth


def test_eyes_that_are_swapped_or_one_twice_are_told_without_the_name_of_a_frame(tmp_path, moments) -> None:
    swapped = [replace(one, left=one.right, right=one.left) for one in moments]
    twice = [replace(one, right=one.left) for one in moments]
    for name, eyes, told in (
        ("a.mp4", swapped, "got both eyes in its frames swapped, the right one shows objects"),
        ("b.mp4", twice, "got the same image twice for both eyes in its frames: "),
    ):
        clip = open_clip(film(tmp_path / name, eyes, "side-by-side", told=True))
        assert told in clip.why_no_depth


@pytest.mark.parametrize("layout", AXES)
def test_a_video_that_says_nothing_is_told_to_look_like_two_eyes(tmp_path, moments, layout) -> None:
    path = film(tmp_path / "a.mp4", moments, layout, told=False)
    whole = open_clip(path)
    assert whole.read_right is None
    assert any("look alike" in said and f"set Eyes (--stereo {layout})" in said for said in whole.notices)
    for stereo in ("off", layout):
        assert not any("look alike" in n for n in open_clip(path, ClipOptions(stereo=stereo)).notices)
    with pytest.raises(ClipError, match=rf"a video has none \(.*look alike; .* \(--stereo {layout}\); else "):
        require_depth_source(path, ClipOptions())
    with pytest.raises(ClipError, match="a video has none") as refused:
        require_depth_source(path, ClipOptions(stereo="off"))
    assert "look alike" not in str(refused.value)


def test_frames_of_one_eye_do_not_look_like_two(moments) -> None:
    left, right = moments[0].left.image, moments[0].right.image
    squeezed = np.concatenate((left[:, ::2], right[:, ::2]), axis=1)
    assert likely_layout(squeezed) == "side-by-side"
    noise = np.random.default_rng(0).integers(0, 256, left.shape, np.uint8)
    mirrored = np.concatenate((left, left[:, ::-1]), axis=1)
    upright = np.concatenate((left[:, 40:100], right[:, 40:100]), axis=1)
    for image in (left, noise, mirrored, upright, left * 0, left[:40, :40], left[:1, :1]):
        assert likely_layout(np.ascontiguousarray(image)) is None


def test_what_cannot_be_halved_is_refused_in_a_line(tmp_path) -> None:
    odd = encoded(tmp_path / "a.mkv", [np.full((64, 97, 3), 90, np.uint8)], "ffv1", pixels="bgr0")
    with pytest.raises(ClipError, match=r"expected an even width of side-by-side stereo, got 97x64: .*a.mkv"):
        open_clip(odd, ClipOptions(stereo="side-by-side"))


@pytest.mark.parametrize(
    ("size", "layout", "aspect"),
    [
        ((1920, 1080), "side-by-side", 1.0),
        ((960, 1080), "side-by-side", 2.0),
        ((360, 576), "side-by-side", 2.0),
        ((1280, 1024), "top-bottom", 1.0),
        ((1920, 540), "top-bottom", 0.5),
        ((720, 288), "top-bottom", 0.5),
    ],
)
def test_squeezed_eyes_are_told_by_their_shape(size, layout: StereoLayout, aspect: float) -> None:
    assert eye_aspect(size, layout) == aspect
    assert eye_aspect((size[0] * 2, size[1]), layout, 0.5) == aspect / 2
