"""What training steps measure and how long they take; from that, how long the rest of a training takes.

Steps that compile or load kernels, as the first one does, are no measure of those to come. What is done
between steps and after the last of them counts.
"""

from __future__ import annotations

import math
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Final

import numpy as np

from renderer.train.events import Progress
from renderer.train.held_out import SHARE
from renderer.train.losses import Measured
from renderer.train.recipe import Recipe

PROGRESS_SECONDS: Final = 0.25
SNAPSHOT_SECONDS: Final = 1.0
FULL_COST: Final = 1.7
"""A step at full resolution takes about this many at half resolution; only the time left depends on it."""
COMPILES: Final = 30.0
"""So many usual steps long, a step has compiled something."""
RECENT: Final = 0.25
"""Of the steps done, those whose pace counts for as much as that of all: models grow."""


class Meter:
    """`after`: what follows the last step, in steps at full resolution."""

    def __init__(self, recipe: Recipe, seconds: float, after: float = 0.0) -> None:
        self.seconds = seconds
        self._recipe, self._after = recipe, after
        self._results: list[Measured] = []
        self._paces: list[float] | None = None
        self._stepped, self._between = 0.0, 0.0
        self._n_gaussians = 0
        self._told = self._shown = time.perf_counter()

    def add(self, result: Measured, iteration: int, seconds: float, n_gaussians: int) -> None:
        self.seconds += seconds
        self._n_gaussians = n_gaussians
        self._results.append(result)
        if self._paces is None:
            self._paces, self._between = [], 0.0
        else:
            self._stepped += seconds
            self._paces.append(seconds / self._cost(iteration, iteration + 1))

    @contextmanager
    def between(self) -> Iterator[None]:
        """Work between two steps: frames that are read, checkpoints."""
        began = time.perf_counter()
        yield
        self._between += time.perf_counter() - began

    def progress_is_due(self) -> bool:
        return bool(self._paces) and time.perf_counter() - self._told > PROGRESS_SECONDS

    def snapshot_is_due(self) -> bool:
        due = time.perf_counter() - self._shown > SNAPSHOT_SECONDS
        if due:
            self._shown = time.perf_counter()
        return due

    def progress(self, done: int) -> Progress:
        error = float(np.mean([result.squared_error for result in self._results]))
        event = Progress(
            iteration=done,
            iterations=self._recipe.iterations,
            loss=float(np.mean([result.loss for result in self._results])),
            psnr=-10 * math.log10(max(error, 1e-12)),
            seconds=self.seconds,
            seconds_left=self._left(done),
            n_gaussians=self._n_gaussians,
        )
        self._results, self._told = [], time.perf_counter()
        return event

    def after_steps(self) -> float:
        """Seconds of what follows the last step."""
        return self._after * FULL_COST * self._pace()

    def _left(self, done: int) -> float:
        between = self._between / self._stepped if self._stepped else 0.0
        steps = self._pace() * self._cost(done, self._recipe.iterations)
        return steps * (1 + between + SHARE) + self.after_steps()

    def _pace(self) -> float:
        """Seconds of a step at half resolution."""
        if not self._paces:
            return 0.0
        usual = COMPILES * float(np.median(self._paces))
        paces = [pace for pace in self._paces if pace <= usual]
        recent = paces[-max(round(RECENT * len(paces)), 50) :]
        return float(np.mean(paces) + np.mean(recent)) / 2

    def _cost(self, first: int, end: int) -> float:
        """Expected time of the steps from `first` up to `end`, in steps at half resolution."""
        total, start = 0.0, 0
        for stage in self._recipe.stages:
            steps = max(0, min(end, start + stage.steps) - max(first, start))
            total += steps * (1.0 if stage.half else FULL_COST)
            start += stage.steps
        return total
