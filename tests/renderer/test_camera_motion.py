"""A camera that is said to stand still and does not is noticed; tissue that moves is no camera."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Literal

import cv2
import numpy as np
import pytest

from renderer.camera_motion import camera_motion, contradicted
from renderer.clip import ByteImage, Clip, Frame
from renderer.evenly import evenly
from renderer.phantom import Phantom, PhantomParams
from renderer.readers.image_folders.frames import open_images
from renderer.readers.video import open_video
from renderer.sources import open_clip

DATA = Path(__file__).resolve().parents[2] / "../shared/data"
PULLING = DATA / "endonerf/pulling_soft_tissues"
SINUS = DATA / "clips/sinus_moving_camera"
LAPAROSCOPY = DATA / "clips/laparoscopy_1280x720.mp4"

SEED = 7
"""Of none of the phantoms on which the bounds were chosen."""


COUNT = 12


@cache
def phantom(camera: Literal["fixed", "moving"], tissue: Literal["moving", "static"]) -> Phantom:
    params = PhantomParams(n_frames=COUNT, width=160, height=128, seed=SEED, camera=camera, tissue=tissue)
    return Phantom(params)


@cache
def drawn(scene: Phantom, index: int) -> Frame:
    return scene.view(index).frame


def clip_of(scene: Phantom, *, said_fixed: bool = True, has_depth: bool = True) -> Clip:
    """A phantom as a clip, with its poses erased when its camera is said to be fixed."""
    cameras = tuple(scene.camera(0 if said_fixed else index) for index in range(COUNT))

    def read_frame(index: int) -> Frame:
        frame = replace(drawn(scene, index), camera=cameras[index])
        return frame if has_depth else replace(frame, depth=None)

    return Clip(
        name="phantom",
        path=Path("phantom"),
        format="endonerf",
        cameras=cameras,
        read_frame=read_frame,
        read_image=lambda index: read_frame(index).image,
        labels=tuple(map(str, range(COUNT))),
        has_depth=has_depth,
        unit="mm",
    )


def camera_notice(clip: Clip) -> str | None:
    moves = camera_motion(clip)
    return None if moves is None else contradicted(moves)


@pytest.mark.parametrize("tissue", ["moving", "static"])
def test_a_camera_whose_poses_are_erased_is_noticed(tissue):
    notice = camera_notice(clip_of(phantom("moving", tissue)))
    assert notice is not None
    assert "fixed camera" in notice
    assert "\n" not in notice


def test_tissue_that_moves_is_no_camera():
    assert camera_notice(clip_of(phantom("fixed", "moving"))) is None


def test_poses_that_are_known_need_no_notice():
    assert camera_notice(clip_of(phantom("moving", "static"), said_fixed=False)) is None


def test_depth_that_may_be_a_guess_is_no_witness():
    clip = clip_of(phantom("moving", "static"))
    assert camera_notice(replace(clip, unit="scene units")) is None


def test_depth_in_other_units_gives_the_same_notice():
    clip = clip_of(phantom("moving", "static"))

    def in_metres(index: int) -> Frame:
        frame = clip.read_frame(index)
        assert frame.depth is not None
        return replace(frame, depth=frame.depth / np.float32(1000))

    assert camera_notice(replace(clip, read_frame=in_metres)) == camera_notice(clip)


def test_nothing_is_said_of_what_cannot_be_tracked():
    clip = clip_of(phantom("moving", "static"), has_depth=False)
    rng = np.random.default_rng(0)

    def noise(index: int) -> Frame:
        frame = clip.read_frame(index)
        return replace(frame, image=rng.integers(0, 256, frame.image.shape).astype(np.uint8))

    def black(index: int) -> Frame:
        frame = clip.read_frame(index)
        return replace(frame, image=np.zeros_like(frame.image))

    assert camera_notice(replace(clip, read_frame=noise)) is None
    assert camera_notice(replace(clip, read_frame=black)) is None
    assert camera_notice(clip.every(100)) is None


def test_a_view_that_slides_is_noticed_without_depth():
    clip = clip_of(phantom("fixed", "moving"), has_depth=False)
    wide = clip.read_frame(0).image

    def slid(index: int) -> Frame:
        image = np.roll(wide, -2 * index, axis=1)
        every = np.ones(image.shape[:2], dtype=bool)
        return Frame(index, index / COUNT, image, clip.cameras[index], every, every)

    notice = camera_notice(replace(clip, read_frame=slid))
    assert notice is not None
    assert "14 % of the image width" in notice


def moved_at(clip: Clip, frames: range) -> Clip:
    """With another view in these frames."""

    def read_frame(index: int) -> Frame:
        frame = clip.read_frame(0)
        turned = np.ascontiguousarray(frame.image[::-1, ::-1])
        return replace(frame, index=index, image=turned if index in frames else frame.image)

    return replace(clip, read_frame=read_frame)


@pytest.mark.parametrize("frames", [range(8, 12), range(5, 9)])
def test_a_view_that_jumps_is_noticed(frames):
    clip = clip_of(phantom("fixed", "static"), has_depth=False)
    before = max(index for index in clip.train_indices if index < frames.start)
    wanted = f"the view jumps between the frames {before} and {frames.start}"
    assert camera_motion(moved_at(clip, frames)) == wanted
    assert camera_motion(moved_at(clip, range(0))) is None


@pytest.mark.parametrize("tissue", ["moving", "static"])
@pytest.mark.parametrize("share", [0.6, 0.7, 0.8])
def test_a_view_that_is_covered_from_some_frame_on_does_not_jump(tissue, share):
    clip = clip_of(phantom("fixed", tissue))

    def covered(index: int) -> Frame:
        frame = clip.read_frame(index)
        image, columns = frame.image.copy(), round(share * frame.image.shape[1])
        if index >= COUNT // 2:
            image[:, :columns] = frame.image[::-1, ::-1][:, :columns]
        return replace(frame, image=image)

    assert camera_motion(replace(clip, read_frame=covered)) is None


@pytest.mark.parametrize("tissue", ["moving", "static"])
@pytest.mark.parametrize("share", [0.6, 0.9])
def test_a_view_that_is_nearly_covered_for_some_frames_does_not_jump(tissue, share):
    clip = clip_of(phantom("fixed", tissue))

    def covered(index: int) -> Frame:
        frame = clip.read_frame(index)
        image, columns = frame.image.copy(), round(share * frame.image.shape[1])
        if index in range(5, 9):
            image[:, :columns] = drawn(phantom("fixed", tissue), 0).image[::-1, ::-1][:, :columns]
        return replace(frame, image=image)

    assert camera_motion(replace(clip, read_frame=covered)) is None


def again_and_again(clip: Clip, times: int) -> Clip:
    """So that many frames lie between those that are looked at first."""

    def read_frame(index: int) -> Frame:
        frame = clip.read_frame(index % COUNT)
        return replace(frame, index=index, time=index / (times * COUNT))

    return replace(
        clip,
        cameras=clip.cameras * times,
        labels=tuple(map(str, range(times * COUNT))),
        read_frame=read_frame,
        read_image=lambda index: read_frame(index).image,
    )


@pytest.mark.parametrize("farthest", [12, 30])
def test_a_camera_that_glides_away_and_comes_back_between_two_looks_is_noticed(farthest):
    clip = again_and_again(clip_of(phantom("fixed", "static"), has_depth=False), 20)
    moments = evenly(clip.train_indices, 13)
    first, last = moments[6] + 1, moments[7] - 1
    assert last - first > 12

    def read_image(index: int) -> ByteImage:
        share = (index - first) / (last - first)
        away = round(farthest * np.sin(np.pi * share)) if 0 <= share <= 1 else 0
        return np.roll(clip.read_image(index), away, axis=1)

    moves = camera_motion(replace(clip, read_image=read_image))
    assert moves is not None
    assert moves.endswith("% of the image width and comes back")
    assert camera_motion(clip) is None


def test_tissue_that_moves_between_two_looks_is_no_camera():
    assert camera_motion(again_and_again(clip_of(phantom("fixed", "moving")), 10)) is None


def test_a_swab_that_sweeps_through_between_two_looks_is_no_camera():
    clip = again_and_again(clip_of(phantom("fixed", "moving"), has_depth=False), 20)
    coarse = np.random.default_rng(0).integers(150, 235, (32, 24, 3), dtype=np.uint8)
    swab = cv2.resize(coarse, (96, 128), interpolation=cv2.INTER_CUBIC)

    def read_image(index: int) -> ByteImage:
        start = 160 - round(index % 110 / 110 * (160 + 96))
        left, right = max(start, 0), min(start + 96, 160)
        image = clip.read_image(index).copy()
        image[:, left:right] = swab[:, left - start : right - start]
        return image

    def read_frame(index: int) -> Frame:
        return replace(clip.read_frame(index), image=read_image(index))

    assert camera_motion(replace(clip, read_frame=read_frame, read_image=read_image)) is None


def test_another_scene_is_a_jump():
    clip, params = clip_of(phantom("fixed", "static")), PhantomParams(n_frames=COUNT, width=160, height=128)
    other = clip_of(Phantom(params))

    def cut(index: int) -> Frame:
        return (clip if index < COUNT // 2 else other).read_frame(index)

    assert camera_motion(replace(clip, read_frame=cut)) == "the view jumps between the frames 5 and 6"


def test_short_blackouts_hide_no_motion_and_are_none():
    def blinking(clip: Clip) -> Clip:
        def read_frame(index: int) -> Frame:
            frame = clip.read_frame(index)
            return replace(frame, image=frame.image * np.uint8(index not in (0, 5, 6)))

        return replace(clip, read_frame=read_frame)

    assert camera_notice(blinking(clip_of(phantom("moving", "static")))) is not None
    assert camera_notice(blinking(clip_of(phantom("fixed", "moving")))) is None


@pytest.mark.data
@pytest.mark.skipif(not DATA.is_dir(), reason="the real clips are not there")
def test_real_clips():
    assert camera_notice(open_clip(PULLING)) is None
    assert camera_notice(open_images(SINUS)) is not None
    assert camera_notice(open_clip(SINUS)) is None
    assert camera_notice(open_video(LAPAROSCOPY)) is not None
