"""The report's plots: work-precision diagrams, and growth with its fitted exponent."""

from __future__ import annotations

import io
import math
from collections.abc import Iterator, Sequence
from typing import Final, TypeVar

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from app.report.colors import COLORS
from app.report.diagrams import Diagram, Gain, Growth, Point, of_a_decade, pareto_front

Drawn = TypeVar("Drawn", Point, Gain)

PANEL: Final = (4.6, 3.9)
"""Inches."""
MARKS: Final = "osD^vPX<"
COLUMNS: Final = 3
ALONE: Final = 6.6
"""Inches: the width of a diagram that has the row for itself."""
CLEAR: Final = 0.3, 0.05
"""Of width and height of a diagram: labels of points that are nearer in both would lie on each other."""


def svg(figure: Figure) -> bytes:
    """The same bytes for the same figure; text stays text, in a font of the system."""
    out = io.BytesIO()
    with mpl.rc_context({"svg.fonttype": "none", "svg.hashsalt": "vesselsplat"}):
        figure.savefig(out, format="svg", metadata={"Date": None})
    return out.getvalue()


def diagrams_figure(diagrams: Sequence[Diagram], title: str = "") -> Figure:
    """All in one; those without a point are left out."""
    drawn = [diagram for diagram in diagrams if pareto_front(diagram)]
    columns = COLUMNS if len(drawn) % COLUMNS == 0 else min(len(drawn), COLUMNS - 1)
    rows = -(-len(drawn) // columns)
    width = ALONE if len(drawn) == 1 else PANEL[0] * columns
    figure = Figure(figsize=(width, PANEL[1] * rows + 0.9), layout="constrained")
    if title:
        figure.suptitle(title, x=0.01, ha="left", fontsize=10)
    series = list(dict.fromkeys(point.series for diagram in drawn for point in diagram.points))
    for index, diagram in enumerate(drawn):
        _draw(figure.add_subplot(rows, columns, 1 + index), diagram, series)
    handles, labels = figure.axes[0].get_legend_handles_labels()
    across = max(2, min(len(labels), round(width / 1.5)))
    figure.legend(handles, labels, loc="outside lower left", ncols=across, frameon=False, fontsize=8)
    return figure


def growth_figure(growths: Sequence[Growth]) -> Figure:
    """Three in a row, each curve with its fitted power law."""
    columns = min(COLUMNS, len(growths))
    rows = -(-len(growths) // columns)
    figure = Figure(figsize=(PANEL[0] * columns, PANEL[1] * rows), layout="constrained")
    for index, growth in enumerate(growths):
        _draw_growth(figure.add_subplot(rows, columns, 1 + index), growth)
    return figure


def _draw_growth(axes: Axes, growth: Growth) -> None:
    axes.set(xscale="log", yscale="log", xlabel=growth.work, ylabel=growth.cost)
    axes.set_title(growth.title, fontsize=10, loc="left")
    for place, curve in enumerate(growth.curves):
        color, mark = COLORS[place % len(COLORS)], MARKS[place % len(MARKS)]
        axes.plot(curve.work, curve.cost, mark, color=color, label=curve.label, markersize=5)
        axes.plot(*curve.law(), color=color, linewidth=1)
    for axis in (axes.xaxis, axes.yaxis):
        labelled(axis)
    axes.grid(alpha=0.3, linewidth=0.5)
    axes.legend(frameon=False, fontsize=8)


def _draw(axes: Axes, diagram: Diagram, series: Sequence[str]) -> None:
    finite = [point for point in diagram.points if math.isfinite(point.error)]
    front = pareto_front(diagram)
    unit, floor = diagram.unit, _floor(diagram, finite)
    # Limits follow from all points at once: those of a single one are no range.
    axes.set_autoscale_on(False)
    axes.set_xscale("log")
    if not diagram.more_is_better:
        axes.set_yscale("log")
    axes.set(xlabel=unit.name, ylabel=diagram.measure)

    def place(points: Sequence[Point]) -> tuple[list[float], list[float]]:
        return [unit.of_a_second * point.seconds for point in points], [
            max(point.error, floor) for point in points
        ]

    axes.plot(
        *place(front), color="#555555", linewidth=1, drawstyle="steps-post", label="Pareto front", zorder=1
    )
    for index, one in enumerate(series):
        own = [point for point in finite if point.series == one]
        color, mark = COLORS[index % len(COLORS)], MARKS[index % len(MARKS)]
        axes.scatter(*place(own), s=30, color=color, marker=mark, label=one, zorder=2)
        spreads = [unit.of_a_second * min(point.spread, 0.9 * point.seconds) for point in own]
        axes.errorbar(*place(own), xerr=spreads, fmt="none", ecolor=color, elinewidth=0.8, zorder=2)
    default = [point for point in finite if point.is_default]
    axes.scatter(*place(default), s=130, facecolors="none", edgecolors="black", label="default", zorder=3)
    axes.set_autoscale_on(True)
    axes.margins(x=0.14)
    for point, at in without_overlap(axes, front, list(zip(*place(front), strict=True))):
        axes.annotate(point.setting, at, (4, 4), textcoords="offset points", fontsize=6)
    for axis in (axes.xaxis, axes.yaxis):
        if axis.get_scale() == "log":
            labelled(axis)
    if any(point.error < floor for point in finite):
        axes.axhline(floor, color="#999999", linewidth=0.6, linestyle=":")
        axes.annotate("no error", (1, floor), (-2, 3), ("axes fraction", "data"), "offset points",
                      ha="right", fontsize=6, color="#666666")  # fmt: skip
    axes.grid(alpha=0.3, which="both", linewidth=0.5)


def without_overlap(
    axes: Axes, points: Sequence[Drawn], places: Sequence[tuple[float, float]]
) -> Iterator[tuple[Drawn, tuple[float, float]]]:
    """Points whose labels do not lie on each other, the default before all others."""
    axes.autoscale_view()
    scale = axes.transData + axes.transAxes.inverted()
    taken: list[tuple[float, float]] = []
    for point, place in sorted(zip(points, places, strict=True), key=lambda each: not each[0].is_default):
        x, y = (float(value) for value in scale.transform(place))
        if all(abs(x - u) > CLEAR[0] or abs(y - v) > CLEAR[1] for u, v in taken):
            taken.append((x, y))
            yield point, place


def _floor(diagram: Diagram, points: Sequence[Point]) -> float:
    """Where errors of 0 are drawn on a logarithmic axis: a decade below the least of the others."""
    if diagram.more_is_better:
        return -math.inf
    least = min((point.error for point in points if point.error > 0), default=1.0)
    return 10.0 ** (math.floor(math.log10(least)) - 1) if any(point.error <= 0 for point in points) else 0.0


def labelled(axis: Axis) -> None:
    """Plain numbers on a logarithmic axis, more of them the fewer decades it has."""
    axis.set_major_locator(LogLocator(subs=of_a_decade(*axis.get_view_interval())))
    axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axis.set_minor_formatter(NullFormatter())
