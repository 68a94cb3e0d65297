"""Editing of the shown model: what is chosen and done. A part of the state."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Literal

import numpy as np

from app.gui.work.saving_edits import SaveRequest
from app.gui.work.selecting import Limits, SelectRequest
from app.scenes.free_camera import Vector
from app.scenes.scene import Scene
from renderer.editing.edits import Combination, Edits
from renderer.editing.highlight import highlighted
from renderer.editing.history import History
from renderer.editing.mask import Mask
from renderer.editing.sight import Trait

Tool = Literal["look", "rectangle", "lasso", "sphere", "box"]
TOOLS: tuple[Tool, ...] = ("look", "rectangle", "lasso", "sphere", "box")
Change = Callable[[Edits], Edits]
Step = Callable[[History], History]
Saving = Literal["save"]


@dataclass
class Editing:
    """Edit actions change it; drawing reads it."""

    base: Scene | None = None
    """The model without any edit; None when there is none that can be edited."""
    history: History = field(default_factory=lambda: History(Edits.none(0)))
    saved: Edits = field(default_factory=lambda: Edits.none(0))
    """As they are on disk; selections do not count."""
    edited: Scene | None = None
    """`base` after the edits: what the window shows as its model."""
    drawn: Mask = field(default_factory=lambda: Mask(0))
    """The Gaussians of `base` that `edited` has."""
    tinted: Scene | None = None
    """`edited` with the selected Gaussians in colour; None without any."""

    active: bool = False
    """The mouse selects in the 3D view."""
    tool: Tool = "rectangle"
    how: Combination = "replace"
    radius: float = 0.05
    """Of the sphere or half of the box, in scene distances."""
    ranges: dict[Trait, Limits] = field(default_factory=dict)
    """Those that have been moved."""
    limits: dict[Trait, Limits] = field(default_factory=dict)
    center: Vector | None = None
    """Of the last sphere or box."""

    stroke: tuple[tuple[float, float], ...] = ()
    """Of the drag that is going on: pixel positions in the view's picture."""
    wish: SelectRequest | None = None
    """Until it is answered."""
    saving: SaveRequest | None = None
    """Until it is answered."""
    waiting: list[Step | SelectRequest | Saving] = field(default_factory=list)
    """What was asked for after it, in that order."""
    leaving: Callable[[], None] | None = None
    """What waits for an answer to "save the edits?"."""
    after_saving: Callable[[], None] | None = None
    """What goes on once they are saved."""

    @property
    def edits(self) -> Edits:
        return self.history.present

    @property
    def is_unsaved(self) -> bool:
        present, saved = self.edits, self.saved
        return (present.deleted, present.hidden) != (saved.deleted, saved.hidden)

    @property
    def is_under_way(self) -> bool:
        """In edit mode, or edits are neither saved nor discarded: no other model comes by itself."""
        return self.active or self.is_unsaved or self.leaving is not None

    @property
    def takes_drags(self) -> bool:
        """The left button belongs to a tool."""
        return self.active and self.tool != "look"

    @property
    def run_path(self) -> Path | None:
        """Run folder or file of splats that the model is of."""
        return self.base.path if self.base else None

    @property
    def is_of_run(self) -> bool:
        return self.base is not None and self.base.is_of_run


def tinted_model(edited: Scene, edits: Edits) -> Scene | None:
    """With the selected Gaussians in colour; None without any."""
    if not len(edits.selected):
        return None
    chosen = edits.selected.booleans()[edits.visible.indices()]
    every = edited, np.arange(len(edited.model))
    return replace(edited, model=highlighted(edited.model, chosen), of=every)
