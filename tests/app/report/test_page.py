from __future__ import annotations

import math
import re
from html.parser import HTMLParser

from app.report.diagrams import Curve, Diagram, Growth, Point
from app.report.page import page
from app.report.section import Column, Plate, Section, Table

VOID = {"meta", "img", "br"}


class Outline(HTMLParser):
    """Holds every tag against the one it closes."""

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.seen: list[str] = []
        self.links: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.seen.append(tag)
        self.links += [value or "" for name, value in attrs if name in ("src", "href")]
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        if tag not in VOID:
            assert self.open.pop() == tag


def section() -> Section:
    points = (Point(series="a", setting="x < y", seconds=0.01, error=0.0, is_default=True),)
    points += (Point(series="b", setting="z", seconds=0.002, error=0.5),)
    return Section(
        title="Errors & times",
        sentences=("a <b> c",),
        plates=(Plate(title="Plate", diagrams=(Diagram(measure="error", points=points),)),),
        growths=(
            Growth(
                title="g", work="pixels", cost="ms", curves=(Curve.through("c", (1, 10, 100), (2, 20, 200)),)
            ),
        ),
        tables=(
            Table(
                title="Table",
                columns=(Column(name="n"), Column(name="v", best="low"), Column(name="ok")),
                rows=(("<i>", 2.5, True), ("j", 1.5, False), ("k", None, True), ("l", math.nan, True)),
            ),
        ),
        not_measured=("that",),
    )


def test_the_page_is_well_formed_and_needs_nothing_else() -> None:
    text = page({"one": section(), "two": section()}, {"machine": {"cores": 2}, "load": 0.5})
    outline = Outline()
    outline.feed(text)
    assert outline.open == []
    assert outline.seen.count("table") == 2
    assert outline.seen.count("img") == 4
    for link in outline.links:
        assert link.startswith(("data:image/svg+xml;base64,", "#")), link
    assert not re.search(r"https?://", re.sub(r"base64,[^\"]+", "", text))
    assert "<i>" not in text
    assert "a &lt;b&gt; c" in text


def test_verdicts_best_values_and_what_is_missing_are_marked() -> None:
    text = page({"one": section()}, {})
    assert text.count('class="fail"') == 1
    assert text.count('class="pass"') == 3
    assert re.findall(r'class="number best" data-value="([^"]+)"', text) == ["1.5"]
    assert text.count("–</td>") == 2


def test_long_names_break_in_narrow_windows() -> None:
    text = page({}, {"Clip": "a" * 90})
    assert "max-content minmax(0, 1fr)" in text
    assert "overflow-wrap: anywhere" in text


def test_the_same_values_give_the_same_page() -> None:
    assert page({"one": section()}, {}) == page({"one": section()}, {})
