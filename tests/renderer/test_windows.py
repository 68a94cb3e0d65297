"""Long clips in windows: how they are cut, what moves in them, and training that is cut short."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from renderer.camera import FloatArray
from renderer.clip import Clip, ClipError, Frame, within
from renderer.deformation.windowed_motion import WindowedMotion
from renderer.gaussians import DynamicGaussians
from renderer.model_windows import windows_of as windows_of_model
from renderer.near_plane import middle_distance
from renderer.train.config import TrainConfig
from renderer.train.events import Evaluated, Finished, Progress, Snapshot, Started, TrainEvent, Warned
from renderer.train.trainer import TrainingError
from renderer.train.training import train
from renderer.train.window_files import FOLDER, in_windows, next_of, unfinished
from renderer.train.windows import OVERLAP, SHORTEST, Window, cut, left_out, new_views, windows_of
from tests.renderer.plane import plane_clip

FRAMES, STEPS = 112, 6
CONFIG = TrainConfig(
    iterations=STEPS, n_gaussians=60, node_columns=4, window_frames=SHORTEST, checkpoint_every=2
)


def long_clip() -> Clip:
    """The plane's frames again and again."""
    short = plane_clip(slide=4.0)

    def read_frame(index: int) -> object:
        return replace(short.read_frame(index % len(short)), index=index, time=index / FRAMES)

    return replace(
        short,
        cameras=short.cameras[:1] * FRAMES,
        labels=tuple(map(str, range(FRAMES))),
        read_frame=read_frame,  # type: ignore[arg-type]
    )


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> tuple[list[TrainEvent], Path]:
    folder = tmp_path_factory.mktemp("run")
    return list(train(long_clip(), CONFIG, folder=folder)), folder


def model_of(events: list[TrainEvent]) -> DynamicGaussians:
    assert isinstance(events[-1], Finished)
    return events[-1].model


def same(one: DynamicGaussians, other: DynamicGaussians) -> bool:
    arrays, others = one.arrays(), other.arrays()
    return set(arrays) == set(others) and all(
        arrays[name].tobytes() == others[name].tobytes() for name in arrays
    )


@given(st.integers(1, 5000), st.integers(SHORTEST, 600))
def test_windows_hold_every_frame_and_overlap_none_but_their_neighbours(count: int, longest: int) -> None:
    windows = cut(np.full(count, 1 / longest))
    assert windows[0].first == 0
    assert windows[-1].last == count - 1
    assert all(later.first <= former.last + 1 - OVERLAP for former, later in pairwise(windows))
    assert all(later.first > former.last for former, later in zip(windows, windows[2:], strict=False))
    assert all(window.first % 8 == 0 for window in windows)
    assert max(map(len, windows)) < longest + 2 * OVERLAP


