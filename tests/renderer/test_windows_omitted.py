"""What a long clip's windows do without is told of all of them, also of those that were finished before."""

from __future__ import annotations

from dataclasses import asdict, replace
from pathlib import Path

import pytest

from renderer.clip import Clip
from renderer.train import window_files
from renderer.train.config import TrainConfig
from renderer.train.events import Finished, Omission, Progress, TrainEvent
from renderer.train.trainer import TrainingError
from renderer.train.training import train
from renderer.train.window_files import finish, finished, folder_of
from renderer.train.windows import windows_of
from tests.renderer.plane import plane_clip

COUNT = 80
CONFIG = TrainConfig(iterations=6, n_gaussians=60, node_columns=4, window_frames=48, checkpoint_every=4)


@pytest.fixture
def clip() -> Clip:
    short = plane_clip()
    return replace(
        short,
        cameras=short.cameras[:1] * COUNT,
        labels=tuple(map(str, range(COUNT))),
        read_frame=lambda at: replace(short.read_frame(at % len(short)), index=at, time=at / COUNT),
    )


def omitted(events: list[TrainEvent]) -> tuple[Omission, ...]:
    assert isinstance(events[-1], Finished)
    return events[-1].omitted


def test_a_resumed_run_tells_what_its_finished_windows_did_without(clip: Clip, tmp_path: Path) -> None:
    whole = omitted(list(train(clip, CONFIG)))
    assert whole
    assert all(each.why.endswith("(window 1)") for each in whole)
    events = train(clip, CONFIG, folder=tmp_path)
    next(each for each in events if isinstance(each, Progress) and each.iteration > CONFIG.iterations)
    events.close()
    assert omitted(list(train(clip, CONFIG, folder=tmp_path, resume=True))) == whole
    # And once more, where all windows are finished.
    assert omitted(list(train(clip, CONFIG, folder=tmp_path, resume=True))) == whole


def rewritten(folder: Path, monkeypatch: pytest.MonkeyPatch, **told: object) -> None:
    """The window with another statement of what it did without."""
    known = finished(folder)
    state = asdict(known)
    del state["omitted"]
    monkeypatch.setattr(window_files, "asdict", lambda _: state | told)
    finish(folder, window_files.load(folder), known)
    monkeypatch.undo()


def test_a_window_of_an_earlier_version_tells_nothing(
    clip: Clip, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    whole = omitted(list(train(clip, CONFIG, folder=tmp_path)))
    first = folder_of(tmp_path, windows_of(clip, CONFIG)[0])
    rewritten(first, monkeypatch)
    assert finished(first).omitted == ()
    resumed = omitted(list(train(clip, CONFIG, folder=tmp_path, resume=True)))
    assert {each.what for each in resumed} == {each.what for each in whole}
    assert all(each.why.endswith("(window 2)") for each in resumed)


@pytest.mark.parametrize("told", [[{"what": ["x"], "why": "y", "saves": "z"}], [{"what": "x"}], ["x"], 1])
def test_what_is_no_omission_is_a_damaged_window(
    told: object, clip: Clip, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    list(train(clip, CONFIG, folder=tmp_path))
    rewritten(folder_of(tmp_path, windows_of(clip, CONFIG)[0]), monkeypatch, omitted=told)
    with pytest.raises(TrainingError, match="damaged file"):
        list(train(clip, CONFIG, folder=tmp_path, resume=True))
