"""Depth maps and masks beside pictures are paired with them, used where they are clear, and else told."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from renderer.clip import Clip, ClipError, Frame
from renderer.phantom import Phantom, PhantomParams
from renderer.readers.clip_options import ClipOptions
from renderer.sources import open_clip

COUNT = 3


@cache
def frames() -> tuple[Frame, ...]:
    phantom = Phantom(PhantomParams(n_frames=COUNT, width=64, height=48, seed=2))
    return tuple(phantom.view(index).frame for index in range(COUNT))


def save(path: Path, array: np.ndarray) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    if path.suffix == ".npy":
        np.save(path, array)
    else:
        Image.fromarray(array).save(path)


def write(folder: Path, image: str = "left_{}.png", **patterns: str) -> Path:
    """Pictures, and beside them maps of these kinds under names with a place for the number."""
    for index, frame in enumerate(frames()):
        assert frame.depth is not None
        depth = frame.depth
        arrays = {
            "depth": np.rint(100 * depth).astype(np.uint16),
            "floats": depth.astype(np.float32),
            "bytes": np.rint(depth).astype(np.uint8),
            "colour": np.repeat(np.rint(depth).astype(np.uint8)[:, :, None], 3, axis=2),
            "disparity": np.where(depth > 0, 64 * 500 / np.maximum(depth, 1), 0).astype(np.uint16),
            "mask": np.where(frame.tissue_mask, 0, 1).astype(np.uint8),
        }
        save(folder / image.format(50 + index), frame.image)
        for kind, pattern in patterns.items():
            save(folder / pattern.format(50 + index), arrays[kind])
    return folder


def check(clip: Clip, factor: float = 1.0) -> None:
    """Its frames are the phantom's, its depth is proportional."""
    assert len(clip) == COUNT
    assert clip.has_depth
    assert clip.depth_origin == "beside"
    for index, wanted in enumerate(frames()):
        frame = clip.read_frame(index)
        np.testing.assert_array_equal(frame.image, wanted.image)
        assert frame.depth is not None
        known = frame.depth > 0
        assert known.mean() > 0.9
        ratio = frame.depth[known] / wanted.depth[known]  # type: ignore[index]
        np.testing.assert_allclose(ratio, factor * np.ones_like(ratio), rtol=0.02)


@pytest.mark.parametrize(
    ("image", "depth"),
    [
        ("left_{}.png", "left_depthmap_{}.png"),
        ("{}_color.png", "{}_depth.png"),
        ("FrameBuffer_{}.png", "Depth_{}.png"),
        ("a/{}.jpeg.png", "a/depth.{}.png"),
        ("rgb/{}.png", "depth maps/{}.png"),
    ],
)
def test_depth_of_sixteen_bits_is_used_without_a_unit(tmp_path, image, depth):
    write(tmp_path, image, depth=depth)
    clip = open_clip(tmp_path / "a" if image.startswith("a/") else tmp_path)
    check(clip, 100)
    assert clip.unit == "scene units"
    assert "unknown unit" in clip.notices[0]


def test_floats_and_arrays_and_millimetres(tmp_path):
    check(open_clip(write(tmp_path / "a", floats="depth_{}.tiff")))
    check(open_clip(write(tmp_path / "b", floats="left_{}_depth.npy")))
    clip = open_clip(write(tmp_path / "c", floats="left_{}_depth_mm.tiff"))
    check(clip)
    assert clip.unit == "mm"


def test_disparity_is_inverted_and_its_factor_taken_from_the_name(tmp_path):
    write(tmp_path, "img_left/{}.png", disparity="disparity_x64_png/{}.png")
    clip = open_clip(tmp_path)
    focal = clip.cameras[0].fx
    check(clip, focal / 500)
    assert clip.unit == "scene units"
    assert "1/64 px" in clip.notices[0]
    clip = open_clip(tmp_path, ClipOptions(baseline=4.0))
    check(clip, 4 * focal / 500)
    assert clip.unit == "mm"


@pytest.mark.parametrize(
    "name",
    [
        "{}_disparity_x64.png",
        "disparity_x64_{}.png",
        "disparity/{}_x64.png",
        "disparity/{}_disparity_x64.png",
    ],
)
def test_the_factor_in_each_name_is_no_number_of_a_frame(tmp_path, name):
    write(tmp_path, "{}.png", disparity=name)
    clip = open_clip(tmp_path, ClipOptions(baseline=4.0))
    check(clip, 4 * clip.cameras[0].fx / 500)


