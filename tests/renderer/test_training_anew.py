"""Training in a folder that holds what an earlier one has left: it begins anew, or goes on with its own."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from renderer.clip import Clip
from renderer.train.checkpoint import checkpoint_paths
from renderer.train.config import TrainConfig
from renderer.train.events import Finished, Started
from renderer.train.trainer import TrainingError
from renderer.train.training import train
from renderer.train.window_files import FOLDER
from tests.renderer.plane import plane_clip

CONFIG = TrainConfig(iterations=12, n_gaussians=60, node_columns=4, checkpoint_every=4)
IN_WINDOWS = replace(CONFIG, window_frames=48)


def numbers(folder: Path) -> list[int]:
    return [int(path.stem.split("-")[1]) for path in checkpoint_paths(folder)]


def long_clip() -> Clip:
    short = plane_clip()
    return replace(
        short,
        cameras=short.cameras[:1] * 80,
        labels=tuple(map(str, range(80))),
        read_frame=lambda index: replace(short.read_frame(index % len(short)), index=index, time=index / 80),
    )


def test_what_is_trained_anew_is_kept_and_gone_on_with(tmp_path: Path) -> None:
    list(train(plane_clip(), CONFIG, folder=tmp_path))
    assert numbers(tmp_path) == [8, 12]
    short = replace(CONFIG, iterations=3, seed=1)
    list(train(plane_clip(), short, folder=tmp_path))
    assert numbers(tmp_path) == [3]
    again = list(train(plane_clip(), short, folder=tmp_path, resume=True))
    assert isinstance(again[0], Started)
    assert again[0].iteration == 3


def test_nothing_is_removed_before_the_training_has_started(tmp_path: Path) -> None:
    list(train(plane_clip(), CONFIG, folder=tmp_path))
    events = train(plane_clip(), CONFIG, folder=tmp_path)
    assert isinstance(next(events), Started)
    events.close()
    assert numbers(tmp_path) == [8, 12]


def test_damaged_checkpoints_do_not_stay_in_place_of_new_ones(tmp_path: Path) -> None:
    for number in (100, 200):
        (tmp_path / f"checkpoint-{number:07d}.safetensors").write_bytes(b"damaged")
    list(train(plane_clip(), CONFIG, folder=tmp_path, resume=True))
    assert numbers(tmp_path) == [8, 12]


@pytest.mark.parametrize("in_windows_first", [True, False])
def test_windows_and_none_take_each_others_place(in_windows_first: bool, tmp_path: Path) -> None:
    clip, (first, second) = long_clip(), (CONFIG, IN_WINDOWS)
    if in_windows_first:
        first, second = second, first
    for config in (first, second):
        assert isinstance(list(train(clip, config, folder=tmp_path))[-1], Finished)
    assert (tmp_path / FOLDER).exists() == (not in_windows_first)
    assert numbers(tmp_path) == ([8, 12] if in_windows_first else [])
    with pytest.raises(TrainingError, match="got another"):
        list(train(clip, replace(second, seed=1), folder=tmp_path, resume=True))
