from __future__ import annotations

from app.commands.report import advice
from app.report.diagrams import Diagram, Point
from app.report.section import Plate, Section

POINTS = tuple(
    Point(series="s", setting=name, seconds=seconds, error=error)
    for name, seconds, error in (("slow", 2.0, 0.1), ("middle", 0.5, 1.0), ("fast", 0.01, 9.0))
)


def lines(budget: float | None, error: float | None, more_is_better: bool = False) -> list[str]:
    diagram = Diagram(measure="m", points=POINTS, more_is_better=more_is_better)
    section = Section(title="t", plates=(Plate(title="p", diagrams=(diagram,)),))
    return list(advice({"one": section}, budget, error))


def test_a_budget_takes_the_most_exact_and_a_bound_the_fastest() -> None:
    assert "middle" in lines(0.6, None)[0]
    assert "slow" in lines(5.0, None)[0]
    assert "fast" in lines(None, 10.0)[0]
    assert "middle" in lines(None, 1.0)[0]


def test_what_cannot_be_had_is_said() -> None:
    assert "none of the measured settings" in lines(0.001, None)[0]
    assert "none of the measured settings" in lines(None, 0.01)[0]


def test_an_error_bound_says_nothing_about_a_measure_of_which_more_is_better() -> None:
    assert lines(None, 1.0, more_is_better=True) == []
    assert "fast" in lines(1.0, None, more_is_better=True)[0]
