"""`vesselsplat tune INPUT --vary NAME=FROM:TO:COUNT --out DIR`: a grid of settings, seen and measured."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from app.commands.method_flags import FIELDS, VESSEL_FIELDS, params_of
from app.console.flags import add_fields
from app.console.older_files import say_older
from app.console.progress import measured_text, print_measures, progress
from app.enhancement.contact_sheet import Tile, columns_of, contact_sheet, tile
from app.enhancement.measures import DEFINITIONS, METRICS, Measures
from app.enhancement.methods import PAPER, VESSEL
from app.enhancement.parameter_grid import Axis, Setting, axis, joined, ranked, settings, tried
from app.enhancement.records import EnhancedPicture, SheetCell, TuningSheet
from app.enhancement.settable import PIXELS, Pixels, drawn
from app.enhancement.setting_words import LABELS, said
from app.errors import UserError
from app.files.atomic import filled
from app.files.color_profiles import profile_of
from app.files.csv_table import csv_table
from app.files.image_files import ArrayImage, write_image
from app.files.image_series import open_series
from app.files.provenance import provenance, strict_json, write_png
from app.files.records import Source
from enhance import EnhanceParams, ImageError
from enhance.image import BoolImage
from enhance.measured_pixels import kept
from enhance.surround import inside
from enhance.vessel import VesselParams
from renderer.listing import count
from renderer.readers.image_files.transparency import SAID
from renderer.readers.image_files.used_bits import said_of_bits


def add_flags(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("input", metavar="INPUT", type=Path, help="image, folder of images or video")
    parser.add_argument(
        "--vary",
        action="append",
        required=True,
        metavar="NAME=FROM:TO:COUNT|NAME=VALUE,VALUE",
        help="a parameter and its values, such as d_factor=0:2:5 or z=auto,0.3; repeat for a grid",
    )
    parser.add_argument("--out", type=Path, required=True, metavar="DIR", help="folder to write into")
    parser.add_argument(
        "--frame", type=int, default=0, metavar="I", help="frame of a folder or video (default 0)"
    )
    parser.add_argument("--sort", choices=METRICS, help="best first by this measure (default: as varied)")
    parser.add_argument("--method", choices=(PAPER, VESSEL), default=PAPER, help=f"default {PAPER}")
    parser.add_argument(
        "--pixels",
        choices=PIXELS,
        default=PIXELS[0],
        help="pixels that are enhanced; see enhance --help (default automatic)",
    )
    group = parser.add_argument_group("fixed settings", "settings of either method; see enhance --help")
    add_fields(group, EnhanceParams, FIELDS)
    add_fields(group, VesselParams, VESSEL_FIELDS)
    parser.add_argument("--json", action="store_true", help="print one JSON object on stdout")


@dataclass(frozen=True, eq=False)
class Origin:
    """The picture that is tuned on, and what every file says of it."""

    image: ArrayImage
    tissue: BoolImage | None
    path: Path
    source: Source
    frame: int | None
    """Of a video."""
    method: str
    pixels: Pixels
    bits: int
    """As of a record."""

    @property
    def shared(self) -> dict[str, Any]:
        """What the records of the picture's cells, of their sheet and of all of it have in common."""
        made_of = {"source": self.source, "frame": self.frame, "bits": self.bits}
        return made_of | {"method": self.method, "pixels": self.pixels}


@dataclass(frozen=True)
class Row:
    """A cell once its picture is written."""

    output: str
    setting: Setting
    tile: Tile
    measures: Measures

    @property
    def facts(self) -> dict[str, Any]:
        setting = {"label": self.setting.label, "params": self.setting.params}
        return {"output": self.output} | setting | asdict(self.measures)


def run(flags: argparse.Namespace) -> None:
    base = params_of(flags)
    assert base is not None
    axes = [axis(text, type(base)) for text in flags.vary]
    for one in axes:
        if one.name in flags:
            raise UserError(f"--vary: expected {one.name} to be varied or fixed, got both")
    wanted, origin = settings(base, axes), _origin(flags)
    with filled(flags.out) as staging:
        rows = _tried(staging, origin, wanted)
        if flags.sort:
            rows = [rows[place] for place in ranked([row.measures for row in rows], flags.sort)]
        report = _write_summary(staging, origin, axes, rows, flags.sort)
        written = [path.name for path in staging.iterdir()]
    say_older(flags.out, written)
    if flags.json:
        sys.stdout.write(strict_json(report) + "\n")
    else:
        _print(rows)
        images = count(len(rows), "image")
        sys.stdout.write(f"{flags.out}: sheet.png, tuning.csv, tuning.json and {images}\n")


