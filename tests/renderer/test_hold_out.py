"""Training frames that are held out of the fit: none of them is fitted, and they alone are measured."""

from __future__ import annotations

from dataclasses import replace

import pytest

from renderer.clip import Clip, ClipError, Frame, Split
from renderer.train import trainer, windowed
from renderer.train.config import TrainConfig
from renderer.train.events import Evaluated
from renderer.train.held_out import HeldOut
from renderer.train.trainer import split
from renderer.train.training import train
from tests.renderer.plane import plane_clip

CONFIG = TrainConfig(iterations=2, n_gaussians=60, window_frames=48, hold_out=True)
FRAMES = 112


def recorded(clip: Clip, read: list[int]) -> Clip:
    """The clip's frames again and again, which notes what is read of it."""

    def read_frame(index: int) -> Frame:
        read.append(index)
        return replace(clip.read_frame(index % len(clip)), index=index, time=index / FRAMES)

    cameras, labels = clip.cameras[:1] * FRAMES, tuple(map(str, range(FRAMES)))
    return replace(clip, cameras=cameras, labels=labels, read_frame=read_frame)


@pytest.mark.parametrize("kind", ["field", "even-odd"])
def test_no_window_is_fitted_to_a_frame_that_is_measured(
    kind: Split, monkeypatch: pytest.MonkeyPatch
) -> None:
    read: list[int] = []
    measured: list[int] = []
    clip = replace(recorded(plane_clip(), read), split=kind)

    def judged(model: object, views: list[Frame], *rest: object) -> Evaluated:
        fitted.update(read)
        measured.extend(frame.index for frame in views)
        return Evaluated(0, 30.0, None)

    fitted: set[int] = set()
    monkeypatch.setattr(windowed, "evaluated", judged)
    monkeypatch.setattr(trainer, "evaluated", lambda *_: Evaluated(0, 30.0, None))
    monkeypatch.setattr(HeldOut, "is_due", lambda *_: False)
    list(train(clip, CONFIG))
    assert tuple(measured) == split(clip, CONFIG)[1]
    assert not fitted & {*measured, *clip.test_indices}
    assert fitted == set(range(FRAMES)) - {*measured, *clip.test_indices}


def short(count: int) -> Clip:
    return plane_clip().between(0, count - 1)


@pytest.mark.parametrize("count", [3, 4, 5])
def test_of_few_frames_the_middle_one_is_held_out(count: int) -> None:
    clip = short(count)
    fit, (held_out,) = split(clip, CONFIG)
    assert held_out == clip.train_indices[len(clip.train_indices) // 2]
    assert sorted((*fit, held_out)) == list(clip.train_indices)


def test_test_frames_are_never_measured_instead(monkeypatch: pytest.MonkeyPatch) -> None:
    clip, measured = short(4), list[int]()

    def judged(model: object, views: list[Frame], *rest: object) -> Evaluated:
        measured.extend(frame.index for frame in views)
        return Evaluated(0, 30.0, None)

    monkeypatch.setattr(trainer, "evaluated", judged)
    list(train(clip, CONFIG))
    assert measured == list(split(clip, CONFIG)[1])
    assert not set(measured) & set(clip.test_indices)


def test_a_single_frame_to_train_on_cannot_be_held_out() -> None:
    with pytest.raises(ClipError, match="hold_out expects two frames to train on, or more, got 1"):
        next(train(short(2), CONFIG))
