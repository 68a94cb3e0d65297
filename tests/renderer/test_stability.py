"""Every stiff or extreme case is a test; what float32 cannot do is known, and said."""

from __future__ import annotations

import moderngl
import pytest

from renderer.draw.offscreen import render_offscreen
from renderer.stability import stability
from renderer.stability.blending import pictures
from renderer.stability.row import Row

ROWS = list(stability())
KNOWN = {
    ("gradients of (13)-(16)", "scales of 1e-8 and 1e8"),
    ("Adam", "gradients of 1e+20"),
}
"""Whose failure the report states, with what is done then."""


@pytest.mark.parametrize("row", ROWS, ids=lambda row: f"{row.hazard}: {row.case}")
def test_every_row_passes_but_those_known(row: Row) -> None:
    if (row.hazard, row.case) in KNOWN:
        assert not row.passed, "passes now: no longer a known failure"
        assert row.done
    else:
        assert row.passed, f"{row.measured:g} {row.unit}, expected at most {row.bar:g}"


def test_each_case_is_there_once_and_every_hazard_of_the_design() -> None:
    cases = [(row.hazard, row.case) for row in ROWS]
    assert len(set(cases)) == len(cases)
    told = " ".join(f"{hazard} {case}" for hazard, case in cases)
    for word in (
        *("anisotropy 1e6", "scales of 1e-8", "scales of 1e8", "q = 0", "z at the near plane", "opacity 0"),
        *(
            "opacity 1",
            "1e6 on one ray",
            "one camera",
            "one frame",
            "empty mask",
            "depth all 0",
            "width -> 0",
        ),
        *("learning rates x100", "Adam", "density control", "initialisation", "spline", "FDM", "planes"),
    ):
        assert word in told, word


@pytest.mark.gl
def test_opengl_draws_the_same_extremes(ctx: moderngl.Context) -> None:
    def draw(splats, camera, near):  # type: ignore[no-untyped-def]
        return render_offscreen(ctx, splats, camera, near=near)

    for row in pictures("OpenGL", draw):
        assert row.passed, f"{row.case}: {row.measured:g} grey levels"


@pytest.mark.parametrize("measured", [1.1, float("nan"), float("inf")])
def test_a_row_above_its_bar_or_not_a_number_fails(measured: float) -> None:
    assert not Row("hazard", "case", measured, 1.0, "unit").passed