def _origin(flags: argparse.Namespace) -> Origin:
    """Raises UserError: no such frame, or --out is where the images of the input are."""
    series = open_series(flags.input)
    sys.stderr.writelines(f"{notice}\n" for notice in said_of_bits(len(series), series.bits))
    if flags.out.resolve() in {path.resolve().parent for path in series.sources}:
        raise UserError(f"--out: expected another folder than that of INPUT, got {flags.out}")
    if not 0 <= flags.frame < len(series):
        raise UserError(f"--frame: expected 0 to {len(series) - 1}, got {flags.frame}: {flags.input}")
    image, path = series.read(flags.frame), series.sources[flags.frame]
    frame = series.frame(flags.frame)
    try:
        if not kept(image).all():
            sys.stderr.write(f"{SAID}\n")
        tissue = inside([image]) if flags.pixels == "tissue" else None
    except ImageError as error:
        raise UserError(f"{error}: {path}") from error
    return Origin(image, tissue, path, Source.of(path), frame, flags.method, flags.pixels, series.bits)


def _tried(folder: Path, origin: Origin, wanted: Sequence[Setting]) -> list[Row]:
    """Write each picture as it comes; the rows in the order of the grid."""
    rows: dict[Setting, Row] = {}
    places = {setting: place for place, setting in enumerate(wanted)}
    suffix = ".tiff" if origin.image.dtype.kind == "f" else ".png"
    with progress("tune", len(wanted)) as report:
        try:
            for cell in tried(origin.image, wanted, origin.tissue, drawn(origin.pixels)):
                name = f"setting-{places[cell.setting]:03d}{suffix}"
                record = EnhancedPicture(
                    **origin.shared,
                    params=cell.setting.params,
                    statistics=cell.statistics,
                    measures=cell.measures,
                )
                profile = profile_of(origin.path, cell.image)
                write_image(folder / name, cell.image, record.signed, profile=profile)
                rows[cell.setting] = Row(name, cell.setting, tile(cell, said(cell.setting)), cell.measures)
                report(len(rows), cell.setting.label)
        except ImageError as error:
            raise UserError(f"{error}: {origin.source.name}") from error
    return [rows[setting] for setting in wanted]


def _write_summary(
    folder: Path, origin: Origin, axes: Sequence[Axis], rows: Sequence[Row], sort: str | None
) -> dict[str, Any]:
    """The sheet, the table and all of it as JSON, which is returned."""
    title = f"{origin.source.name}: " + ", ".join(LABELS.get(one.name, one.name) for one in axes)
    title += f", best {sort} first" if sort else ""
    columns = columns_of([len(one.values) for one in axes], in_order=sort is None)
    shown = tuple(SheetCell(label=said(row.setting), params=row.setting.params) for row in rows)
    sheet = TuningSheet(
        **origin.shared,
        title=title,
        columns=columns,
        breaks_labels=True,
        measured_over="field of view",
        noise_cut="unclipped",
        lengths="by size",
        undefined="none",
        settings=shown,
    )
    picture = contact_sheet(title, [row.tile for row in rows], columns, breaks=True)
    write_png(folder / "sheet.png", picture, sheet.signed, profile_of(origin.path, picture))
    (folder / "tuning.csv").write_bytes(_table(axes, rows))
    cells = [row.facts for row in rows]
    report = provenance(**origin.shared, axes=axes, sort=sort, cells=cells, definitions=dict(DEFINITIONS))
    (folder / "tuning.json").write_bytes(strict_json(report, indent=2).encode())
    return report


def _table(axes: Sequence[Axis], rows: Sequence[Row]) -> bytes:
    """CSV; an empty field is what could not be measured."""
    table = []
    for row in rows:
        places = zip(axes, row.setting.places, strict=True)
        values = {one.name: joined(one.values[place]) for one, place in places}
        table.append({"output": row.output} | values | vars(row.measures))
    return csv_table(["output", *(one.name for one in axes), *METRICS], table)


def _print(rows: Sequence[Row]) -> None:
    cells = [(row.setting.label, *map(measured_text, vars(row.measures).values())) for row in rows]
    print_measures(("setting", *METRICS), cells)
