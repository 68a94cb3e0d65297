"""Displacement and change of colour: measured right where they are known, blind to lamp and highlights."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from renderer.clip import Frame
from renderer.phantom import Phantom, PhantomParams
from renderer.train.needs import STILL
from renderer.train.stillness import Stillness, stillness
from tests.renderer.plane import N_FRAMES, SIZE, plane_clip


def measured(**changes: Any) -> Stillness:
    clip = plane_clip(**changes)
    return stillness([clip.read_frame(index) for index in range(N_FRAMES)])


@pytest.mark.parametrize("circle", [0.0, 3.0])
@pytest.mark.parametrize("slide", [0.2, 0.5, 1.0])
def test_a_known_displacement_is_measured(slide: float, circle: float) -> None:
    """The farthest apart that the plane is in two frames."""
    places = slide * np.sin(2.6 * np.pi * np.arange(N_FRAMES) / N_FRAMES)
    assert measured(slide=slide, circle=circle).displacement == pytest.approx(np.ptp(places), rel=0.15)


@pytest.mark.parametrize("circle", [0.0, 3.0])
def test_tissue_at_rest_is_still_whoever_looks_at_it(circle: float) -> None:
    found = measured(circle=circle)
    assert found.displacement < 0.1
    assert found.recoloring < 0.2


@pytest.mark.parametrize("circle", [0.0, 3.0])
def test_lamp_and_highlights_change_colours_but_move_nothing(circle: float) -> None:
    found = measured(circle=circle, lamp=0.2, gloss=0.15)
    assert found.displacement < 0.35
    assert found.recoloring > 3


def test_noise_is_no_motion() -> None:
    """Where it hides the texture, it cannot be told whether anything moves."""
    assert measured(noise=2.0).displacement < 0.5
    assert measured(noise=2.0).recoloring < 0.5
    assert measured(noise=60.0).displacement == np.inf


def test_motion_of_a_part_is_enough() -> None:
    still, moving = plane_clip(), plane_clip(slide=1.5)

    def read(index: int) -> Frame:
        frame, other = still.read_frame(index), moving.read_frame(index)
        frame.image[:40, 48:] = other.image[:40, 48:]
        return frame

    assert stillness([read(index) for index in range(N_FRAMES)]).displacement > 1


def test_what_cannot_be_compared_is_not_still() -> None:
    """A moving camera without depth; a picture without texture; no tissue."""
    assert measured(circle=3.0, has_depth=False).displacement == np.inf
    assert measured(has_depth=False).displacement < 0.1
    clip = plane_clip()
    frames = [clip.read_frame(index) for index in range(N_FRAMES)]
    for frame in frames:
        frame.tissue_mask[:] = False
    assert stillness(frames) == Stillness(np.inf, np.inf, (N_FRAMES, *SIZE))


@pytest.mark.parametrize("channels", [[1, 1, 1], [2, 1, 0]])
def test_frames_that_are_grey_or_never_redder_than_green_are_not_still(channels: list[int]) -> None:
    """In red minus green they show nothing, and no noise either, whatever moves."""
    clip = plane_clip(slide=1.5)
    frames = [clip.read_frame(index) for index in range(N_FRAMES)]
    for frame in frames:
        frame.image[:] = np.sort(frame.image, axis=2)[..., channels]
        frame.image[..., 0] = np.minimum(frame.image[..., 0], frame.image[..., 1])
    assert stillness(frames).displacement == np.inf


def test_one_frame_is_still_and_two_are_compared() -> None:
    clip = plane_clip(slide=1.0)
    assert stillness([clip.read_frame(0)]) == Stillness(0.0, 0.0)
    assert stillness([clip.read_frame(0), clip.read_frame(2)]).displacement > 0.5


def test_pictures_too_small_for_a_block_of_colours_tell_nothing() -> None:
    phantom = Phantom(PhantomParams(n_frames=10, width=64, height=48, tissue="static"))
    assert stillness([phantom.view(index).frame for index in range(10)]) == Stillness(
        np.inf, np.inf, (10, 64, 48)
    )


Plane = NDArray[np.float32]
Field = Callable[[int, Plane, Plane], Plane]


def displaced(
    aside: Field, count: int = 64, scale: int = 1, noise: float = 0.5, quality: int | None = None
) -> list[Frame]:
    """A picture of `scale` times 288 x 160 pixels whose tissue is `aside` px to the right.

    noise: in grey levels. quality: of the JPEG files it was kept in, if any.
    """
    frame = plane_clip().read_frame(0)
    tiled = np.tile(frame.image, (2, 3, 1)).repeat(scale, axis=0).repeat(scale, axis=1)
    picture = cv2.GaussianBlur(tiled, (0, 0), scale / 2)
    height, width = picture.shape[:2]
    mask, camera = np.ones((height, width), bool), frame.camera.resized(width, height)
    columns, rows = np.meshgrid(np.arange(width, dtype=np.float32), np.arange(height, dtype=np.float32))
    frames = []
    for index in range(count):
        moved = cv2.remap(
            picture, (columns - aside(index, columns, rows)).astype(np.float32), rows, cv2.INTER_CUBIC
        )
        noisy = moved + np.random.default_rng(index).normal(0, noise, picture.shape)
        image = np.rint(np.clip(noisy, 0, 255)).astype(np.uint8)
        if quality is not None:
            _, file = cv2.imencode(".jpg", image, [cv2.IMWRITE_JPEG_QUALITY, quality])
            image = np.asarray(cv2.imdecode(file, cv2.IMREAD_COLOR), np.uint8)
        frames.append(
            replace(
                frame,
                index=index,
                image=image,
                camera=camera,
                tissue_mask=mask,
                evaluation_mask=mask,
                depth=None,
            )
        )
    return frames


def rest(index: int, x: Plane, y: Plane) -> Plane:
    return np.zeros_like(x)


def test_tissue_that_is_aside_in_a_few_frames_moves() -> None:
    """12 px in 5 of 64 frames, wherever they are; even in a single one."""
    for away in (range(41, 46), range(5), range(59, 64), range(33, 34)):

        def aside(index: int, x: Plane, y: Plane, away: range = away) -> Plane:
            return rest(index, x, y) + np.float32(12 * (index in away))

        assert stillness(displaced(aside)).displacement > 1
    assert stillness(displaced(rest)).displacement < 0.15


@pytest.mark.parametrize("period", [4, 8, 9.3, 32])
def test_a_small_place_that_beats_moves(period: float) -> None:
    """Of 2 % of the picture, by 3 px each way."""

    def beating(index: int, x: Plane, y: Plane) -> Plane:
        place = np.exp(-((x - 120) ** 2 + (y - 70) ** 2) / (2 * 12**2))
        return np.asarray(3 * np.sin(2 * np.pi * index / period + 0.5) * place, np.float32)

    assert stillness(displaced(beating)).displacement > 1


@pytest.mark.parametrize(("noise", "quality"), [(0.5, None), (1, 80), (2, 60), (5, None)])
def test_a_place_of_20_pixels_that_beats_moves(noise: float, quality: int | None) -> None:
    """By 3 px each way, as does nothing that noise and the blocks of JPEG displace in tissue at rest."""

    def beating(index: int, x: Plane, y: Plane) -> Plane:
        place = np.exp(-((x - 60) ** 2 + (y - 100) ** 2) / (2 * 6**2))
        return np.asarray(3 * np.sin(2 * np.pi * index / 12.7) * place, np.float32)

    assert stillness(displaced(beating, noise=noise, quality=quality)).displacement > STILL
    assert stillness(displaced(rest, noise=noise, quality=quality)).displacement < STILL / 2


@pytest.mark.parametrize("scale", [1, 3])
def test_lengths_are_pixels_of_the_clip_at_any_size(scale: int) -> None:
    """Frames three times as large are compared at a third."""

    def aside(index: int, x: Plane, y: Plane) -> Plane:
        return rest(index, x, y) + np.float32(scale * (index == 3))

    found = stillness(displaced(aside, count=12, scale=scale))
    assert found.displacement == pytest.approx(scale, rel=0.15)
    assert found.compared == (12, 288, 160)


def test_what_a_large_frame_shows_at_a_low_resolution_lies_where_it_was() -> None:
    """A camera that circles, at twice the size: depth and cameras are scaled alike."""
    clip = plane_clip(circle=3.0)
    frames = []
    width, height = 4 * SIZE[0] + 1, 4 * SIZE[1] + 3
    for index in range(N_FRAMES):
        frame = clip.read_frame(index)
        image = cv2.copyMakeBorder(
            frame.image.repeat(4, axis=0).repeat(4, axis=1), 0, 3, 0, 1, cv2.BORDER_REPLICATE
        )
        lens = frame.camera.resized(4 * SIZE[0], 4 * SIZE[1])
        frames.append(
            replace(
                frame,
                image=np.asarray(image, np.uint8),
                camera=replace(lens, width=width, height=height),
                tissue_mask=np.ones((height, width), bool),
                evaluation_mask=np.ones((height, width), bool),
                depth=np.full((height, width), 50, np.float32),
            )
        )
    found = stillness(frames)
    assert found.displacement < 0.5
    assert found.compared == (N_FRAMES, width // 2, height // 2)
