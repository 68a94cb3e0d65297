"""How many threads the environment asks for: what cannot be is one line, and nothing is begun."""

from __future__ import annotations

import pytest

from app.__main__ import main


@pytest.mark.parametrize("said", ["0", "-3", "abc", "2.5", "9999", "9" * 20, "²"])
def test_a_number_of_threads_that_cannot_be_is_one_line(
    said: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("NUMBA_NUM_THREADS", said)
    assert main(["info"]) == 2
    told = capsys.readouterr()
    assert told.out == ""
    assert told.err == (
        f"vesselsplat: expected NUMBA_NUM_THREADS from 1 to 1024 in the environment, got {said!r}\n"
    )


@pytest.mark.parametrize("said", ["", "1", "64"])
def test_one_that_can_be_or_none_is_taken(said: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("NUMBA_NUM_THREADS", said)
    assert main(["--version"]) == 0
