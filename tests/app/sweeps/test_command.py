"""`vesselsplat sweep` as a person uses it."""

from __future__ import annotations

import errno
import json
import os
from pathlib import Path

import cv2
import numpy as np
import pytest

from app.commands.sweep import print_table
from app.report.section import Column, Table
from app.sweeps.engines import dask
from app.sweeps.jobs import Job, JobFolder
from app.sweeps.plan import Plan, write_sweep
from app.sweeps.spec import all_settings, spec_of
from app.sweeps.worker import sweep_locked
from tests.app.conftest import Cli


@pytest.fixture
def spec(tmp_path: Path) -> Path:
    """Two images, one of which is damaged, and two settings."""
    image = np.random.default_rng(4).integers(40, 200, (24, 32, 3), dtype=np.uint8)
    assert cv2.imwrite(str(tmp_path / "good.png"), image)
    (tmp_path / "bad.png").write_bytes((tmp_path / "good.png").read_bytes()[:200])
    path = tmp_path / "sweep.toml"
    path.write_text('clips = ["*.png"]\ntask = "enhance"\ngrid = {method = ["paper", "clahe"]}\n')
    return path


def test_a_folder_without_images_is_refused_before_anything_is_run(
    vesselsplat: Cli, spec: Path, tmp_path: Path
) -> None:
    (tmp_path / "notes").mkdir()
    (tmp_path / "notes" / "read me.txt").write_text("none")
    spec.write_text('clips = ["good.png", "notes"]\ntask = "enhance"\n')
    out = tmp_path / "out"
    for flags in ((), ("--dry-run",)):
        done = vesselsplat("sweep", spec, "--out", out, *flags)
        assert (done.code, done.out) == (2, "")
        assert done.error == (
            f"vesselsplat: expected a folder with images, found none in {tmp_path / 'notes'}\n"
        )
        assert not out.exists()
    done = vesselsplat("protocol", tmp_path / "notes", "--out", out)
    assert (done.code, out.exists()) == (2, False)
    assert "found none in" in done.error


@pytest.mark.slow
def test_a_failed_job_is_one_line_the_rest_is_done_and_repeated_on_request(
    vesselsplat: Cli, spec: Path, tmp_path: Path
) -> None:
    out = tmp_path / "out"
    asked = vesselsplat("sweep", spec, "--out", out, "--dry-run")
    assert asked.code == 0
    assert "4 jobs on 2 clips: 0 finished, 0 failed, 4 left\ntime left: unknown" in asked.out
    assert not out.exists()
    done = vesselsplat("sweep", spec, "--out", out, "--workers", 1)
    assert done.code == 2
    assert "2 of 4 jobs failed (--retry repeats them): bad.png (2 jobs): " in done.error.splitlines()[-1]
    assert "Traceback" not in done.error
    assert "2 finished, 2 failed" in done.out
    assert {"table.csv", "table.jsonl", "sweep.html", "sweep.json"} <= {path.name for path in out.iterdir()}
    told = {path.name: vesselsplat("info", path).out.splitlines()[1:] for path in out.glob("table.*")}
    assert told["table.csv"][0].endswith("table of a sweep")
    assert all(lines == told["table.csv"] for lines in told.values())
    left = vesselsplat("sweep", spec, "--out", out, "--dry-run")
    assert "2 finished, 2 failed, 0 left\ntime left: 0 s" in left.out
    left = vesselsplat("sweep", spec, "--out", out, "--dry-run", "--retry")
    assert "2 finished, 0 failed, 2 left\n" in left.out
    (tmp_path / "bad.png").write_bytes((tmp_path / "good.png").read_bytes())
    again = vesselsplat("sweep", spec, "--out", out, "--workers", 1, "--retry", "--json")
    assert again.code == 0
    assert json.loads(again.out)["counts"] == {"finished": 2, "failed": 0, "left": 0}


