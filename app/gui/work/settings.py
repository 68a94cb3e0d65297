"""What the app remembers between two starts, also of single clips, and the folders where it keeps things."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, replace
from itertools import chain
from pathlib import Path
from typing import Annotated, Any, Literal

import platformdirs
from annotated_types import Interval
from pydantic import AfterValidator, BeforeValidator, ConfigDict, StrictBool, TypeAdapter, model_validator
from pydantic.dataclasses import dataclass as pydantic_dataclass

from app.enhancement.image_mask import NO_MASK, PictureMask
from app.enhancement.methods import VESSEL, Preset
from app.enhancement.settable import FrameNumber, Mode, Name, PathText, Pixels, Scope, at_most
from app.files.mended import mended, mended_file
from app.files.provenance import strict_json
from app.gui.recorded_views import RecordedViews
from app.runs.clip_selection import ClipPart
from app.runs.runs_place import runs_place
from app.scenes.backgrounds import BackgroundName
from renderer.readers.clip_options import FIELD_OF_VIEW, DepthSource, Stereo
from renderer.readers.lenses.calibration import Calibration

RECENT_LIMIT = 8
MOST_FOLDERS = 32
SETTINGS_FILE = "settings.json"
Theme = Literal["dark", "light"]
TEXT_PERCENTS = (80, 90, 100, 110, 125, 150, 175, 200)
"""Sizes of all text, of what the theme says."""


@dataclass(frozen=True)
class Places:
    """Folders of this user: settings and layout, reconstructions, pictures."""

    config: Path
    runs: Path
    pictures: Path

    @classmethod
    def of_user(cls) -> Places:
        """The platform's own folders; VESSELSPLAT_CONFIG_DIR, _RUNS_DIR and _PICTURES_DIR override them."""
        return cls(
            config=_folder("VESSELSPLAT_CONFIG_DIR", _config()),
            runs=runs_place().resolve(),
            pictures=_folder("VESSELSPLAT_PICTURES_DIR", platformdirs.user_pictures_path() / "VesselSplat"),
        )

    @property
    def settings_file(self) -> Path:
        return self.config / SETTINGS_FILE

    @property
    def thumbnails(self) -> Path:
        """Of what was opened lately: in the user's cache folder; with settings elsewhere, beside these."""
        cache = platformdirs.user_cache_path("vesselsplat", False)
        return (cache if self.config == _config() else self.config) / "recent"

    @property
    def tool_masks(self) -> Path:
        """Of clips, a folder each."""
        return self.runs.parent / "tool-masks"

    @property
    def logs(self) -> Path:
        """Errors, for bug reports."""
        return self.config / "log"


def _config() -> Path:
    return platformdirs.user_config_path("vesselsplat", False)


def _folder(variable: str, default: Path) -> Path:
    return Path(os.environ.get(variable) or default)


def _percent(told: int) -> int:
    if told not in TEXT_PERCENTS:
        raise ValueError(f"expected one of {TEXT_PERCENTS}")
    return told


def _newest(told: Any) -> Any:
    return told[:RECENT_LIMIT] if isinstance(told, list) else told


