"""What a report says in words and figures, one heading a part."""

from __future__ import annotations

from imgui_bundle import ImVec2, imgui, imgui_ctx

from app.gui.style import theme
from app.gui.style.widgets import em
from app.gui.work.reported_tables import ReportPart, ShownTable

FLAGS = (
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


def draw_part(part: ReportPart) -> None:
    """Closed until it is asked for."""
    if not imgui.collapsing_header(part.title):
        return
    with imgui_ctx.push_text_wrap_pos(0):
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
    with imgui_ctx.begin_table(key, len(table.heads), FLAGS, ImVec2(0, height)) as drawn:
        if drawn:
            imgui.table_setup_scroll_freeze(1, 1)
            for head, holds_numbers in zip(table.heads, table.numbers, strict=True):
                imgui.table_setup_column(head, FIRST_CLICK[holds_numbers])
            imgui.table_headers_row()
            _draw_rows(table)
    if table.note:
        with imgui_ctx.push_style_color(imgui.Col_.text, theme.now().muted):
            imgui.text_wrapped(table.note)
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
