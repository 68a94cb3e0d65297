"""The parts of a training step, and runs on a small scene with known motion."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from renderer.clip import ClipError, Split
from renderer.rasterize.cpu import Rasterizer, render
from renderer.splats import Splats
from renderer.train.adam import coast_taps, corrected_rate, update_rows, update_taps
from renderer.train.checkpoint import Checkpoint, checkpoint_paths, read_newest_checkpoint, write_checkpoint
from renderer.train.config import Part
from renderer.train.events import Finishing, Progress, Started
from renderer.train.frames import halved, train_frame
from renderer.train.initialize import sampled, scene_size
from renderer.train.losses import LossWeights, picture_loss
from renderer.train.trainer import REMOVING, TrainingError, frame_of, split
from renderer.train.training import train
from tests.renderer.sheet import SIZE, SMALL, finished, moving_sheet, same_bytes


@pytest.mark.parametrize("kind", ["field", "even-odd"])
def test_frames_are_held_out_of_training_frames_however_these_are_split(kind: Split) -> None:
    clip = replace(moving_sheet(), split=kind)
    fit, held_out = split(clip, SMALL)
    assert held_out
    assert sorted((*fit, *held_out)) == list(clip.train_indices)
    assert not set(held_out) & set(clip.test_indices)
    if kind == "field":
        assert all(index % 8 == 5 for index in held_out)


def test_moving_tissue_is_recovered_and_static_is_not_enough() -> None:
    clip = moving_sheet()
    _, moving = finished(clip, SMALL)
    _, static = finished(clip, replace(SMALL, method="static"))
    assert moving > 27
    assert moving > static + 3


def test_depth_of_the_model_follows_the_tissue() -> None:
    clip = moving_sheet()
    model, _ = finished(clip, SMALL)
    frame = clip.read_frame(5)
    assert frame.depth is not None
    got = render(model.at(frame.time), frame.camera)
    error = np.abs(got.depth - frame.depth)[(got.alpha > 0.5) & frame.tissue_mask]
    assert np.median(error) < 1.0  # mm at 50 mm; the depth itself swings by 10 mm


def test_units_do_not_matter() -> None:
    """Metres or millimetres: the same picture quality from the same settings, but for rounding, which any
    factor changes: hence means."""

    def quality(unit: float) -> float:
        return float(np.mean([finished(moving_sheet(unit * factor), SMALL)[1] for factor in (0.7, 1, 1.3)]))

    assert quality(1e-3) == pytest.approx(quality(1.0), abs=0.3)


def test_one_seed_gives_the_same_bytes() -> None:
    clip = moving_sheet()
    short = replace(SMALL, iterations=30)
    assert same_bytes(finished(clip, short)[0], finished(clip, short)[0])
    assert not same_bytes(finished(clip, short)[0], finished(clip, replace(short, seed=1))[0])


@pytest.mark.parametrize("stop_after", [45, 85])
def test_resumed_run_equals_the_uninterrupted_one(tmp_path: Path, stop_after: int) -> None:
    clip = moving_sheet()
    config = replace(SMALL, iterations=100)
    whole, _ = finished(clip, config)
    for event in train(clip, config, folder=str(tmp_path)):
        if isinstance(event, Progress) and event.iteration >= stop_after:
            break
        if len(checkpoint_paths(tmp_path)) * 40 >= stop_after:
            break
    resumed, _ = finished(clip, config, folder=tmp_path, resume=True)
    assert same_bytes(whole, resumed)


def test_closed_between_checkpoints_a_run_keeps_the_steps_that_are_done(tmp_path: Path) -> None:
    config = replace(SMALL, iterations=100_000, checkpoint_every=1_000_000)
    events = train(moving_sheet(), config, folder=tmp_path)
    done = next(event.iteration for event in events if isinstance(event, Progress))
    events.close()
    assert [path.name for path in checkpoint_paths(tmp_path)] == [f"checkpoint-{done:07d}.safetensors"]
    again = train(moving_sheet(), config, folder=tmp_path, resume=True)
    started = next(event for event in again if isinstance(event, Started))
    assert started.iteration == done > 0


def test_checkpoint_of_another_run_is_refused(tmp_path: Path) -> None:
    clip = moving_sheet()
    list(train(clip, replace(SMALL, iterations=40), folder=tmp_path))
    with pytest.raises(TrainingError, match="this clip and configuration"):
        list(train(clip, replace(SMALL, iterations=80), folder=tmp_path, resume=True))


def test_an_old_checkpoint_that_another_program_holds_goes_with_the_next(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As on Windows, where a virus scanner may look at it."""
    arrays = {"means": np.zeros((2, 3), np.float32)}

    def busy(path: Path, missing_ok: bool = False) -> None:
        if path.exists():
            raise PermissionError(13, "in use", str(path))

    with monkeypatch.context() as patch:
        patch.setattr(Path, "unlink", busy)
        for iteration in (10, 20, 30):
            write_checkpoint(tmp_path, Checkpoint(iteration, 1.5, "x", arrays))
    assert len(checkpoint_paths(tmp_path)) == 3
    write_checkpoint(tmp_path, Checkpoint(40, 1.5, "x", arrays))
    assert [int(path.stem[-2:]) for path in checkpoint_paths(tmp_path)] == [30, 40]


