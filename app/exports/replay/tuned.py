"""The sheet of a tuning grid, reproduced."""

from __future__ import annotations

from pathlib import Path
from typing import Literal

from pydantic import ConfigDict, TypeAdapter
from pydantic.dataclasses import dataclass

from app.enhancement.contact_sheet import contact_sheet, tile
from app.enhancement.parameter_grid import Setting, tried
from app.errors import UserError
from app.exports.replay.recorded import Facts, again
from app.exports.replay.sources import Named, Sources
from app.files.image_series import open_series
from app.files.provenance import write_png
from app.runs.run_folder import RecordedSettings
from enhance.surround import inside


@dataclass(frozen=True, config=ConfigDict(extra="ignore"))
class SettingFacts:
    """One cell."""

    label: str
    params: RecordedSettings


@dataclass(frozen=True, config=ConfigDict(extra="ignore"))
class SheetFacts:
    """What a sheet says of itself, as far as its pixels depend on it."""

    source: Named
    frame: int | None
    pixels: Literal["all", "tissue"]
    title: str
    columns: int
    settings: tuple[SettingFacts, ...]


SHEET = TypeAdapter(SheetFacts)


def remake_tuning_sheet(facts: Facts, sources: Sources, target: Path) -> None:
    """Raises UserError, ClipError, ImageError or pydantic.ValidationError."""
    said = SHEET.validate_python(facts)
    series, frame = open_series(sources.find(said.source)), said.frame or 0
    if not 0 <= frame < len(series) or not said.settings or said.columns < 1:
        raise UserError(f"expected settings, columns and one of {len(series)} frames: {sources.file}")
    image = series.read(frame)
    mask = inside([image]) if said.pixels == "tissue" else None
    wanted = [Setting((place,), one.label, one.params) for place, one in enumerate(said.settings)]
    tiles = {cell.setting: tile(cell) for cell in tried(image, wanted, mask)}
    sheet = contact_sheet(said.title, [tiles[setting] for setting in wanted], said.columns)
    write_png(target, sheet, again(facts))
