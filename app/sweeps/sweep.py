"""Runs the jobs of a sweep on an engine, and keeps what comes of each."""

from __future__ import annotations

from collections import Counter, deque
from collections.abc import Callable, Collection
from concurrent.futures import FIRST_COMPLETED, CancelledError, Future, wait
from dataclasses import replace
from pathlib import Path
from typing import Final

from app.errors import UserError
from app.files.atomic import write_bytes
from app.sweeps.clip_transfer import packed
from app.sweeps.engines.engine import Engine
from app.sweeps.jobs import PICTURE, JobFolder, Keeps
from app.sweeps.keeping import to_render
from app.sweeps.plan import Plan
from app.sweeps.worker import Order, Outcome, carry_out_order, made_known

MOST_LOSSES: Final = 5
"""Workers that may be lost with one job before it counts as failed: it may be what ends them. Where others
share its fate it runs alone from the first loss on, so that none of them fails with it."""
MOST_SENT: Final = 4_000_000_000
"""Bytes of clips that are on their way to workers at a time."""
LOOK: Final = 1.0
"""Seconds after which progress is told although nothing was finished."""

Report = Callable[[int, str], None]
"""Jobs done of all, and what is to be said beside."""


def run_jobs(
    plan: Plan,
    folder: Path,
    engine: Engine,
    report: Report,
    carry_out: Callable[[Order], Outcome] = carry_out_order,
) -> None:
    """Do what is neither done nor failed, and draw the renders that finished jobs lack; `folder` is recorded.
    `carry_out`: a function of a module, since it is sent to the workers.

    Raises:
        UserError: the engine is gone; finished jobs are kept.
    """
    token, keeps = made_known(folder), Keeps(plan.spec.models, plan.spec.renders)
    places = {job.key: JobFolder.of(folder, job.key) for job in plan.jobs}
    states = {key: place.state for key, place in places.items()}
    rendered = {job.key for job in to_render(plan, folder)}
    waiting = deque(
        Order(job, plan.clip_of(job), folder.absolute(), token, plan.spec.threads, keeps, job.key in rendered)
        for job in plan.jobs
        if states[job.key] == "left" or job.key in rendered
    )
    done, failed = len(plan.jobs) - len(waiting), sum(one == "failed" for one in states.values())
    running: dict[Future[Outcome], Order] = {}
    losses: Counter[str] = Counter()
    report(done, _note(failed, 0))
    while waiting or running:
        alone = losses if engine.shares_fate else ()
        while len(running) < engine.window and (order := next_order(waiting, running.values(), alone)):
            running[engine.executor.submit(carry_out, order)] = order
        finished, _ = wait(running, LOOK, FIRST_COMPLETED)
        for future in finished:
            order = running.pop(future)
            answer = _answer(future, engine, order, losses)
            if isinstance(answer, Order):
                waiting.appendleft(answer)
                continue
            _keep(places[order.job.key], order, answer)
            done, failed = done + 1, failed + (answer.state == "failed")
        report(done, _note(failed, len(running)))


def next_order(
    waiting: deque[Order], running: Collection[Order], alone: Collection[str] = ()
) -> Order | None:
    """Taken from those that wait, in their order; one whose clip is sent along waits until there is room for
    it, since what is on its way lies in the memory of the engine.

    Args:
        alone: keys of jobs that run beside no other.
    """
    if any(order.job.key in alone for order in running):
        return None
    room = MOST_SENT - sum(order.sent for order in running)
    fits = (order for order in waiting if order.sent <= room and order.job.key not in alone)
    found = next(fits if running else iter(waiting), None)
    if found is not None:
        waiting.remove(found)
    return found


def _note(failed: int, running: int) -> str:
    told = [f"{running} running"] if running else []
    return ", ".join([*told, *([f"{failed} failed"] if failed else [])])


def _answer(future: Future[Outcome], engine: Engine, order: Order, losses: Counter[str]) -> Order | Outcome:
    """The order to give once more, or the outcome that stands: a worker may end without a word, or not see
    the clip."""
    try:
        outcome = future.result()
    except CancelledError as error:
        raise UserError(
            f"the connection to {engine.name} was lost: finished jobs are kept, the same command resumes"
        ) from error
    except Exception as error:
        losses[order.job.key] += 1
        if losses[order.job.key] < MOST_LOSSES:
            return order
        reason = f"its worker ended {MOST_LOSSES} times before the job was done"
        return Outcome("failed", reason, f"{type(error).__name__}: {error}")
    if outcome.state != "needs the clip":
        return outcome
    try:
        return replace(order, content=packed(order.clip))
    except (UserError, OSError) as error:
        return replace(outcome, state="failed", reason=f"the worker does not see the clip; {error}")


def _keep(place: JobFolder, order: Order, outcome: Outcome) -> None:
    if outcome.state == "failed":
        place.fail(order.job, outcome.reason, outcome.details)
        return
    if outcome.picture is not None:
        write_bytes(place.path / PICTURE, outcome.picture)
    if outcome.facts is not None:
        place.finish(order.job, outcome.facts)
