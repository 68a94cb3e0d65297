"""The loop that hands jobs out: nothing lost, nothing twice, whatever becomes of the workers."""

from __future__ import annotations

import os
import shutil
import sys
import threading
from collections import deque
from collections.abc import Callable
from concurrent.futures import Executor, Future
from concurrent.futures.process import BrokenProcessPool
from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from app.commands.sweep import PAGE, write_summary
from app.errors import UserError
from app.files.provenance import digest
from app.sweeps.clip_transfer import Missing, located, packed
from app.sweeps.engines.engine import Engine
from app.sweeps.jobs import FAILURE, PICTURE, RESULT, JobFolder, Keeps
from app.sweeps.plan import Plan, estimate, planned, read_sweep, state, write_sweep
from app.sweeps.spec import spec_of
from app.sweeps.summary import Summary
from app.sweeps.sweep import MOST_LOSSES, next_order, run_jobs
from app.sweeps.table import rows
from app.sweeps.worker import Order, Outcome, carry_out_order, sweep_locked

Answer = Callable[[Order], Outcome]


class Here(Executor):
    """Answers at once, in this process."""

    def __init__(self, answer: Answer = carry_out_order) -> None:
        self.orders: list[Order] = []
        self._answer = answer

    def submit(self, function: Callable[..., Any], /, *given: Any, **named: Any) -> Future[Any]:
        future: Future[Any] = Future()
        (order,) = given
        self.orders.append(order)
        try:
            future.set_result(self._answer(order))
        except Exception as error:
            future.set_exception(error)
        return future


@pytest.fixture
def plan(tmp_path: Path) -> Plan:
    """Two pictures, three settings."""
    random = np.random.default_rng(list(tmp_path.name.encode()))
    for name in ("a", "b"):
        image = random.integers(40, 200, (24, 32, 3), dtype=np.uint8)
        assert cv2.imwrite(str(tmp_path / f"{name}.png"), image)
    given = {"clips": ["*.png"], "task": "enhance", "grid": {"z": [0.2, 0.4, 0.6]}}
    return planned(spec_of(given, path := tmp_path / "sweep.toml"), path)


@pytest.fixture
def folder(tmp_path: Path, plan: Plan) -> Path:
    write_sweep(plan, tmp_path / "sweep")
    return tmp_path / "sweep"


def silent(done: int, note: str) -> None:
    """Progress is not looked at."""


def carried_out(plan: Plan, folder: Path, executor: Here, window: int = 2) -> None:
    run_jobs(plan, folder, Engine("here", executor, 1, window), silent)


@pytest.mark.skipif(sys.platform != "linux", reason="such names are a matter of Linux")
def test_a_folder_whose_name_is_not_utf8_has_its_page(plan: Plan, tmp_path: Path) -> None:
    folder = tmp_path / os.fsdecode(b"caf\xe9")
    write_sweep(plan, folder)
    write_summary(folder)
    assert b"caf?" in (folder / PAGE).read_bytes()


def test_every_job_has_a_result_and_a_picture_and_none_is_done_twice(plan: Plan, folder: Path) -> None:
    first, again = Here(), Here()
    carried_out(plan, folder, first)
    assert len(first.orders) == 6
    for job in plan.jobs:
        place = JobFolder.of(folder, job.key)
        result = place.result()
        assert result is not None
        assert result["measures"]["vessel_contrast"] is not None or result["measures"]["dv"] is not None
        assert result["seconds"] > 0
        assert (place.path / PICTURE).is_file()
    carried_out(plan, folder, again)
    assert again.orders == []


def test_a_lost_worker_costs_its_job_another_try(plan: Plan, folder: Path) -> None:
    lost: list[str] = []

    def answer(order: Order) -> Outcome:
        if order.job.key not in lost:
            lost.append(order.job.key)
            raise RuntimeError("killed")
        return carry_out_order(order)

    carried_out(plan, folder, Here(answer))
    assert len(lost) == 6
    assert state(plan.jobs, folder)["finished"] == 6


