"""Clips of a few frames: measured on what they have, and no run twice."""

from __future__ import annotations

from pathlib import Path

import pytest

from app.report.bench import Bench, Clock, measured_frames
from app.report.measures import paper, training
from app.report.runs import PUBLISHED, STEPS
from app.report.section import Section
from renderer.phantom import PhantomParams, write_phantom
from renderer.train.config import TrainConfig


@pytest.fixture(autouse=True)
def quick(monkeypatch: pytest.MonkeyPatch) -> None:
    for method in STEPS:
        monkeypatch.setitem(STEPS, method, (6,))
    for method in PUBLISHED:
        monkeypatch.setitem(PUBLISHED, method, 9)


def bench(tmp_path: Path, frames: int) -> Bench:
    write_phantom(tmp_path / "clip", PhantomParams(n_frames=frames, width=64, height=48, seed=1), "endonerf")
    return Bench(tmp_path / "clip", (), tmp_path / "work", print)


def runs_of(section: Section) -> list[int]:
    """How many runs each row tells."""
    (table,) = section.tables
    place = [column.name for column in table.columns].index("runs")
    return [int(str(row[place])) for row in table.rows]


def test_a_clip_of_one_frame_is_measured_on_it(tmp_path: Path) -> None:
    one = bench(tmp_path, 1)
    assert one.clip.test_indices == ()
    section = training.measure(one, Clock.of(600))
    assert section.not_measured == ()
    assert runs_of(section)
    assert "measured on 1 training frame (the clip is too short" in section.sentences[0]
    assert "Renders are of 1 training frame" in paper.measure(one, Clock.of(-1)).sentences[0]


def test_a_longer_clip_is_measured_on_held_out_frames(clip_path: Path, tmp_path: Path) -> None:
    clip = Bench(clip_path, (), tmp_path, print).clip
    assert measured_frames(clip) == "2 held-out frames"


@pytest.mark.parametrize("frames", [1, 8, 9, 10])
def test_no_run_is_wanted_twice(tmp_path: Path, frames: int) -> None:
    clip = bench(tmp_path, frames).clip
    wanted = list(training._wanted(clip, TrainConfig(), 3))
    assert len(wanted) == len(set(wanted))


def test_published_methods_are_trained_at_their_published_length_with_every_seed(tmp_path: Path) -> None:
    """On original frames, after all that is shorter."""
    clip = bench(tmp_path, 9).clip
    *others, last = (
        [(config.method, config.seed) for config, kind in training._wanted(clip, TrainConfig(), seeds)
         if (config.iterations, kind) == (9, "original")]
        for seeds in (1, 3)
    )  # fmt: skip
    assert others == [[("deform3dgs", 0), ("endogaussian", 0)]]
    assert last == [(method, seed) for seed in range(3) for method in ("deform3dgs", "endogaussian")]
