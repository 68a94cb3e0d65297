"""What a training needs is told before it starts, and refused where there is no room."""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path

import pytest

from app.__main__ import main
from app.runs import memory
from app.runs.memory import free_memory
from renderer.sources import open_clip
from renderer.train.config import TrainConfig
from renderer.train.demand import demand


@pytest.fixture
def poor(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(memory, "free_memory", lambda: 100_000_000)


def train(clip: Path, run: Path, *flags: str) -> int:
    return main(["train", str(clip), "--run", str(run), "--iterations", "2", *flags])


def test_too_little_memory_is_one_line_before_anything_is_read(
    poor: None,
    clip_path: Path,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("app.runs.train_run.ReadAhead", None)
    assert train(clip_path, tmp_path / "run") == 2
    said = capsys.readouterr().err
    assert "MB of free memory" in said
    assert "got 100 MB" in said
    assert said.count("\n") == 1
    assert not (tmp_path / "run").exists()


def test_a_full_disk_is_told_before_training(
    clip_path: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    usage = shutil.disk_usage(tmp_path)
    monkeypatch.setattr(shutil, "disk_usage", lambda path: usage._replace(free=1_000_000))
    assert train(clip_path, tmp_path / "run") == 2
    said = capsys.readouterr().err
    assert "of free disk" in said
    assert "(free some, or trim the clip" in said


def test_the_need_is_said(clip_path: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert train(clip_path, tmp_path / "run", "--method", "static") == 0
    assert "needs up to 486 MB of memory and 58 MB of disk" in capsys.readouterr().err


def test_frames_beyond_the_bound_cost_disk_and_no_memory(clip_path: Path) -> None:
    clip, config = open_clip(clip_path), TrainConfig(method="static", window_frames=4000)
    camera = replace(clip.cameras[0], width=640, height=512)
    long = [replace(clip, cameras=(camera,) * count) for count in (250, 1000, 4000)]
    needs = [demand(each, config) for each in long]
    assert needs[0].memory == needs[1].memory == needs[2].memory < 2e9
    assert needs[2].disk > 3.9 * needs[1].disk > 0
    curves = [demand(each, TrainConfig(window_frames=4000)) for each in long]
    assert curves[2].memory > 2 * curves[1].memory
    windows = [demand(replace(clip, cameras=(camera,) * count), TrainConfig()) for count in (1000, 10_000)]
    assert windows[0].memory < windows[1].memory < min(1.2 * windows[0].memory, 2e9)


def test_small_tissue_needs_no_more_gaussians_than_it_has_pixels(clip_path: Path) -> None:
    """And small machines are not refused for others."""
    clip = open_clip(clip_path)
    tiny = replace(clip, cameras=(replace(clip.cameras[0], width=8, height=6),) * len(clip))
    for method in ("vesselsplat", "deform3dgs"):
        need = demand(tiny, TrainConfig(method=method))
        assert need.memory < 500_000_000
        assert need.disk < 100_000_000


def test_one_frame_is_not_to_be_trimmed(
    poor: None, clip_path: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert train(clip_path, tmp_path / "run", "--frames", "0:1") == 2
    said = capsys.readouterr().err
    assert "to train on 1 frame of" in said
    assert "trim" not in said


def test_free_memory_is_what_a_container_leaves(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    whole = free_memory()
    for name, value in (("max", 300_000_000), ("current", 250_000_000)):
        (tmp_path / f"memory.{name}").write_text(f"{value}\n")
    (tmp_path / "memory.stat").write_text("anon 5\ninactive_file 20000000\n")
    monkeypatch.setattr("app.runs.memory.CONTAINER", tmp_path)
    assert free_memory() == 70_000_000 < whole
    (tmp_path / "memory.max").write_text("max\n")
    assert free_memory() > 70_000_000
