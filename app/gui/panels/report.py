"""The report panel: error against run time as `vesselsplat report` measured it, and the current settings."""

from __future__ import annotations

from imgui_bundle import ImVec2, imgui, implot

from app.gui.actions import actions
from app.gui.panels.report_tables import draw_part
from app.gui.state.app_state import AppState
from app.gui.style import theme
from app.gui.style.widgets import centered, em, explain
from app.gui.work.reported import Chart, Reported, Scale, current, plain

FLAGS = implot.Flags_.no_title | implot.Flags_.no_menus | implot.Flags_.no_box_select
NEAR = 0.75
"""Text heights from the pointer to a point that it names."""


def draw_report(state: AppState) -> None:
    """A diagram, which one, and what the report says in words and tables."""
    if state.reports.shown is None:
        imgui.dummy(ImVec2(0, em(3)))
        centered("Open a report.json written by vesselsplat report: Ctrl+I, or drop it here.")
        return
    report = state.reports.shown
    imgui.text_colored(theme.now().muted, report.about)
    if report.charts:
        chart = report.charts[_chosen(state, report)]
        _draw_chart(state, chart)
    for part in report.parts:
        draw_part(part)


def _chosen(state: AppState, report: Reported) -> int:
    names = [chart.name for chart in report.charts]
    imgui.set_next_item_width(-1)
    changed, place = imgui.combo("##diagram", min(state.reports.place, len(names) - 1), names)
    explain("Which diagram to show. Each point is a setting; the line joins the Pareto-optimal settings.")
    if changed:
        actions.choose_chart(state, place)
    return place


def _draw_chart(state: AppState, chart: Chart) -> None:
    now = current(chart, state.enhancement.params)
    size = ImVec2(-1, max(em(12), imgui.get_content_region_avail().y * 0.62))
    if not implot.begin_plot(f"##{chart.title}{chart.measure}", size, FLAGS):
        return
    implot.setup_axes(chart.against, chart.measure)
    _setup(implot.ImAxis_.x1, chart.across, logarithmic=True)
    _setup(implot.ImAxis_.y1, chart.up, logarithmic=chart.logarithmic)
    if (front := chart.front) is None:
        implot.setup_legend(implot.Location_.south, implot.LegendFlags_.outside)
    else:
        # Nothing lies beyond the front: no setting is both faster and better.
        where = implot.Location_.south_west if chart.logarithmic else implot.Location_.north_west
        implot.setup_legend(where)
        implot.plot_stairs(front.name, front.across, front.up, implot.Spec(line_weight=em(0.1)))
    for fit in chart.fits:
        implot.plot_line(fit.name, fit.across, fit.up, implot.Spec(line_weight=em(0.08)))
    for line in chart.series:
        implot.plot_scatter(line.name, line.across, line.up, implot.Spec(marker_size=em(0.25)))
    if now is not None:
        _draw_dot(chart, now)
    _explain_nearest(chart)
    implot.end_plot()
    if now is not None:
        text = f"Now: {now.setting}, {plain(now.error)} in {plain(1e3 * now.seconds)} ms"
        imgui.text_colored(theme.now().accent, f"{text}, the default" if now.is_default else text)
    elif chart.part == "enhancement":
        imgui.text_colored(theme.now().muted, "The current settings are not among those measured.")


def _setup(axis: int, scale: Scale, *, logarithmic: bool) -> None:
    implot.setup_axis_limits(axis, scale.least, scale.most)
    if logarithmic:
        implot.setup_axis_scale(axis, implot.Scale_.log10)
        implot.setup_axis_ticks(axis, list(scale.ticks), scale.labels)


def _draw_dot(chart: Chart, now: object) -> None:
    place = implot.plot_to_pixels(*chart.place(now))  # type: ignore[arg-type]
    draw = implot.get_plot_draw_list()
    implot.push_plot_clip_rect()
    draw.add_circle_filled(place, em(0.38), imgui.get_color_u32(theme.now().accent))
    draw.add_circle(place, em(0.6), imgui.get_color_u32(theme.now().accent), 0, em(0.12))
    implot.pop_plot_clip_rect()


def _explain_nearest(chart: Chart) -> None:
    """Name the setting under the pointer."""
    if not implot.is_plot_hovered():
        return
    mouse = imgui.get_mouse_pos()
    for point in chart.points:
        place = implot.plot_to_pixels(*chart.place(point))
        if (place.x - mouse.x) ** 2 + (place.y - mouse.y) ** 2 < em(NEAR) ** 2:
            default = " (default)" if point.is_default else ""
            measured = f"{plain(point.error, 4)} in {plain(1e3 * point.seconds, 4)} ms"
            imgui.set_tooltip(f"{point.series}: {point.setting}{default}\n{measured}")
            return
