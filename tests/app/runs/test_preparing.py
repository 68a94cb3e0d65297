"""What comes before the first step is told while it lasts, is done once, and refuses what cannot be."""

from __future__ import annotations

import os
import time
from collections.abc import Generator
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from app.errors import UserError
from app.runs import preparing
from app.runs.preparing import ReadAhead, Tell, told_meanwhile
from app.runs.train_run import TrainRequest, run_training
from renderer.clip import Clip, ClipError, Frame
from renderer.readers.clip_options import ClipOptions
from renderer.sources import open_clip
from renderer.train.events import Finished, Planned, Preparing, Started, TrainEvent
from renderer.train.windows import Window
from tests.app.conftest import CONFIG, Cli, request_of


def ended(work: Generator[Preparing, None, object]) -> tuple[list[Preparing], object]:
    said = []
    while True:
        try:
            said.append(next(work))
        except StopIteration as end:
            return said, end.value


@pytest.fixture
def eager(patient: None, monkeypatch: pytest.MonkeyPatch) -> None:
    """Whatever lasts is told."""
    monkeypatch.setattr(preparing, "SECONDS_BETWEEN", 0.001)


def test_work_that_lasts_is_told_with_the_time_left(eager: None) -> None:
    def work(told: Tell) -> str:
        for done in range(4):
            told(done, 4)
            time.sleep(0.03)
        return "result"

    said, result = ended(told_meanwhile("count", work))
    assert result == "result"
    assert {each.stage for each in said} == {"count"}
    counts = [each.done for each in said]
    assert counts == sorted(counts)
    assert {1, 2, 3} <= set(counts)
    last = said[-1]
    assert (last.done, last.total) == (3, 4)
    assert last.seconds_left is not None
    assert 0 <= last.seconds_left < last.seconds
    assert said[0].seconds_left is None


def test_work_that_fails_says_so(eager: None) -> None:
    def work(told: Tell) -> None:
        raise ClipError("no such thing")

    with pytest.raises(ClipError, match="no such thing"):
        ended(told_meanwhile("fail", work))


def test_work_that_nobody_waits_for_ends(eager: None) -> None:
    rounds = [0]

    def endless(told: Tell) -> None:
        while True:
            rounds[0] += 1
            time.sleep(0.001)

    work = told_meanwhile("run", endless)
    assert isinstance(next(work), Preparing)
    work.close()
    done = rounds[0]
    time.sleep(0.05)
    assert rounds[0] == done


def counting(clip: Clip, read: list[int]) -> Clip:
    def read_frame(index: int) -> Frame:
        read.append(range(len(clip))[index])
        return clip.read_frame(index)

    return replace(clip, read_frame=read_frame)


def test_frames_are_read_once_and_handed_over(clip_path: Path, tmp_path: Path) -> None:
    read: list[int] = []
    clip = counting(open_clip(clip_path), read)
    ahead = ReadAhead(clip, tmp_path, Window(0, len(clip) - 1))
    ahead.fill(lambda done, total: None)
    for index in clip.train_indices:
        assert ahead.clip.read_frame(index) is ahead.clip.read_frame(index)
    assert sorted(read) == list(clip.train_indices)
    ahead.hand_over()
    kept = ahead.clip.read_frame(0)
    assert sorted(read) == list(clip.train_indices)
    assert ahead.clip.read_frame(0) is not kept


def test_of_a_long_clip_the_frames_of_one_window_are_read(clip_path: Path, tmp_path: Path) -> None:
    read: list[int] = []
    clip = counting(open_clip(clip_path), read)
    ReadAhead(clip, tmp_path, Window(3, 6)).fill(lambda done, total: None)
    assert read == [index for index in clip.train_indices if 3 <= index <= 6]
    assert len(read) > 2


