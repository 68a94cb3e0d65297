"""What a sweep asks to keep of trainings that were finished before it asked."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

from app.runs.run_folder import RunFolder
from app.sweeps.folder import JOBS
from app.sweeps.jobs import RENDERS, RUN, Job, JobFolder
from app.sweeps.plan import Plan
from app.sweeps.settings import training_of
from renderer.listing import listed


def to_render(plan: Plan, folder: Path) -> list[Job]:
    """Finished trainings whose renders are asked for and missing, and whose model is there to draw them."""
    return [job for job in _without_renders(plan, folder) if _run(folder, job).is_finished]


def not_kept(plan: Plan, folder: Path) -> Iterator[str]:
    """What finished trainings lack of what is asked for, each in a sentence; of those whose runs are in the
    sweep's folder."""
    failed = to_render(plan, folder)
    if failed:
        facts = JobFolder.of(folder, failed[0].key).failed_facts() or {}
        why = facts.get("reason", "they are not drawn yet")
        yield f"no renders of {_of(failed, plan)}: {why}"
    asked = _finished_trainings(plan, folder) if plan.spec.models else _without_renders(plan, folder)
    gone = [job for job in asked if _run(folder, job).is_run and not _run(folder, job).is_finished]
    if gone:
        wanted = "renders or models" if plan.spec.renders else "models"
        yield (
            f"no model was kept of {_of(gone, plan)}: for their {wanted}, remove their folders in "
            f"{folder / JOBS} and run the sweep again: {listed([job.key for job in gone])}"
        )


def _of(jobs: Sequence[Job], plan: Plan) -> str:
    return f"{len(jobs)} of {len(plan.jobs)} jobs"


def _without_renders(plan: Plan, folder: Path) -> list[Job]:
    """Trainings with `hold_out` draw none."""
    if not plan.spec.renders:
        return []
    return [
        job
        for job in _finished_trainings(plan, folder)
        if (training := training_of(job.settings)) and not training.config.hold_out
        if not (JobFolder.of(folder, job.key).path / RENDERS).is_dir()
    ]


def _finished_trainings(plan: Plan, folder: Path) -> list[Job]:
    return [
        job
        for job in plan.jobs
        if training_of(job.settings) is not None and JobFolder.of(folder, job.key).state == "finished"
    ]


def _run(folder: Path, job: Job) -> RunFolder:
    return RunFolder(JobFolder.of(folder, job.key).path / RUN)
