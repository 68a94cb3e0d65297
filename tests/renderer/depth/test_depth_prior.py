"""Depth by brightness: exact on a lit plane, right in rank on the phantom, and without a scale."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from renderer.camera import Camera
from renderer.clip import Clip, ClipError, Frame
from renderer.depth.depth_prior import brightness_guess, depth_from_brightness, with_guessed_depth
from renderer.phantom import Phantom, PhantomParams

SAID = "guessed"


def clip_of(frames: list[Frame]) -> Clip:
    return Clip(
        name="made",
        path=Path("made"),
        format="images",
        cameras=tuple(frame.camera for frame in frames),
        read_frame=lambda index: replace(frames[index], index=index, time=index / len(frames)),
        read_image=lambda index: frames[index].image,
        labels=tuple(f"{index}.png" for index in range(len(frames))),
        has_depth=False,
        unit="scene units",
    )


def encoded(linear: np.ndarray) -> np.ndarray:
    """Linear light to sRGB bytes (IEC 61966-2-1)."""
    light = np.clip(linear, 0, 1)
    level = np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055)
    return np.rint(255 * level).astype(np.uint8)


def decoded(image: np.ndarray) -> np.ndarray:
    level = image / 255
    return np.where(level <= 0.04045, level / 12.92, ((level + 0.055) / 1.055) ** 2.4)


def lit_plane(near: float = 40.0, gain: float = 600.0) -> Frame:
    """Even tissue on a plane that leans away, its light gain cos^2 / r^2 for a lamp at the camera."""
    camera = Camera(150, 150, 70, 66, 160, 128)
    x = (np.arange(160) + 0.5 - 70) / 150
    y = ((np.arange(128) + 0.5 - 66) / 150)[:, None]
    depth = near / (1 - 0.35 * x - 0.2 * y)
    widened = 1 + x * x + y * y
    image = encoded((gain / (depth * widened) ** 2)[:, :, None] * [1.0, 0.55, 0.45])
    everything = np.ones((128, 160), dtype=bool)
    return Frame(0, 0.0, image, camera, everything, everything, depth.astype(np.float32))


def depth_of(frame: Frame) -> np.ndarray:
    assert frame.depth is not None
    return frame.depth


def rank_correlation(one: np.ndarray, other: np.ndarray) -> float:
    ranks = [np.argsort(np.argsort(values, kind="stable"), kind="stable") for values in (one, other)]
    return float(np.corrcoef(ranks)[0, 1])


def guessed(frames: list[Frame]) -> list[np.ndarray]:
    clip = with_guessed_depth(clip_of(frames), depth_from_brightness, SAID)
    return [depth_of(clip.read_frame(index)) for index in range(len(frames))]


def test_an_even_plane_is_found_up_to_its_scale():
    """Away from the border, over which the window averages one side only."""
    frame = lit_plane()
    inner = (slice(24, -24), slice(24, -24))
    ratio = depth_from_brightness(frame)[inner] / depth_of(frame)[inner]
    assert np.abs(ratio / np.median(ratio) - 1).max() < 0.04


def test_the_phantom_in_rank():
    """Far is dark, in spite of vessels, fat, slopes, reflections and vignetting."""
    correlations = []
    for seed in range(41, 45):
        frame = Phantom(PhantomParams(n_frames=1, width=96, height=80, seed=seed)).view(0).frame
        tissue = frame.tissue_mask
        (guess,) = guessed([frame])
        correlations.append(rank_correlation(guess[tissue], depth_of(frame)[tissue]))
        assert (guess[tissue] > 0).all()
        assert not guess[~tissue].any()
        assert np.median(guess[tissue]) == pytest.approx(1, abs=0.01)
    assert min(correlations) > 0.2
    assert np.mean(correlations) > 0.5


@pytest.mark.parametrize("gain", [0.25, 0.6])
def test_exposure_changes_nothing(gain):
    """Up to the rounding to bytes."""
    frame = Phantom(PhantomParams(n_frames=1, width=160, height=128, seed=44, tools=0, noise=0)).view(0).frame
    dimmed = replace(frame, image=encoded(gain * decoded(frame.image)))
    same, darker = guessed([frame])[0], guessed([dimmed])[0]
    # The margin of a reflection may differ by a few pixels.
    assert np.abs(darker / same - 1).max() < 0.05
    assert np.abs(darker / same - 1).mean() < 0.005


def test_one_scale_for_the_clip():
    """A plane at twice the distance keeps its ratio to the near one, and equal frames stay equal."""
    near, far = lit_plane(30.0), lit_plane(60.0)
    depths = guessed([near, near, far, far])
    np.testing.assert_array_equal(depths[0], depths[1])
    middle = (64, 70)
    assert depths[3][middle] / depths[0][middle] == pytest.approx(2, rel=0.03)


def test_reflections_take_the_depth_around_them():
    frame = lit_plane()
    image = frame.image.copy()
    image[60:66, 76:82] = 255
    plain, shining = guessed([frame])[0], guessed([replace(frame, image=image)])[0]
    assert np.abs(shining / plain - 1).max() < 0.01


def test_no_depth_off_the_tissue_and_in_the_black():
    frame = lit_plane()
    image, tissue = frame.image.copy(), frame.tissue_mask.copy()
    image[:, :50] = 0
    tissue[:30] = False
    (depth,) = guessed([replace(frame, image=image, tissue_mask=tissue)])
    assert not depth[:, :50].any()
    assert not depth[:30].any()
    assert (depth[30:, 50:] > 0).all()
    assert np.isfinite(depth).all()


def test_what_a_surround_shows_changes_no_depth_of_tissue():
    """Round views of a plane: in black, and in the noise that some endoscopes show instead."""
    rows, columns = np.indices((128, 160))
    inside = (rows - 64) ** 2 + (columns - 80) ** 2 < 58**2
    frames = [lit_plane(near) for near in (40.0, 44.0, 48.0)]
    noise = np.random.default_rng(0).integers(0, 25, (3, 128, 160, 3), dtype=np.uint8)
    found = []
    for around in (np.zeros_like(noise), noise):
        round_views = [
            replace(frame, image=np.where(inside[:, :, None], frame.image, levels))
            for frame, levels in zip(frames, around, strict=True)
        ]
        clip = clip_of(round_views)
        seen = with_guessed_depth(clip, brightness_guess(clip), SAID)
        found.append([depth_of(seen.read_frame(index)) for index in range(3)])
    for black, noisy in zip(*found, strict=True):
        np.testing.assert_array_equal(noisy, black)
        assert (black[inside] > 0).mean() > 0.95
        assert not black[~inside].any()


def test_the_range_is_cut_to_percentiles():
    """A dark corner does not lie at infinity."""
    frame = lit_plane()
    image = frame.image.copy()
    image[:4, :4] = 12
    (depth,) = guessed([replace(frame, image=image)])
    raw = depth_from_brightness(replace(frame, image=image))
    limits = np.percentile(raw, [1, 99]) / np.median(raw)
    np.testing.assert_allclose([depth.min(), depth.max()], limits, rtol=1e-5)


def test_what_the_clip_says_of_itself():
    clip = with_guessed_depth(clip_of([lit_plane()]), depth_from_brightness, SAID)
    assert (clip.has_depth, clip.unit) == (True, "scene units")
    assert clip.notices == (SAID,)


def test_a_moving_camera_and_a_black_clip_are_refused():
    frame = lit_plane()
    moved = np.eye(4)
    moved[0, 3] = 5
    moving = [frame, replace(frame, camera=frame.camera.moved(moved))]
    with pytest.raises(ClipError, match="fixed camera"):
        guessed(moving)
    with pytest.raises(ClipError, match="expected lit tissue"):
        guessed([replace(frame, image=np.zeros_like(frame.image))])
