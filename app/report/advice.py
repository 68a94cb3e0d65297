"""The setting to use for a time budget or an error bound."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from app.report.section import Section
from app.report.work_precision import Point, within_budget, within_error


def advice(sections: Mapping[str, Section], budget: float | None, error: float | None) -> Iterator[str]:
    """A line for each diagram and bound; `budget` in seconds, `error` in the unit of each diagram.

    An error bound says nothing about measures of which more is better.
    """
    for section in sections.values():
        for plate in section.plates:
            for diagram in plate.diagrams:
                where = f"{plate.title}, {diagram.measure}"
                if budget is not None:
                    found = within_budget(diagram, budget)
                    yield f"{where}, within {_time(budget)}: {_told(found)}"
                if error is not None and not diagram.more_is_better:
                    yield f"{where}, at most {error:g}: {_told(within_error(diagram, error))}"


def _told(point: Point | None) -> str:
    if point is None:
        return "none of the measured settings"
    default = ", the default" if point.is_default else ""
    return f"{point.series}, {point.setting} ({point.error:.3g} in {_time(point.seconds)}){default}"


def _time(seconds: float) -> str:
    return f"{1000 * seconds:.3g} ms" if seconds < 1 else f"{seconds:.3g} s"
