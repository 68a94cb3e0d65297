"""The page to print: a section a picture, with what is in it, its measures, a note, and its file."""

from __future__ import annotations

import base64
import math
from collections.abc import Sequence
from html import escape
from importlib.resources import files
from typing import Final

from app.exports.html_file import filled_in, in_script
from app.exports.records import CaseSummary, SummaryPicture
from app.exports.summary.saved_picture import Measured, Part, SavedPicture
from app.files.provenance import NOTICE

COLUMNS: Final = (
    ("vessel_contrast", "Vessel contrast", ".3f"),
    ("color_difference", "Colour difference", ".1f"),
    ("noise_gain", "Noise gain", ".2f"),
    ("chroma_noise_gain", "Chroma noise", ".2f"),
    ("dv_bv", "DV/BV*", ".2f"),
)
"""Measures, their headings and how many digits are shown."""
INFERRED: Final = "* The paper's measure, by an inferred definition."


def summary_page(record: CaseSummary, pictures: Sequence[SavedPicture]) -> bytes:
    """The HTML of a summary, `pictures` being those of the record; the same bytes for the same ones."""
    sections = (
        _section(number, picture, told)
        for number, (picture, told) in enumerate(zip(pictures, record.pictures, strict=True), start=1)
    )
    return filled_in(
        _own("page.html"),
        {
            "TITLE": escape(record.title),
            "DAY": escape(record.day),
            "NOTICE": escape(NOTICE),
            "NOTES": _note(record.notes),
            "STYLE": _own("page.css") + (_own("fitted.css") if record.layout == "fitted" else ""),
            "PICTURES": "".join(sections),
            "PROVENANCE": in_script(record.signed),
        },
    )


def _section(number: int, picture: SavedPicture, told: SummaryPicture) -> str:
    source = f"data:{picture.media_type};base64,{base64.b64encode(picture.content).decode()}"
    origin = f"{told.picture.name} · SHA-256 {told.picture.sha256[:16]}…"
    return (
        f"<section>\n<h2>{number}. {escape(picture.title)}</h2>\n"
        f'<figure><img src="{source}" alt="{escape(picture.title)}"/>\n'
        f"<figcaption>{escape(NOTICE)}</figcaption></figure>\n"
        f"{_note(told.note)}{_table(picture.parts)}"
        f'<p class="quiet">{escape(origin)}</p>\n</section>\n'
    )


def _table(parts: Sequence[Part]) -> str:
    """What is in the picture, a line each, with the measures that some of them have."""
    shown = [
        column for column in COLUMNS if any(_said(part.measured, column[0], column[2]) for part in parts)
    ]
    heads = "".join(f'<th class="number">{label}</th>' for _, label, _ in shown)
    rows = "".join(
        f"<tr><td>{escape(part.shows)}</td><td>{escape(part.settings)}</td>"
        + "".join(f'<td class="number">{_said(part.measured, name, form)}</td>' for name, _, form in shown)
        + "</tr>\n"
        for part in parts
    )
    inferred = f'<p class="quiet">{INFERRED}</p>\n' if any(name == "dv_bv" for name, *_ in shown) else ""
    return f"<table>\n<tr><th>Shown</th><th>Settings</th>{heads}</tr>\n{rows}</table>\n{inferred}"


def _said(measured: Measured | None, name: str, form: str) -> str:
    """Empty where it is not known."""
    value = None if measured is None else measured.get(name)
    return "" if value is None or not math.isfinite(value) else format(value, form)


def _note(text: str) -> str:
    return f'<p class="note">{escape(text)}</p>\n' if text.strip() else ""


def _own(name: str) -> str:
    return files("app.exports.summary").joinpath(name).read_text(encoding="utf-8")
