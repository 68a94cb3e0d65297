"""Faults of the gains of frames."""

from __future__ import annotations

from typing import Any

from tests.benchmarks.stability_faults.faults import Fault, edited, rounded

GAINS = "renderer.frame_gains"
PART = "exposure"


def _fault(kind: Any, what: str, old: str, new: str, quick: bool = False) -> Fault:
    return Fault("gains", kind, what, (PART,), edited(GAINS, old, new), quick)


FAULTS: tuple[Fault, ...] = (
    _fault("sign", "of a ratio", "residual = gathered(ratios)", "residual = gathered(-ratios)", quick=True),
    _fault("dropped", "the pull to 1", "+ REST**2 * step", "+ 0 * step"),
    _fault("dropped", "what is cut off", "< CLIPPED)", "<= CLIPPED)"),
    _fault(
        "swapped",
        "the two of a ratio",
        "other.values[both] / one.values[both]",
        "one.values[both] / other.values[both]",
    ),
    _fault("guard", "too little to compare", "LEAST = 100", "LEAST = 0"),
    _fault("other", "the mean for the median", "np.median(np.log", "np.mean(np.log"),
    Fault("gains", "float16", "of all", (PART,), rounded(f"{GAINS}:log_gains")),
)