def test_a_job_that_ends_every_worker_fails_and_the_rest_goes_on(plan: Plan, folder: Path) -> None:
    bad = plan.jobs[1].key

    def answer(order: Order) -> Outcome:
        if order.job.key == bad:
            raise RuntimeError("killed")
        return carry_out_order(order)

    executor = Here(answer)
    carried_out(plan, folder, executor)
    assert sum(order.job.key == bad for order in executor.orders) == MOST_LOSSES
    now = state(plan.jobs, folder)
    assert (now["finished"], now["failed"], now["left"]) == (5, 1, 0)
    facts = JobFolder.of(folder, bad).failed_facts()
    assert facts is not None
    assert "its worker ended 5 times" in facts["reason"]


class OnePool(Here):
    """Where one job ends its worker, all that run are lost."""

    def __init__(self, bad: str) -> None:
        super().__init__()
        self._bad, self._together = bad, list[tuple[Order, Future[Any]]]()

    def submit(self, function: Callable[..., Any], /, *given: Any, **named: Any) -> Future[Any]:
        future: Future[Any] = Future()
        (order,) = given
        if not self._together:
            threading.Timer(0.1, self._end).start()
        self._together.append((order, future))
        return future

    def _end(self) -> None:
        together, self._together = self._together, []
        is_broken = any(order.job.key == self._bad for order, _ in together)
        for order, future in together:
            if is_broken:
                future.set_exception(BrokenProcessPool("killed"))
            else:
                future.set_result(carry_out_order(order))


def test_jobs_that_ran_beside_one_that_ends_its_worker_do_not_fail_with_it(plan: Plan, folder: Path) -> None:
    bad = plan.jobs[1].key
    run_jobs(plan, folder, Engine("here", OnePool(bad), 4, 4, shares_fate=True), silent)
    now = state(plan.jobs, folder)
    assert (now["finished"], now["failed"], now["left"]) == (5, 1, 0)
    assert JobFolder.of(folder, bad).state == "failed"


def test_a_failed_job_keeps_its_reason_until_it_is_repeated(plan: Plan, folder: Path) -> None:
    bad = plan.clips[plan.jobs[0].clip_sha256]
    kept = bad.read_bytes()
    bad.write_bytes(b"no image")
    carried_out(plan, folder, Here())
    failed = [row for row in rows(read_sweep(folder), folder) if row.state == "failed"]
    assert len(failed) == 3
    bad.write_bytes(kept)
    executor = Here()
    carried_out(plan, folder, executor)
    assert executor.orders == []
    for job in plan.jobs:
        JobFolder.of(folder, job.key).forget_failure()
    carried_out(plan, folder, executor)
    assert state(plan.jobs, folder)["finished"] == 6


def test_a_worker_that_sees_no_folder_gives_the_same_results_through_the_engine(
    plan: Plan, folder: Path, tmp_path: Path
) -> None:
    carried_out(plan, folder, Here())
    seen = {row.job: row.measures for row in rows(read_sweep(folder), folder)}
    shutil.rmtree(folder / "jobs")

    def far(order: Order) -> Outcome:
        return carry_out_order(
            replace(order, clip=tmp_path / "elsewhere" / order.clip.name, sweep=tmp_path / "elsewhere")
        )

    executor = Here(far)
    carried_out(plan, folder, executor, window=1)
    sent = [order for order in executor.orders if order.content is not None]
    assert len(sent) == 2  # Once a clip and worker.
    for row in rows(read_sweep(folder), folder):
        steady = {name: value for name, value in row.measures.items() if name != "milliseconds"}
        assert steady == {name: seen[row.job][name] for name in steady}
        assert (JobFolder.of(folder, row.job).path / PICTURE).is_file()


