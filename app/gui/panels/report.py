"""The report panel: error against run time as `vesselsplat report` measured it, and the current settings."""

from __future__ import annotations

from imgui_bundle import ImVec2, imgui, imgui_ctx, implot

from app.gui.actions import actions
from app.gui.drawing.textures import ShowsPictures
from app.gui.panels.overlays import make_room
from app.gui.panels.swept import MARKERS, draw_swept, nearest, ring
from app.gui.state.app_state import AppState
from app.gui.style import theme
from app.gui.style.widgets import centered, choose, em, muted, note
from app.gui.views.key_words import with_keys
from app.gui.work.reported import Chart, Scale, current
from app.gui.work.reported_tables import ReportPart, ShownTable
from app.report.diagrams import Point

TABLE_FLAGS = (
    imgui.TableFlags_.sortable | imgui.TableFlags_.sort_tristate | imgui.TableFlags_.row_bg
    | imgui.TableFlags_.scroll_x | imgui.TableFlags_.scroll_y | imgui.TableFlags_.sizing_fixed_fit
)  # fmt: skip
FIRST_CLICK = {
    True: imgui.TableColumnFlags_.prefer_sort_descending,
    False: imgui.TableColumnFlags_.prefer_sort_ascending,
}
"""Numbers: the largest first; words by the alphabet."""
MOST_ROWS = 12
"""That are in sight at once."""
CHART_TEXT = "Which diagram to show. Each point is a setting; the line joins the Pareto-optimal settings."
MOST_BELOW = 4
"""Lines whose legend is below the diagram; that of more is beside it, to leave the diagram its height."""


def draw_report(state: AppState, textures: ShowsPictures) -> None:
    """A diagram, which one, and what the report says in words and tables; of a sweep, its jobs first."""
    if state.reports.shown is None:
        imgui.dummy(ImVec2(0, em(3)))
        centered(
            with_keys(
                "Open the report.json of vesselsplat report (Ctrl+I) or the folder of a sweep (Ctrl+O), or "
                "drop it here."
            )
        )
        return
    report = state.reports.shown
    make_room(state)
    muted(report.about)
    if report.sweep is not None and report.sweep.jobs:
        draw_swept(state, textures, report.sweep)
    if report.charts:
        names = {place: chart.name for place, chart in enumerate(report.charts)}
        now = min(state.reports.place, len(names) - 1)
        chosen = choose("diagram", now, names, CHART_TEXT, -1 / em())
        if chosen != now:
            actions.choose_chart(state, chosen)
        _draw_chart(state, report.charts[chosen])
    for part in report.parts:
        draw_part(part)


def _draw_chart(state: AppState, chart: Chart) -> None:
    now = current(chart, state.enhancement.params)
    size = ImVec2(-1, max(em(12), imgui.get_content_region_avail().y * 0.62))
    if implot.begin_plot(f"##{chart.title}{chart.measure}", size, theme.PLOT):
        _plot(chart, now)
        implot.end_plot()
    # Also while the diagram is scrolled out of sight: the height of the page stays.
    if now is not None:
        text = f"Now: {now.setting}, {chart.told(now)}"
        imgui.text_colored(theme.now().accent, f"{text}, the default" if now.is_default else text)
    elif chart.part == "enhancement":
        muted("The current settings are not among those measured.")


