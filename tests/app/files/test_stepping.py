from __future__ import annotations

import threading
import time
from collections.abc import Generator

import pytest

from app.files.stepping import DEPTH, ahead, map_steps, run_to_end


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


def numbers(count: int, seen: list[int], fail_at: int | None = None) -> Generator[int, None, None]:
    try:
        for number in range(count):
            if number == fail_at:
                raise OSError("broken")
            seen.append(number)
            yield number
    finally:
        seen.append(-1)


def test_the_same_items_in_the_same_order() -> None:
    seen: list[int] = []
    assert list(ahead(numbers(100, seen))) == list(range(100))
    assert seen[-1] == -1


def test_another_thread_works_in_advance_and_not_too_far() -> None:
    seen: list[int] = []
    items = ahead(numbers(100, seen))
    assert next(items) == 0
    deadline = time.monotonic() + 5
    while len(seen) < DEPTH and time.monotonic() < deadline:
        time.sleep(0.001)
    time.sleep(0.02)
    assert DEPTH <= len(seen) <= DEPTH + 2
    items.close()
    assert seen[-1] == -1


def test_the_first_item_is_made_where_it_can_be_interrupted() -> None:
    threads = []

    def noted() -> Generator[None, None, None]:
        for _ in range(3):
            threads.append(threading.current_thread())
            yield

    assert len(list(ahead(noted()))) == 3
    assert [one is threading.main_thread() for one in threads] == [True, False, False]


def test_what_goes_wrong_comes_after_what_went_well() -> None:
    seen: list[int] = []
    items = ahead(numbers(5, seen, fail_at=3))
    assert [next(items) for _ in range(3)] == [0, 1, 2]
    with pytest.raises(OSError, match="broken"):
        next(items)
    assert seen == [0, 1, 2, -1]


def test_no_thread_is_left_behind_however_it_ends() -> None:
    before = threading.active_count()
    for taken in (0, 1, 4, 50):
        inner, outer = [], []
        chained = ahead(doubled(ahead(numbers(50, inner)), outer))
        for _, _ in zip(range(taken), chained, strict=False):
            pass
        chained.close()
        assert threading.active_count() == before
        assert taken == 0 or (inner[-1], outer[-1]) == (-1, -1)


def doubled(items: Generator[int, None, None], seen: list[int]) -> Generator[int, None, None]:
    try:
        for item in items:
            yield 2 * item
    finally:
        items.close()
        seen.append(-1)
