"""How long a live picture takes to the screen, measured on the screen itself, beside a moving slider.

python -m tests.benchmarks.live_delay CLIP [--kinds painted udp http] [--sizes 1280x720 ...] [--rates 30]
    [--methods paper vessel] [--seconds 30] [--screen 1280x720] [--alone] [--still]

The time of each frame's capture is painted into it. A virtual display keeps its screen in a file, in which
another program looks for the painted time without rest: capture to screen is the whole way, of streams also
their encoding and their transport. Arrival to swap is what the window says itself. A hand moves a slider all
the while, by the display's own mouse.
"""

from __future__ import annotations

import argparse
import itertools
import json
import os
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any, Final

import numpy as np

from tests.benchmarks.live_delay.screen import Screen, display
from tests.benchmarks.live_delay.time_code import age, middles, read
from tests.benchmarks.live_delay.window import METHODS, PAINTED, Trial
from tests.ports import free_port

LOOK: Final = 5e-4
"""Seconds from one look at the screen to the next."""
OLDEST: Final = 30.0
"""Seconds beyond which a time that is read is taken for an accident."""
STREAMS: Final = {
    "udp": (
        "udp://127.0.0.1:{port}",
        "-c:v libx264 -preset ultrafast -tune zerolatency -b:v 20M -g 30 -f mpegts udp://127.0.0.1:{port}?pkt_size=1316",
    ),
    "http": (
        "http://127.0.0.1:{port}/",
        "-c:v mjpeg -q:v 3 -f mpjpeg -listen 1 http://127.0.0.1:{port}/",
    ),
}
SLIDER: Final = {(1280, 720): ((1000, 1200), 250)}
"""Of a screen, the first and last x and the y of what the hand moves."""
PACE: Final = 0.05
"""Seconds from one move of the hand to the next."""


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("clip", type=Path)
    parser.add_argument("--kinds", nargs="+", default=[PAINTED], choices=[PAINTED, *STREAMS])
    parser.add_argument("--sizes", nargs="+", type=size_of, default=[(1280, 720)])
    parser.add_argument("--rates", nargs="+", type=float, default=[30.0])
    parser.add_argument("--methods", nargs="+", default=["paper"], choices=[*METHODS])
    parser.add_argument("--seconds", type=float, default=30.0)
    parser.add_argument("--screen", type=size_of, default=(1280, 720))
    parser.add_argument("--alone", action="store_true", help="the picture alone, as on a theatre monitor")
    parser.add_argument("--still", action="store_true", help="no hand on the slider")
    given = parser.parse_args()
    print(f"load {os.getloadavg()[0]:.1f} at the start")
    print(
        "kind size rate method | capture to screen, arrival to swap, arrival to enhanced: median/p95/worst ms"
        " | on screen, frames/s, dropped, cores, MB"
    )
    for kind, size, rate, method in itertools.product(given.kinds, given.sizes, given.rates, given.methods):
        trial = Trial(str(given.clip), kind, *size, rate, method, given.alone, given.seconds)  # type: ignore[call-arg]
        print(row(trial, *measured(trial, given.screen, still=given.still)), flush=True)


def measured(trial: Trial, size: tuple[int, int], *, still: bool) -> tuple[dict[str, Any], list[float]]:
    """What the window said, and the delay of each picture that was seen on the screen."""
    with (
        tempfile.TemporaryDirectory() as folder,
        display(Path(folder), size) as (name, screen),
        fed(trial) as address,
    ):
        command = [sys.executable, "-m", "tests.benchmarks.live_delay.window"]
        given = json.dumps(asdict(replace(trial, kind=address)))
        window = subprocess.Popen(
            [*command, given], env=os.environ | {"DISPLAY": name}, stdout=subprocess.PIPE, text=True
        )
        try:
            assert window.stdout is not None
            left, top, width, height = json.loads(window.stdout.readline())["box"]
            over = threading.Event()
            if not (still or trial.alone):
                threading.Thread(target=move, args=(name, size, over), daemon=True).start()
            seen = Looking(screen, round(top + height / 2), round(left), round(left + width))
            threading.Thread(target=seen.look, args=(over,)).start()
            said = json.loads(window.stdout.readline())
            over.set()
            window.wait()
            return said, seen.delays
        finally:
            window.kill()


