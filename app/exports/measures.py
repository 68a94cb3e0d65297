"""Measures of panes: in a table over frames, or of one picture."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from app.enhancement.measures import (
    DEFINITIONS,
    DEFINITIONS_BEFORE,
    LENGTHS_BEFORE,
    NOISE_BEFORE,
    Lengths,
    MeasuredOver,
    Original,
)
from app.exports.panes import Made, PaneMaker
from app.exports.records import MeasuresTable
from app.exports.sizing import Sizing
from app.files.atomic import together, write_bytes
from app.files.csv_table import csv_table
from app.files.provenance import write_sidecar
from enhance.noise import NoiseCut

Row = dict[str, Any]


def measures_at(
    frame: int,
    names: Sequence[str],
    maker: PaneMaker,
    made: Sequence[Made],
    measured_over: MeasuredOver = "field of view",
    noise_cut: NoiseCut = "unclipped",
    lengths: Lengths = "by size",
) -> list[Row]:
    """Those of these names, of each pane's picture, `made` in its own size; NaN: it cannot be measured.

    Raises ClipError or ImageError.
    """
    original = Original.of(maker.clip.read_image(frame), lengths)
    found = (asdict(original.measures(one.panel.image, 0.0, measured_over, noise_cut)) for one in made)
    return [{name: one[name] for name in names} for one in found]


def rows_at(frame: int, record: MeasuresTable, maker: PaneMaker) -> list[Row]:
    """At a frame a row a pane. Raises ClipError or ImageError."""
    label, made = maker.clip.labels[frame], maker.made(frame, Sizing())
    told = record.measured_over, record.noise_cut, record.lengths
    rows = measures_at(frame, record.measures, maker, made, *told)
    pairs = zip(record.panes, rows, strict=True)
    return [{"frame": frame, "label": label, "pane": pane.title} | row for pane, row in pairs]


def write_measures(path: Path, rows: list[Row], record: MeasuresTable) -> None:
    """The table at `path` as CSV, and beside it NAME.csv.json with the same, definitions and record."""
    every = {
        **DEFINITIONS,
        **(DEFINITIONS_BEFORE if record.measured_over == "whole image" else {}),
        **(LENGTHS_BEFORE if record.lengths == "in pixels" else {}),
        **(NOISE_BEFORE if record.noise_cut != "unclipped" else {}),
    }
    definitions = {name: text for name, text in every.items() if name in record.measures}
    with together(path) as place:
        write_bytes(place, csv_table(("frame", "label", "pane", *record.measures), rows))
        write_sidecar(place, record.signed | {"definitions": definitions, "frames": rows})
