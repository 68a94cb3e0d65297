"""All that a person sets, as one value: the steps of undo. How it is looked at is no setting."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import Final

from app.enhancement.methods import EnhancementSettings
from app.enhancement.settable import InputKind, Pixels, Scope
from app.gui.views.comparison import Comparison
from app.runs.clip_selection import WHOLE, ClipPart
from app.runs.train_run import RECONSTRUCTION_PARAMS
from enhance import EnhanceParams
from renderer.train.config import TrainConfig

DEFAULT_PARAMS: Final = EnhanceParams()
DEFAULT_CONFIG: Final = TrainConfig()
DEFAULT_COMPARISON: Final = Comparison()
NAMES: Final = {
    "params": "enhancement",
    "scope": "statistics",
    "pixels": "statistics",
    "comparison": "comparison",
    "config": "reconstruction settings",
    "input": "reconstruction settings",
    "d_factor": "reconstruction settings",
}
PARAMS: Final = {"z": "z", "p": "P", "radii": "windows", "eps": "eps", "d_factor": "d-factor"}


@dataclass(frozen=True)
class SettingsSnapshot:
    """What undo goes back to."""

    params: EnhancementSettings = DEFAULT_PARAMS
    scope: Scope = "image"
    pixels: Pixels = "automatic"
    part: ClipPart = WHOLE
    comparison: Comparison = DEFAULT_COMPARISON
    """The line of the wipe in the middle, nothing flipped: these are looked at, not set."""
    config: TrainConfig = DEFAULT_CONFIG
    input: InputKind = "original"
    d_factor: float = RECONSTRUCTION_PARAMS.k

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
