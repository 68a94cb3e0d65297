"""A run that goes wrong says so."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from renderer.clip import Frame
from renderer.raw_gaussians import RawGaussians
from renderer.train.checkpoint import checkpoint_paths, read_checkpoint, write_checkpoint
from renderer.train.events import Finished, Warned
from renderer.train.guards import JUDGED, LossWatch, hold_scales, leave_out_broken, shorten
from renderer.train.trainer import LOSSES, TROUBLE, TrainingError
from renderer.train.training import train
from tests.renderer.sheet import SMALL, moving_sheet

RATES = (
    "mean_rate", "motion_rate", "color_rate", "color_motion_rate", "opacity_rate", "scale_rate", "quat_rate"
)  # fmt: skip


def gradients(count: int) -> RawGaussians:
    shapes = {"means": (3,), "quats": (4,), "log_scales": (3,), "opacity_logits": (), "colors": (3,)}
    arrays = {name: np.ones((count, *tail), np.float32) for name, tail in shapes.items()}
    return RawGaussians(**arrays, harmonics=np.zeros((count, 0, 3), np.float32))


@pytest.mark.parametrize("name", ["means", "quats", "log_scales", "opacity_logits", "colors"])
@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_a_gradient_that_is_no_number_is_left_out_alone(name: str, value: float) -> None:
    by, seen = gradients(6), np.array([True, True, False, True, True, True])
    flat = getattr(by, name).reshape(6, -1)
    flat[3, -1] = value
    flat[2, 0] = value
    assert leave_out_broken(by, seen) == 1
    assert seen.tolist() == [True, True, False, False, True, True]
    # Nodes gather gradients of all Gaussians, also of those that are left out.
    for kind in ("means", "quats", "log_scales", "opacity_logits", "colors"):
        assert not getattr(by, kind)[3].any()
        assert getattr(by, kind)[[0, 1, 4, 5]].all()


def test_scales_that_run_away_are_held() -> None:
    log_scales = np.float32([[0, 1, 2], [-80, 0, 88]])
    assert hold_scales(log_scales, 50.0) == 2
    assert np.isfinite(np.exp(log_scales)).all()
    assert log_scales[0].tolist() == [0, 1, 2]
    assert hold_scales(log_scales, 50.0) == 0


def test_needles_are_shortened_and_discs_stay() -> None:
    scales = np.float32([[1, 1, 100], [100, 2, 1], [1, 50, 6], [3, 3, 0.01], [5, 0, 1]])
    with np.errstate(divide="ignore"):
        log_scales = np.log(scales)
    shorten(log_scales, 8.0)
    wanted = np.float32([[1, 1, 8], [16, 2, 1], [1, 48, 6], [3, 3, 0.01], [5, 0, 1]])
    np.testing.assert_allclose(np.exp(log_scales), wanted, rtol=1e-5)


def test_a_loss_that_rises_for_good_is_a_problem_and_one_that_swings_is_not() -> None:
    rng = np.random.default_rng(0)
    calm, wild = LossWatch(), LossWatch()
    for step in range(3 * JUDGED):
        calm.add(0.1 * rng.uniform(0.2, 3.0))
        wild.add(0.1 * (1 + 5 * step / JUDGED))
    assert calm.problem is None
    assert wild.problem is not None
    wild.add(float("nan"))
    assert wild.problem == "the loss is not finite"


@pytest.mark.parametrize("place", [0, 1, 7])
def test_frames_without_tissue_do_not_end_a_good_run(place: int) -> None:
    """Their loss is 0: of the first step, or of every eighth."""
    watch = LossWatch()
    for step in range(3 * JUDGED):
        watch.add(*((0.0, 0.0) if step % 8 == place else (0.1, 1.0)))
    assert watch.problem is None
    assert watch.state[0] == pytest.approx(3 * JUDGED * 7 / 8, abs=1)


def test_a_first_frame_with_little_tissue_does_not_end_a_good_run() -> None:
    watch = LossWatch()
    for loss, tissue in ((0.01, 0.05), *[(0.1, 0.8)] * 3 * JUDGED):
        watch.add(loss, tissue)
    assert watch.problem is None


@pytest.mark.parametrize("seed", range(4))
def test_a_clip_with_a_masked_frame_is_trained_to_its_end(seed: int) -> None:
    """Whichever frame comes first."""
    clip = moving_sheet()

    def read_frame(index: int) -> Frame:
        frame = clip.read_frame(index)
        empty = np.zeros_like(frame.tissue_mask)
        return replace(frame, tissue_mask=empty) if index % 4 == 0 else frame

    masked = replace(clip, read_frame=read_frame)
    last = list(train(masked, replace(SMALL, seed=seed, iterations=JUDGED + 20)))[-1]
    assert isinstance(last, Finished)


def test_what_was_watched_outlives_an_interruption(tmp_path: Path) -> None:
    """Judged by its first steps, not by those after the checkpoint."""
    config = replace(SMALL, iterations=40, checkpoint_every=20)
    whole = list(train(moving_sheet(), config, folder=tmp_path))
    assert isinstance(whole[-1], Finished)
    newest, older = (read_checkpoint(path) for path in reversed(checkpoint_paths(tmp_path)))
    assert newest.arrays[LOSSES][0] == 40
    assert older.arrays[LOSSES][0] == 20
    checkpoint_paths(tmp_path)[-1].unlink()
    list(train(moving_sheet(), config, folder=tmp_path, resume=True))
    again = read_checkpoint(checkpoint_paths(tmp_path)[-1])
    np.testing.assert_array_equal(again.arrays[LOSSES], newest.arrays[LOSSES])


def test_trouble_of_all_parts_of_a_run_is_told_in_the_end(tmp_path: Path) -> None:
    """Also where the last one, or a checkpoint of an earlier version, has none."""
    config = replace(SMALL, iterations=4, checkpoint_every=2)
    list(train(moving_sheet(), config, folder=tmp_path))
    last, first = (read_checkpoint(path) for path in reversed(checkpoint_paths(tmp_path)))
    assert not first.arrays[TROUBLE].any()
    for counts, told in (({TROUBLE: np.array([3, 5])}, ["3 gradients", "5 times"]), ({}, [])):
        for path in checkpoint_paths(tmp_path):
            path.unlink()
        arrays = {name: value for name, value in first.arrays.items() if name != TROUBLE}
        write_checkpoint(tmp_path, replace(first, arrays=arrays | counts))
        events = list(train(moving_sheet(), config, folder=tmp_path, resume=True))
        said = [event.message for event in events if isinstance(event, Warned)]
        assert [" ".join(message.split()[:2]) for message in said] == told
        again = read_checkpoint(checkpoint_paths(tmp_path)[-1])
        assert again.arrays[TROUBLE].tolist() == [*(counts.get(TROUBLE, (0, 0)))]
        assert again.iteration == last.iteration


def test_rates_a_hundred_times_too_high_end_in_one_clear_line() -> None:
    config = replace(SMALL, **{name: min(1.0, 100 * getattr(SMALL, name)) for name in RATES})
    with pytest.raises(TrainingError, match="lower the learning rates"):
        list(train(moving_sheet(), config))
