"""A session on disk: what was open, how it was set and looked at, and notes, as one JSON file.

Sources are named relative to the file, with their bytes' digest where it was saved on purpose.
"""

from __future__ import annotations

import os
from contextlib import suppress
from dataclasses import field, fields, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Annotated, Any, Final, Literal

import numpy as np
from annotated_types import Interval
from pydantic import ConfigDict, TypeAdapter, model_validator
from pydantic.dataclasses import dataclass

from app.console.flags import shortened
from app.enhancement.measures import METRICS
from app.enhancement.methods import RecordedSettings
from app.enhancement.parameter_grid import Axis
from app.enhancement.settable import (
    MOST_VALUES,
    SLOTS,
    FrameNumber,
    InputKind,
    Name,
    Notes,
    PathText,
    Pixels,
    Scope,
    Share,
    Slot,
    Zoom,
    at_most,
    one_of,
    renamed,
)
from app.errors import UserError
from app.files.atomic import write_bytes
from app.files.mended import mended
from app.files.process_files import left_behind, own_file
from app.files.provenance import strict_json, version
from app.gui.recorded_views import RecordedViews
from app.gui.views.comparison import Comparison
from app.runs.clip_selection import ClipPart
from app.runs.run_edits import MOST, MaskText
from app.scenes.free_camera import FreeView
from app.scenes.view_kinds import ViewKind
from enhance import EnhanceParams
from enhance.vessel import VesselParams
from renderer.json_files import parsed
from renderer.readers.clip_options import DEFAULTS, FIELD_OF_VIEW, ClipOptions
from renderer.regular_files import read_regular
from renderer.train.config import TrainConfig

SUFFIX: Final = ".vesselsplat"
AUTOSAVE: Final = "autosave"
MOST_STEPS = 50
"""Of undo that are kept."""
MOST_ITEMS: Final = 200
"""Pictures of a case summary."""
MOST_VARIED: Final = 1e6
"""What a parameter that is tuned goes to; each has a range of its own within."""
PARAMETERS: Final = ("", *(item.name for kind in (EnhanceParams, VesselParams) for item in fields(kind)))
"""That can be tuned, of either method; empty: none."""


@dataclass(frozen=True, config=ConfigDict(extra="ignore"))
class SessionSource:
    """A clip, a run or a file of splats."""

    path: PathText
    """Relative to the folder of the session file, with forward slashes; absolute on another drive."""
    sha256: Annotated[str, at_most(64)] | None = None
    """None: saved in passing."""

    @classmethod
    def of(cls, path: Path, folder: Path) -> SessionSource:
        """As seen from a folder."""
        try:
            return cls(Path(os.path.relpath(path, folder)).as_posix())
        except ValueError:
            return cls(path.absolute().as_posix())

    @property
    def bare(self) -> SessionSource:
        """Without its folder and its bytes."""
        return SessionSource(Path(self.path).name)

    def found(self, session: Path) -> Path | None:
        """Where it lies now: at its place, or moved along with the session file; None: nowhere."""
        name = Path(self.path).name
        # A drive has no name, and does not move along.
        moved = [session.absolute().parent / name] if name else []
        return next((place for place in (self.place(session), *moved) if place.exists()), None)

    def place(self, session: Path) -> Path:
        """Where it lay when that session was saved there."""
        return Path(os.path.normpath(session.absolute().parent / self.path))


@dataclass(frozen=True, config=ConfigDict(extra="ignore", allow_inf_nan=False))
class Choice:
    """One parameter of the tuning grid to vary, as chosen; an empty name: none."""

    name: Annotated[str, one_of(PARAMETERS)] = ""
    first: Annotated[float, Interval(ge=-MOST_VARIED, le=MOST_VARIED)] = 0.0
    last: Annotated[float, Interval(ge=-MOST_VARIED, le=MOST_VARIED)] = 1.0
    count: Annotated[int, Interval(ge=1, le=MOST_VALUES)] = 4

    def axis(self, *, whole: bool) -> Axis:
        """`count` values with both ends; fewer where only whole numbers do."""
        values = [round(float(value), 6) for value in np.linspace(self.first, self.last, self.count)]
        return Axis(self.name, tuple(dict.fromkeys(map(round, values) if whole else values)))


