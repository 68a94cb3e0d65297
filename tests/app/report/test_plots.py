from __future__ import annotations

from itertools import combinations

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.text import Annotation

from app.report.diagrams import Diagram, Point
from app.report.plots import diagrams_figure


def crowded(count: int, default: int) -> Diagram:
    """A front whose points lie close in its middle."""
    times = np.geomspace(1, 1.4, count) * np.where(np.arange(count) < count // 2, 1, 8)
    points = tuple(
        Point(
            series="s",
            setting=f"{index:05d} Gaussians",
            seconds=time,
            error=0.9**index,
            is_default=index == default,
        )
        for index, time in enumerate(times.tolist())
    )
    return Diagram(measure="error", points=points)


def test_labels_do_not_lie_on_each_other_and_the_default_has_one() -> None:
    figure = diagrams_figure([crowded(14, default) for default in (3, 8, 12)])
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    for axes, default in zip(figure.axes, (3, 8, 12), strict=True):
        labels = [each for each in axes.texts if isinstance(each, Annotation)]
        assert f"{default:05d} Gaussians" in {label.get_text() for label in labels}
        assert len(labels) >= 3
        boxes = [label.get_window_extent(canvas.get_renderer()) for label in labels]
        assert not any(a.overlaps(b) for a, b in combinations(boxes, 2))