@pydantic_dataclass(frozen=True, config=ConfigDict(extra="ignore"))
class Settings:
    """Kept as JSON in the user's own configuration folder, never beside a clip or in an export."""

    acknowledged: StrictBool = False
    """The notice "Research use only" has been read."""
    remember_recent: StrictBool = True
    recent: Annotated[tuple[PathText, ...], at_most(RECENT_LIMIT), BeforeValidator(_newest)] = ()
    """Opened clips and runs, newest first."""
    theme: Theme = "dark"
    text_percent: Annotated[int, AfterValidator(_percent)] = 100
    method: Preset = VESSEL
    scope: Scope = "automatic"
    pixels: Pixels = "automatic"
    mode: Mode = "side by side"
    """As last worked with, like the three before it."""
    second_place: tuple[int, int, int, int] | None = None
    """Of the second window: left, top, width and height."""
    second_full_screen: bool = False
    background: BackgroundName = "grey"
    """Of reconstructions, where nothing was observed."""
    unobserved: StrictBool = False
    """Reconstructions are drawn with what no frame shows."""
    folders: Annotated[dict[Name, PathText], at_most(MOST_FOLDERS)] = field(default_factory=dict)
    """Where a person was last, by purpose of the dialog."""

    def moved(self, path: Path, to: Path | None) -> Settings:
        """With what was opened by a path that has changed, or has gone."""
        now = () if to is None else (str(to),)
        kept = (now if item == str(path) else (item,) for item in self.recent)
        return replace(self, recent=tuple(chain.from_iterable(kept)))

    def opened(self, path: Path) -> Settings:
        """With `path` in front of the recent ones, when they are remembered at all."""
        if not self.remember_recent:
            return self
        others = tuple(item for item in self.recent if item != str(path))
        return replace(self, recent=(str(path), *others)[:RECENT_LIMIT])

    def visited(self, purpose: str, folder: Path) -> Settings:
        """With the folder as the one for this purpose, when paths are remembered at all."""
        if not self.remember_recent:
            return self
        return replace(self, folders={**self.folders, purpose: str(folder)})

    def resized(self, steps: int) -> Settings:
        """With larger or smaller text, that many of TEXT_PERCENTS on, as far as they go."""
        place = TEXT_PERCENTS.index(self.text_percent) + steps
        return replace(self, text_percent=TEXT_PERCENTS[min(max(place, 0), len(TEXT_PERCENTS) - 1)])

    def remembering(self, remember: bool) -> Settings:
        """Switching the list off also forgets it, and the folders."""
        if remember:
            return replace(self, remember_recent=True)
        return replace(self, remember_recent=False, recent=(), folders={})


SETTINGS = TypeAdapter(Settings)


def load_settings(path: Path) -> Settings:
    """What `settings_content` was; defaults for what is missing or damaged: nothing in it is precious."""
    return mended_file(SETTINGS, path) or Settings()


def settings_content(settings: Settings) -> bytes:
    """The whole file."""
    return json.dumps(asdict(settings), indent=2).encode()


MOST_CLIPS = 200
FILE = "clips.json"


def _last(told: Any) -> Any:
    return dict(list(told.items())[-MOST_CLIPS:]) if isinstance(told, dict) else told


@pydantic_dataclass(frozen=True, kw_only=True, config=ConfigDict(extra="forbid"))
class KnownClip:
    """What was chosen for one clip."""

    trim: tuple[FrameNumber, FrameNumber] | None = None
    mask: PictureMask = NO_MASK
    depth: DepthSource = "auto"
    baseline: Annotated[float, Interval(ge=0.01, le=1000)] | None = None
    """In mm; None: not said."""
    view_angle: Annotated[float, Interval(ge=5, le=170)] | None = None
    """Horizontal, in degrees; None: not said."""
    stereo: Stereo = "auto"
    """How both eyes lie in the frames."""
    calibration: Calibration | None = None
    views: RecordedViews | None = None
    """Named views and a camera path, also of a model without a clip; None: none."""

    @model_validator(mode="before")
    @classmethod
    def _of_before(cls, given: Any) -> Any:
        """Files of former versions name a field of view that nobody has said."""
        if not isinstance(given, dict) or "field_of_view" not in given:
            return given
        others = {name: value for name, value in given.items() if name != "field_of_view"}
        said = given["field_of_view"]
        return others if said == FIELD_OF_VIEW else others | {"view_angle": said}

    @property
    def part(self) -> ClipPart:
        return ClipPart(trim=self.trim, mask=self.mask)


UNKNOWN = KnownClip()
CLIP = TypeAdapter(KnownClip)


def _readable(told: Any) -> Any:
    """Of a clip what can be read: a camera path that is damaged takes nothing else with it."""
    return mended(CLIP, told)[0] if isinstance(told, dict) else told


CLIPS = TypeAdapter(
    Annotated[dict[str, Annotated[KnownClip, BeforeValidator(_readable)]], BeforeValidator(_last)]
)


def load_clips(folder: Path) -> dict[str, KnownClip]:
    """By path, those that can be read: nothing in it is precious."""
    clips = mended_file(CLIPS, folder / FILE) or {}
    return {path: known for path, known in clips.items() if known != UNKNOWN}


def clips_content(clips: Mapping[str, KnownClip]) -> bytes:
    """The whole file: the last MOST_CLIPS of those that differ from the defaults."""
    said = [(path, known) for path, known in clips.items() if known != UNKNOWN]
    return strict_json(dict(said[-MOST_CLIPS:]), indent=2).encode()