def test_training_reads_each_frame_once_before_it_starts(
    clip_path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    read: list[int] = []
    monkeypatch.setattr(
        "app.runs.train_run.open_bare", lambda path, options: counting(open_clip(path, options), read)
    )
    request = request_of(clip_path, tmp_path / "run", input="enhanced")
    for event in run_training(request):
        if isinstance(event, Started):
            assert sorted(read) == list(open_clip(clip_path).train_indices)


def test_training_tells_what_it_prepares(eager: None, clip_path: Path, tmp_path: Path) -> None:
    events: list[TrainEvent] = list(run_training(request_of(clip_path, tmp_path / "run")))
    before = events[: [isinstance(event, Started) for event in events].index(True)]
    assert before
    assert all(isinstance(event, Preparing | Planned) for event in before)
    assert isinstance(events[-1], Finished)
    assert "Preparing" not in (tmp_path / "run" / "events.jsonl").read_text()


def test_the_command_prints_it(
    clip_path: Path, tmp_path: Path, vesselsplat: Cli, monkeypatch: pytest.MonkeyPatch
) -> None:
    def slowly(request: TrainRequest) -> Generator[TrainEvent, None, None]:
        for done in range(3):
            now[0] += 3.0
            yield Preparing("matching left and right images", done, 3, now[0], None)
        now[0] += 3.0
        yield Preparing("analysing the clip", 0, 0, 3.0, None)
        now[0] += 3.0
        yield Preparing("analysing the clip", 0, 0, 6.0, None)
        yield from run_training(request)

    now = [0.0]
    monkeypatch.setattr("app.console.progress.time.monotonic", lambda: now[0])
    monkeypatch.setattr("app.commands.train.run_training", slowly)
    call = vesselsplat("train", clip_path, "--run", tmp_path / "run", "--iterations", 2)
    assert call.code == 0
    assert "matching left and right images 1/3, 6 s left" in call.error
    assert "matching left and right images 2/3, 3 s left" in call.error
    assert "analysing the clip, 6 s so far" in call.error


def no_clip(path: Path, options: ClipOptions) -> Clip:
    raise AssertionError("the clip is opened in vain")


def test_a_video_without_depth_is_refused_by_its_header(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "long.avi"
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*"MJPG"), 25.0, (32, 24))
    for _ in range(3):
        writer.write(np.zeros((24, 32, 3), np.uint8))
    writer.release()
    monkeypatch.setattr("app.runs.train_run.open_bare", no_clip)
    request = TrainRequest(clip_path=path, run_path=tmp_path / "run", config=CONFIG)
    with pytest.raises(ClipError, match=r"a video has none \(--depth brightness"):
        next(run_training(request))
    (tmp_path / "text.mp4").write_text("none")
    with pytest.raises(ClipError, match="neither"):
        next(run_training(replace(request, clip_path=tmp_path / "text.mp4")))
    with pytest.raises(AssertionError, match="in vain"):
        next(run_training(replace(request, clip_options=ClipOptions(depth="brightness"))))


def test_a_run_that_cannot_be_written_is_refused_before_the_clip_is_opened(
    clip_path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("app.runs.train_run.open_bare", no_clip)

    # The superuser may write everywhere.
    def no_folder(path: str, *_: object) -> None:
        raise PermissionError(path)

    monkeypatch.setattr(os, "mkdir", no_folder)
    with pytest.raises(UserError, match=r"expected a writable folder for the run.*test_a_run"):
        next(run_training(request_of(clip_path, tmp_path / "deep" / "run")))
    assert list(tmp_path.iterdir()) == []


def test_a_run_below_a_file_is_refused_before_the_clip_is_opened(
    clip_path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("app.runs.train_run.open_bare", no_clip)
    (tmp_path / "file").write_text("")
    for place in ("file/run", "file/deep/run"):
        with pytest.raises(UserError, match=r"expected a folder, got a file as a parent of .*run"):
            next(run_training(request_of(clip_path, tmp_path / place)))


@pytest.mark.skipif(not Path("/proc/self").is_dir(), reason="only Linux has /proc")
def test_a_place_where_no_folder_can_be_made_is_not_called_full(clip_path: Path) -> None:
    with pytest.raises(UserError, match="expected a writable folder for the run, got one that is not: /proc"):
        next(run_training(request_of(clip_path, Path("/proc/run"))))


def test_pairs_that_match_nowhere_are_refused_after_a_few(clip_path: Path, tmp_path: Path) -> None:
    read: list[int] = []
    clip = open_clip(clip_path)

    def unmatched(index: int) -> Frame:
        read.append(index)
        frame = clip.read_frame(index)
        return replace(frame, depth=np.zeros(frame.tissue_mask.shape, np.float32))

    ahead = ReadAhead(
        replace(clip, read_frame=unmatched, depth_origin="stereo"), tmp_path, Window(0, len(clip) - 1)
    )
    with pytest.raises(ClipError, match="none that match in"):
        ahead.fill(lambda done, total: None)
    assert len(read) == 3


@pytest.mark.parametrize("matches", [True, False])
def test_of_a_long_clip_a_window_may_show_nothing_that_matches(
    clip_path: Path, tmp_path: Path, matches: bool
) -> None:
    """As where the endoscope is out of the body at first."""
    read, clip = list[int](), open_clip(clip_path)

    def dark_at_first(index: int) -> Frame:
        read.append(index)
        frame = clip.read_frame(index)
        if matches and index > 5:
            return frame
        return replace(frame, depth=np.zeros(frame.tissue_mask.shape, np.float32))

    source = replace(clip, read_frame=dark_at_first, depth_origin="stereo")
    ahead = ReadAhead(source, tmp_path, Window(0, 5))
    if matches:
        ahead.fill(lambda done, total: None)
        assert {index for index in clip.train_indices if index <= 5} <= set(read)
        ahead.hand_over()
        assert not ahead.clip.read_frame(0).depth_mask.any()
    else:
        with pytest.raises(ClipError, match="none that match in"):
            ahead.fill(lambda done, total: None)
        assert len(read) < 6
