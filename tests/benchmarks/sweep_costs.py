"""What a sweep costs beside its jobs, and what it withstands: `python -m tests.benchmarks.sweep_costs PART`.

overhead: jobs a second of empty jobs on each engine, and bytes on disk.
efficiency: sum of the jobs' seconds over workers times wall time, at 1 and 2 workers.
losses: 240 short trainings on processes, and on dask while a worker is killed every 20 s and the client at
random moments; the tables must be the same, and nothing finished may be done again.
"""

from __future__ import annotations

import json
import random
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

import cv2
import numpy as np
import psutil

from app.sweeps.engines.opening import open_engine
from app.sweeps.plan import Plan, planned, state, write_sweep
from app.sweeps.spec import Slurm, spec_of
from app.sweeps.sweep import run_jobs
from app.sweeps.worker import Order, Outcome
from renderer.phantom import PhantomParams, write_phantom

EMPTY = 2000
"""Jobs without work."""
TIMED = ("ms_per_frame", "wall_seconds", "train_seconds")
KILLED_EVERY, CLIENT_LIVES = 20.0, (25.0, 60.0)
"""Seconds from one killed worker to the next, and bounds on those of a client."""


def nothing(order: Order) -> Outcome:
    return Outcome("finished", facts={"measures": {"dv": 1.0}, "seconds": 0.0})


def overhead(work: Path) -> None:
    assert cv2.imwrite(str(work / "a.png"), np.full((16, 16, 3), 90, np.uint8))
    values = np.linspace(0, 1, EMPTY).round(5).tolist()
    spec = spec_of({"clips": ["a.png"], "task": "enhance", "grid": {"z": values}}, work / "s.toml")
    began = time.perf_counter()
    plan = planned(spec, work / "s.toml")
    print(f"planning: {len(plan.jobs) / (time.perf_counter() - began):.0f} jobs/s")
    for on in ("local", "dask"):
        folder = work / on
        write_sweep(plan, folder)
        with open_engine(on, workers=2, threads=1, slurm=Slurm(), folder=folder) as engine:
            run_jobs(_first(plan, 4), folder, engine, _silent, nothing)  # Workers have begun.
            began = time.perf_counter()
            run_jobs(plan, folder, engine, _silent, nothing)
            seconds = time.perf_counter() - began
        began = time.perf_counter()
        state(plan.jobs, folder)
        looked = time.perf_counter() - began
        size = sum(path.stat().st_size for path in folder.rglob("*") if path.is_file()) / len(plan.jobs)
        print(
            f"{on}: {len(plan.jobs) / seconds:.0f} empty jobs/s, {size:.0f} bytes a job, "
            f"{len(plan.jobs) / looked:.0f} jobs/s looked through at a start"
        )


def _first(plan: Plan, count: int) -> Plan:
    return Plan(plan.spec, plan.jobs[:count], plan.clips)


def _silent(done: int, note: str) -> None:
    """Nothing is shown."""


def efficiency(work: Path) -> None:
    """Trainings of about two seconds."""
    write_phantom(work / "clip", PhantomParams(n_frames=8, width=96, height=64))
    given = {"clips": ["clip"], "task": "train", "seeds": list(range(24))}
    settings = {"iterations": 300, "n_gaussians": 800}
    plan = planned(spec_of(given | {"settings": settings}, path := work / "s.toml"), path)
    for workers in (1, 2):
        folder = work / f"of-{workers}"
        write_sweep(plan, folder)
        with open_engine("local", workers=workers, threads=1, slurm=Slurm(), folder=folder) as engine:
            run_jobs(_first(plan, 2 * workers), folder, engine, _silent)  # Kernels are loaded.
            began = time.perf_counter()
            run_jobs(plan, folder, engine, _silent)
            wall = time.perf_counter() - began
        keys = [job.key for job in plan.jobs[2 * workers :]]
        seconds = [json.loads((folder / "jobs" / key / "result.json").read_text())["seconds"] for key in keys]
        share = sum(seconds) / (workers * wall)
        print(f"{workers} workers: {sum(seconds):.1f} s of jobs in {wall:.1f} s, efficiency {share:.3f}")