def test_two_checkpoints_are_kept_and_a_damaged_one_is_passed_over(tmp_path: Path) -> None:
    for iteration in (10, 20, 30):
        write_checkpoint(
            tmp_path, Checkpoint(iteration, 1.5, "x", {"means": np.full((2, 3), iteration, np.float32)})
        )
    assert [path.name for path in checkpoint_paths(tmp_path)] == [
        "checkpoint-0000020.safetensors",
        "checkpoint-0000030.safetensors",
    ]
    newest = checkpoint_paths(tmp_path)[-1]
    newest.write_bytes(newest.read_bytes()[:50])
    checkpoint = read_newest_checkpoint(tmp_path)
    assert checkpoint is not None
    assert checkpoint.iteration == 20
    assert (checkpoint.arrays["means"] == 20).all()


def test_clip_without_depth_is_refused() -> None:
    clip = moving_sheet()
    blind = replace(
        clip, read_frame=lambda index: replace(clip.read_frame(index), depth=None), has_depth=False
    )
    with pytest.raises(ClipError, match="depth"):
        next(iter(train(blind, SMALL)))


def test_a_path_is_no_clip() -> None:
    path: Any = Path("clip")
    with pytest.raises(TypeError, match=r"expected a Clip, as open_clip gives it, got .*Path"):
        next(train(path, SMALL))


def test_absurd_rates_end_in_a_clear_failure_or_a_finite_model() -> None:
    wild = replace(
        SMALL, iterations=60, motion_rate=1.0, mean_rate=1.0, scale_rate=1.0, color_motion_rate=1.0
    )
    try:
        model, _ = finished(moving_sheet(), wild)
    except TrainingError:
        return
    assert all(np.isfinite(value).all() for value in model.arrays().values())


def test_initial_points_lie_on_the_surface_behind_pixel_centres() -> None:
    clip = moving_sheet()
    frames = [clip.read_frame(index) for index in (0, 2)]
    model = sampled(frames, SMALL)
    depths = {float(frame.depth[0, 0]) for frame in frames if frame.depth is not None}
    assert {round(float(z), 3) for z in model.means[:, 2]} == {round(z, 3) for z in depths}
    pixels, _ = frames[0].camera.project(model.means.astype(np.float64))
    assert np.abs(pixels - np.floor(pixels) - 0.5).max() < 1e-3
    inside = np.floor(pixels).astype(int)
    assert frames[0].tissue_mask[inside[:, 1], inside[:, 0]].all()
    assert scene_size(frames) == pytest.approx(np.median(sorted(depths)), rel=1e-6)


def test_every_frame_once_an_epoch_and_test_frames_never() -> None:
    clip = moving_sheet()
    fit, held_out = split(clip, SMALL)
    assert not set(fit) & set(held_out)
    assert not (set(fit) | set(held_out)) & set(clip.test_indices)
    frames = [train_frame(clip.read_frame(index)) for index in fit]
    for epoch in range(3):
        steps = range(epoch * len(frames), (epoch + 1) * len(frames))
        assert sorted(frame_of(step, frames, 0).time for step in steps) == sorted(
            frame.time for frame in frames
        )


def test_half_resolution_frame_keeps_means_and_masks() -> None:
    frame = train_frame(moving_sheet().read_frame(3))
    small = halved(frame)
    assert (small.camera.width, small.camera.height) == (24, 16)
    blocks = frame.colors[:, :32, :48].reshape(3, 16, 2, 24, 2).mean(axis=(2, 4))
    inside = small.color_mask[:16, :24]
    assert np.abs(small.colors[:, :16, :24] - blocks)[:, inside].max() <= 0.5 + 1e-4
    assert not inside[:4, :5].any()
    assert small.depth[8, 20] == pytest.approx(frame.depth[16, 40], rel=1e-6)


