"""The table that the history of training prints."""

from __future__ import annotations

import pytest

from tests.benchmarks.train_history import COLUMNS, HISTORY, _rows, lines


def row(tree: str, psnr: str, seeds: str = "0 1 2", note: str = "") -> dict[str, str]:
    return dict.fromkeys(COLUMNS, "") | {"tree": tree, "psnr": psnr, "seeds": seeds, "note": note}


def test_a_change_is_told_between_rows_of_the_same_seeds() -> None:
    first, other, second = lines(
        [row("a", "38.0 38.2 38.4"), row("b", "30.0", "0"), row("c", "38.1 38.3 38.5", note="new")]
    )
    assert "38.200 dB +-0.200" in first
    assert "-" not in first.replace("+-", "")
    assert "30.000 dB +-0.000" in other
    assert "38.300 dB +-0.200  +0.100" in second
    assert second.endswith("new")


@pytest.mark.skipif(not HISTORY.exists(), reason="a tree without a history")
def test_the_history_that_is_kept_has_as_many_figures_as_seeds() -> None:
    for kept in _rows():
        assert tuple(kept) == COLUMNS
        for name in ("psnr", "depth", "train_seconds", "wall_seconds"):
            assert len(kept[name].split()) in (0, len(kept["seeds"].split()))