def _plot(chart: Chart, now: Point | None) -> None:
    """The lines of a diagram, the fronts, and where the current settings are."""
    implot.setup_axes(chart.against, chart.measure)
    _setup(implot.ImAxis_.x1, chart.across, logarithmic=True)
    _setup(implot.ImAxis_.y1, chart.up, logarithmic=chart.logarithmic)
    if (front := chart.front) is None:
        few = len(chart.series) <= MOST_BELOW
        where = implot.Location_.south if few else implot.Location_.east
        implot.setup_legend(where, implot.LegendFlags_.outside)
    elif chart.corner_is_free:
        corner = implot.Location_.south_west if chart.logarithmic else implot.Location_.north_west
        implot.setup_legend(corner)
    else:
        implot.setup_legend(implot.Location_.east, implot.LegendFlags_.outside)
    for fit in chart.fits:
        implot.plot_line(fit.name, fit.across, fit.up, implot.Spec(line_weight=em(0.08)))
    for place, line in enumerate(chart.series):
        mark = implot.Spec(marker=place % MARKERS, marker_size=em(0.28))
        implot.plot_scatter(line.name, line.across, line.up, mark)
    # Last, so that a series has the same colour whether there is a front or not.
    if front is not None:
        implot.plot_stairs(front.name, front.across, front.up, implot.Spec(line_weight=em(0.1)))
    if now is not None:
        ring(*chart.place(now), filled=True)
    if (point := nearest((one, chart.place(one)) for one in chart.points)) is not None:
        default = " (default)" if point.is_default else ""
        imgui.set_tooltip(f"{point.series}: {point.setting}{default}\n{chart.told(point, 4)}")


def _setup(axis: int, scale: Scale, *, logarithmic: bool) -> None:
    implot.setup_axis_limits(axis, scale.least, scale.most)
    if logarithmic:
        implot.setup_axis_scale(axis, implot.Scale_.log10)
        implot.setup_axis_ticks(axis, list(scale.ticks), scale.labels)


def draw_part(part: ReportPart) -> None:
    """Closed until it is asked for."""
    if not imgui.collapsing_header(part.title):
        return
    for sentence in part.sentences:
        imgui.text_wrapped(sentence)
    for place, table in enumerate(part.tables):
        if imgui.tree_node(f"{table.title}##{part.title}{place}"):
            draw_table(table, f"{part.title}{place}")
            imgui.tree_pop()
    if part.not_measured and imgui.tree_node(f"Not measured##{part.title}"):
        for line in part.not_measured:
            imgui.bullet()
            imgui.text_wrapped(line)
        imgui.tree_pop()


def draw_table(table: ShownTable, key: str) -> None:
    """Sorted by the heading that was clicked last; a third click brings the rows back as they were."""
    line = imgui.get_text_line_height() + 2 * imgui.get_style().cell_padding.y
    height = line * (min(len(table.rows), MOST_ROWS) + 1.4) + imgui.get_style().scrollbar_size
    with imgui_ctx.begin_table(key, len(table.heads), TABLE_FLAGS, ImVec2(0, height)) as drawn:
        if drawn:
            imgui.table_setup_scroll_freeze(1, 1)
            for head, holds_numbers in zip(table.heads, table.numbers, strict=True):
                imgui.table_setup_column(head, FIRST_CLICK[holds_numbers])
            imgui.table_headers_row()
            _draw_rows(table)
    if table.note:
        note(table.note)
    imgui.dummy(ImVec2(0, em(0.3)))


def _draw_rows(table: ShownTable) -> None:
    order = _order(table)
    clipper = imgui.ListClipper()
    clipper.begin(len(order))
    while clipper.step():
        for row in order[clipper.display_start : clipper.display_end]:
            imgui.table_next_row()
            for column, text in enumerate(table.rows[row]):
                imgui.table_next_column()
                if table.numbers[column]:
                    room = imgui.get_content_region_avail().x - imgui.calc_text_size(text).x
                    imgui.set_cursor_pos_x(imgui.get_cursor_pos_x() + max(0.0, room))
                if (row, column) in table.failed:
                    imgui.text_colored(theme.now().danger, text)
                else:
                    imgui.text(text)


def _order(table: ShownTable) -> tuple[int, ...]:
    specs = imgui.table_get_sort_specs()
    if specs.specs_count == 0:
        return tuple(range(len(table.rows)))
    spec = specs.get_specs(0)
    return table.order(spec.column_index, falls=spec.get_sort_direction() == imgui.SortDirection.descending)
