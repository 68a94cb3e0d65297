from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from renderer.measuring.ablation import ablation
from renderer.phantom import PhantomParams, write_phantom
from renderer.sources import open_clip
from renderer.train.config import TrainConfig
from renderer.train.needs import decide
from renderer.train.trainer import split

CONFIG = TrainConfig(iterations=40, n_gaussians=500, hold_out=True)


def test_a_part_that_is_kept_in_weighs_more_and_is_not_left_out(tmp_path: Path) -> None:
    write_phantom(tmp_path / "clip", PhantomParams(n_frames=12, width=96, height=72))
    clip = open_clip(tmp_path / "clip")
    frames = [clip.read_frame(index) for index in split(clip, CONFIG)[0]]
    left_out = decide(clip, frames, CONFIG).omitted
    assert "harmonics" in [omission.part for omission in left_out]
    assert None not in [omission.part for omission in left_out]
    without, kept = ablation(clip, [CONFIG, replace(CONFIG, keep=("harmonics",))], timed_steps=12)
    assert "harmonics" in {each.part for each in without.omitted} - {each.part for each in kept.omitted}
    assert kept.megabytes > without.megabytes
    assert min(without.milliseconds, kept.milliseconds, without.spread, kept.spread) > 0
    assert 5 < without.psnr < 50


def test_pairs_of_one_seed_repeat(tmp_path: Path) -> None:
    write_phantom(tmp_path / "clip", PhantomParams(n_frames=10, width=96, height=72, tissue="static"))
    clip = open_clip(tmp_path / "clip")
    config = replace(CONFIG, iterations=10)
    first, second = ablation(clip, [config, config], timed_steps=4)
    assert (first.psnr, first.megabytes) == (second.psnr, second.megabytes)


def test_a_single_picture_is_its_own_measure(tmp_path: Path) -> None:
    write_phantom(tmp_path / "clip", PhantomParams(n_frames=1, width=96, height=72))
    config = replace(CONFIG, hold_out=False)
    schedules = [replace(config, iterations=count) for count in (1, 60)]
    early, late = ablation(open_clip(tmp_path / "clip"), schedules, timed_steps=4)
    assert 5 < early.psnr < late.psnr < 60
