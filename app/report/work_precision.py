"""Work-precision diagrams: error against run time, the Pareto front and the default marked."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

PANEL: Final = (4.6, 3.9)
"""Inches."""
COLORS: Final = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#7f7f7f", "#000000")
"""Told apart by colour-blind eyes (Okabe & Ito 2008)."""
MARKS: Final = "osD^vPX<"


@dataclass(frozen=True, kw_only=True)
class Point:
    """A setting, measured."""

    series: str
    """What it is drawn with."""
    setting: str
    seconds: float
    error: float
    is_default: bool = False


@dataclass(frozen=True, kw_only=True)
class Diagram:
    """Points of one measure."""

    measure: str
    """Name and unit, for the axis."""
    points: tuple[Point, ...]
    more_is_better: bool = False
    """A measure on a linear axis, such as PSNR; else an error, on a logarithmic one."""


def pareto_front(diagram: Diagram) -> tuple[Point, ...]:
    """The points that no other beats in one of time and error without losing in the other; fastest first."""
    sign = -1.0 if diagram.more_is_better else 1.0
    finite = [point for point in diagram.points if math.isfinite(point.error)]
    front: list[Point] = []
    for point in sorted(finite, key=lambda point: (point.seconds, sign * point.error)):
        if not front or sign * point.error < sign * front[-1].error:
            front.append(point)
    return tuple(front)


def write_diagrams(path: Path, diagrams: Sequence[Diagram], title: str) -> None:
    """Side by side in one picture, whose type follows from the suffix; those without a point are left out."""
    drawn = [diagram for diagram in diagrams if pareto_front(diagram)]
    figure = Figure(figsize=(PANEL[0] * len(drawn), PANEL[1] + 0.9), layout="constrained")
    figure.suptitle(title, x=0.01, ha="left", fontsize=10)
    series = list(dict.fromkeys(point.series for diagram in drawn for point in diagram.points))
    for index, diagram in enumerate(drawn):
        _draw(figure.add_subplot(1, len(drawn), 1 + index), diagram, series)
    handles, labels = figure.axes[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower left", ncols=len(labels), frameon=False)
    figure.savefig(path, dpi=150)


def _draw(axes: Axes, diagram: Diagram, series: Sequence[str]) -> None:
    front = pareto_front(diagram)
    axes.set_xscale("log")
    if not diagram.more_is_better:
        axes.set_yscale("log")
    axes.set_xlabel("seconds")
    axes.set_ylabel(diagram.measure)
    for axis in (axes.xaxis, axes.yaxis):
        if axis.get_scale() == "log":
            axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
        axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        axis.set_minor_formatter(NullFormatter())
    axes.grid(alpha=0.3, which="both", linewidth=0.5)
    axes.plot(
        [point.seconds for point in front], [point.error for point in front],
        color="#555555", linewidth=1, drawstyle="steps-post", label="Pareto front", zorder=1,
    )  # fmt: skip
    for name in series:
        own = [point for point in diagram.points if point.series == name]
        style = series.index(name)
        axes.scatter(
            [point.seconds for point in own], [point.error for point in own],
            s=30, color=COLORS[style % len(COLORS)], marker=MARKS[style % len(MARKS)], label=name, zorder=2,
        )  # fmt: skip
    default = [point for point in diagram.points if point.is_default]
    axes.scatter(
        [point.seconds for point in default], [point.error for point in default],
        s=130, facecolors="none", edgecolors="black", label="default", zorder=3,
    )  # fmt: skip
    for point in front:
        axes.annotate(
            point.setting, (point.seconds, point.error), (4, 4), textcoords="offset points", fontsize=6
        )
