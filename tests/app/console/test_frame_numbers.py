"""`--frames` means the same to every command: numbers and ranges with both ends."""

from __future__ import annotations

from pathlib import Path

import pytest

from app.console.frame_numbers import frame_numbers
from app.errors import UserError
from tests.app.conftest import Cli


def test_numbers_and_ranges_in_the_order_given() -> None:
    assert frame_numbers(["7", "2:4", "0"], 8) == [7, 2, 3, 4, 0]
    assert frame_numbers(["3:3"]) == [3]
    assert frame_numbers(["5", "0", "4:6", "0"]) == [5, 0, 4, 6]
    assert frame_numbers(["5,0", "4:6,0"]) == [5, 0, 4, 6]
    assert frame_numbers([]) == []


@pytest.mark.parametrize(
    "text", ["8", "-1", "4:2", "2:8", "2:", "a", "1-3", "٣", "", "9" * 12, "2,", ",", "1,,2"]
)
def test_anything_else_is_refused_with_what_was_expected(text: str) -> None:
    with pytest.raises(
        UserError, match=r"--frames: expected numbers and ranges .* from 0 to 7, got "
    ) as error:
        frame_numbers(["1", text], 8)
    assert any(repr(part) in str(error.value) for part in text.split(","))


def test_render_and_train_take_the_same(
    runs: dict[str, Path], clip_path: Path, tmp_path: Path, vesselsplat: Cli
) -> None:
    call = vesselsplat("render", runs["original"], "--out", tmp_path / "out", "--frames", "2:4", 7)
    assert call.code == 0
    assert {path.stem for path in (tmp_path / "out").glob("*.png")} == {
        f"frame-{index:06d}" for index in (2, 3, 4, 7)
    }
    begin = ("train", clip_path, "--iterations", 10, "--run", tmp_path / "run")
    assert vesselsplat(*begin, "--frames", 2, "3:7", 8).code == 0
    apart = vesselsplat(*begin[:-1], tmp_path / "apart", "--frames", "2:4", 7)
    assert (apart.code, apart.error.count("\n")) == (2, 1)
    assert "follow one another to train on, got 2:4 7" in apart.error
    assert not (tmp_path / "apart").exists()
