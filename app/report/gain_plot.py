"""The plot of contrast against noise: a line for each method, through its amounts."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from app.report.colors import COLORS
from app.report.diagrams import Gain, GainDiagram, gain_front
from app.report.plots import MARKS, labelled, without_overlap

SIZE: Final = (8.4, 5.6)
"""Inches."""


def gain_figure(diagram: GainDiagram) -> Figure:
    """Up is more contrast, left is less noise; below the front, another setting has both."""
    figure = Figure(figsize=SIZE, layout="constrained")
    axes = figure.add_subplot()
    axes.set(xscale="log", yscale="log", xlabel="noise, relative to the original (less is better)")
    axes.set_ylabel("vessel contrast, relative to the original (more is better)")
    axes.set_xlim(*_limits([gain.noise for gain in diagram.gains]))
    series = list(dict.fromkeys(gain.series for gain in diagram.gains))
    for index, name in enumerate(series):
        _draw(axes, [gain for gain in diagram.gains if gain.series == name], index)
    default = [gain for gain in diagram.gains if gain.is_default]
    axes.scatter(*_places(default), s=110, facecolors="none", edgecolors="black", label="default", zorder=4)
    front = gain_front(diagram)
    ahead = {gain.series.partition(",")[0] for gain in front}  # Before the comma, the method.
    _name(axes, [*front, *(gain for gain in default if gain.series in ahead and gain not in front)], front)
    _draw_front(axes, front)
    for axis in (axes.xaxis, axes.yaxis):
        labelled(axis)
    axes.grid(alpha=0.3, which="both", linewidth=0.5)
    figure.legend(loc="outside right upper", frameon=False, fontsize=8)
    return figure


def _limits(noise: Sequence[float]) -> tuple[float, float]:
    """With room for names at the left."""
    least, most = min(noise), max(noise)
    span = max(most / least, 1.1)
    return least / span**0.36, most * span**0.07


def _draw(axes: Axes, gains: Sequence[Gain], index: int) -> None:
    """Dashed where a colour comes again."""
    again, place = divmod(index, len(COLORS))
    axes.plot(
        *_places(gains), color=COLORS[place], marker=MARKS[(place + again) % len(MARKS)], markersize=4.5,
        linewidth=1, linestyle="--" if again else "-", label=gains[0].series,
    )  # fmt: skip


def _draw_front(axes: Axes, front: Sequence[Gain]) -> None:
    """To the ends of the axes."""
    noise, contrast = _places(front)
    axes.set_autoscale_on(False)
    axes.step(
        [noise[0], *noise, axes.get_xlim()[1]], [axes.get_ylim()[0], *contrast, contrast[-1]],
        where="post", color="#555555", linewidth=4, alpha=0.25, label="Pareto front", zorder=1,
    )  # fmt: skip


def _name(axes: Axes, gains: Sequence[Gain], front: Sequence[Gain]) -> None:
    """Where little is drawn: there is no setting above a front and to its left."""
    for gain, place in without_overlap(axes, gains, list(zip(*_places(gains), strict=True))):
        name = f"{gain.series}, {gain.setting}"
        away, side = ((-7, 2), "right") if gain in front else ((9, -2), "left")
        axes.annotate(name, place, away, textcoords="offset points", fontsize=7, ha=side)


def _places(gains: Sequence[Gain]) -> tuple[list[float], list[float]]:
    return [gain.noise for gain in gains], [gain.contrast for gain in gains]
