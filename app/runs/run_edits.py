"""Edits of a run, kept beside its model: edits.json says what is deleted and hidden, and of which model.

The trained model stays as it is. What no edit changes, or another model, has no such file.
"""

from __future__ import annotations

import base64
import binascii
import zlib
from pathlib import Path
from typing import Annotated, Final, Literal

from pydantic import ConfigDict, Field, TypeAdapter, ValidationError
from pydantic.dataclasses import dataclass

from app.console.flags import problem
from app.enhancement.settable import at_most
from app.errors import UserError
from app.files.atomic import write_bytes
from app.files.provenance import digest, strict_json, version
from app.files.records import LENIENT, Record
from app.runs.run_folder import RunFolder
from renderer.atomic_files import unlinked
from renderer.editing.edits import Edits
from renderer.editing.mask import Mask
from renderer.regular_files import read_regular

MOST = 100_000_000
"""Gaussians: no file makes the program ask for more memory than their masks take."""
LONGEST: Final = 4 * (MOST // 8 + MOST // 800) // 3
"""Characters of a mask of so many, where nothing of it can be made shorter."""
MaskText = Annotated[str, at_most(LONGEST)]


@dataclass(frozen=True, kw_only=True, config=ConfigDict(extra="forbid"))
class EditsRecord:
    """The content of edits.json. Masks are base64 of zlib of bits, the first Gaussian in the lowest."""

    schema: Literal[1] = 1
    version: str
    model_sha256: str
    """Of model.safetensors."""
    gaussians: Annotated[int, Field(ge=0, le=MOST)]
    """Of that model, before any edit."""
    deleted: MaskText
    hidden: MaskText


RECORD = TypeAdapter(EditsRecord)


def save_edits(folder: RunFolder, edits: Edits) -> None:
    """Write edits.json, or remove it where nothing is deleted or hidden. Raises OSError or UserError."""
    if edits.is_empty:
        folder.edits_path.unlink(missing_ok=True)
        return
    deleted, hidden = packed(edits)
    sha256 = digest(folder.model_path)
    record = EditsRecord(
        version=version(), model_sha256=sha256, gaussians=edits.count, deleted=deleted, hidden=hidden
    )
    write_bytes(unlinked(folder.edits_path), strict_json(record, indent=1).encode())


def saved_since(folder: RunFolder, known: Edits) -> Edits | None:
    """What another window has saved beside the run since `known` was read or saved; None: nothing."""
    try:
        record = RECORD.validate_json(read_regular(folder.edits_path))
        there = unpacked(record.deleted, record.hidden, known.count, folder.edits_path)
    except FileNotFoundError:
        there = Edits.none(known.count)
    except (ValidationError, UserError, OSError):
        return Edits.none(known.count)
    return None if (there.deleted, there.hidden) == (known.deleted, known.hidden) else there


def read_edits(folder: RunFolder, count: int) -> Edits | None:
    """What was saved last of the model of `count` Gaussians; None when the run is as it was trained.

    Raises:
        UserError: the file is damaged, or of another model than that of the run.
    """
    path = folder.edits_path
    if not path.is_file():
        return None
    try:
        record = RECORD.validate_json(read_regular(path))
    except ValidationError as error:
        raise UserError(f"{path}: {problem(error)}") from error
    if record.model_sha256 != digest(folder.model_path):
        raise UserError(
            f"expected edits of this run's model, got edits of another model: {path} "
            "(use --as-trained to ignore them, or delete the file)"
        )
    if record.gaussians != count:
        raise UserError(f"expected edits of {count} Gaussians, got edits of {record.gaussians}: {path}")
    return unpacked(record.deleted, record.hidden, count, path)


def unpacked(deleted: str, hidden: str, count: int, place: Path) -> Edits:
    """From the masks of edits.json or of provenance. Raises UserError for damaged ones."""
    try:
        gone, unseen = _mask(count, deleted), _mask(count, hidden)
    except (binascii.Error, zlib.error, ValueError) as error:
        raise UserError(f"expected masks of {count} Gaussians, got {error}: {place}") from error
    return Edits(gone, unseen - gone, Mask(count))


def packed(edits: Edits) -> tuple[str, str]:
    """What is deleted and what is hidden, as `unpacked` takes it."""
    return _text(edits.deleted), _text(edits.hidden)


@dataclass(frozen=True, kw_only=True, config=LENIENT)
class RecordedEdits(Record):
    """What an export says of the edits of its model."""

    gaussians: int = 0
    """Of the model, before any edit."""
    n_deleted: int = 0
    n_hidden: int = 0
    deleted: str
    hidden: str

    @classmethod
    def of(cls, edits: Edits) -> RecordedEdits:
        deleted, hidden = packed(edits)
        counts = {"n_deleted": len(edits.deleted), "n_hidden": len(edits.hidden)}
        return cls(gaussians=edits.count, **counts, deleted=deleted, hidden=hidden)


def _text(mask: Mask) -> str:
    return base64.b64encode(zlib.compress(mask.packed(), 9)).decode("ascii")


def _mask(count: int, text: str) -> Mask:
    """Raises binascii.Error, zlib.error or ValueError for what is no mask of so many."""
    room = -(-count // 8)
    unpacker = zlib.decompressobj()
    packed = unpacker.decompress(base64.b64decode(text, validate=True), max(room, 1))
    if len(packed) != room or not unpacker.eof:
        raise ValueError("others")
    return Mask.unpacked(count, packed)
