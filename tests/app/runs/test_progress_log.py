"""What events.jsonl says of a run, whichever version wrote it."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path

from app.runs.progress_log import told
from app.runs.run_folder import RunFolder
from renderer.train.events import Evaluated, Progress, Started

STEP = Progress(10, 20, 0.5, 20.0, 1.0, 9.0, 30)


def test_events_come_back_as_they_were_logged(tmp_path: Path) -> None:
    run, events = RunFolder(tmp_path), (STEP, Evaluated(10, 21.0, 0.25), Evaluated(20, 22.0))
    for event in events:
        run.log(event)
    said = told(run)
    assert said.progress == events[:1]
    assert said.evaluated == events[1:]
    assert said.until(10).evaluated == events[1:2]


def test_steps_that_were_done_again_are_told_once(tmp_path: Path) -> None:
    """Killed after step 500 and 450 with a checkpoint of 300, and after 430 with one of 400."""
    run = RunFolder(tmp_path)
    for start, steps in ((0, range(100, 501, 100)), (300, (350, 450)), (300, (330, 430)), (400, (401, 600))):
        run.log(Started(start, 600, 30, ()))
        for step in steps:
            run.log(replace(STEP, iteration=step))
            run.log(Evaluated(step, 20.0 + start))
    said = told(run)
    assert [event.iteration for event in said.progress] == [100, 200, 300, 330, 401, 600]
    assert [event.psnr for event in said.evaluated] == [20.0, 20.0, 20.0, 320.0, 420.0, 420.0]


def test_lines_of_older_and_newer_versions_and_broken_ones_load_as_far_as_they_go(tmp_path: Path) -> None:
    lines = [
        {"event": "Evaluated", "iteration": 5, "psnr": 20.0},  # As before there was a depth error.
        {"event": "Evaluated", "iteration": 6, "psnr": 20.5, "depth_rmse": None, "lpips": 0.1},
        {"event": "Evaluated", "iteration": 7, "psnr": None, "depth_rmse": 0.5},  # Infinite, or of nothing.
        {"event": "Evaluated", "iteration": "8", "psnr": True},
        {"event": "Progress", "iteration": 9},
        {"event": "Other"},
    ]
    text = "\n".join(json.dumps(line) for line in lines) + "\n{half"
    (tmp_path / "events.jsonl").write_text(text, encoding="utf-8")
    said = told(RunFolder(tmp_path))
    assert said.evaluated[:2] == (Evaluated(5, 20.0), Evaluated(6, 20.5))
    ((last, psnr, depth),) = (tuple(vars(one).values()) for one in said.evaluated[2:])
    assert (last, math.isnan(psnr), depth) == (7, True, 0.5), "no training PSNR in its place"
    assert said.progress == ()


def test_a_finished_run_took_as_long_as_its_end_says(tmp_path: Path) -> None:
    first, last = (replace(STEP, iteration=step, wall_seconds=0.5 * step) for step in (10, 20))
    lines = [
        {"event": "Progress", **vars(first)},
        {"event": "Progress", **vars(last)},
        {"event": "Finished", "iteration": 20, "seconds": 9.0, "wall_seconds": 13.0},
    ]
    path = tmp_path / "events.jsonl"
    path.write_text("\n".join(json.dumps(line) for line in lines[:2]) + "\n", encoding="utf-8")
    assert told(RunFolder(tmp_path)).progress == (first, last)
    path.write_text("\n".join(json.dumps(line) for line in lines) + "\n", encoding="utf-8")
    assert told(RunFolder(tmp_path)).progress == (first, replace(last, wall_seconds=13.0))