def test_clips_on_their_way_are_bounded_and_hold_nothing_else_up(
    plan: Plan, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("app.sweeps.sweep.MOST_SENT", 1500)
    orders = [Order(job, plan.clip_of(job), folder, "", 1, Keeps(True, True)) for job in plan.jobs]
    waiting = deque(replace(order, content=bytes(1000)) for order in orders[:3])
    waiting.append(orders[3])
    first = next_order(waiting, [])
    assert first is not None
    assert first.sent == 1000
    second = next_order(waiting, [first])
    assert second == orders[3]
    assert next_order(waiting, [first]) is None
    assert len(waiting) == 2
    # One that is larger than the bound still goes, alone.
    monkeypatch.setattr("app.sweeps.sweep.MOST_SENT", 10)
    assert next_order(waiting, []) is not None


def test_clips_of_one_name_are_told_apart(tmp_path: Path) -> None:
    for place, grey in (("1", 60), ("2", 160)):
        (tmp_path / place).mkdir()
        image = np.full((24, 32, 3), grey, np.uint8)
        image[8:12] //= 2
        assert cv2.imwrite(str(tmp_path / place / "x.png"), image)
    given = {"clips": ["1/x.png", "2/x.png"], "task": "enhance", "grid": {"z": [0.2, 0.4]}}
    plan = planned(spec_of(given, path := tmp_path / "sweep.toml"), path)
    write_sweep(plan, tmp_path / "sweep")
    carried_out(plan, tmp_path / "sweep", Here())
    table = rows(read_sweep(tmp_path / "sweep"), tmp_path / "sweep")
    assert {row.clip for row in table} == {f"x.png ({one[:6]})" for one in plan.clips}
    assert len(Summary.of(table, ["z"]).clips) == 2


def test_a_clip_that_changed_is_another_one(plan: Plan, folder: Path) -> None:
    changed = plan.clips[plan.jobs[0].clip_sha256]
    assert cv2.imwrite(str(changed), np.full((24, 32, 3), 90, np.uint8))
    carried_out(plan, folder, Here())
    now = state(plan.jobs, folder)
    assert (now["finished"], now["failed"]) == (3, 3)


def test_a_worker_notices_a_frame_that_is_overwritten_in_place(tmp_path: Path) -> None:
    clip = tmp_path / "clip"
    clip.mkdir()
    for name in ("0.png", "1.png"):
        assert cv2.imwrite(str(clip / name), np.full((24, 32, 3), 100, np.uint8))
    sha256, folder_time = digest(clip), clip.stat().st_mtime_ns
    assert located(clip, sha256, None) == clip
    overwritten = cv2.imencode(".png", np.full((24, 32, 3), 7, np.uint8))[1].tobytes()
    with (clip / "1.png").open("r+b") as file:
        file.write(overwritten)
        file.truncate()
    assert clip.stat().st_mtime_ns == folder_time
    with pytest.raises(Missing):
        located(clip, sha256, None)
    assert located(clip, digest(clip), None) == clip


def test_a_clip_of_files_of_before_1980_is_sent(tmp_path: Path) -> None:
    clip = tmp_path / "clip"
    clip.mkdir()
    assert cv2.imwrite(str(clip / "0.png"), np.full((24, 32, 3), 100, np.uint8))
    os.utime(clip / "0.png", (0, 0))
    sha256 = digest(clip)
    assert digest(located(tmp_path / "nowhere", sha256, packed(clip))) == sha256


def test_content_is_checked_against_the_digest(tmp_path: Path, clip_path: Path) -> None:
    content = packed(clip_path)
    with pytest.raises(UserError, match="got another's"):
        located(tmp_path / "nowhere", "0" * 64, content)


def test_the_time_left_comes_from_jobs_of_the_same_method(plan: Plan, folder: Path) -> None:
    assert estimate(plan.jobs, folder) == (None, 0)
    for job in plan.jobs[:2]:
        JobFolder.of(folder, job.key).finish(job, {"measures": {}, "seconds": 10.0})
    assert estimate(plan.jobs, folder) == (40.0, 2)


def test_two_processes_do_not_run_one_sweep(folder: Path) -> None:
    with sweep_locked(folder), pytest.raises(UserError, match="another process"), sweep_locked(folder):
        pass


def test_a_half_written_result_is_no_result(plan: Plan, folder: Path) -> None:
    place = JobFolder.of(folder, plan.jobs[0].key)
    place.path.mkdir(parents=True)
    (place.path / RESULT).write_text('{"measures": {')
    assert place.state != "finished"
    (place.path / FAILURE).write_text("[]")
    assert place.failed_facts() is None
