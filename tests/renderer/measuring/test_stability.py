"""Every stiff or extreme case is a test; what float32 cannot do is known, and said."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, get_args

import moderngl
import numpy as np
import pytest

from renderer.clip import ClipError
from renderer.draw.offscreen import render_offscreen
from renderer.draw.splat_view import SplatView
from renderer.measuring.stability import PARTS, blending, cutting, learning, runs, stability
from renderer.measuring.stability.blending import pictures
from renderer.measuring.stability.row import Row, worst
from renderer.measuring.stability.scenes import NEAR
from renderer.rasterize.cpu import Rasterizer
from renderer.train import guards, model
from renderer.train.config import Method
from renderer.train.trainer import TrainingError

KNOWN = {
    ("gradients of (13)-(16)", "scales of 1e-8 and 1e8"),
    ("Adam", "gradients of 1e+20"),
}
"""Whose failure the report states, with what is done then."""


@pytest.fixture(scope="module")
def rows() -> list[Row]:
    return list(stability())


def test_every_row_passes_but_those_known(rows: list[Row]) -> None:
    """What passes is no longer a known failure."""
    failed = {(row.hazard, row.case): row for row in rows if not row.passed}
    assert [row for case, row in failed.items() if case not in KNOWN] == []
    assert failed.keys() == KNOWN
    assert all(row.done for row in failed.values())


def test_each_case_is_there_once_and_every_hazard_of_the_design(rows: list[Row]) -> None:
    cases = [(row.hazard, row.case) for row in rows]
    assert len(set(cases)) == len(cases) > 300
    told = " ".join(f"{hazard} {case}" for hazard, case in cases)
    for word in (
        *("anisotropy 1e6", "scales of 1e-8", "scales of 1e8", "q = 0", "z at the near plane", "opacity 0"),
        *(
            "opacity 1",
            "1e6 on one ray",
            "one camera",
            "one frame",
            "empty mask",
            "needle of 1e8 px",
            "1e12 away",
            "field of one pixel",
            "depth all 0",
            "width -> 0",
        ),
        *("learning rates x100", "Adam", "density control", "initialisation", "spline", "FDM", "planes"),
    ):
        assert word in told, word


def test_few_rows_can_be_nothing_but_0(rows: list[Row]) -> None:
    """Such a row says whether something happens, and not how far it is from right."""
    exact = [row for row in rows if row.bar == 0]
    assert len(exact) <= 15, [f"{row.hazard}: {row.case}" for row in exact]


@pytest.mark.gl
def test_opengl_draws_the_same_extremes(ctx: moderngl.Context) -> None:
    def draw(splats, camera, near):  # type: ignore[no-untyped-def]
        return render_offscreen(ctx, splats, camera, near=near)

    for row in pictures("OpenGL", draw):
        assert row.passed, f"{row.case}: {row.measured:g} {row.unit}"


@pytest.mark.gl
@pytest.mark.parametrize(
    "name", [name for name in cutting.SCENES if "needle" not in name and "numbers" not in name]
)
def test_opengl_cuts_the_same_splats(ctx: moderngl.Context, name: str) -> None:
    """But for values that it takes none of, and needles of which a float32 tells no direction across."""
    splats, camera, within = cutting.SCENES[name]()
    view = SplatView(ctx, precision="float", near=NEAR)
    view.upload(splats)
    apart = np.abs(view.read_color(camera, within=within)[..., :3] - cutting.drawn(splats, camera, within))
    view.release()
    assert 255 * apart.max() < cutting.GREY


@pytest.mark.parametrize("measured", [1.1, float("nan"), float("inf")])
def test_a_row_above_its_bar_or_not_a_number_fails(measured: float) -> None:
    assert not Row("hazard", "case", measured, 1.0, "unit").passed


def test_the_worst_of_errors_is_the_one_that_is_no_number() -> None:
    assert worst([0.1, 0.3, 0.2]) == 0.3
    assert np.isnan(worst([0.1, np.nan, 0.2]))
    assert worst([]) == 0


WHOLE_RUNS = [name for name in PARTS if name.startswith("whole run")]


@pytest.mark.parametrize("part", WHOLE_RUNS)
@pytest.mark.parametrize(
    "failure",
    [TrainingError("the card is gone"), ClipError("expected a mask"), ClipError("the loss rises")],
)
def test_whole_runs_that_always_fail_fail(
    part: str, failure: Exception, monkeypatch: pytest.MonkeyPatch
) -> None:
    def train(*_: object, **__: object) -> Iterator[object]:
        raise failure
        yield

    monkeypatch.setattr(runs, "train", train)
    rows = list(PARTS[part]())
    assert rows
    assert [row.case for row in rows if row.passed] == []


@pytest.mark.parametrize("method", get_args(Method))
def test_whole_runs_that_do_not_train_fail(method: Method, monkeypatch: pytest.MonkeyPatch) -> None:
    """A step that moves nothing leaves pictures as they are at first."""
    monkeypatch.setattr(model, "update_rows", lambda *_: None)
    rows = [row for row in runs.of_method(method) if not row.case.endswith(": depth")]
    assert [row.case for row in rows if row.passed] == []


def test_a_run_that_is_not_refused_fails(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(guards, "WORSE", 1e30)
    rows = {row.case: row for row in runs.refused()}
    assert not rows["static, learning rates x100"].passed
    assert rows["static, learning rates x100"].done == "expected 'the loss rises', got it trained"


def test_one_gradient_that_is_no_number_fails(monkeypatch: pytest.MonkeyPatch) -> None:
    whole = Rasterizer.backward

    def broken(self: Any, splats: Any) -> Any:
        found = whole(self, splats)
        found.colors[0, 0] = np.nan
        return found

    monkeypatch.setattr(Rasterizer, "backward", broken)
    assert not any(row.passed for row in blending.gradients() if row.hazard == "gradients of (13)-(16)")


def test_a_bias_correction_that_both_sides_share_is_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(learning, "corrected_rate", lambda rate, steps: rate)
    rows = {row.case: row for row in learning.adam()}
    assert not rows["gradients of 1"].passed
