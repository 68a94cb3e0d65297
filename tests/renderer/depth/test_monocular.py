"""Monocular maps, whose scale and shift differ between frames, give one scene that does not breathe."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from renderer.clip import Clip, ClipError
from renderer.depth.depth_prior import with_guessed_depth
from renderer.depth.monocular import monocular_guess, monocular_maps, read_inverse_depth
from renderer.readers.image_folders.frames import open_images

HEIGHT, WIDTH, COUNT = 60, 80, 4
ROWS, COLUMNS = np.indices((HEIGHT, WIDTH))
SHAPE = 50 + 12 * np.sin(COLUMNS / 15) + 0.2 * ROWS
"""Depth of tissue that stays in place, mm."""


def depth_at(index: int) -> np.ndarray:
    """A part of the tissue moves."""
    moving = (ROWS > 40) & (COLUMNS > 60)
    return np.where(moving, SHAPE + 3 * index, SHAPE)


def write_clip(folder: Path) -> Clip:
    images = folder / "images"
    images.mkdir(parents=True)
    for index in range(COUNT):
        Image.new("RGB", (WIDTH, HEIGHT), (120, 60, 50)).save(images / f"frame-{index:06d}.color.png")
    return open_images(images)


def write_arrays(folder: Path, scales: tuple[float, ...], shifts: tuple[float, ...]) -> None:
    (folder / "depth_dam").mkdir()
    for index, (scale, shift) in enumerate(zip(scales, shifts, strict=True)):
        inverse = (scale * 50 / depth_at(index) + shift).astype(np.float32)
        np.save(folder / "depth_dam" / f"{index}.npy", inverse)


def guessed(clip: Clip) -> list[np.ndarray]:
    with_depth = with_guessed_depth(clip, monocular_guess(clip, monocular_maps(clip)), "said")
    depths = [with_depth.read_frame(index).depth for index in range(COUNT)]
    return [depth for depth in depths if depth is not None]


def test_scale_and_shift_of_each_frame_are_taken_out(tmp_path):
    """The first frame's map is true but for its scale, so that all depths are."""
    clip = write_clip(tmp_path)
    write_arrays(tmp_path, (1.0, 2.5, 0.4, 7.0), (0.0, 0.3, -0.1, 2.0))
    depths = guessed(clip)
    factor = np.median(depths[0] / depth_at(0))
    low, high = depths[0].min(), depths[0].max()
    for index, depth in enumerate(depths):
        wanted = np.clip(factor * depth_at(index), low, high)
        np.testing.assert_allclose(depth, wanted, rtol=2e-3)
    assert np.median(np.concatenate(depths)) == pytest.approx(1, abs=0.02)


def test_pictures_of_disparity(tmp_path):
    """monodepth/: 0 to 255 in the first channel of a colour picture, 0 = none."""
    clip = write_clip(tmp_path)
    (tmp_path / "monodepth").mkdir()
    for index in range(COUNT):
        byte = np.rint(255 * 38 / depth_at(index)).astype(np.uint8)
        byte[:10] = 0
        other = np.zeros_like(byte)
        picture = np.stack([byte, other, other], axis=2)
        Image.fromarray(picture).save(tmp_path / f"monodepth/frame-{index:06d}.png")
    for index, depth in enumerate(guessed(clip)):
        assert not depth[:10].any()
        known = depth[10:] / depth_at(index)[10:]
        assert np.abs(known / np.median(known) - 1).max() < 0.05


def test_maps_of_another_size_are_resampled(tmp_path):
    plane = (0.5 + np.arange(40) / 80)[None, :].repeat(30, axis=0)
    path = tmp_path / "0.npy"
    np.save(path, plane[None].astype(np.float32))
    found = read_inverse_depth(path, (WIDTH, HEIGHT))
    wanted = 0.5 + ((COLUMNS + 0.5) / 2 - 0.5) / 80
    np.testing.assert_allclose(found[:, 1:-1], wanted[:, 1:-1], atol=1e-6)
    plane[:, 10] = np.nan
    plane[:, 11] = -3
    np.save(path, plane)
    holes = read_inverse_depth(path, (WIDTH, HEIGHT))
    assert not holes[:, 20:24].any()
    assert (holes[:, :18] > 0).all()
    assert holes[holes > 0].min() > 0.4


def test_maps_are_found_beside_or_in_the_folder(tmp_path):
    clip = write_clip(tmp_path)
    assert monocular_maps(clip) == ()
    write_arrays(tmp_path, (1.0,) * COUNT, (0.0,) * COUNT)
    assert [path.name for path in monocular_maps(clip)] == [f"{index}.npy" for index in range(COUNT)]
    (tmp_path / "depth_dam").rename(tmp_path / "images/depth_dam")
    assert len(monocular_maps(clip)) == COUNT


def test_missing_maps_are_refused(tmp_path):
    clip = write_clip(tmp_path)
    write_arrays(tmp_path, (1.0,) * COUNT, (0.0,) * COUNT)
    (tmp_path / "depth_dam/2.npy").unlink()
    with pytest.raises(ClipError, match=r"every frame, got none for 1 of 4, number 2: .*depth_dam$"):
        monocular_maps(clip)


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (np.zeros((3, 4, 5)), "one number a pixel"),
        (np.array([["a", "b"]]), "one number a pixel"),
        (np.array([{}], dtype=object), "unreadable"),
        (b"hello", "unreadable"),
        (b"", "unreadable"),
    ],
)
def test_what_is_no_map_is_refused(tmp_path, content, said):
    path = tmp_path / "0.npy"
    if isinstance(content, bytes):
        path.write_bytes(content)
    else:
        np.save(path, content)
    with pytest.raises(ClipError, match=rf"{said}.*0\.npy$"):
        read_inverse_depth(path, (4, 3))


def test_an_empty_map_is_refused_where_it_is_the_reference(tmp_path):
    clip = write_clip(tmp_path)
    write_arrays(tmp_path, (0.0, 1.0, 1.0, 1.0), (0.0,) * COUNT)
    with pytest.raises(ClipError, match=r"on the tissue, got none: .*0\.npy$"):
        guessed(clip)