def losses(work: Path) -> None:
    for seed in range(4):
        write_phantom(work / f"p{seed}", PhantomParams(n_frames=6, width=48, height=32, seed=seed))
    spec = work / "sweep.toml"
    spec.write_text(
        'clips = ["p?"]\ntask = "train"\nseeds = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9]\n'
        "settings = {iterations = 60, n_gaussians = 150}\n"
        'grid = {method = ["vesselsplat", "static", "deform3dgs"], depth_weight = [0.1, 0.4]}\n'
    )
    began = time.perf_counter()
    _run(spec, work / "whole")
    print(f"processes, undisturbed: {_facts(work / 'whole')}, {time.perf_counter() - began:.0f} s")
    for on in ("local", "dask"):
        began = time.perf_counter()
        clients, workers, again = _disturbed(spec, work / on, on)
        same = "the same" if _table(work / on) == _table(work / "whole") else "ANOTHER ONE"
        print(
            f"{on}: {clients} clients and {workers} workers killed, {again} finished jobs done again, "
            f"{_facts(work / on)}, {time.perf_counter() - began:.0f} s, table {same}"
        )


def _command(spec: Path, out: Path, on: str) -> list[str]:
    return [sys.executable, "-m", "app", "sweep", str(spec), "--out", str(out), "--on", on, "--workers", "2"]


def _run(spec: Path, out: Path) -> None:
    subprocess.run(_command(spec, out, "local"), check=True, capture_output=True)


def _disturbed(spec: Path, out: Path, on: str) -> tuple[int, int, int]:
    """Clients and workers killed, and results that were written twice."""
    chance = random.Random(0)
    clients = workers = 0
    seen: dict[str, int] = {}
    again = 0
    while True:
        client = subprocess.Popen(
            _command(spec, out, on), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
        )
        end, next_kill = time.monotonic() + chance.uniform(*CLIENT_LIVES), time.monotonic() + KILLED_EVERY
        while client.poll() is None and time.monotonic() < end:
            time.sleep(0.5)
            for key, written in _written(out).items():
                again += seen.setdefault(key, written) != written
                seen[key] = written
            if time.monotonic() > next_kill and (victims := list(_workers(client))):
                chance.choice(victims).kill()
                workers, next_kill = workers + 1, time.monotonic() + KILLED_EVERY
        if client.poll() is not None:
            return clients, workers, again
        client.kill()
        client.wait()
        clients += 1


def _workers(client: subprocess.Popen[bytes]) -> Iterator[psutil.Process]:
    """The processes that do jobs, of any depth: their nannies are not among them."""
    for process in psutil.Process(client.pid).children(recursive=True):
        try:
            if "spawn_main" in " ".join(process.cmdline()) and not process.children():
                yield process
        except psutil.Error:
            continue


def _written(out: Path) -> dict[str, int]:
    return {path.parent.name: path.stat().st_mtime_ns for path in out.glob("jobs/*/result.json")}


def _table(out: Path) -> list[dict[str, object]]:
    """Without what depends on time and place."""
    rows = [json.loads(line) for line in (out / "table.jsonl").read_text().splitlines()]
    left_out = (*TIMED, "seconds", "peak_memory_mb", "machine")
    return [{name: value for name, value in row.items() if name not in left_out} for row in rows]


def _facts(out: Path) -> str:
    rows = [json.loads(line) for line in (out / "table.jsonl").read_text().splitlines()]
    counts = {name: sum(row["state"] == name for row in rows) for name in ("finished", "failed", "left")}
    return ", ".join(f"{count} {name}" for name, count in counts.items())


def main(part: str) -> None:
    with tempfile.TemporaryDirectory() as work:
        {"overhead": overhead, "efficiency": efficiency, "losses": losses}[part](Path(work))


if __name__ == "__main__":
    main(sys.argv[1])