@dataclass(frozen=True, config=ConfigDict(extra="ignore"))
class KeptSettings:
    """Of frames that are reconstructed, apart from what the image is set to."""

    params: RecordedSettings
    since: Name = ""
    """When they were the image's; local, ISO 8601 to the minute."""


@dataclass(frozen=True, config=ConfigDict(extra="ignore"))
class UnsavedEdits:
    """Of the open model, not kept beside its run yet; masks as in edits.json."""

    gaussians: Annotated[int, Interval(ge=0, le=MOST)]
    deleted: MaskText
    hidden: MaskText


@dataclass(frozen=True, config=ConfigDict(extra="ignore"))
class SummaryPicture:
    """A saved picture of the case summary."""

    file: SessionSource
    note: Notes = ""


@dataclass(frozen=True, kw_only=True, config=ConfigDict(extra="ignore"))
class SummaryDraft:
    """The case summary as it is put together."""

    title: Name = ""
    notes: Notes = ""
    pictures: Annotated[tuple[SummaryPicture, ...], at_most(MOST_ITEMS)] = ()

    @property
    def substance(self) -> SummaryDraft:
        """Without folders."""
        bare = (SummaryPicture(one.file.bare, one.note) for one in self.pictures)
        return replace(self, pictures=tuple(bare))


Case = tuple[str, SummaryDraft]
"""Notes, and the case summary without folders."""


def _unstated(given: Any) -> Any:
    """Files of former versions name a field of view that nobody has stated."""
    options = given.get("clip_options") if isinstance(given, dict) else None
    if not isinstance(options, dict) or given.get("version") == version():
        return given
    is_assumed = options.get("field_of_view") == FIELD_OF_VIEW
    return given | {"clip_options": options | {"field_of_view": None}} if is_assumed else given


@dataclass(frozen=True, kw_only=True, config=ConfigDict(extra="ignore", allow_inf_nan=False))
class Session:
    """Everything of a session that another start can take up."""

    @model_validator(mode="before")
    @classmethod
    def _of_before(cls, given: Any) -> Any:
        return _unstated(renamed(given))

    schema: Literal[1] = 1
    version: Name = ""
    saved: Name = ""
    """UTC, ISO 8601."""
    source: SessionSource | None = None
    """What was opened."""
    run: SessionSource | None = None
    """The newest reconstruction; it goes before `source` where it can be opened."""
    second: SessionSource | None = None
    """What is in the second 3D view: a run or a file of splats."""
    clip_options: ClipOptions = DEFAULTS
    part: ClipPart | None = None
    """Trim and mask; None: not said."""
    edits: UnsavedEdits | None = None
    frame: FrameNumber = 0
    frozen: FrameNumber | None = None
    params: RecordedSettings = EnhanceParams()
    past: Annotated[tuple[RecordedSettings, ...], at_most(MOST_STEPS)] = ()
    """Settled parameters, oldest first."""
    scope: Scope = "automatic"
    pixels: Pixels = "automatic"
    enhancing: bool = True
    stored: Annotated[dict[Slot, RecordedSettings], at_most(len(SLOTS))] = field(default_factory=dict)
    """Settings kept under a letter, to compare with."""
    comparison: Comparison = Comparison()
    zoom: Zoom | None = None
    center: tuple[Share, Share] = (0.5, 0.5)
    linked: bool = True
    view_time: Share = 0.0
    free: FreeView | None = None
    """Where the 3D view is seen from, away from the clip's camera."""
    views: RecordedViews | None = None
    """Named views and the camera path, as their own files hold them."""
    view_kind: ViewKind = "color"
    snapped: bool = False
    blend: Share = 0.5
    """Share of the frame over a snapped view."""
    config: TrainConfig = TrainConfig()
    input: InputKind = "original"
    kept: KeptSettings | None = None
    """Settings of frames that are reconstructed; None: as the image."""
    run_name: Name = ""
    varied: Annotated[tuple[Choice, ...], at_most(2)] = ()
    tuning_shown: bool = False
    sort: Annotated[str, one_of(("", *METRICS))] = ""
    notes: Notes = ""
    summary: SummaryDraft = SummaryDraft()

    @property
    def substance(self) -> Session:
        """What a person would miss: without where one looks, steps of undo, and the folders of sources."""
        kept = {name: getattr(self, name) for name in SUBSTANCE}
        run, second = (one and one.bare for one in (self.run, self.second))
        return Session(run=run, second=second, summary=self.summary.substance, **kept)

    @property
    def case(self) -> Case:
        """What was written down and collected."""
        return self.notes, self.summary.substance


