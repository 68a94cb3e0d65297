"""What the enhancement did to the image on screen: transfer curves, histograms, measures, omissions."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from imgui_bundle import ImVec2, imgui, implot
from numpy.typing import NDArray

from app.enhancement.frame_enhancer import Pictures
from app.enhancement.measures import DEFINITIONS, Measures
from app.files.legible import legible
from app.gui.state.app_state import AppState
from app.gui.style import theme
from app.gui.style.widgets import cell, em, explain, in_table, muted, note, percent
from app.gui.work.measuring import BINS, Measured, curves
from enhance import Statistics

AXIS_FLAGS = (
    implot.AxisFlags_.no_tick_labels | implot.AxisFlags_.no_tick_marks | implot.AxisFlags_.no_highlight
)
MIDDLES = (np.arange(BINS) + 0.5) / BINS
FILL_ALPHA = 0.45
Array = NDArray[np.float64]
Rows = tuple[tuple[str, str, Callable[[Measures], str]], ...]
ROWS: Rows = (
    ("Vessel contrast", "vessel_contrast", lambda one: measure_text(one.vessel_contrast, ".3f")),
    ("Colour difference", "color_difference", lambda one: measure_text(one.color_difference, ".1f")),
    ("Noise gain", "noise_gain", lambda one: measure_text(one.noise_gain, ".2f")),
    ("Chroma noise", "chroma_noise_gain", lambda one: measure_text(one.chroma_noise_gain, ".2f")),
    ("Saturated", "saturated_share", lambda one: measure_text(100 * one.saturated_share, ".1f") + " %"),
)
PAPER_ROWS: Rows = (
    ("DV", "dv_bv", lambda one: measure_text(one.dv, ".0f")),
    ("BV", "dv_bv", lambda one: measure_text(one.bv, ".0f")),
    ("DV/BV", "dv_bv", lambda one: measure_text(one.dv_bv, ".2f")),
)
PAPER_HEADING = "Paper's measures (inferred definition)"
MISLEADS = "DV/BV rises although vessel contrast falls: it counts other changes, too."
DV_TEXT = (
    "Variance of detail and background, in squared grey levels. Inferred definition: the paper gives none."
)
UNUSED = "unused"
COLOR_TEXT = (
    "Share of the change of saturation of Eqs 11 and 12 in use: with d on Auto, less than all where colours "
    "are faint beside their noise, which the whole change would light up."
)
SIGMA_TEXT = (
    "Eq 9: standard deviation of each window's base layer, in grey levels. "
    "Not measured while P is set by hand."
)


def measure_text(value: float, form: str) -> str:
    """In this form; a dash where nothing can be measured."""
    return "—" if math.isnan(value) else format(value, form)


def draw_curves(state: AppState) -> None:
    """V and S before and after, over their histograms, with L and S_m marked."""
    pictures = state.picture.pictures
    if state.opens:
        muted(state.opens)
        return
    if pictures is None or pictures.statistics is None or pictures.request.params is None:
        muted("—")
        return
    used, made = pictures.statistics, curves(pictures.request.params, pictures.statistics)
    space = imgui.get_content_region_avail()
    size = ImVec2((space.x - em(0.5)) / 2, min(max(space.y - 1.6 * em(), em(5)), em(11)))
    now, seen = pictures.request, state.measured
    then = None if seen is None else seen.pictures.request
    if then is None or then.clip is not now.clip or then.frame_index != now.frame_index:
        seen = None  # A histogram of another setting is worth showing, one of another frame is not.
    spreads = None if seen is None else (seen.original.value, seen.enhanced.value)
    _draw_plot("V", size, spreads, (made.given, made.value), used.level / 255)
    explain("Eq 1: V to Vn, at the marked L. Histograms: grey, the original frame; blue, the enhanced one.")
    imgui.same_line(0, em(0.5))
    spreads = None if seen is None else (seen.original.saturation, seen.enhanced.saturation)
    _draw_plot("S", size, spreads, (made.given, made.saturation), used.saturation_mean)
    explain("Eqs 11 and 12: S to S*, at the marked mean S_m. Grey: original frame; blue: enhanced.")
    _captions(used, size.x)


def _captions(used: Statistics, width: float) -> None:
    start = imgui.get_cursor_pos_x()
    muted("V to Vn")
    imgui.same_line(0, em(0.6))
    imgui.text_colored(theme.now().warning, f"L {used.level:.0f}")
    imgui.same_line(start + width + em(0.5))
    muted("S to S*")
    imgui.same_line(0, em(0.6))
    imgui.text_colored(theme.now().warning, f"S_m {used.saturation_mean:.2f}")


def _draw_plot(
    name: str, size: ImVec2, spreads: tuple[Array, Array] | None, line: tuple[Array, Array], mark: float
) -> None:
    if not implot.begin_plot(f"##{name}", size, theme.QUIET_PLOT | implot.Flags_.no_inputs):
        return
    implot.setup_axes("", "", AXIS_FLAGS, AXIS_FLAGS)
    implot.setup_axis_limits(implot.ImAxis_.x1, 0, 1, implot.Cond_.always)
    implot.setup_axis_limits(implot.ImAxis_.y1, 0, 1.02, implot.Cond_.always)
    ink = theme.now()
    fills = (ink.shade(0.75), ink.accent)
    for label, color, shares in zip(("original", "enhanced"), fills, spreads or (), strict=False):
        implot.plot_shaded(label, MIDDLES, shares, 0.0, implot.Spec(fill_color=color, fill_alpha=FILL_ALPHA))
    implot.plot_line("same", line[0], line[0], implot.Spec(line_color=ink.shade(0.4), line_weight=em(0.06)))
    implot.plot_line("curve", *line, implot.Spec(line_color=ink.text, line_weight=em(0.12)))
    implot.plot_inf_lines("mark", np.array([mark]), implot.Spec(line_color=ink.warning, line_weight=em(0.1)))
    implot.end_plot()


def draw_measures(state: AppState) -> None:
    """Frame and enhanced picture in numbers, greyed while they are of an earlier setting."""
    seen, pictures = state.measured, state.picture.pictures
    if state.opens:
        muted(state.opens)
        return
    if seen is None or pictures is None:
        muted("Not measured yet.")
    else:
        imgui.begin_disabled(seen.pictures is not pictures)
        _draw_table(seen)
        imgui.end_disabled()
    if pictures is not None and pictures.statistics is not None:
        facts = facts_of(pictures.statistics, pictures.milliseconds)
        for name, value, text in in_table("measured", (3.6, 4.5, 2.6, 6.5), facts):
            cell(name, tooltip=text)
            cell(value, None if value == UNUSED else theme.now().text, text)
        _draw_omitted(pictures)


def _draw_table(seen: Measured) -> None:
    """Contrast and noise lead; what the paper gives stands below, with a warning where it misleads."""
    _draw_rows("measures", ROWS, seen, "", heads=("original", "enhanced"))
    muted(PAPER_HEADING)
    explain(DV_TEXT)
    _draw_rows("paper's measures", PAPER_ROWS, seen, f"{DV_TEXT} ")
    if misleads(seen.before, seen.after):
        note(MISLEADS, theme.now().warning)


def misleads(before: Measures, after: Measures) -> bool:
    """DV/BV says that vessels became clearer, their contrast that they became fainter."""
    return after.dv_bv > before.dv_bv and after.vessel_contrast < before.vessel_contrast


def _draw_rows(name: str, rows: Rows, seen: Measured, why: str, heads: tuple[str, str] | None = None) -> None:
    told = [(label, text(seen.before), text(seen.after), why + DEFINITIONS[key]) for label, key, text in rows]
    head = [("", *heads, "")] if heads is not None else []
    for label, before, after, text in in_table(name, (8.0, 4.4, 4.4), head + told, imgui.TableFlags_.row_bg):
        cell(label, tooltip=text)
        cell(before, tooltip=text)
        cell(after, theme.now().text if text else None, text)


def _draw_omitted(pictures: Pictures) -> None:
    """What this picture does without, and how much that can change."""
    for omission in pictures.omitted:
        bound = f"at most {omission.error:.2f} levels" if omission.error else "changes nothing"
        note(legible(f"Left out: {omission.what} ({omission.why}; {bound})"))


def facts_of(used: Statistics, milliseconds: float) -> tuple[tuple[str, str, str], ...]:
    """Name, value and explanation of what was measured."""
    sigmas = "  ".join(f"{sigma:.0f}" for sigma in used.sigmas) or UNUSED
    exponents = "  ".join(f"{p:.2f}" for p in dict.fromkeys(used.p))
    return (
        ("L", f"{used.level:.0f}", "Eq 2: grey level below which a tenth of the pixels lie."),
        ("σ", sigmas, SIGMA_TEXT),
        ("z", f"{used.z:.3f}", "Eq 1: brightness factor used."),
        ("P", exponents, "Eq 7: exponent used for each window."),
        ("S mean", f"{used.saturation_mean:.3f}", "Eq 12: mean saturation."),
        ("colour", percent(used.color), COLOR_TEXT),
        ("time", f"{milliseconds:.0f} ms", "Time to enhance this frame on this computer."),
    )
