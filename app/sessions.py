"""A session on disk: what was open, how it was set and looked at, and notes, as one JSON file.

Sources are named relative to the file, with their bytes' digest where it was saved on purpose.
"""

from __future__ import annotations

import os
from contextlib import suppress
from dataclasses import field
from datetime import UTC, datetime
from pathlib import Path
from typing import Annotated, Any, Final, Literal

from pydantic import ConfigDict, Field, TypeAdapter, ValidationError
from pydantic.dataclasses import dataclass

from app.arguments import problem
from app.atomic import write_bytes
from app.clip_part import ClipPart
from app.errors import UserError
from app.own_files import left_behind, own_file
from app.provenance import strict_json, version
from app.run_edits import MOST
from app.run_folder import RecordedLook
from app.views import ViewKind
from enhance import EnhanceParams
from renderer.json_files import parsed, read_text
from renderer.readers.clip_options import DEFAULTS, ClipOptions
from renderer.train.config import TrainConfig

SUFFIX: Final = ".vesselsplat"
AUTOSAVE: Final = "autosave"
MOST_STEPS = 50
"""Of undo that are kept."""


@dataclass(frozen=True, config=ConfigDict(extra="ignore"))
class SessionSource:
    """A clip, a run or a file of splats."""

    path: str
    """Relative to the folder of the session file, with forward slashes; absolute on another drive."""
    sha256: str | None = None
    """None: saved in passing."""

    @classmethod
    def of(cls, path: Path, folder: Path) -> SessionSource:
        """As seen from a folder."""
        try:
            return cls(Path(os.path.relpath(path, folder)).as_posix())
        except ValueError:
            return cls(path.absolute().as_posix())

    def found(self, session: Path) -> Path | None:
        """Where it lies now: at its place, or moved along with the session file; None: nowhere."""
        folder = session.absolute().parent
        places = (Path(os.path.normpath(folder / self.path)), folder / Path(self.path).name)
        return next((place for place in places if place.exists()), None)


@dataclass(frozen=True, config=ConfigDict(extra="ignore", allow_inf_nan=False))
class FreeCamera:
    """Where the 3D view is seen from, away from the clip's camera."""

    camera: dict[str, Any]
    down: tuple[float, float, float]


@dataclass(frozen=True, config=ConfigDict(extra="ignore", allow_inf_nan=False))
class ComparedAs:
    """What the panes of the pictures show, and how."""

    mode: Literal["side by side", "wipe", "flip", "difference"] = "side by side"
    left: str = "original"
    right: str = "enhanced"
    wipe: float = 0.5
    flipped: bool = False
    zebra: bool = False


@dataclass(frozen=True, config=ConfigDict(extra="ignore", allow_inf_nan=False))
class Varied:
    """A parameter of the tuning grid."""

    name: str
    first: float
    last: float
    count: int


@dataclass(frozen=True, config=ConfigDict(extra="ignore"))
class UnsavedEdits:
    """Of the open model, not kept beside its run yet; masks as in edits.json."""

    gaussians: Annotated[int, Field(ge=0, le=MOST)]
    deleted: str
    hidden: str


@dataclass(frozen=True, kw_only=True, config=ConfigDict(extra="ignore", allow_inf_nan=False))
class Session:
    """Everything of a session that another start can take up."""

    schema: Literal[1] = 1
    version: str = ""
    saved: str = ""
    """UTC, ISO 8601."""
    source: SessionSource | None = None
    """What was opened."""
    run: SessionSource | None = None
    """The newest reconstruction; it goes before `source` where it can be opened."""
    clip_options: ClipOptions = DEFAULTS
    part: ClipPart | None = None
    """Trim and mask; None: not said."""
    edits: UnsavedEdits | None = None
    frame: int = 0
    frozen: int | None = None
    params: RecordedLook = EnhanceParams()
    past: tuple[RecordedLook, ...] = ()
    """Settled parameters, oldest first."""
    scope: Literal["image", "clip"] = "image"
    tissue_only: bool = False
    enhancing: bool = True
    stored: dict[str, RecordedLook] = field(default_factory=dict)
    """Settings kept under a letter, to compare with."""
    comparison: ComparedAs = ComparedAs()
    zoom: float | None = None
    center: tuple[float, float] = (0.5, 0.5)
    linked: bool = True
    view_time: float = 0.0
    free: FreeCamera | None = None
    views: dict[str, Any] | None = None
    """Named views and the camera path, as their own files hold them."""
    view_kind: ViewKind = "color"
    snapped: bool = False
    blend: float = 0.5
    """Share of the photo over a snapped view."""
    config: TrainConfig = TrainConfig()
    input: Literal["original", "enhanced", "both in turn"] = "original"
    d_factor: float = 0.5
    run_name: str = ""
    varied: tuple[Varied, ...] = ()
    tuning_shown: bool = False
    sort: str = ""
    notes: str = ""


SESSION = TypeAdapter(Session)


def write_session(path: Path, session: Session) -> None:
    """The file becomes this session or stays as it was. Raises OSError or UserError."""
    now = datetime.now(UTC).isoformat(timespec="seconds")
    facts = SESSION.dump_python(session) | {"version": version(), "saved": now}
    write_bytes(path, strict_json(facts, indent=1).encode())


def read_session(path: Path) -> Session:
    """All of it that can be read. Raises UserError: see `mended_session`."""
    return mended_session(path)[0]


def mended_session(path: Path) -> tuple[Session, str]:
    """All of a session that can be read, and in a sentence what cannot; empty when all can.

    Raises:
        UserError: no such file, or nothing to open in it. A damaged file is kept beside as NAME.broken.
    """
    try:
        content = read_text(path)
    except OSError as error:
        raise UserError(f"the session cannot be read, {error.strerror}: {path}") from error
    kept = path.with_name(f"{path.name}.broken")
    try:
        return SESSION.validate_json(content), ""
    except ValidationError as error:
        session, left_out = _readable(content)
        if session is None or (session.source is None and session.run is None):
            with suppress(OSError):
                os.replace(path, kept)
            raise UserError(
                f"the session is damaged and was kept as {kept.name} ({problem(error)}): {path}"
            ) from error
    with suppress(OSError):
        kept.write_bytes(content)
    return session, (
        f"of the session, {', '.join(left_out)} cannot be read and is as at first; "
        f"the file as it was is kept as {kept.name}"
    )


def _readable(content: bytes) -> tuple[Session | None, list[str]]:
    """The session without the parts that are not valid, and their names; None for no session at all."""
    try:
        told = parsed(content)
    except ValueError:
        return None, []
    if not isinstance(told, dict) or told.get("schema", 1) != 1:
        return None, []
    left_out: list[str] = []
    while True:
        try:
            return SESSION.validate_python(told), left_out
        except ValidationError as error:
            wrong = sorted({str(each["loc"][0]) for each in error.errors() if each["loc"]} & set(told))
            if not wrong:
                return None, []
            left_out += wrong
            told = {name: value for name, value in told.items() if name not in wrong}


def autosave_path(folder: Path) -> Path:
    """Where this process keeps its session."""
    return own_file(folder, AUTOSAVE, SUFFIX)


def recoverable(folder: Path) -> Path | None:
    """The newest session of a process that ended without clearing it away."""
    return next(reversed(left_behind(folder, AUTOSAVE, SUFFIX)), None)
