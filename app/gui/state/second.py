"""The second 3D view: another reconstruction with the first one's camera and time. A part of the state."""

from __future__ import annotations

from dataclasses import dataclass

from app.gui.work.baking import Baked
from app.gui.work.opening import OpenRequest
from app.scenes.scene import Scene
from app.scenes.viewing import View


@dataclass
class Second:
    """Second actions change it; drawing reads it."""

    opening: OpenRequest | None = None
    shown: Scene | None = None
    view: View | None = None
    """The newest picture of it that the processor drew."""
    baked: Baked | None = None
    """Keyframes of it for the graphics card; more to come while they are None."""
