"""How pictures are enhanced, what that was before, and settings kept by name. A part of the state."""

from __future__ import annotations

from dataclasses import dataclass, field

from app.enhancement.methods import EnhancementSettings
from app.enhancement.settable import Pixels, Scope, Slot
from app.gui.state.settings_snapshot import SettingsSnapshot
from app.gui.work.thumbnails import Thumbnails
from enhance import EnhanceParams


@dataclass
class Enhancement:
    """Enhancement, history and preset actions change it; drawing reads it."""

    params: EnhancementSettings = field(default_factory=EnhanceParams)
    """Of the method that is chosen."""
    scope: Scope = "image"
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
    preset_draft: str = ""
    """Name that is being typed for one."""
