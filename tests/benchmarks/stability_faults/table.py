"""All faults, the rows of the stability table, and which of these notice a fault."""

from __future__ import annotations

import time
import warnings
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import cache, partial

from moderngl import Context

import enhance.stability
import enhance.stability_row
import renderer.measuring.stability
from renderer.camera import Camera
from renderer.draw.context import OpenGLUnavailable, standalone_context
from renderer.draw.offscreen import render_offscreen
from renderer.measuring.stability import blending, exact, runs
from renderer.measuring.stability.row import Row
from renderer.measuring.stability.scenes import SCENES
from renderer.splats import Float32Array, Splats
from tests.benchmarks.stability_faults import (
    closing,
    cutting,
    drawing,
    enhancement,
    equations,
    exposure,
    learning,
    motion,
)
from tests.benchmarks.stability_faults import runs as whole_runs
from tests.benchmarks.stability_faults.faults import Fault
from tests.enhance.pictures import vessels

AnyRow = Row | enhance.stability_row.Row
Key = tuple[str, str]
"""Hazard and case of a row."""
FAULTS: tuple[Fault, ...] = (
    *drawing.FAULTS,
    *cutting.FAULTS,
    *closing.FAULTS,
    *motion.FAULTS,
    *learning.FAULTS,
    *whole_runs.FAULTS,
    *enhancement.FAULTS,
    *equations.FAULTS,
    *exposure.FAULTS,
)


@dataclass(frozen=True)
class Outcome:
    """What came of one fault."""

    fault: str
    kind: str
    looked: int
    """Rows that were measured."""
    failed: tuple[Key, ...]
    """Those of them that fail by it."""
    raised: tuple[str, ...]
    """What ended parts of the table."""
    seconds: float

    @property
    def noticed(self) -> bool:
        """By any row, or by an end that no report survives."""
        return bool(self.failed or self.raised)


@cache
def parts() -> dict[str, Callable[[], Iterable[AnyRow]]]:
    """The table's rows, by what they are of."""
    picture = vessels(96, 130)
    found: dict[str, Callable[[], Iterable[AnyRow]]] = dict(renderer.measuring.stability.PARTS)
    found["OpenGL"] = _opengl
    for name, part in enhance.stability.PARTS.items():
        found[f"enhancement, {name}"] = partial(part, picture)
    return found


@cache
def _context() -> Context:
    """Made when the first picture is drawn."""
    return standalone_context()


def _opengl() -> Iterable[AnyRow]:
    def draw(splats: Splats, camera: Camera, near: float) -> Float32Array:
        return render_offscreen(_context(), splats, camera, near=near)

    return blending.pictures("OpenGL: image", draw)


def warm() -> None:
    """What faults must not meet half made: oracles, phantoms, and the kernels as they are."""
    for scene in SCENES:
        exact.of_scene(scene)
    runs.warm()


def measured(names: Iterable[str]) -> tuple[dict[Key, AnyRow], tuple[str, ...]]:
    """Rows of these parts, and what ended some of them."""
    rows: dict[Key, AnyRow] = {}
    raised = []
    for name in names:
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                for row in parts()[name]():
                    rows[row.hazard, row.case] = row
        except Exception as error:  # a fault may end in anything
            raised.append(f"{name}: {type(error).__name__}: {error}")
    return rows, tuple(raised)


def tried(fault: Fault, failing: frozenset[Key]) -> Outcome:
    """One, beside the rows that fail without it."""
    began = time.perf_counter()
    with fault.change():
        rows, raised = measured(fault.parts)
    failed = tuple(key for key, row in rows.items() if not row.passed and key not in failing)
    return Outcome(fault.name, fault.kind, len(rows), failed, raised, time.perf_counter() - began)


def tried_by_name(name: str, failing: frozenset[Key]) -> Outcome:
    """In another process, which faults cannot be sent to."""
    return tried(next(fault for fault in FAULTS if fault.name == name), failing)


def possible(faults: Sequence[Fault]) -> list[Fault]:
    """All, or without OpenGL all others."""
    try:
        _context()
    except OpenGLUnavailable:
        return [fault for fault in faults if "OpenGL" not in fault.parts]
    return list(faults)