@given(st.integers(SHORTEST, 1500), st.integers(0, 99))
def test_windows_are_shorter_where_there_is_more_to_see(count: int, seed: int) -> None:
    shares = np.random.default_rng(seed).exponential(0.01, count)
    shares[: count // 2] *= 5
    windows = cut(shares)
    assert (windows[0].first, windows[-1].last) == (0, count - 1)
    assert all(later.first == former.last + 1 - OVERLAP for former, later in pairwise(windows))
    assert all(window.first % 8 == 0 and len(window) >= SHORTEST for window in windows)
    if len(windows) > 1:
        assert len(windows[0]) <= max(len(windows[-1]), SHORTEST) + OVERLAP


def test_a_camera_that_travels_sees_new_views() -> None:
    clip = plane_clip()
    still, width = clip.cameras[0], clip.size[0] * 50.0 / clip.cameras[0].fx
    moved = []
    for index in range(len(clip)):
        pose = np.eye(4)
        pose[0, 3] = -0.25 * width * index
        moved.append(still.moved(pose))
    assert not new_views(clip).any()
    seen = new_views(clip.through(tuple(moved)))
    assert seen[0] == 0
    assert seen[1:] == pytest.approx(0.25, abs=0.06)


def test_windows_hold_out_the_frames_that_the_clip_does() -> None:
    clip = long_clip()
    held = {
        window.first + index for window in windows_of(clip, CONFIG) for index in window.of(clip).test_indices
    }
    assert held == set(clip.test_indices)


def test_a_window_of_which_hardly_any_frame_counts_goes_on_the_one_before() -> None:
    clip = long_clip()
    first, second, third = windows_of(clip, CONFIG)
    hidden = replace(clip, passed_over=frozenset(range(second.first + 2, second.last - 1)))
    assert windows_of(hidden, CONFIG) == (Window(first.first, second.last), third)
    begun = replace(clip, passed_over=frozenset(range(first.first + 2, first.last - 1)))
    assert windows_of(begun, CONFIG) == (Window(first.first, second.last), third)
    some = replace(clip, passed_over=frozenset(range(second.first + 4, second.last - 3)))
    assert windows_of(some, CONFIG) == (first, second, third)


def test_a_short_clip_has_one_window_and_says_so() -> None:
    clip = plane_clip()
    started = next(iter(train(clip, CONFIG)))
    assert isinstance(started, Started)
    assert [each.why for each in started.omitted if each.what == "windows"] == [
        "the clip has 12 frames, and windows are for more than 79 frames"
    ]


@pytest.mark.parametrize("longest", [SHORTEST, 60, 80, 100])
def test_the_limit_that_is_told_is_the_one_that_cuts(longest: int) -> None:
    config = replace(CONFIG, window_frames=longest)
    limit = next(count for count in range(1, 200) if len(cut(np.full(count + 1, 1 / longest))) > 1)
    (told,) = left_out((Window(0, limit - 1),), config)
    assert told.why.endswith(f"windows are for more than {limit} frames")


def test_one_of_a_kind_is_told_as_one() -> None:
    (told,) = left_out((Window(0, 0),), TrainConfig())
    assert (
        told.why
        == "the clip has 1 frame, and windows are for more than 400 frames or 1 view beside the first"
    )


def test_steps_of_all_windows_are_counted(whole: tuple[list[TrainEvent], Path]) -> None:
    events, _ = whole
    number = len(windows_of(long_clip(), CONFIG))
    assert number == 3
    assert isinstance(events[0], Started)
    done = [event.iteration for event in events if isinstance(event, Progress | Evaluated | Finished)]
    assert done == sorted(done)
    assert done[-1] == events[0].iterations == number * STEPS
    assert sum(isinstance(event, Evaluated) and event.iteration == done[-1] for event in events) == 1


def test_every_frame_shows_one_window_and_between_two_frames_the_next_one_fades_in(
    whole: tuple[list[TrainEvent], Path],
) -> None:
    model = model_of(whole[0])
    motion = model.motion
    assert isinstance(motion, WindowedMotion)
    last = [int(motion.middle(window)) for window in range(len(motion) - 1)]
    assert [motion.windows_at(frame / FRAMES) for frame in range(FRAMES)] == [
        (sum(frame > middle for middle in last),) for frame in range(FRAMES)
    ]
    for middle, (former, latter) in zip(last, pairwise(motion.frames), strict=True):
        assert middle - latter[0] + 1 == former[1] - middle == OVERLAP // 2
    first = np.linspace(last[0], last[0] + 1, 41)
    fades_in_the_middle(model, first[1:-1] / FRAMES)


def test_a_model_of_an_earlier_version_fades_over_all_of_the_overlap(
    whole: tuple[list[TrainEvent], Path],
) -> None:
    model = model_of(whole[0])
    arrays = {name: array for name, array in model.arrays().items() if name != "window_fade"}
    earlier = DynamicGaussians.checked(arrays)
    assert set(earlier.arrays()) == set(arrays)
    frames = earlier.motion.frames  # type: ignore[attr-defined]
    fades_in_the_middle(earlier, np.linspace(frames[1, 0], frames[0, 1], 41)[1:-1] / FRAMES)


def fades_in_the_middle(model: DynamicGaussians, times: FloatArray) -> None:
    """Wherever it is looked at, one of the first two windows is all there, and nothing jumps."""
    counts = np.diff(model.motion.first_rows)  # type: ignore[attr-defined]
    seen = [model.at(float(time)).opacities for time in times]
    assert [len(opacities) for opacities in seen] == [counts[0] + counts[1]] * len(times)
    assert seen[0][counts[0] :].max() < 0.06 > seen[-1][: counts[0]].max()
    both = model.at(float(times.mean())).opacities
    for opacities in seen:
        faded = opacities / both
        assert max(np.median(faded[: counts[0]]), np.median(faded[counts[0] :])) > 0.95
    assert max(np.abs(later - former).max() for former, later in pairwise(seen)) < 0.1


def test_a_model_in_windows_comes_back_from_its_file(
    whole: tuple[list[TrainEvent], Path], tmp_path: Path
) -> None:
    model = model_of(whole[0])
    model.save(tmp_path / "model.safetensors")
    back = DynamicGaussians.load(tmp_path / "model.safetensors")
    assert same(model, back)
    for time in (0.0, 0.31, 0.42, 0.99, 1.0):
        assert np.array_equal(model.at(time).means, back.at(time).means)
    kept = np.arange(0, len(model), 3)
    chosen = back.rows(kept)
    rows = back.motion.rows_at(0.42)  # type: ignore[attr-defined]
    assert np.array_equal(chosen.at(0.42).means, back.at(0.42).means[np.isin(rows, kept)])
    with pytest.raises(ValueError, match="order of their windows"):
        back.rows(kept[::-1])


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("window_rows", np.array([0, 1, 2, 3])),
        ("window_frames", np.array([[0, 47], [30, 90], [40, 99]])),
        ("window_frames", np.array([[0, 47], [32, 79], [64, FRAMES]])),
        ("1.node_indices", np.zeros((3, 4), np.int32)),
    ],
)
def test_damaged_windows_are_refused(
    whole: tuple[list[TrainEvent], Path], name: str, value: np.ndarray[tuple[int, ...], np.dtype[np.int64]]
) -> None:
    arrays = dict(model_of(whole[0]).arrays())
    assert name in arrays
    with pytest.raises(ValueError, match="expected"):
        DynamicGaussians.checked(arrays | {name: value})


