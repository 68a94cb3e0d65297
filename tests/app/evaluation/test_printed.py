"""The printed table: numbers are whole at every width, and each stands beside the name of its row."""

from __future__ import annotations

import pytest

from app.commands.evaluate import COLUMNS, _heading, _say

MEAN = ["mean", "38.12", "37.91", "0.9612", "0.1134", "10.371", "11.16", "2027.3", "56.6", "1.351", "126.4"]
FRAME = ["121", "39.12", "38.91", "0.9712", "0.1234", "11.371", "12.16", "2127.3", "156.6", "1.451", "127.4"]


@pytest.mark.parametrize(("width", "parts"), [(60, 2), (140, 1)])
def test_no_number_is_cut(
    width: int, parts: int, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("app.console.progress.WIDTH", width)
    monkeypatch.setenv("COLUMNS", "60")
    _say(_heading("frame", COLUMNS), [[FRAME], [MEAN]], "title", "caution")
    *lines, caution = capsys.readouterr().out.splitlines()
    assert caution == "caution"
    assert max(map(len, lines)) <= width
    for row in (FRAME, MEAN):
        shown = [line.split() for line in lines if line.split()[:1] == row[:1]]
        assert len(shown) == parts
        assert [cell for line in shown for cell in line[1:]] == row[1:]
