"""Deliberate faults against the rows of the stability table that notice them: a mutation score.

python -m tests.benchmarks.stability_faults [--quick] [--jobs N] [--only WORD ...]

Exit code 1 where fewer than TARGET of the faults are noticed, or, of all faults, a row notices none.
"""

from __future__ import annotations

import argparse
import os
import sys
import time
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from multiprocessing import get_context

from tests.benchmarks.stability_faults.faults import Fault
from tests.benchmarks.stability_faults.table import (
    FAULTS,
    AnyRow,
    Key,
    Outcome,
    measured,
    parts,
    possible,
    tried,
    tried_by_name,
    warm,
)

TARGET = 0.95


def main() -> int:
    """Prints each fault with the rows that notice it, then the score and the rows that noticed nothing."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--jobs", type=int)
    parser.add_argument("--only", nargs="*", default=())
    given = parser.parse_args()
    began = time.perf_counter()
    faults = possible([fault for fault in FAULTS if _is_wanted(fault, given.quick, given.only)])
    names = {part for fault in faults for part in fault.parts}
    rows, raised = measured(name for name in parts() if name in names)
    if raised:
        raise RuntimeError(f"without a fault: {raised}")
    failing = frozenset(key for key, row in rows.items() if not row.passed)
    jobs = given.jobs or (1 if given.quick else min(2, os.cpu_count() or 1))
    outcomes = []
    for outcome in _tried(faults, failing, jobs):
        outcomes.append(outcome)
        _tell(outcome)
    whole = len(faults) == len(possible(FAULTS))
    unmoved = _unmoved(rows, failing, outcomes) if whole else None
    score = sum(outcome.noticed for outcome in outcomes) / len(outcomes)
    _sum_up(outcomes, rows, failing, unmoved)
    skipped = len(FAULTS) - len(possible(FAULTS))
    print(f"{skipped} faults need OpenGL, which is not here; {time.perf_counter() - began:.0f} s")
    return int(score < TARGET or bool(unmoved))


def _is_wanted(fault: Fault, quick: bool, words: Sequence[str]) -> bool:
    return (fault.quick or not quick) and (not words or any(word in fault.name for word in words))


def _tried(faults: Sequence[Fault], failing: frozenset[Key], jobs: int) -> Iterator[Outcome]:
    """Here one after another, or in so many processes as they come."""
    if jobs == 1:
        yield from (tried(fault, failing) for fault in faults)
        return
    # Nothing depends on the number of threads, and compiling takes one.
    os.environ.update({f"{library}_NUM_THREADS": "1" for library in ("NUMBA", "OMP", "OPENBLAS", "MKL")})
    with ProcessPoolExecutor(jobs, get_context("spawn"), initializer=warm) as pool:
        waiting = [pool.submit(tried_by_name, fault.name, failing) for fault in faults]
        yield from (done.result() for done in as_completed(waiting))


def _tell(outcome: Outcome) -> None:
    """A line, and below it the rows that notice, hazard by hazard."""
    verdict = "noticed" if outcome.noticed else "MISSED "
    where = f"{len(outcome.failed):3d} of {outcome.looked:3d} rows"
    print(f"{verdict} {where} {outcome.seconds:5.1f} s  {outcome.fault}")
    for hazard, count in Counter(hazard for hazard, _ in outcome.failed).items():
        cases = [case for each, case in outcome.failed if each == hazard]
        print(f"{'':12}{hazard}: {cases[0]}" + (f", and {count - 1} more" if count > 1 else ""))
    for end in outcome.raised:
        print(f"{'':12}ended {end[:120]}")
    sys.stdout.flush()


def _unmoved(rows: Iterable[Key], failing: frozenset[Key], outcomes: Sequence[Outcome]) -> list[Key]:
    moved = {key for outcome in outcomes for key in outcome.failed}
    return [key for key in rows if key not in moved and key not in failing]


def _sum_up(
    outcomes: Sequence[Outcome],
    rows: dict[Key, AnyRow],
    failing: frozenset[Key],
    unmoved: Sequence[Key] | None,
) -> None:
    noticed = [outcome for outcome in outcomes if outcome.noticed]
    for kind, count in Counter(outcome.kind for outcome in outcomes).items():
        print(f"{kind:10}{sum(outcome.kind == kind for outcome in noticed):4d} of {count}")
    for hazard, case in unmoved or ():
        print(f"no fault fails the row {hazard}: {case}")
    if unmoved is not None:
        print(f"{len(unmoved)} rows that no fault fails")
    for hazard, case in sorted(failing):
        print(f"fails without a fault: {hazard}: {case}")
    score = len(noticed) / len(outcomes)
    print(f"{len(noticed)} of {len(outcomes)} faults noticed: score {score:.3f}, target {TARGET}")
    print(f"{len(rows)} rows, {len(failing)} of them failing by themselves")


if __name__ == "__main__":
    sys.exit(main())
