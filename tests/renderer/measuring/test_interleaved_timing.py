from __future__ import annotations

from functools import partial
from time import perf_counter

from renderer.measuring.interleaved_timing import interleaved_times


def test_works_take_turns_and_the_first_lap_does_not_count() -> None:
    done: list[str] = []
    times = interleaved_times([partial(done.append, name) for name in "ab"], 3)
    assert "".join(done) == "abababab"
    assert times.shape == (2, 3)


def test_times_are_those_of_each_work() -> None:
    def wait(seconds: float) -> None:
        end = perf_counter() + seconds
        while perf_counter() < end:
            pass

    short, long = interleaved_times([partial(wait, 0.001), partial(wait, 0.01)], 2)
    assert short.min() >= 0.001
    assert long.min() >= 0.01
