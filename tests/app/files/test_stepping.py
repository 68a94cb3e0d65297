from __future__ import annotations

from collections.abc import Generator

from app.files.stepping import map_steps, run_to_end


def counting(ended: list[str]) -> Generator[int, None, str]:
    try:
        yield 1
        yield 2
    finally:
        ended.append("closed")
    return "done"


def test_steps_are_told_otherwise_and_the_result_stays() -> None:
    ended: list[str] = []
    told: list[int] = []
    assert run_to_end(map_steps(counting(ended), told.append)) == "done"
    assert told == [1, 2]
    assert run_to_end(counting(ended)) == "done"
    assert ended == ["closed", "closed"]


def test_work_that_is_given_up_is_closed_at_once() -> None:
    ended: list[str] = []
    inner = counting(ended)
    work = map_steps(inner, str)
    next(work)
    work.close()
    assert ended == ["closed"]
