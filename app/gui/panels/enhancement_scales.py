"""The windows of the paper's method: a radius and an exponent each, and how the filter is computed."""

from __future__ import annotations

from dataclasses import replace

from imgui_bundle import ImVec2, imgui, imgui_ctx

from app.gui.state import scales
from app.gui.style.widgets import NAMES, button, declared, em, explain, row, slide, slider
from enhance import EnhanceParams, Statistics

SUBSAMPLES = (1, 2, 4, 8)
CLAMPED = imgui.SliderFlags_.always_clamp


def draw_scales(params: EnhanceParams, used: Statistics | None) -> EnhanceParams:
    """A row for each window, then what all have in common."""
    exponents = scales.exponents(params, used.p if used else ())
    changed = params
    for index in range(len(params.radii)):
        # These sliders are narrow: a handle of the usual width hides what they say.
        thin = imgui_ctx.push_style_var(imgui.StyleVar_.grab_min_size, em(0.3))
        with imgui_ctx.push_id(f"window {index}"), thin:
            changed = _draw_scale(changed, index, exponents)
        if len(changed.radii) != len(params.radii):
            return changed
    changed = _draw_counts(changed)
    changed = slide(changed, "eps", "Smoothing", "%.4f", log=True)
    changed = _draw_subsample(changed)
    return slide(changed, "omit_below", "Omit below", "%.2f levels")


def _draw_scale(params: EnhanceParams, index: int, exponents: tuple[float, ...]) -> EnhanceParams:
    about, p = declared(EnhanceParams, "radii"), declared(EnhanceParams, "p")
    row(f"Window {index + 1}", about.text)
    width = (imgui.get_content_region_avail().x - em(2.3)) / 2
    imgui.set_next_item_width(width)
    flags = CLAMPED | imgui.SliderFlags_.logarithmic
    changed, radius = slider("##radius", params.radii[index], about, "%d px", flags)
    explain(about.text)
    params = scales.with_radius(params, index, radius) if changed else params
    imgui.same_line(0, em(0.25))
    imgui.set_next_item_width(width - em(0.25))
    moved, value = slider("##p", float(exponents[index]), p, "P %.2f", CLAMPED)
    explain(f"{p.text} Changed here, each window has its own P.")
    params = scales.with_exponent(params, index, value, exponents) if moved else params
    imgui.same_line(0, em(0.25))
    imgui.begin_disabled(len(params.radii) < 2)
    removed = imgui.button("–", ImVec2(-1, 0))
    imgui.end_disabled()
    explain("Remove this window.")
    return scales.without_scale(params, index) if removed else params


def _draw_counts(params: EnhanceParams) -> EnhanceParams:
    made: list[EnhanceParams] = []
    imgui.set_cursor_pos_x(imgui.get_cursor_pos_x() + em(NAMES))
    more = len(params.radii) < scales.MOST_SCALES
    button("Add window", lambda: made.append(scales.with_scale(params)), enabled=more)
    explain(f"Add a window twice as wide; at most {scales.MOST_SCALES}.")
    imgui.same_line()
    apart = isinstance(params.p, tuple)
    button("One P for all", lambda: made.append(scales.together(params)), enabled=apart)
    explain("Use the mean of the exponents above for every window.")
    return made[0] if made else params


def _draw_subsample(params: EnhanceParams) -> EnhanceParams:
    about = declared(EnhanceParams, "subsample")
    row("Subsample", about.text)
    imgui.set_next_item_width(em(4.2))
    labels = [f"{factor}×" if factor > 1 else "Off" for factor in SUBSAMPLES]
    index = SUBSAMPLES.index(params.subsample) if params.subsample in SUBSAMPLES else 1
    changed, index = imgui.combo("##subsample", index, labels)
    explain(about.text)
    params = replace(params, subsample=SUBSAMPLES[index]) if changed else params
    imgui.same_line()
    changed, keep = imgui.checkbox("Keep black", params.keep_black)
    explain(declared(EnhanceParams, "keep_black").text)
    return replace(params, keep_black=keep) if changed else params
