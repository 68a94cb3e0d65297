from __future__ import annotations

import numpy as np

from app.report.costs import held_megabytes


def test_arrays_that_are_held_count_and_neither_those_let_go_nor_other_objects() -> None:
    held: list[object] = []

    def work() -> np.ndarray:
        np.ones(500_000).sum()
        held.append([str(number) for number in range(10_000)])
        held.append(np.ones(250_000))
        return np.ones(125_000)

    assert held_megabytes(work) == 3.0
    assert held_megabytes(work) == 3.0
