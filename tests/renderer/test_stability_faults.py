"""Faults that are put into kernels on purpose are noticed by rows of the stability table, and go again."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest

from renderer.train import adam
from renderer.train.guards import LossWatch
from tests.benchmarks.stability_faults.faults import Fault, edited, replaced
from tests.benchmarks.stability_faults.table import FAULTS, parts, tried

FEW = (
    "projection, float16: records",
    "tile lists, sign: back to front",
    "splines, sign: of a weight",
    "nodes, swapped: across and down",
    "bumps, float16: what they add",
    "Adam, sign: of the step",
    "density, sign: of a turn",
    "loss, float16: the adjoint",
    "whole run, other: it always fails",
    "statistics, sign: of z",
    "edges, guard: NaN is let in",
)


def _named(name: str) -> Fault:
    return next(fault for fault in FAULTS if fault.name == name)


@pytest.mark.parametrize("name", FEW)
def test_a_fault_is_noticed(name: str) -> None:
    outcome = tried(_named(name), frozenset())
    assert outcome.failed, outcome.raised


def test_every_fault_has_a_name_and_every_part_of_the_table_a_fault() -> None:
    assert [name for name, count in Counter(fault.name for fault in FAULTS).items() if count > 1] == []
    assert {part for fault in FAULTS for part in fault.parts} == set(parts())


def test_every_kind_of_fault_is_in_every_kernel_it_can_be_in() -> None:
    kinds = {"sign", "dropped", "swapped", "float16"}
    for kernel in {fault.kernel for fault in FAULTS} - {"edges", "exponent"}:
        assert {fault.kind for fault in FAULTS if fault.kernel == kernel} >= kinds, kernel


@pytest.mark.parametrize("fault", FAULTS, ids=lambda fault: fault.name)
def test_every_fault_finds_its_place(fault: Fault) -> None:
    """The sources that it edits are as it expects them; nothing is compiled."""
    with fault.change():
        pass


def test_a_fault_goes_again() -> None:
    with _named("Adam, sign: of the step").change():
        assert _first_step() > 0
    assert _first_step() < 0


def _first_step() -> float:
    values, first, second = (np.zeros((1, 1), np.float32) for _ in range(3))
    adam.update_rows(values, np.ones((1, 1), np.float32), first, second, np.ones(1, bool), 0.1)
    return float(values[0, 0])


def test_a_number_that_methods_use_changes_with_its_module() -> None:
    def problem() -> str | None:
        return LossWatch(np.array([200.0, 1.0, 3.0])).problem

    assert problem() is not None
    with edited("renderer.train.guards", "WORSE = 2.0", "WORSE = 1e30")():
        assert problem() is None
    assert problem() is not None


def test_what_stands_in_a_table_is_replaced_too() -> None:
    from renderer.train.methods import RECIPES

    whole = RECIPES["static"]
    with replaced("renderer.train.methods.static:recipe", lambda _: "another")():
        assert RECIPES["static"] == "another"
    assert RECIPES["static"] is whole


def test_an_edit_that_finds_nothing_is_no_fault() -> None:
    with (
        pytest.raises(ValueError, match="expected 'no such text'"),
        edited("renderer.harmonics", "no such text", "")(),
    ):
        pass
