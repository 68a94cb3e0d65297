"""JSON of files that anyone may have made."""

from __future__ import annotations

import pytest

from renderer.json_files import parsed


@pytest.mark.parametrize("number", ["NaN", "Infinity", "-Infinity", "1e999", "-1e999"])
def test_numbers_that_are_not_finite_are_refused_by_their_name(number: str) -> None:
    with pytest.raises(ValueError, match=f"expected numbers, got {number}"):
        parsed(f'{{"a": [1.5, {number}]}}')


def test_numbers_keep_their_value_and_kind() -> None:
    value = parsed("[0.1, 1e308, 5e-324, -2.5e3, 3, 12345678901234567890]")
    assert value == [0.1, 1e308, 5e-324, -2500.0, 3, 12345678901234567890]
    assert [type(each) for each in value] == [float] * 4 + [int] * 2