def test_mistakes_are_one_line(
    vesselsplat: Cli, spec: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(dask, "SECONDS", 1)
    for flags, told in (
        ((spec,), "expected --out DIR"),
        ((tmp_path / "none.toml", "--out", tmp_path / "out"), "none.toml"),
        ((tmp_path, "--table"), "expected the folder of a sweep"),
        ((spec, "--out", tmp_path / "out", "--workers", 0), "--workers: expected 1 or more, got '0'"),
        ((spec, "--out", tmp_path / "out", "--on", "tcp://127.0.0.1:9"), "tcp://127.0.0.1:9"),
        ((spec, "--out", tmp_path / "good.png"), "good.png"),
        ((spec, "--out", tmp_path / "out", "--measures", "psnr"), "--measures: expected --table"),
        ((tmp_path, "--table", "--out", tmp_path / "out"), "--out has no effect with --table"),
        ((tmp_path, "--table", "--on", "slurm"), "--on has no effect with --table"),
        ((tmp_path, "--table", "--retry"), "--retry has no effect with --table"),
    ):
        called = vesselsplat("sweep", *flags)
        assert called.code == 2, called
        assert told in called.error
        assert called.error.count("\n") <= 2  # The clips are read before the engine is opened.
        assert "Traceback" not in called.error


def test_where_no_jobs_run_nothing_is_written(vesselsplat: Cli, spec: Path, tmp_path: Path) -> None:
    for more in ((), ("--dry-run",)):
        called = vesselsplat("sweep", spec, "--out", tmp_path / "out", "--on", "slrum", *more)
        assert called.code == 2
        assert "--on: expected local, dask, tcp://HOST:PORT or slurm, got 'slrum'" in called.error
        assert not (tmp_path / "out").exists()


def test_what_a_sweep_that_runs_records_is_not_replaced(vesselsplat: Cli, spec: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    out.mkdir()
    (out / "sweep.json").write_text("of the one that runs")
    with sweep_locked(out):
        called = vesselsplat("sweep", spec, "--out", out)
    assert called.code == 2
    assert "another process" in called.error
    assert (out / "sweep.json").read_text() == "of the one that runs"


@pytest.mark.parametrize("is_new", [True, False])
def test_a_sweep_that_finds_no_room_leaves_nothing(
    vesselsplat: Cli, spec: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, is_new: bool
) -> None:
    def refused(path: Path, content: bytes) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(path))

    out = tmp_path / "out"
    if not is_new:
        out.mkdir()
    monkeypatch.setattr("app.sweeps.plan.write_bytes", refused)
    called = vesselsplat("sweep", spec, "--out", out)
    assert called.code == 2
    assert called.error.endswith(f"No space left on device: {out / 'sweep.json'}\n")
    assert out.exists() is not is_new, "a folder that was there stays"
    assert is_new or not [*out.iterdir()]


def test_info_says_what_a_sweep_has_and_what_is_next(vesselsplat: Cli, tmp_path: Path) -> None:
    spec = spec_of(
        {"clips": ["a.png"], "task": "enhance", "grid": {"z": [0.1, 0.2, 0.3]}}, tmp_path / "s.toml"
    )
    jobs = tuple(Job("enhance", "a.png", "5" * 64, one, 8) for one in all_settings(spec))
    write_sweep(Plan(spec, jobs, {}), tmp_path / "out")
    JobFolder.of(tmp_path / "out", jobs[0].key).finish(jobs[0], {"measures": {}, "seconds": 1.0})
    JobFolder.of(tmp_path / "out", jobs[1].key).fail(jobs[1], "why")
    for path in (tmp_path / "out", tmp_path / "out" / "sweep.json"):
        told = vesselsplat("info", path)
        assert told.code == 0
        assert "3: 1 finished, 1 failed, 1 left" in told.out
        assert "--table" in told.out


def test_a_narrow_terminal_cuts_no_number(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("FORCE_COLOR", "1")
    monkeypatch.setenv("COLUMNS", "80")
    columns = tuple(Column(f"measure {number}") for number in range(12))
    print_table(Table(title="Means", columns=columns, rows=((0.1234,) * len(columns),)))
    assert capsys.readouterr().out.count("0.1234") == len(columns)
