"""A model by its windows: all of it at one time, each by its own clock."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from itertools import pairwise

import numpy as np
import pytest

from renderer.editing.edits import Edits
from renderer.editing.highlight import COLOR, OWN, highlighted
from renderer.editing.mask import Mask
from renderer.editing.regions import Present, Rectangle, found
from renderer.editing.sight import Sight, Trail
from renderer.gaussians import DynamicGaussians
from renderer.model_windows import first_at, handover, there_at, whole_at, window_at, windows_of
from tests.renderer import test_gaussians
from tests.renderer.editing.models import models
from tests.renderer.scenes import turned_camera
from tests.renderer.windowed import windowed

FRAMES = 100
PARTS = ((0, 44, 50), (30, 79, 40), (64, 99, 70))
"""First and last frame, Gaussians."""
WITHIN = (0.1, 0.55, 0.9)
"""A time of each window at which it is alone."""
BETWEEN = 0.375
"""A time at which the first two are there."""


@cache
def parts() -> tuple[DynamicGaussians, ...]:
    return tuple(test_gaussians.model(count) for _, _, count in PARTS)


@cache
def model() -> DynamicGaussians:
    return windowed(
        FRAMES, *((first, last, part) for (first, last, _), part in zip(PARTS, parts(), strict=True))
    )


def clock(window: int, time: float) -> float:
    """The time of a window, from its frames."""
    first, last, _ = PARTS[window]
    return min(max((FRAMES * time - first) / (last - first + 1), 0.0), 1.0)


@pytest.mark.parametrize("time", [0.0, 0.1, 0.35, 0.4, 0.6, 0.7, 0.9, 1.0])
def test_all_of_it_is_each_window_at_its_nearest_moment(time: float) -> None:
    splats = whole_at(model(), time)
    for window, (got, part) in enumerate(zip(windows_of(model()), parts(), strict=True)):
        own = part.at(clock(window, time))
        assert np.array_equal(splats.means[got.rows], own.means)
        assert np.array_equal(splats.opacities[got.rows], own.opacities)
        assert got.local(time) == pytest.approx(clock(window, time), abs=1e-12)
        assert np.array_equal(got.model.at(0.3).means, part.at(0.3).means)
    there = there_at(model(), time)
    assert np.array_equal(splats.means[there], model().at(time).means)


def test_the_next_window_takes_over_in_the_middle_of_the_overlap() -> None:
    windows = windows_of(model())
    times = [handover(window) for window in windows[:-1]]
    assert times == pytest.approx([0.375, 0.715])
    for index, time in enumerate(times):
        assert window_at(model(), time - 0.001).index == index
        assert window_at(model(), time + 0.001).index == index + 1
    assert [window_at(model(), time).index for time in (0.0, *WITHIN, 1.0)] == [0, 0, 1, 2, 2]
    assert all(former.time(1.0) > latter.time(0.0) for former, latter in pairwise(windows))


def test_each_frame_shows_one_window_and_in_models_of_before_all_of_an_overlap_shows_two() -> None:
    windows = windows_of(model())
    assert [one.seen_frames(FRAMES) for one in windows] == [range(38), range(38, 72), range(72, FRAMES)]
    for one in windows:
        shown = one.seen_frames(FRAMES)
        assert [one.fade(frame / FRAMES) for frame in range(FRAMES)] == [
            float(frame in shown) for frame in range(FRAMES)
        ]
    motion = replace(model().motion, fade=None)  # type: ignore[type-var]
    before = windows_of(DynamicGaussians(model().raw, motion))
    assert [one.seen_frames(FRAMES) for one in before] == [one.frames(FRAMES) for one in windows]
    assert [one.shown for one in before] == [None] * 3


@pytest.mark.parametrize("kind", ["still", "spline", "flexible", "hexplane"])
def test_a_model_that_is_not_cut_is_one_window(kind: str) -> None:
    whole = models()[kind]
    (window,) = windows_of(whole)
    assert window.model is whole
    assert window.rows == slice(0, len(whole))
    assert (window.shown, window.seen_frames(7)) == (None, range(7))
    assert (window.local(0.3), window.time(0.3)) == (0.3, 0.3)
    assert there_at(whole, 0.3).all()
    assert np.array_equal(whole_at(whole, 0.3).means, whole.at(0.3).means)
    assert np.array_equal(first_at(whole, 0.3).means, whole.at(0.0).means)


def test_motion_begins_anew_in_each_window() -> None:
    for time, window in zip(WITHIN, parts(), strict=True):
        assert np.array_equal(first_at(model(), time).means, window.at(0.0).means)
    both = first_at(model(), BETWEEN).means
    assert np.array_equal(both, np.concatenate([part.at(0.0).means for part in parts()[:2]]))
    times = tuple(np.linspace(0, 1, 7))
    own = [Trail(part, times).amplitudes for part in parts()]
    assert np.array_equal(Trail(model(), times).amplitudes, np.concatenate(own))


def sight(time: float) -> Sight:
    camera = turned_camera(64, 48, focal=30.0)
    pose = camera.camera_from_world.copy()
    pose[:3, 3] = np.array([0.0, 0.0, 3.0]) - pose[:3, :3] @ np.median(model().means, axis=0)
    return Sight.of(Trail(model(), (0.0, 1.0)), camera.moved(pose), time, 0.1)


def test_a_selection_takes_all_windows_or_the_present_one_alone() -> None:
    seen = sight(0.1)
    left = Rectangle(-1e9, -1e9, 32.0, 1e9)
    chosen = found(left, seen)
    rows = [window.rows for window in windows_of(model())]
    counts = [int(chosen.booleans()[row].sum()) for row in rows]
    assert all(0 < count < part[2] for count, part in zip(counts, PARTS, strict=True))
    edits = Edits.none(len(model())).selecting(chosen, "replace")
    kept = edits.selecting(found(Present(), seen), "intersect").selected
    assert kept.indices().tolist() == chosen.indices()[: counts[0]].tolist()
    here = found(Present(), sight(BETWEEN))
    assert here == Mask.of(np.arange(len(model())) < PARTS[0][2] + PARTS[1][2])


def test_what_is_deleted_is_gone_at_all_times_and_the_rest_moves_as_before() -> None:
    gone = Mask.of(np.arange(len(model())) % 3 == 0)
    edits = Edits.none(len(model())).selecting(gone, "replace").deleting()
    left = edits.applied(model())
    for time in (0.0, BETWEEN, 0.55, 0.9):
        whole, kept = model().at(time), (~gone.booleans())[there_at(model(), time)]
        assert 0 < kept.sum() < len(kept)
        assert np.array_equal(left.at(time).means, whole.means[kept])
        assert np.array_equal(left.at(time).colors, whole.colors[kept])
    empty = Edits.none(len(model())).selecting(found(Present(), sight(0.1)), "replace").deleting()
    without = empty.applied(model())
    assert len(without.at(0.1)) == len(first_at(without, 0.1)) == 0
    assert np.array_equal(without.at(0.9).means, model().at(0.9).means)
    assert len(whole_at(without, 0.1)) == len(without) == PARTS[1][2] + PARTS[2][2]


def test_what_is_selected_is_coloured_in_every_window() -> None:
    chosen = np.arange(len(model())) % 2 == 0
    tinted = highlighted(model(), chosen)
    for time in (*WITHIN, 0.36):
        seen, own = tinted.at(time), model().at(time)
        some = chosen[there_at(model(), time)]
        np.testing.assert_array_equal(seen.colors[~some], own.colors[~some])
        mixed = OWN * own.colors[some] + (1 - OWN) * np.array(COLOR)
        np.testing.assert_allclose(seen.colors[some], mixed, atol=1e-5)
        assert np.array_equal(seen.means, own.means)
