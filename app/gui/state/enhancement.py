"""How pictures are enhanced, the steps of undo of all that a person sets, settings kept by name. A part of
the state."""

from __future__ import annotations

from dataclasses import dataclass, field, fields, replace
from typing import Final

from app.enhancement.methods import EnhancementSettings
from app.enhancement.settable import InputKind, Pixels, Scope, Slot
from app.gui.session_file import KeptSettings
from app.gui.state.summary import Item
from app.gui.views.comparison import Comparison
from app.gui.work.thumbnails import Thumbnails
from app.runs.clip_selection import WHOLE, ClipPart
from enhance import EnhanceParams
from renderer.readers.clip_options import DEFAULTS, DepthSource
from renderer.train.config import TrainConfig
from renderer.view_files import Views

NAMES: Final = {
    "params": "enhancement",
    "scope": "statistics",
    "pixels": "statistics",
    "comparison": "comparison",
    "config": "reconstruction settings",
    "input": "reconstruction settings",
    "kept": "reconstruction settings",
    "depth": "depth",
    "baseline": "depth",
    "field_of_view": "depth",
    "views": "saved views and path",
    "images": "case summary",
}
PARAMS: Final = {
    "strength": "strength",
    "z": "brightness",
    "p": "detail",
    "radii": "windows",
    "eps": "smoothing",
    "d_factor": "colour",
}


@dataclass(frozen=True)
class SettingsSnapshot:
    """All that a person sets: what undo goes back to. How it is looked at is no setting."""

    params: EnhancementSettings = field(default_factory=EnhanceParams)
    scope: Scope = "automatic"
    pixels: Pixels = "automatic"
    part: ClipPart = WHOLE
    comparison: Comparison = field(default_factory=Comparison)
    """The line of the wipe in the middle, nothing flipped: these are looked at, not set."""
    config: TrainConfig = field(default_factory=TrainConfig)
    input: InputKind = "original"
    kept: KeptSettings | None = None
    depth: DepthSource = "auto"
    baseline: float | None = DEFAULTS.baseline
    """mm, as typed."""
    field_of_view: float | None = DEFAULTS.field_of_view
    """Degrees, as typed."""
    views: Views = field(default_factory=Views)
    images: tuple[Item, ...] = ()
    """Of the case summary, with their notes."""

    def with_params(self, params: EnhancementSettings) -> SettingsSnapshot:
        return replace(self, params=params)


def step_name(before: SettingsSnapshot, after: SettingsSnapshot) -> str:
    """What the step from one to the other has changed, in a word or two."""
    names = {NAMES[name] for name in NAMES if getattr(before, name) != getattr(after, name)}
    names |= {name for name in ("trim", "mask") if getattr(before.part, name) != getattr(after.part, name)}
    if len(names) != 1:
        return "settings"
    (name,) = names
    return _of_params(before.params, after.params) if name == "enhancement" else name


def _of_params(before: EnhancementSettings, after: EnhancementSettings) -> str:
    if type(before) is not type(after):
        return "method"
    names = (each.name for each in fields(before))
    changed = [name for name in names if getattr(before, name) != getattr(after, name)]
    return PARAMS.get(changed[0], "enhancement") if len(changed) == 1 else "enhancement"


@dataclass
class Enhancement:
    """Enhancement, history and preset actions change it; drawing reads it."""

    params: EnhancementSettings = field(default_factory=EnhanceParams)
    """Of the method that is chosen."""
    scope: Scope = "automatic"
    pixels: Pixels = "automatic"
    active: bool = True
    """False: plain white light on both sides."""
    peeking: bool = False
    """The original is shown in the enhanced pane while a key is held."""
    past: list[SettingsSnapshot] = field(default_factory=lambda: [SettingsSnapshot()])
    """Settled settings; the last are the present ones. Undo goes back in it."""
    future: list[SettingsSnapshot] = field(default_factory=list)
    stored: dict[Slot, EnhancementSettings] = field(default_factory=dict)
    """Settings kept as "A" and "B", to compare with."""
    presets: dict[str, EnhancementSettings] = field(default_factory=dict)
    """A person's own, by name."""
    choosing: bool = False
    """The menu of presets is open."""
    thumbnails: Thumbnails | None = None
    """What presets made of a frame, when the menu was last open."""
    preset_doomed: str = ""
    """An own one that is deleted once that is confirmed."""
    preset_renamed: str = ""
    """The own preset whose new name is asked for; empty: none."""
    preset_draft: str = ""
    """Name that is being typed for one."""