def test_numbers_of_frames_that_look_like_a_factor_are_none(tmp_path):
    write(tmp_path, "x{}.png", disparity="x{}_disparity.png")
    clip = open_clip(tmp_path)
    check(clip, clip.cameras[0].fx / 500 / 64)


@pytest.mark.parametrize("size", [(32, 24), (64, 48), (128, 96)])
def test_disparities_are_in_pixels_of_their_map(tmp_path, size):
    write(tmp_path, "{}.png")
    for index, frame in enumerate(frames()):
        focal, baseline = frame.camera.fx, 4.0
        own = np.full(size[::-1], size[0] / 64 * focal * baseline / (50 + index), np.float32)
        save(tmp_path / f"disparity/{50 + index}.npy", own)
    clip = open_clip(tmp_path, ClipOptions(baseline=4.0, field_of_view=frames()[0].camera.field_of_view))
    assert clip.unit == "mm"
    for index in range(COUNT):
        np.testing.assert_allclose(clip.read_frame(index).depth, 50 + index, rtol=1e-4)
    said = [text for text in clip.notices if f"pixels of the maps, {size[0]}x{size[1]}, not of" in text]
    assert len(said) == (size != (64, 48))


@pytest.mark.parametrize(("kind", "way"), [("bytes", "--depth measured"), ("colour", "holds colours")])
def test_what_is_not_clear_is_left_out_with_the_way(tmp_path, kind, way):
    clip = open_clip(write(tmp_path, **{kind: "left_depth_{}.png"}))
    assert len(clip) == COUNT
    assert not clip.has_depth
    assert "left out, depth maps beside the images: left_depth_50.png and 2 more" in clip.notices[0]
    assert way in clip.notices[0]


def test_bytes_are_depth_when_that_is_said(tmp_path):
    check(open_clip(write(tmp_path, bytes="left_depth_{}.png"), ClipOptions(depth="measured")))


def test_sixteen_bits_without_a_name_are_left_out_with_the_way(tmp_path):
    clip = open_clip(write(tmp_path, depth="left_{}_z.png"))
    assert (len(clip), clip.has_depth) == (COUNT, False)
    assert "name them _depth" in clip.notices[0]


def test_two_that_could_be_meant_are_neither(tmp_path):
    clip = open_clip(write(tmp_path, depth="left_{}_depth.png", floats="left_{}_depthmap.tiff"))
    assert not clip.has_depth
    assert "neither is used" in clip.notices[0]


def test_maps_of_the_right_eye_are_not_those_of_the_left(tmp_path):
    clip = open_clip(write(tmp_path, depth="right_depth_{}.png"))
    assert (len(clip), clip.has_depth) == (COUNT, False)


def test_a_picture_without_its_map_has_no_depth(tmp_path):
    write(tmp_path, depth="left_depthmap_{}.png")
    (tmp_path / "left_depthmap_51.png").unlink()
    clip = open_clip(tmp_path)
    assert "1 of 3 images have no depth map, such as left_51.png" in clip.notices
    depth = clip.read_frame(1).depth
    assert depth is not None
    assert not depth.any()
    assert clip.read_frame(2).depth_mask.any()


@pytest.mark.parametrize("maps", ["depth/{}.npy", "depth/frame_{}.npy", "frame_{}_depth.npy"])
@pytest.mark.parametrize("start", [0, 1, 40])
def test_maps_counted_from_another_start_keep_their_images(tmp_path, maps, start):
    images = [f"frame_{start + index}.png" for index in range(COUNT)]
    first = 1 if start == 0 else 0
    for index, (name, frame) in enumerate(zip(images, frames(), strict=True)):
        save(tmp_path / name, frame.image)
        save(tmp_path / maps.format(first + index), frame.depth)
    clip = open_clip(tmp_path)
    check(clip)
    paired = f"paired in order: {Path(maps.format(first)).name} with {images[0]}"
    assert [said for said in clip.notices if said.endswith(paired)]


def test_maps_that_are_perhaps_shifted_are_left_out(tmp_path):
    write(tmp_path, image="{}.png", depth="depth/{}.png")
    (tmp_path / "depth/52.png").unlink()
    (tmp_path / "depth/51.png").rename(tmp_path / "depth/49.png")
    clip = open_clip(tmp_path)
    assert not clip.has_depth
    assert "names and numbers do not say which of the images they belong to" in clip.notices[0]