def test_loss_adjoint_is_the_slope_of_the_loss() -> None:
    """Central differences of the loss through the raster, with splats so wide that no cut-off moves."""
    seen = moving_sheet().read_frame(1)
    shown = seen.tissue_mask.copy()
    shown[:, :5] = True  # Half of what is hidden here, other frames show.
    frame = train_frame(seen, ~shown, shown)
    rng = np.random.default_rng(0)
    count = 20
    means = np.column_stack(
        [rng.uniform(-20, 20, count), rng.uniform(-14, 14, count), rng.uniform(45, 60, count)]
    )
    splats = Splats(
        means.astype(np.float32), rng.normal(size=(count, 4)).astype(np.float32),
        rng.uniform(20, 30, (count, 3)).astype(np.float32), rng.uniform(0.05, 0.2, count).astype(np.float32),
        rng.uniform(0, 1, (count, 3)).astype(np.float32),
    )  # fmt: skip
    rasterizer = Rasterizer(*SIZE)
    weights = LossWeights(
        color=0.7, opacity=0.5, depth=0.2, inverse_depth=0.3, image_variation=0.1,
        inverse_depth_variation=0.4,
    )  # fmt: skip

    def loss(changed: Splats) -> float:
        rasterizer.forward(changed, frame.camera)
        return picture_loss(rasterizer, frame, weights, 50.0).loss

    loss(splats)
    gradients = rasterizer.backward(splats)
    for name, step in (("colors", 1e-3), ("opacities", 1e-4), ("means", 1e-2)):
        direction = rng.normal(size=getattr(splats, name).shape).astype(np.float32)
        ahead = replace(splats, **{name: getattr(splats, name) + np.float32(step) * direction})
        behind = replace(splats, **{name: getattr(splats, name) - np.float32(step) * direction})
        slope = (loss(ahead) - loss(behind)) / (2 * step)
        assert float((getattr(gradients, name) * direction).sum()) == pytest.approx(slope, rel=0.03)


def test_adam_rows_follow_the_published_algorithm_and_skip_unseen_rows() -> None:
    rng = np.random.default_rng(4)
    values = rng.normal(size=(5, 3)).astype(np.float32)
    start = values.copy()
    first, second = np.zeros_like(values), np.zeros_like(values)
    seen = np.array([True, True, False, True, False])
    expected, m, v = values.astype(np.float64), np.zeros((5, 3)), np.zeros((5, 3))
    for step in range(1, 6):
        gradient = rng.normal(size=(5, 3)).astype(np.float32)
        update_rows(values, gradient, first, second, seen, corrected_rate(0.1, step))
        m, v = 0.9 * m + 0.1 * gradient, 0.999 * v + 0.001 * gradient.astype(np.float64) ** 2
        expected -= 0.1 * (m / (1 - 0.9**step)) / np.sqrt(v / (1 - 0.999**step))
    assert np.allclose(values[seen], expected[seen], atol=1e-5)
    assert np.array_equal(values[~seen], start[~seen])


def test_only_the_active_control_values_move() -> None:
    controls = np.zeros((2, 8, 1), np.float32)
    first, second = np.zeros((2, 8, 2, 1), np.float32)
    weights = np.array([0.1, 0.6, 0.2, 0.1], np.float32)
    seen = np.array([True, False])
    rates = np.full(4, 0.5, np.float32)
    update_taps(controls, np.ones((2, 1), np.float32), first, second, seen, 2, weights, rates, 0.0)
    assert (controls[0, 2:6, 0] < 0).all()
    assert not controls[0, [0, 1, 6, 7]].any()
    assert not controls[1].any()


def test_far_control_values_coast_as_adam_is_published() -> None:
    """Five steps with a gradient, then five without, of one value; in float64 with no special case."""
    controls = np.zeros((1, 6, 1), np.float32)
    first, second = np.zeros((2, 6, 1, 1), np.float32)
    weights, seen = np.full(4, 0.25, np.float32), np.array([True])
    value = m = v = 0.0
    for step in range(1, 11):
        gradient = 2.0 * step if step <= 5 else 0.0
        rate = corrected_rate(0.1, step)
        if step <= 5:
            by = np.full((1, 1), 4 * gradient, np.float32)
            update_taps(controls, by, first, second, seen, 0, weights, np.full(4, rate, np.float32), 0.0)
            active = controls[0, 2:].copy()
        else:
            coast_taps(controls, first, second, 2, np.full(6, rate, np.float32))
        m, v = 0.9 * m + 0.1 * gradient, 0.999 * v + 0.001 * gradient**2
        value -= 0.1 * (m / (1 - 0.9**step)) / np.sqrt(v / (1 - 0.999**step))
    assert np.allclose(controls[0, :2, 0], value, rtol=1e-5)
    assert np.array_equal(controls[0, 2:], active)


def test_progress_ends_at_the_last_step_with_the_time_of_what_follows_it() -> None:
    events = list(train(moving_sheet(), SMALL))
    told = [event for event in events if isinstance(event, Progress)]
    assert told[-1].iteration == told[-1].iterations == SMALL.iterations
    follows = [event for event in events if isinstance(event, Finishing)]
    assert [event.stage for event in follows][-1] == "measuring held-out frames"
    assert events.index(follows[0]) == events.index(told[-1]) + 1
    left = [told[-1].seconds_left, *(event.seconds_left for event in follows)]
    assert left == sorted(left, reverse=True)
    assert left[-1] > 0
    assert all(event.seconds_left > left[0] for event in told[:-1])
    assert [event.seconds for event in told] == sorted(event.seconds for event in told)


def test_what_is_left_out_is_not_announced() -> None:
    def stages(*keep: Part) -> set[str]:
        events = train(moving_sheet(), replace(SMALL, iterations=20, keep=keep))
        return {event.stage for event in events if isinstance(event, Finishing)}

    assert stages() - stages("unseen") == {REMOVING}
