"""Frames that training does not see: what is said of them is true, and costs a bounded share of the time."""

from __future__ import annotations

from dataclasses import replace
from itertools import count
from pathlib import Path

import numpy as np
import pytest

from renderer.clip import Clip
from renderer.measuring.training_accuracy import measured
from renderer.phantom import PhantomParams, write_phantom
from renderer.sources import open_clip
from renderer.train import held_out
from renderer.train.events import Evaluated, Finished
from renderer.train.held_out import MOST, SHARE, HeldOut, evaluated
from renderer.train.training import train
from tests.renderer.sheet import SMALL, moving_sheet, same_bytes

PLAIN = replace(SMALL, iterations=90, hold_out=False)


def run(clip: Clip) -> tuple[list[Evaluated], Finished]:
    events = list(train(clip, PLAIN))
    assert isinstance(events[-1], Finished)
    return [event for event in events if isinstance(event, Evaluated)], events[-1]


def test_what_is_said_at_the_end_is_what_is_measured_afterwards() -> None:
    clip = moving_sheet()
    (*_, last), finished = run(clip)
    found = measured(finished.model, clip, clip.test_indices, clip.train_indices)
    psnr, depth = found.psnr, found.depth_rmse
    assert last.psnr == pytest.approx(psnr, abs=0.01)
    assert last.depth_rmse == pytest.approx(depth, rel=0.01)


def test_at_the_end_all_held_out_frames_count(tmp_path: Path) -> None:
    """Also those that are not watched meanwhile: here one that is black."""
    write_phantom(tmp_path / "clip", PhantomParams(n_frames=48, width=48, height=32))
    phantom = open_clip(tmp_path / "clip")
    watched = HeldOut(phantom, phantom.test_indices, 1.0)._indices
    (black, *_) = sorted(set(phantom.test_indices) - set(watched))
    clip = phantom.with_images(lambda image, frame: image * (frame.index != black), "phantom")
    events, finished = run(clip)
    every, some = (
        measured(finished.model, clip, indices, clip.train_indices).psnr
        for indices in (clip.test_indices, watched)
    )
    assert events[-1].psnr == pytest.approx(every, abs=0.01)
    assert every < some - 1


def test_a_frame_of_which_nothing_is_evaluated_takes_no_part(tmp_path: Path) -> None:
    clip = moving_sheet()
    views = [clip.read_frame(index) for index in clip.test_indices]
    model = run(clip)[1].model
    hidden = replace(views[0], evaluation_mask=np.zeros_like(views[0].evaluation_mask))
    every, some, none = (
        evaluated(model, given, 9, 50.0).psnr for given in (views, [*views, hidden], [hidden])
    )
    assert (some, np.isnan(none)) == (every, True)


def test_a_run_is_measured_as_it_is_drawn_in_training() -> None:
    """Of splats narrower than a pixel, which are drawn otherwise by default."""
    clip, fine = moving_sheet(), replace(PLAIN, render_mode="mip", initial_spacing=0.2)
    *_, last, finished = train(clip, fine)
    assert isinstance(last, Evaluated)
    assert isinstance(finished, Finished)
    found = measured(finished.model, clip, clip.test_indices, clip.train_indices, "mip")
    psnr, depth = found.psnr, found.depth_rmse
    assert last.psnr == pytest.approx(psnr, abs=0.01)
    assert last.depth_rmse == pytest.approx(depth, rel=0.01)
    assert psnr > measured(finished.model, clip, clip.test_indices, clip.train_indices).psnr + 1


def test_watching_changes_nothing_and_shows_progress(monkeypatch: pytest.MonkeyPatch) -> None:
    clip = moving_sheet()
    _, alone = run(clip)
    monkeypatch.setattr(held_out, "FIRST_SECONDS", 0.0)
    monkeypatch.setattr(held_out, "SHARE", 1e9)
    watched, finished = run(clip)
    assert same_bytes(alone.model, finished.model)
    assert len(watched) == PLAIN.iterations
    assert [event.iteration for event in watched] == list(range(1, PLAIN.iterations + 1))
    assert watched[-1].psnr > watched[0].psnr + 3
    errors = [event.depth_rmse for event in watched]
    assert None not in errors
    assert errors[-1] < errors[0]  # type: ignore[operator]


def test_a_guessed_depth_is_no_measure_of_error() -> None:
    clip = moving_sheet()
    guessed = replace(clip, read_frame=lambda index: replace(clip.read_frame(index), depth_is_guess=True))
    (*_, last), _ = run(guessed)
    assert last.depth_rmse is None
    assert np.isfinite(last.psnr)


def test_it_takes_a_bounded_share_of_the_time(monkeypatch: pytest.MonkeyPatch) -> None:
    """A second a time, so a few frames, read once, and then not before its share has passed."""
    clip = moving_sheet()
    read: list[int] = []
    own = clip.read_frame
    watched = replace(clip, read_frame=lambda index: (read.append(index), own(index))[1])
    _, finished = run(clip)
    clock = count(0.0, 1.0)
    monkeypatch.setattr(held_out, "perf_counter", lambda: next(clock))
    held = HeldOut(watched, tuple(range(12)), 50.0)
    assert not held.is_due(held_out.FIRST_SECONDS - 0.1)
    assert held.is_due(held_out.FIRST_SECONDS)
    for seconds in (3.0, 3.0 + 1 / SHARE):
        assert held.is_due(seconds)
        held.measure(finished.model, 1, seconds)
        assert not held.is_due(seconds + 0.99 / SHARE)
    assert len(read) == MOST
    assert {read[0], read[-1]} == {0, 11}


def test_without_held_out_frames_nothing_is_measured() -> None:
    assert not HeldOut(moving_sheet(), (), 50.0).is_due(1e9)
