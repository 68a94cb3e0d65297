"""An exported file reproduced from its provenance, and how far the two differ."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from pydantic import ValidationError

from app.console.flags import problem
from app.errors import UserError
from app.exports.make import make
from app.exports.records import EXPORT, KINDS, Export, PanesRecord
from app.exports.replay.difference import Difference, difference
from app.exports.replay.recorded import Facts, recorded
from app.exports.replay.sources import Found
from app.files.provenance import SCHEMA
from app.files.stepping import run_to_end
from app.live.picture import FRAME, RECORDING


@dataclass(frozen=True)
class Replayed:
    """What came of making a file again."""

    kind: str
    difference: Difference
    reasons: tuple[str, ...]
    """What is not here as it was there."""

    @property
    def sentence(self) -> str:
        """Identical, or by how much not and why."""
        if self.difference.is_none:
            return "identical"
        why = "; ".join(self.reasons) or "the file or its provenance has been changed since"
        return f"{self.difference.text}: {why}"


def replay(path: Path, given: tuple[Path, ...], target: Path) -> Replayed:
    """Make the file at `path` again at `target`, from sources beside it, in the current folder or `given`.

    Raises:
        UserError: no provenance or an incomplete one, or a source that is missing or has changed.
        ClipError, ImageError: a source that cannot be read or used.
    """
    facts = recorded(path)
    record = _record(facts, path)
    try:
        run_to_end(make(record, Found(path, given), target))
    except UserError as error:
        raise error if path.name in str(error) else UserError(f"{error}: {path}") from error
    reasons = (*_reasons(facts, recorded(target)), *_without_tools(record))
    return Replayed(record.kind, difference(path, target), reasons)


def _record(facts: Facts, path: Path) -> Export:
    kind, schema = facts.get("kind"), facts.get("schema", SCHEMA)
    if schema != SCHEMA:
        raise UserError(f"expected a record of schema {SCHEMA}, got {schema}, of another version: {path}")
    if kind in (FRAME, RECORDING):
        raise UserError(f"a {kind} is of its moment, and nothing can make it again: {path}")
    if kind not in KINDS:
        raise UserError(f"expected an export of one of {', '.join(KINDS)}, got kind {kind}: {path}")
    try:
        record = EXPORT.validate_python(facts)
    except ValidationError as error:
        raise UserError(f"{path.name} has invalid provenance: {problem(error)}") from error
    if isinstance(record, PanesRecord) and any(one.drawn_tools and one.given is None for one in record.panes):
        raise UserError(
            f"the tool masks of {path.name} are in no file, and nothing can make it again: {path}"
        )
    return record


def _reasons(before: Facts, again: Facts) -> list[str]:
    """Why pixels may differ although nothing was changed."""
    told, now = before.get("libraries"), dict(again["libraries"])
    then = told if isinstance(told, dict) else {}
    # Before 0.2.0, records said no more of a processor than its architecture.
    if " " not in str(then.get("processor")):
        now["processor"] = now["processor"].split()[0]
    names = sorted(then.keys() | now.keys())
    pairs = [("VesselSplat", before.get("version"), again["version"])]
    pairs += [(name, then.get(name), now.get(name, "none")) for name in names]
    pairs.append(("renderer", _renderer(before), _renderer(again)))
    return [f"made with {name} {one}, here {other}" for name, one, other in pairs if one != other]


def _without_tools(record: Export) -> list[str]:
    """Statistics that are given know of the tools; what `vessel` takes from each picture itself does not."""
    panes = record.panes if isinstance(record, PanesRecord) else ()
    masked = any(one.drawn_tools for one in panes)
    return ["made with tools masked in the window, whose masks are in no file"] if masked else []


def _renderer(facts: Facts) -> object:
    """Of the picture, or of the 3D views in it, which one renderer has drawn."""
    views = facts.get("views")
    first = views[0] if isinstance(views, list) and views else None
    return facts.get("renderer") or (first.get("renderer") if isinstance(first, dict) else None)
