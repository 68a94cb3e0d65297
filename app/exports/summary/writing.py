"""A summary written of its record and of the pictures that it names."""

from __future__ import annotations

from pathlib import Path

from app.errors import UserError
from app.exports.records import CaseSummary
from app.exports.sources import Sources
from app.exports.summary.page import summary_page
from app.exports.summary.saved_picture import read_picture
from app.files.atomic import write_bytes


def write_summary(record: CaseSummary, sources: Sources, target: Path) -> None:
    """Raises OSError; UserError: no pictures, or one that is missing, has changed or is not ours."""
    if not record.pictures:
        raise UserError("expected at least one image, got none")
    pictures = [read_picture(sources.saved(one.picture), record.measures_of) for one in record.pictures]
    write_bytes(target, summary_page(record, pictures))