def test_maps_of_no_image_are_named(tmp_path):
    write(tmp_path, depth="depth/{}.png")
    (tmp_path / "left_51.png").unlink()
    clip = open_clip(tmp_path)
    assert clip.has_depth
    assert "1 of 3 depth maps belong to none of the images: 51.png" in clip.notices


def test_masks_counted_from_another_start_keep_their_images(tmp_path):
    write(tmp_path, image="{}.png", mask="masks/{}.png")
    for index in range(COUNT):
        (tmp_path / f"masks/{50 + index}.png").rename(tmp_path / f"masks/{index}.png")
    clip = open_clip(tmp_path, ClipOptions(mask_polarity="tool"))
    for index, wanted in enumerate(frames()):
        np.testing.assert_array_equal(clip.read_frame(index).tissue_mask, wanted.tissue_mask)
    assert any("paired in order: 0.png with 50.png" in said for said in clip.notices)


def test_a_smaller_map_is_resampled_and_another_shape_left_out(tmp_path):
    write(tmp_path, depth="left_depthmap_{}.png")
    for path in tmp_path.glob("*depthmap*"):
        with Image.open(path) as picture:
            half = picture.resize((32, 24), Image.Resampling.NEAREST)
        half.save(path)
    depth = open_clip(tmp_path).read_frame(0).depth
    assert depth is not None
    assert depth.shape == (48, 64)
    half.resize((32, 32)).save(tmp_path / "left_depthmap_52.png")
    clip = open_clip(tmp_path)
    assert not clip.has_depth
    assert "left_depthmap_52.png is 32x32, another shape" in clip.notices[0]


def test_masks_are_used_when_it_is_said_what_they_mark(tmp_path):
    write(tmp_path, mask="masks/{}.png")
    clip = open_clip(tmp_path)
    assert clip.read_frame(0).tissue_mask.all()
    assert "--mask-polarity" in clip.notices[0]
    marked = open_clip(tmp_path, ClipOptions(mask_polarity="tool"))
    for index, wanted in enumerate(frames()):
        np.testing.assert_array_equal(marked.read_frame(index).tissue_mask, wanted.tissue_mask)
    tissue = open_clip(tmp_path, ClipOptions(mask_polarity="tissue")).read_frame(0)
    np.testing.assert_array_equal(tissue.tissue_mask, ~frames()[0].tissue_mask)


def test_lossy_masks_of_half_the_size_mark_what_is_bright(tmp_path):
    write(tmp_path)
    for index in range(COUNT):
        tool = np.zeros((24, 32), np.uint8)
        tool[8:16, 8:24] = 255
        save(tmp_path / f"masks/{50 + index}.jpg", tool)
    tissue = open_clip(tmp_path, ClipOptions(mask_polarity="tool")).read_frame(1).tissue_mask
    wanted = np.ones((48, 64), bool)
    wanted[16:32, 16:48] = False
    np.testing.assert_array_equal(tissue, wanted)


def test_a_mask_of_another_shape_is_refused_when_the_clip_is_opened(tmp_path):
    write(tmp_path, mask="masks/{}.png")
    Image.new("L", (48, 48)).save(tmp_path / "masks/52.png")
    with pytest.raises(ClipError, match=r"64x48, got 48x48: .*52\.png$"):
        open_clip(tmp_path, ClipOptions(mask_polarity="tool"))


def test_depth_asked_for_elsewhere_leaves_maps_alone(tmp_path):
    write(tmp_path, depth="left_depthmap_{}.png")
    clip = open_clip(tmp_path, ClipOptions(depth="off"))
    assert (len(clip), clip.has_depth) == (COUNT, False)
    assert open_clip(tmp_path, ClipOptions(depth="brightness")).depth_origin == "brightness"


def test_a_damaged_map_is_named(tmp_path):
    write(tmp_path, depth="left_depthmap_{}.png")
    whole = (tmp_path / "left_depthmap_51.png").read_bytes()
    (tmp_path / "left_depthmap_51.png").write_bytes(whole[: len(whole) // 2])
    with pytest.raises(ClipError, match=r"left_depthmap_51\.png$"):
        open_clip(tmp_path).read_frame(1)
