"""What training measured, over its iterations: a small diagram for each quantity."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from imgui_bundle import ImVec2, ImVec4, imgui, implot

from app.gui.look import theme
from app.gui.look.widgets import em, explain
from app.gui.state.reconstruction import Reconstruction
from renderer.train.events import Evaluated, Progress

FLAGS = (
    implot.Flags_.no_title
    | implot.Flags_.no_menus
    | implot.Flags_.no_box_select
    | implot.Flags_.no_mouse_text
    | implot.Flags_.no_legend
)
HELD_OUT = (
    "Line: of the training frames' tissue. Dot: of frames held out, over all pixels, measured at the end."
)

COUNT = "How many make up the model."


def draw_curves(run: Reconstruction) -> None:
    """Nothing before the first Progress."""
    if not run.curve:
        return
    curve, end, ink = run.curve, run.iterations, theme.now()
    now, measured = curve[-1], run.evaluated
    held_out = f", held out {measured[-1].psnr:.1f} dB" if measured else ""
    _draw("PSNR", f"{now.psnr:.1f} dB{held_out}", ink.accent, _line(curve, "psnr"), end, HELD_OUT, measured)
    _draw("Loss", f"{now.loss:.4f}", ink.warning, _line(curve, "loss"), end, "Mean since the point before.")
    _draw("Gaussians", f"{now.n_gaussians:,}", ink.shade(0.75), _line(curve, "n_gaussians"), end, COUNT)


def _line(curve: Sequence[Progress], name: str) -> np.ndarray:
    """(2, N): iterations, values."""
    return np.array([[event.iteration for event in curve], [getattr(event, name) for event in curve]], float)


def _draw(
    name: str,
    value: str,
    color: ImVec4,
    line: np.ndarray,
    iterations: int,
    text: str,
    dots: Sequence[Evaluated] = (),
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
    implot.setup_axis_ticks(axis.y1, [low, high], [f"{low:.4g}", f"{high:.4g}"])
    implot.setup_axis_limits(axis.x1, 0, max(iterations, line[0, -1]), implot.Cond_.always)
    implot.plot_line(
        name,
        np.ascontiguousarray(line[0]),
        np.ascontiguousarray(line[1]),
        implot.Spec(line_color=color, line_weight=em(0.1)),
    )
    if dots:
        x = np.array([float(dot.iteration) for dot in dots])
        y = np.array([dot.psnr for dot in dots])
        implot.plot_scatter("held out", x, y, implot.Spec(marker_fill_color=color, marker_size=em(0.25)))
    implot.end_plot()
