"""The start from tracks: tissue is found to move as it does, rests where it rests, and no input breaks it."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Literal

import cv2
import numpy as np
import pytest

from renderer.camera import FloatArray
from renderer.clip import Frame
from renderer.deformation.nodes import attach, node_grid
from renderer.deformation.spline import FEWEST_PER_CONTROL, controls_for
from renderer.deformation.spline_motion import SplineMotion
from renderer.phantom import Phantom, PhantomParams, View
from renderer.train.config import TrainConfig
from renderer.train.curve_fit import Seen
from renderer.train.events import Finished
from renderer.train.flow_tracks import SMALLEST, tracks_from, view_of
from renderer.train.initialize import round_gaussians
from renderer.train.methods import recipe_for
from renderer.train.needs import STILL_TO_A_MOVING_CAMERA
from renderer.train.starting_motion import APART, Followed, StartingMotion
from renderer.train.training import train
from tests.renderer.sheet import moving_sheet, needs_of

FRAMES, CONTROLS, COLUMNS = 20, 8, 12
NEAR = 0.3
"""Millimetres on the tissue, within which two frames show the same point."""

Eye = Literal["fixed", "moving"]


@cache
def seen_by(camera: Eye, tissue: Literal["moving", "static"] = "moving") -> list[View]:
    params = PhantomParams(n_frames=FRAMES, width=160, height=128, camera=camera, tissue=tissue)
    phantom = Phantom(params)
    return [phantom.view(index) for index in range(FRAMES)]


def motion_of(frames: list[Frame]) -> StartingMotion:
    return Followed.of(frames, COLUMNS).motion(CONTROLS)


def followed(views: list[View], count: int = 60) -> list[tuple[FloatArray, FloatArray]]:
    """Of points of the first frame: positions (P, 3) at the times (P,) that show them."""
    points = [view.frame.camera.unproject(view.frame.depth).reshape(-1, 3) for view in views]  # type: ignore[arg-type]
    shown = np.flatnonzero(views[0].frame.tissue_mask)
    out = []
    for pixel in np.random.default_rng(0).choice(shown, count, replace=False):
        material = views[0].material.reshape(-1, 2)[pixel]
        positions, times = [], []
        for view, where in zip(views, points, strict=True):
            apart = np.linalg.norm(view.material.reshape(-1, 2) - material, axis=1)
            nearest = int(np.where(view.frame.tissue_mask.reshape(-1), apart, np.inf).argmin())
            if apart[nearest] < NEAR:
                positions.append(where[nearest])
                times.append(view.frame.time)
        out.append((np.array(positions), np.array(times)))
    return out


def spread(positions: FloatArray) -> float:
    return float(np.sqrt(np.square(positions - positions.mean(axis=0)).sum(axis=1).mean()))


@pytest.mark.parametrize("camera", ["fixed", "moving"])
def test_a_point_of_tissue_rests_in_one_place(camera: Eye) -> None:
    views = seen_by(camera)
    motion = motion_of([view.frame for view in views])
    before, after = [], []
    for positions, times in followed(views):
        rest = [
            motion.at_rest(place[None], float(time))[0] for place, time in zip(positions, times, strict=True)
        ]
        before.append(spread(positions))
        after.append(spread(np.array(rest, np.float64)))
    assert np.mean(before) > 1
    assert np.mean(after) < 0.25 * np.mean(before)


def test_tissue_at_rest_gets_no_motion() -> None:
    """But what shading does that follows the lamp."""
    views = seen_by("moving", "static")
    motion = motion_of([view.frame for view in views])
    pixel = np.median(views[0].frame.depth[views[0].frame.depth_mask]) / views[0].frame.camera.fx  # type: ignore[index]
    assert np.percentile(np.abs(motion.controls), 95) < STILL_TO_A_MOVING_CAMERA * pixel


def test_the_motion_takes_what_rests_to_where_it_was_seen() -> None:
    views = seen_by("fixed")
    frames = [view.frame for view in views]
    motion, camera = motion_of(frames), frames[0].camera
    points = camera.unproject(frames[7].depth).reshape(-1, 3)[frames[7].tissue_mask.reshape(-1)][::97]  # type: ignore[arg-type]
    resting = motion.at_rest(points, frames[7].time)
    indices, weights = attach(resting, camera, motion.grid)
    none = np.zeros((0, CONTROLS, 3), np.float32)
    curves = SplineMotion(none, none, none[:, :, :1], motion.controls, indices, weights)
    raw = round_gaussians(resting, np.ones(len(resting)), np.zeros_like(resting), 0.5)
    moved = curves.moved(raw, frames[7].time).means
    assert np.abs(resting - points).max() > 1
    assert np.abs(moved - points).max() < 0.02 * np.abs(resting - points).max()


@pytest.mark.parametrize(
    ("beats", "pixels", "more"),
    [(1.0, 20.0, False), (9.0, 20.0, True), (9.0, 0.05, False), (0.0, 0.0, False)],
)
def test_curves_are_as_dense_as_the_motion_is_fast(beats: float, pixels: float, more: bool) -> None:
    camera, n_frames = seen_by("fixed")[0].frame.camera, 64
    grid = node_grid(camera, COLUMNS)
    times = np.arange(n_frames) / (n_frames - 1)
    way = pixels * np.sin(2 * np.pi * beats * times)
    shifts = np.broadcast_to(way[:, None, None], (n_frames, grid[0] * grid[1], 3)).copy()
    rng = np.random.default_rng(0)
    shifts += rng.normal(0, 0.02 * pixels, shifts.shape)
    seen = tuple(
        Seen(place, slice(0, n_frames), shifts - shifts[place], np.ones(shifts.shape[:2]))
        for place in range(APART // 2, n_frames, APART)
    )
    count = Followed(camera, grid, tuple(times), 1.0, seen).controls_for(n_frames)
    assert (count > controls_for(n_frames)) == more
    assert count <= controls_for(n_frames, FEWEST_PER_CONTROL)


def test_threads_make_no_difference() -> None:
    frames = [view.frame for view in seen_by("fixed")]
    before = cv2.getNumThreads()
    try:
        cv2.setNumThreads(1)
        alone = motion_of(frames).controls
        cv2.setNumThreads(3)
        assert np.array_equal(motion_of(frames).controls, alone)
    finally:
        cv2.setNumThreads(before)


def test_tracks_keep_off_tools_and_what_has_no_depth() -> None:
    first, second = (view.frame for view in seen_by("fixed")[:2])
    whole = tracks_from([view_of(first), view_of(second)], 0)[1]
    depth = first.depth.copy()  # type: ignore[union-attr]
    depth[:, :80] = 0
    half = tracks_from([view_of(replace(first, depth=depth)), view_of(second)], 0)[1]
    assert 0 < len(half.start) < len(whole.start)
    pixels, _ = first.camera.project(half.start.astype(np.float64))
    assert pixels[:, 0].min() > 80
    tools = ~first.tissue_mask
    assert tools.any()
    shown = np.floor(first.camera.project(whole.start.astype(np.float64))[0]).astype(int)
    assert not tools[shown[:, 1], shown[:, 0]].any()


@pytest.mark.parametrize("size", [(1, 1), (9, 64), (64, 12), (SMALLEST, SMALLEST), (400, 8)])
def test_frames_of_any_size_have_a_start(size: tuple[int, int]) -> None:
    width, height = size
    camera = seen_by("fixed")[0].frame.camera.resized(width, height)
    rng = np.random.default_rng(0)
    keep = np.ones((height, width), bool)
    frames = [
        Frame(
            index, index / 5, rng.integers(0, 255, (height, width, 3), np.uint8), camera, keep, keep,
            np.full((height, width), 50, np.float32),
        )
        for index in range(5)
    ]  # fmt: skip
    controls = motion_of(frames).controls
    assert np.isfinite(controls).all()
    if min(size) < SMALLEST:
        assert not controls.any()


def test_without_depth_or_with_one_frame_nothing_is_known_to_move() -> None:
    frames = [view.frame for view in seen_by("fixed")]
    blind = [replace(frame, depth=None) for frame in frames[1:]]
    assert not motion_of([frames[0], *blind]).controls.any()
    assert Followed.of([frames[0], *blind], COLUMNS).controls_for(20) == controls_for(20)
    assert not motion_of(frames[:1]).controls.any()


def test_the_start_from_tracks_is_left_out_by_name() -> None:
    clip = moving_sheet()
    config = TrainConfig(n_gaussians=100, keep=("deformation",))
    frames = [clip.read_frame(index) for index in range(len(clip))]
    starts = []
    for given in (config, replace(config, leave_out=("tracks",))):
        needs = needs_of(clip, given)
        recipe = recipe_for(given, needs)
        motion = recipe.make_trainer(recipe.initialize(frames), frames, 50.0).motion
        assert isinstance(motion, SplineMotion)
        starts.append(motion.node_controls)
        told = [omission.why for omission in needs.omitted if omission.what == "start from tracks"]
        assert told == (["as requested"] if given.leave_out else [])
    assert starts[0].any()
    assert not starts[1].any()


def test_a_run_that_goes_on_looks_for_no_tracks(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """What they gave is in its checkpoint."""
    config = TrainConfig(iterations=6, n_gaussians=100, keep=("deformation",))
    monkeypatch.setattr(Followed, "controls_for", lambda followed, n_frames: 9)
    folder = tmp_path / "run"
    folder.mkdir()
    *_, whole = train(moving_sheet(), config, folder=folder)
    monkeypatch.setattr(Followed, "of", None)
    *_, last = train(moving_sheet(), config, folder=folder, resume=True)
    assert isinstance(whole, Finished)
    assert isinstance(last, Finished)
    ends = whole.model.arrays(), last.model.arrays()
    assert all(np.array_equal(ends[0][name], ends[1][name]) for name in ends[0])
    with pytest.raises(TypeError):
        list(train(moving_sheet(), config))
