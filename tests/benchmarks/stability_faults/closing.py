"""Faults of small gaps that are closed."""

from __future__ import annotations

from typing import Any

from tests.benchmarks.stability_faults.faults import Fault, edited, rounded

GAPS = "renderer.rasterize.gaps"


def _fault(kind: Any, what: str, old: str, new: str, quick: bool = False) -> Fault:
    return Fault("closed gaps", kind, what, ("closed gaps",), edited(GAPS, old, new), quick)


FAULTS: tuple[Fault, ...] = (
    _fault("sign", "of what leaves the window", "-_ONE, summed)", "_ONE, summed)", quick=True),
    _fault("sign", "of what shows through", "(_ONE - alpha[x])", "(_ONE + alpha[x])"),
    _fault("dropped", "what leaves the window in a row", "red -= colors[3 * x]", "red -= _NONE"),
    _fault("dropped", "the smoothstep", "t = t * t * (_THREE - _TWO * t)", "t = t"),
    _fault("dropped", "sides of the image", "min(x + radius, width - 1)", "(x + radius)"),
    _fault("swapped", "green and blue", "green += colors[3 * ahead + 1]", "green += colors[3 * ahead + 2]"),
    _fault("guard", "of an empty window", "if t > _NONE else _NONE", "if True else _NONE"),
    _fault("other", "a tile that is not empty passed over", "last]) == _NONE", "last]) >= _NONE"),
    _fault("other", "a row too few", "y + radius < end", "y + radius < end - 1"),
    Fault("closed gaps", "float16", "image", ("closed gaps",), rounded(f"{GAPS}:close", 5, 6)),
)
