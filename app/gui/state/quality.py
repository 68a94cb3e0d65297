"""How good a reconstruction shall be, in words, and how long it takes where that was measured."""

from __future__ import annotations

from app.gui.state.reconstruction import Reconstruction

QUALITIES = {"Draft": 500, "Standard": 3000, "Fine": 6000}
"""Iterations: enough to look at, the default, and twice that."""
OWN = "Custom"


def quality_of(iterations: int) -> str:
    """The word for a number of iterations; OWN for one without a word."""
    return next((name for name, steps in QUALITIES.items() if steps == iterations), OWN)


def expected_seconds(run: Reconstruction) -> float | None:
    """In all, of what is chosen: steps at the pace of the run shown, and what that takes beside them. None
    where it is of another method or has no pace yet."""
    begun, progress = run.request, run.progress
    if begun is None or progress is None or progress.iteration < 1:
        return None
    if (begun.config.method, begun.config.n_gaussians) != (run.config.method, run.config.n_gaussians):
        return None
    steps = progress.seconds / progress.iteration * run.config.iterations
    beside = 0.0 if progress.wall_seconds is None else max(progress.wall_seconds - progress.seconds, 0.0)
    return steps + beside
