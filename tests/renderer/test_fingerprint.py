"""A training goes on from a checkpoint of the same frames alone."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from renderer.clip import Clip, Frame
from renderer.train.checkpoint import checkpoint_paths, read_newest_checkpoint, write_checkpoint
from renderer.train.config import TrainConfig
from renderer.train.events import Progress, Started
from renderer.train.fingerprint import former_fingerprint
from renderer.train.trainer import TrainingError
from renderer.train.training import train
from renderer.train.window_files import finished, folder_of
from renderer.train.windows import windows_of
from tests.renderer.plane import plane_clip

CONFIG = TrainConfig(iterations=12, n_gaussians=60, node_columns=4, checkpoint_every=4)


def shown(clip: Clip, change: Callable[[Frame], Frame]) -> Clip:
    return replace(clip, read_frame=lambda index: change(clip.read_frame(index)))


def moved(clip: Clip) -> Clip:
    pose = np.eye(4)
    pose[0, 3] = 1.0
    return clip.through((*clip.cameras[:-1], clip.cameras[-1].moved(pose)))


OTHERS: dict[str, Callable[[Clip], Clip]] = {
    "split": lambda clip: replace(clip, split="even-odd"),
    "images": lambda clip: shown(clip, lambda frame: replace(frame, image=255 - frame.image)),
    "masks": lambda clip: shown(clip, lambda frame: replace(frame, tissue_mask=_half(frame))),
    "depth": lambda clip: shown(clip, lambda frame: replace(frame, depth=_twice(frame))),
    "cameras": moved,
}


def _half(frame: Frame) -> np.ndarray[tuple[int, ...], np.dtype[np.bool_]]:
    mask = frame.tissue_mask.copy()
    mask[: len(mask) // 2] = False
    return mask


def _twice(frame: Frame) -> np.ndarray[tuple[int, ...], np.dtype[np.float32]]:
    assert frame.depth is not None
    return 2 * frame.depth


def interrupted(clip: Clip, config: TrainConfig, folder: Path) -> int:
    events = train(clip, replace(config, iterations=100_000), folder=folder)
    done = next(event.iteration for event in events if isinstance(event, Progress))
    events.close()
    return done


def goes_on_at(clip: Clip, config: TrainConfig, folder: Path) -> int:
    events = train(clip, replace(config, iterations=100_000), folder=folder, resume=True)
    started = next(events)
    events.close()
    assert isinstance(started, Started)
    return started.iteration


@pytest.mark.parametrize("what", OTHERS)
def test_what_another_clip_of_the_same_names_has_left_is_refused(what: str, tmp_path: Path) -> None:
    clip = plane_clip()
    done = interrupted(clip, CONFIG, tmp_path)
    with pytest.raises(TrainingError, match="this clip and configuration, got another"):
        goes_on_at(OTHERS[what](clip), CONFIG, tmp_path)
    assert goes_on_at(clip, CONFIG, tmp_path) == done


def test_depth_that_is_reckoned_anew_may_differ(tmp_path: Path) -> None:
    clip = replace(plane_clip(), depth_origin="monocular")
    done = interrupted(clip, CONFIG, tmp_path)
    assert goes_on_at(OTHERS["depth"](clip), CONFIG, tmp_path) == done


def test_trainings_of_earlier_versions_go_on(tmp_path: Path) -> None:
    clip = plane_clip()
    done = interrupted(clip, CONFIG, tmp_path)
    newest = read_newest_checkpoint(tmp_path)
    assert newest is not None
    known_as = former_fingerprint(clip, replace(CONFIG, iterations=100_000))
    assert newest.fingerprint != known_as
    for path in checkpoint_paths(tmp_path):
        path.unlink()
    write_checkpoint(tmp_path, replace(newest, fingerprint=known_as))
    assert goes_on_at(clip, CONFIG, tmp_path) == done


def test_windows_that_another_clip_has_left_are_refused(tmp_path: Path) -> None:
    short, count = plane_clip(), 80
    clip = replace(
        short,
        cameras=short.cameras[:1] * count,
        labels=tuple(map(str, range(count))),
        read_frame=lambda at: replace(short.read_frame(at % len(short)), index=at, time=at / count),
    )
    config = replace(CONFIG, window_frames=48)
    list(train(clip, config, folder=tmp_path))
    assert isinstance(next(train(clip, config, folder=tmp_path, resume=True)), Started)
    first = windows_of(clip, config)[0]
    assert finished(folder_of(tmp_path, first)).fingerprint != former_fingerprint(first.of(clip), config)
    with pytest.raises(TrainingError, match="a window of this clip and configuration, got another"):
        list(train(OTHERS["images"](clip), config, folder=tmp_path, resume=True))