SUBSTANCE: Final = (
    "part", "edits", "params", "scope", "pixels", "enhancing", "stored", "comparison", "views", "config",
    "input", "kept", "run_name", "varied", "notes", "clip_options",
)  # fmt: skip
SESSION = TypeAdapter(Session)


OTHER: Final = "expected a session of schema"


def write_session(path: Path, session: Session) -> None:
    """The file becomes this session or stays as it was. Raises OSError or UserError."""
    now = datetime.now(UTC).isoformat(timespec="seconds")
    facts = SESSION.dump_python(session) | {"version": version(), "saved": now}
    write_bytes(path, strict_json(facts, indent=1).encode())


def readable_session(path: Path) -> Session | None:
    """All of a session that can be read; None for no session at all. The file stays as it is.

    Raises:
        OSError: it cannot be read.
    """
    return _readable(read_regular(path))[0]


def mended_session(path: Path) -> tuple[Session, str]:
    """All of a session that can be read, and in a sentence what cannot; empty when all can.

    Raises:
        UserError: no such file, nothing to open in it, or of another schema. A damaged file is kept beside as
            NAME.broken.
    """
    try:
        content = read_regular(path)
    except OSError as error:
        raise UserError(f"the session cannot be read, {error.strerror}: {path}") from error
    kept = path.with_name(f"{path.name}.broken")
    session, wrong = _readable(content)
    if not wrong and session is not None:
        return session, ""
    if wrong.startswith(OTHER):
        # Another version reads it: it stays.
        raise UserError(f"{wrong}: {path}")
    if session is None or (session.source is None and session.run is None):
        with suppress(OSError):
            os.replace(path, kept)
        raise UserError(f"the session is damaged and was kept as {kept.name} ({wrong}): {path}")
    with suppress(OSError, UserError):
        write_bytes(kept, content)
    return session, f"in the session, {wrong}, so defaults are used; the old file is kept as {kept.name}"


def _readable(content: bytes) -> tuple[Session | None, str]:
    """The session without the parts that are not valid, and what is wrong; None for no session at all."""
    try:
        told = parsed(content)
    except ValueError:
        return None, "not JSON"
    if not isinstance(told, dict):
        return None, "not a JSON object"
    if told.get("schema", 1) != 1:
        return None, f"{OTHER} 1, got {shortened(told['schema'])}, which another version can open"
    found = mended(SESSION, told)
    session, left_out = found
    return session, f"{', '.join(left_out)} cannot be read" if left_out else ""


def autosave_path(folder: Path) -> Path:
    """Where this process keeps its session."""
    return own_file(folder, AUTOSAVE, SUFFIX)


def recoverable(folder: Path) -> Path | None:
    """The newest session of a process that ended without clearing it away."""
    return next(reversed(left_behind(folder, AUTOSAVE, SUFFIX)), None)