def cut_short(folder: Path, steps: int) -> Iterator[TrainEvent]:
    for event in train(long_clip(), CONFIG, folder=folder):
        yield event
        if isinstance(event, Progress) and event.iteration >= steps:
            return


def test_a_run_cut_short_in_its_second_window_goes_on_to_the_same_bytes(
    whole: tuple[list[TrainEvent], Path], tmp_path: Path
) -> None:
    list(cut_short(tmp_path, 2 * STEPS))
    left = unfinished(tmp_path, FRAMES)
    assert left is not None
    assert left.iteration == 2 * STEPS
    assert len(left.model.motion.frames) == 2  # type: ignore[attr-defined]
    windows = windows_of(long_clip(), CONFIG)
    assert next_of(tmp_path, windows) == windows[1]
    with pytest.raises(TrainingError, match="another"):
        list(train(long_clip(), replace(CONFIG, seed=1), folder=tmp_path, resume=True))
    events = list(train(long_clip(), CONFIG, folder=tmp_path, resume=True))
    assert isinstance(events[0], Started)
    assert events[0].iteration == 2 * STEPS
    assert same(model_of(whole[0]), model_of(events))
    assert next_of(tmp_path, windows) == windows[-1]
    # And once more, where only the end is missing.
    again = list(train(long_clip(), CONFIG, folder=tmp_path, resume=True))
    assert isinstance(again[0], Started)
    assert again[0].iteration == again[0].iterations == 3 * STEPS
    assert same(model_of(again), model_of(events))
    damaged = next((tmp_path / FOLDER).glob("*/*.safetensors"))
    damaged.write_bytes(damaged.read_bytes()[:50])
    with pytest.raises(TrainingError, match="damaged"):
        list(train(long_clip(), CONFIG, folder=tmp_path, resume=True))


def test_a_preview_shows_the_window_in_training_at_every_time(whole: tuple[list[TrainEvent], Path]) -> None:
    model = model_of(whole[0])
    rows = model.motion.first_rows  # type: ignore[attr-defined]
    second = DynamicGaussians(
        model.rows(np.arange(rows[1], rows[2])).raw,
        model.motion.motions[1],  # type: ignore[attr-defined]
    )
    preview = in_windows(FRAMES, [Window(32, 79)], [lambda: second])
    sent = DynamicGaussians.from_arrays(dict(preview.arrays()))
    assert np.array_equal(sent.at(0.0).means, second.at(0.0).means)
    assert np.array_equal(sent.at(0.5).means, second.at((FRAMES / 2 - 32) / 48).means)
    assert np.array_equal(sent.at(1.0).means, second.at(1.0).means)
    assert isinstance(Snapshot(0, preview).model, DynamicGaussians)


def masked(clip: Clip, frames: range) -> Clip:
    """Without tissue in some of its frames, as out of the body."""

    def read_frame(index: int) -> Frame:
        frame = clip.read_frame(index)
        return within(frame, np.zeros_like(frame.tissue_mask)) if index in frames else frame

    return replace(clip, read_frame=read_frame)


@pytest.mark.parametrize("frames", [range(32, 80), range(48)])
def test_a_window_without_tissue_is_left_empty(
    frames: range, whole: tuple[list[TrainEvent], Path], tmp_path: Path
) -> None:
    events = list(train(masked(long_clip(), frames), CONFIG, folder=tmp_path))
    assert isinstance(events[0], Started)
    said = [event.message for event in events if isinstance(event, Warned)]
    assert any(f"of the frames {frames[0]} to {frames[-1]}: they show no" in message for message in said)
    windows = windows_of_model(model_of(events))
    empty = 0 if frames[0] == 0 else 1
    assert [len(one) > 0 for one in windows] == [place != empty for place in range(3)]
    model_of(events).save(tmp_path / "model.safetensors")
    assert same(DynamicGaussians.load(tmp_path / "model.safetensors"), model_of(events))
    assert middle_distance(model_of(events), long_clip().cameras[0]) == pytest.approx(
        middle_distance(model_of(whole[0]), long_clip().cameras[0]), rel=0.1
    )


def test_a_long_clip_without_any_tissue_is_refused() -> None:
    with pytest.raises(ClipError, match="its masks leave out all of it"):
        list(train(masked(long_clip(), range(FRAMES)), CONFIG))
