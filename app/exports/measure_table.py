"""Measures of panes at every frame against the original, as a table and as JSON that says what they mean."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from app.enhancement.parameter_grid import DEFINITIONS, measured
from app.exports.panes import PaneMaker
from app.exports.records import MeasuresTable
from app.exports.sizing import Sizing
from app.files.atomic import together, write_bytes
from app.files.provenance import write_sidecar
from enhance.ridges import field_of_view, vessel_mask

Row = dict[str, Any]


def rows_at(frame: int, record: MeasuresTable, maker: PaneMaker) -> list[Row]:
    """At a frame a row a pane, of its picture in its own size. Raises ClipError or ImageError."""
    photo, label = maker.clip.read_image(frame), maker.clip.labels[frame]
    view = field_of_view(photo)
    vessels = vessel_mask(photo, tissue_mask=view)
    rows = []
    for pane, one in zip(record.panes, maker.made(frame, Sizing()), strict=True):
        found = asdict(measured(one.panel.image, photo, vessels, view, 0.0))
        chosen = {name: found[name] for name in record.measures}
        rows.append({"frame": frame, "label": label, "pane": pane.title} | chosen)
    return rows


def write_measures(path: Path, rows: list[Row], record: MeasuresTable) -> None:
    """The table at `path` as CSV, and beside it NAME.csv.json with the same, definitions and record."""
    definitions = {name: text for name, text in DEFINITIONS.items() if name in record.measures}
    with together(path) as place:
        write_bytes(place, _table(rows, record.measures))
        write_sidecar(place, record.signed | {"definitions": definitions, "frames": rows})


def _table(rows: list[Row], measures: Sequence[str]) -> bytes:
    """CSV; an empty field is what could not be measured."""
    text = io.StringIO()
    writer = csv.DictWriter(text, ["frame", "label", "pane", *measures])
    writer.writeheader()
    for row in rows:
        writer.writerow({name: "" if value != value else value for name, value in row.items()})
    return text.getvalue().encode()
