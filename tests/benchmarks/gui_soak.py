"""The window used for a long time by a script, at a bounded rate: what grows, leaks or fails.

xvfb-run -a python -m tests.benchmarks.gui_soak CLIP --minutes 60 [--rate 8] [--seed 0]

First everything is done twice, which loads what it needs; then at random, for so many minutes. Every minute
the window comes to rest, and its resident memory, processor share, open files, threads, child processes and
OpenGL objects are printed. Exits with 1 when memory has grown by more than 5 % since then,
or after any OpenGL error, exception, logged warning or process that outlives its job.
"""

from __future__ import annotations

import argparse
import random
import sys
import tempfile
import time
import traceback
from collections.abc import Iterable, Iterator
from pathlib import Path

from imgui_bundle.immapp import testing

from app.gui.state.app_state import AppState
from app.gui.window import Window
from app.gui.work.settings import Places, Settings
from tests.benchmarks.person import Context, Person, quieten
from tests.benchmarks.soak_deeds import DEEDS, Deed
from tests.benchmarks.soak_health import Health, children


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("clip", type=Path)
    parser.add_argument("--minutes", type=float, default=60.0)
    parser.add_argument("--rate", type=float, default=8.0, help="acts a second, at most")
    parser.add_argument("--seed", type=int, default=0)
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        kept = soak(given.clip, Path(folder), given.minutes, given.rate, given.seed)
    sys.exit(0 if kept else 1)


def soak(clip: Path, folder: Path, minutes: float, rate: float, seed: int) -> bool:
    """Whether every bar was kept."""
    places = Places(folder / "config", folder / "runs", folder / "pictures")
    for path in vars(places).values():
        path.mkdir()
    window = Window(AppState(places, Settings(acknowledged=True)))
    health = Health()
    health.watch()
    params = window.runner_params()
    params.ini_disable = True
    params.callbacks.before_swap = health.after_frame

    def drive(ctx: Context) -> None:
        quieten(ctx)
        person = Person(ctx, window, clip, random.Random(seed), rate)
        one_round(person, health, (*DEEDS, *DEEDS))
        health.warm = health.minutes
        while health.minutes < health.warm + minutes and not ctx.is_error():
            one_round(person, health, at_random(person.rng, health))
        print(f"{person.acts} acts")

    try:
        testing.run(test_function=drive, runner_params=params, add_ons_params=window.add_ons())
    except Exception as error:
        traceback.print_exc()
        told = [line for line in str(error).splitlines() if "Error" in line] or [repr(error)]
        health.troubles.append(f"the script ended: {told[-1]}")
    time.sleep(1)
    return health.report(children())


def at_random(rng: random.Random, health: Health) -> Iterator[Deed]:
    """For a minute."""
    end = health.minutes + 1
    while health.minutes < end:
        yield from rng.choices([*DEEDS], [*DEEDS.values()])


def one_round(person: Person, health: Health, deeds: Iterable[Deed]) -> None:
    """Deeds, then rest and a reading."""
    done = []
    person.rest()
    for deed in deeds:
        if person.ctx.is_error():
            break
        done.append(deed.__name__)
        deed(person)
        if person.state.window.banner is not None:
            health.troubles.append(f"{deed.__name__}: {person.state.window.banner.message}")
            person.state.window.banner = None
    if person.ctx.is_error():
        print(f"failed in {done[-1]}", flush=True)
    person.rest()
    if left := children():
        health.troubles.append(f"{len(left)} processes at rest after {', '.join(done)}")
    health.due = True
    person.wait(lambda: not health.due, "a frame")
    print(health.readings[-1], " ", " ".join(done), flush=True)


if __name__ == "__main__":
    main()
