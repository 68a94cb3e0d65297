"""The tables of the report panel: the same text as on the page, sorted as asked."""

from __future__ import annotations

import math

import pytest

from app.gui.panels.report import draw_table
from app.gui.work.reported_tables import ShownTable, part_of, shown
from app.report.page import page
from app.report.section import Column, Section, Table
from tests.app.gui.ui import Ui

TABLE = Table(
    title="T",
    columns=(
        *(Column(name="what"), Column(name="ms", form=".2f")), Column(name="count"), Column(name="verdict"),
    ),
    rows=(
        ("b", 2.0, 10, True), ("a", None, 9, False), ("d", 0.125, 1, True), ("c", math.nan, 200, True),
    ),
    note="N",
)  # fmt: skip


@pytest.fixture
def table() -> ShownTable:
    return shown(TABLE)


def test_cells_say_what_the_page_says(table: ShownTable) -> None:
    assert table.rows[0] == ("b", "2.00", "10", "pass")
    assert table.rows[1] == ("a", "–", "9", "FAIL")
    assert table.failed == {(1, 3)}
    assert table.numbers == (False, True, True, False)
    html = page({"x": Section(title="X", tables=(TABLE,))}, {})
    assert all(f">{text}</td>" in html for row in table.rows for text in row)


def test_rows_go_by_a_column_and_silent_ones_last_both_ways(table: ShownTable) -> None:
    assert table.order(0, falls=False) == (1, 0, 3, 2)
    assert table.order(1, falls=False) == (2, 0, 1, 3)
    assert table.order(1, falls=True) == (0, 2, 1, 3)
    assert table.order(2, falls=True) == (3, 0, 1, 2)
    for column in range(4):
        assert sorted(table.order(column, falls=True)) == [0, 1, 2, 3]


def test_a_click_on_a_heading_sorts_what_is_drawn(table: ShownTable, monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[tuple[int, bool]] = []
    order = ShownTable.order

    def heard(self: ShownTable, column: int, *, falls: bool) -> tuple[int, ...]:
        asked.append((column, falls))
        return order(self, column, falls=falls)

    monkeypatch.setattr(ShownTable, "order", heard)
    ui = Ui()
    for _ in range(3):
        ui.frame(lambda: draw_table(table, "t"))
    assert not asked, "as the report has them"
    ui.drag(lambda: draw_table(table, "t"), (20, 20), (20, 20))
    ui.frame(lambda: draw_table(table, "t"))
    assert asked[-1] == (0, False)
    ui.close()


def test_a_part_without_rows_is_shown(table: ShownTable) -> None:
    empty = Section(
        title="E", tables=(Table(title="none", columns=TABLE.columns, rows=()),), not_measured=("x",)
    )
    part = part_of(empty)
    assert part.tables[0].order(1, falls=True) == ()
    assert part.not_measured == ("x",)
