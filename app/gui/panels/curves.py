"""What training measured, over its iterations: a small diagram for each quantity."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from imgui_bundle import ImVec2, ImVec4, imgui, implot
from numpy.typing import NDArray

from app.files.legible import grouped
from app.gui.state.reconstruction import Reconstruction
from app.gui.style import theme
from app.gui.style.widgets import em, explain
from app.scenes.view_kinds import SCENE_UNITS
from renderer.train.events import Evaluated, Progress

FLAGS = (
    implot.Flags_.no_title
    | implot.Flags_.no_menus
    | implot.Flags_.no_box_select
    | implot.Flags_.no_mouse_text
    | implot.Flags_.no_legend
)
PSNR = "Line: training frames, tissue only. Dots: up to 4 held-out frames, all pixels."
DEPTH = "RMS error along z on the same frames, where both the clip and the model have depth."
COUNT = "Number of Gaussians in the model."

Line = NDArray[np.float64]
NO_DOTS: Line = np.empty((2, 0))


def draw_curves(run: Reconstruction) -> None:
    """Nothing before the first Progress; no depth where none is measured."""
    if not run.told.progress:
        return
    curve, end, ink = run.told.progress, run.iterations, theme.now()
    now, seen = curve[-1], _line(run.told.evaluated, "psnr")
    held_out = f", held out {seen[1, -1]:.1f} dB" if seen.size else ""
    psnr, loss, count = (_line(curve, name) for name in ("psnr", "loss", "n_gaussians"))
    _draw("PSNR", f"{now.psnr:.1f} dB{held_out}", ink.accent, psnr, end, "{:.1f}".format, PSNR, seen)
    depth = _line([each for each in run.told.evaluated if each.depth_rmse is not None], "depth_rmse")
    if depth.size:
        unit = run.clip.unit if run.clip is not None else SCENE_UNITS
        said = f"{depth[1, -1]:.3g} {unit}"
        _draw("Depth error", said, ink.danger, depth, end, "{:.2g}".format, DEPTH, depth)
    _draw(
        "Loss", f"{now.loss:.4f}", ink.warning, loss, end, "{:.2g}".format, "Mean since the previous point."
    )
    _draw("Gaussians", grouped(now.n_gaussians), ink.shade(0.75), count, end, "{:,.0f}".format, COUNT)


def _line(events: Sequence[Progress] | Sequence[Evaluated], name: str) -> Line:
    """(2, N): iterations, values."""
    values = [getattr(event, name) for event in events]
    return np.array([[event.iteration for event in events], values], float)


def _draw(
    name: str,
    value: str,
    color: ImVec4,
    line: Line,
    iterations: int,
    form: Callable[[float], str],
    text: str,
    dots: Line = NO_DOTS,
) -> None:
    imgui.text_colored(color, name)
    explain(text)
    imgui.same_line()
    imgui.text_colored(theme.now().muted, value)
    if not implot.begin_plot(f"##{name}", ImVec2(-1, em(4.6)), FLAGS):
        return
    axis, quiet = implot.ImAxis_, implot.AxisFlags_.no_highlight
    implot.setup_axis(axis.x1, "", quiet)
    implot.setup_axis(axis.y1, "", implot.AxisFlags_.auto_fit | quiet)
    low, high = float(line[1].min()), float(line[1].max())
    # So low a diagram has room for two labels.
    implot.setup_axis_ticks(axis.y1, [low, high], [form(low), form(high)])
    # None at the end, where its half would be cut off.
    across = [iterations * quarter / 4 for quarter in range(4)]
    implot.setup_axis_ticks(axis.x1, across, [grouped(round(tick)) for tick in across])
    implot.setup_axis_limits(axis.x1, 0, max(iterations, line[0, -1]), implot.Cond_.always)
    implot.plot_line(
        name,
        np.ascontiguousarray(line[0]),
        np.ascontiguousarray(line[1]),
        implot.Spec(line_color=color, line_weight=em(0.1)),
    )
    if dots.size:
        marks = implot.Spec(marker_fill_color=color, marker_size=em(0.25))
        implot.plot_scatter("held out", np.ascontiguousarray(dots[0]), np.ascontiguousarray(dots[1]), marks)
    implot.end_plot()
