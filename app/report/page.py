"""The report as one HTML page that needs nothing else: plots inline, tables that sort, light, printable."""

from __future__ import annotations

import base64
import math
from collections.abc import Iterator, Mapping
from html import escape
from importlib.resources import files
from typing import Any

from matplotlib.figure import Figure

from app.files.provenance import NOTICE
from app.report.diagrams import pareto_front
from app.report.gain_plot import gain_figure
from app.report.plots import diagrams_figure, growth_figure, svg
from app.report.section import Cell, Column, Section, Table, is_number, said


def page(sections: Mapping[str, Section], facts: Mapping[str, Any], title: str = "VesselSplat report") -> str:
    """`facts`: what is said at the top, by name."""
    head = "".join(f'<a href="#{name}">{escape(one.title)}</a>' for name, one in sections.items())
    body = "\n".join(_section(name, one) for name, one in sections.items())
    style, script = (_asset(name) for name in ("page.css", "page.js"))
    return (
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8"/>\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1"/>\n'
        f"<title>{escape(title)}</title>\n<style>\n{style}</style>\n</head>\n<body>\n"
        f"<header><h1>{escape(title)}</h1><p>{escape(NOTICE)} Visibility only, neither detection nor "
        f"diagnosis.</p>{_facts(facts)}</header>\n<nav>{head}</nav>\n<main>\n{body}\n</main>\n"
        f"<script>\n{script}</script>\n</body>\n</html>\n"
    )


def _asset(name: str) -> str:
    return files("app.report").joinpath(name).read_text(encoding="utf-8")


def _facts(facts: Mapping[str, Any]) -> str:
    rows = "".join(f"<dt>{escape(name)}</dt><dd>{escape(_fact(value))}</dd>" for name, value in facts.items())
    return f"<dl>{rows}</dl>"


def _fact(value: Any) -> str:
    if isinstance(value, Mapping):
        return ", ".join(f"{name} {item}" for name, item in value.items() if item is not None)
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def _section(name: str, section: Section) -> str:
    return "\n".join(
        [f'<section id="{name}">', f"<h2>{escape(section.title)}</h2>", *_parts(section), "</section>"]
    )


def _parts(section: Section) -> Iterator[str]:
    for sentence in section.sentences:
        yield f"<p>{escape(sentence)}</p>"
    for plate in section.plates:
        if any(pareto_front(diagram) for diagram in plate.diagrams):
            yield _figure(diagrams_figure(plate.diagrams), plate.title)
    if section.growths:
        yield _figure(growth_figure(section.growths), section.title)
    for diagram in section.gain_diagrams:
        yield _figure(gain_figure(diagram), diagram.title)
    for table in section.tables:
        yield _table(table)
    if section.not_measured:
        items = "".join(f"<li>{escape(each)}</li>" for each in section.not_measured)
        yield f"<h3>Not measured</h3><ul>{items}</ul>"


def _figure(figure: Figure, title: str) -> str:
    data = base64.b64encode(svg(figure)).decode()
    image = f'<img alt="{escape(title)}" src="data:image/svg+xml;base64,{data}"/>'
    return f"<figure>{image}<figcaption>{escape(title)}</figcaption></figure>"


def _table(table: Table) -> str:
    columns = [(column, [row[place] for row in table.rows]) for place, column in enumerate(table.columns)]
    best, head = [_best(*each) for each in columns], "".join(_head(*each) for each in columns)
    body = "\n".join(
        "<tr>" + "".join(_cell(*each) for each in zip(row, table.columns, best, strict=True)) + "</tr>"
        for row in table.rows
    )
    note = f"<p class='note'>{escape(table.note)}</p>" if table.note else ""
    return (
        f"<h3>{escape(table.title)}</h3><div class='wide'><table><thead><tr>{head}</tr></thead>\n"
        f"<tbody>\n{body}\n</tbody></table></div>{note}"
    )


def _head(column: Column, cells: list[Cell]) -> str:
    kind = ' class="number"' if any(map(is_number, cells)) else ""
    return f"<th{kind}>{escape(column.name)}</th>"


def _best(column: Column, cells: list[Cell]) -> float | None:
    numbers = [float(cell) for cell in cells if is_number(cell)]
    if not column.best or len(numbers) < 2:
        return None
    return max(numbers) if column.best == "high" else min(numbers)


def _cell(cell: Cell, column: Column, best: float | None) -> str:
    text = escape(said(cell, column))
    if isinstance(cell, bool):
        return f'<td class="{text.lower()}">{text}</td>'
    if isinstance(cell, str):
        return f"<td>{text}</td>"
    if cell is None or math.isnan(cell):
        return f'<td class="number">{text}</td>'
    kind = "number best" if best is not None and cell == best else "number"
    return f'<td class="{kind}" data-value="{cell}">{text}</td>'
