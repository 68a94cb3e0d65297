"""An exported file reproduced from its provenance, and how far the two differ."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Final

from pydantic import ValidationError

from app.console.flags import problem
from app.errors import UserError
from app.exports.replay.difference import Difference, difference
from app.exports.replay.drawn import remake_depth, remake_render, remake_splats, remake_video
from app.exports.replay.enhanced import remake_enhanced, remake_enhanced_video
from app.exports.replay.panes import remake_measures, remake_panes, remake_panes_video, remake_view_video
from app.exports.replay.recorded import Facts, recorded
from app.exports.replay.sources import Sources
from app.exports.replay.tuned import remake_tuning_sheet
from app.files.provenance import libraries, version

Remake = Callable[[Facts, Sources, Path], str | None]
"""What a file says of itself and where its sources lie, to the file made again at a path; it tells the
renderer that drew it, or None."""


def refuse_window(facts: Facts, sources: Sources, target: Path) -> None:
    """Raises UserError: menus, panels and text are no pictures of the data."""
    raise UserError(
        "expected panes or a 3D view, which can be reproduced from their sources, got a "
        "capture of the whole window "
        f"as on screen: {sources.file}"
    )


KINDS: Final[Mapping[str, Remake]] = MappingProxyType(
    {
        "enhanced picture": remake_enhanced,
        "enhanced video": remake_enhanced_video,
        "render": remake_render,
        "depth": remake_depth,
        "render video": remake_video,
        "splats": remake_splats,
        "panes": remake_panes,
        "panes video": remake_panes_video,
        "view video": remake_view_video,
        "measures": remake_measures,
        "tuning sheet": remake_tuning_sheet,
        "window": refuse_window,
    }
)


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
    kind = str(facts.get("kind"))
    if kind not in KINDS:
        raise UserError(f"expected an export of one of {', '.join(KINDS)}, got kind {kind}: {path}")
    try:
        drawn_by = KINDS[kind](facts, Sources(path, given), target)
    except ValidationError as error:
        raise UserError(f"{path.name} has invalid provenance: {problem(error)}") from error
    return Replayed(kind, difference(path, target), tuple(_reasons(facts, drawn_by)))


def _reasons(facts: Facts, drawn_by: str | None) -> list[str]:
    """Why pixels may differ without anyone's doing."""
    before, now = dict(facts.get("libraries", {})), dict(libraries())
    names = sorted(before.keys() | now.keys())
    pairs = [("VesselSplat", facts.get("version"), version())]
    pairs += [(name, before.get(name), now.get(name, "none")) for name in names]
    if drawn_by is not None:
        pairs.append(("renderer", _renderer(facts), drawn_by))
    return [f"made with {name} {then}, here {here}" for name, then, here in pairs if then != here]


def _renderer(facts: Facts) -> object:
    """Of the picture, or of the 3D views in it, which one renderer has drawn."""
    views = facts.get("views") or [{}]
    return facts.get("renderer") or views[0].get("renderer")