class Looking:
    """At the row of the screen through the painted time."""

    def __init__(self, screen: Screen, y: int, left: int, right: int) -> None:
        self._row, self._places = screen.row(y, left, right), middles(right - left)
        self.delays: list[float] = []
        """Seconds, of each painted time when it was first on the screen."""

    def look(self, over: threading.Event) -> None:
        """What has not changed is not read again: looking takes time from what is looked at."""
        before, last = np.zeros(0, np.uint8), None
        while not over.is_set():
            time.sleep(LOOK)
            levels, now = self._row[self._places], time.perf_counter()
            if np.array_equal(levels, before):
                continue
            before, shown = levels, read(levels)
            if shown is not None and shown != last and age(shown, now) < OLDEST:
                self.delays.append(age(shown, now))
                last = shown


def move(name: str, size: tuple[int, int], over: threading.Event) -> None:
    """A hand that holds a slider and moves it to and fro."""
    (first, last), y = SLIDER[size]
    steps = [*range(first, last, 10), *range(last, first, -10)]

    def do(*said: object) -> None:
        subprocess.run(["xdotool", *map(str, said)], env=os.environ | {"DISPLAY": name}, check=True)

    do("mousemove", first, y, "mousedown", 1)
    for x in itertools.cycle(steps):
        if over.wait(PACE):
            return
        do("mousemove", x, y)


@contextmanager
def fed(trial: Trial) -> Iterator[str]:
    """The address of the stream, which ffmpeg serves; itself where it is none."""
    if trial.kind not in STREAMS:
        yield trial.kind
        return
    port = free_port()
    address, options = (text.format(port=port) for text in STREAMS[trial.kind])
    size, rate = (trial.width, trial.height), trial.frames_per_second
    painter = [
        sys.executable,
        "-m",
        "tests.benchmarks.live_delay.painted",
        trial.clip,
        *map(str, (*size, rate)),
    ]
    given = f"-f rawvideo -pix_fmt rgb24 -s {size[0]}x{size[1]} -r {rate:g} -i -"
    # Encoders with threads hold back a frame for each.
    encoder = f"ffmpeg -loglevel error {given} -threads 1 {options}"
    with subprocess.Popen(painter, stdout=subprocess.PIPE) as frames:
        stream = subprocess.Popen(encoder.split(), stdin=frames.stdout)
        try:
            yield address
        finally:
            stream.kill()
            frames.kill()


def row(trial: Trial, said: dict[str, Any], delays: list[float]) -> str:
    seen = (
        "/".join(f"{1000 * np.percentile(delays, share):.0f}" for share in (50, 95, 100)) if delays else "-"
    )
    own = ", ".join(
        "/".join(f"{one[name]:.0f}" for name in ("median", "p95", "worst")) if one else "-"
        for one in (said["to_screen"], said["to_ready"])
    )
    rate = said["frames"] / trial.seconds
    memory = "->".join(f"{one:.0f}" for one in said["memory"])
    return (
        f"{trial.kind} {trial.width}x{trial.height} {trial.frames_per_second:g} {trial.method} | "
        f"{seen}, {own} | "
        f"{len(delays)} of {said['arrived']} on screen, {rate:.1f}/s drawn, {said['dropped']} dropped, "
        f"{said['moves']} moves, {said['cores']:.2f} cores, {memory} MB"
    )


def size_of(said: str) -> tuple[int, int]:
    width, _, height = said.partition("x")
    return int(width), int(height)


if __name__ == "__main__":
    main()
