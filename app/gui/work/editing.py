"""Editing of the shown model: what is chosen and done, and selecting off the window's thread."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Literal

import numpy as np

from app.gui.work.picking import surface
from app.gui.work.saving_edits import SaveRequest
from app.scenes.free_camera import Vector
from app.scenes.scene import Scene
from app.scenes.view_request import ViewRequest
from renderer.editing.edits import Combination, Edits
from renderer.editing.highlight import highlighted
from renderer.editing.history import History
from renderer.editing.mask import Mask
from renderer.editing.regions import Box, Region, Sphere, found
from renderer.editing.sight import Sight, Trail, Trait

Tool = Literal["look", "rectangle", "lasso", "sphere", "box"]
TOOLS: tuple[Tool, ...] = ("look", "rectangle", "lasso", "sphere", "box")
TRAITS: tuple[Trait, ...] = ("opacity", "size", "depth", "motion")
Limits = tuple[float, float]
Change = Callable[[Edits], Edits]
MOST_TIMES = 32
"""Moments at which the motion over a clip is looked at."""


@dataclass(frozen=True)
class Around:
    """A sphere or a box around the surface behind a pixel of the view."""

    pixel: tuple[int, int]
    kind: Literal["sphere", "box"]
    radius: float
    """Or half of the box's edges, in the clip's unit."""

    def region(self, center: Vector) -> Region:
        half = (self.radius,) * 3
        return Sphere(center, self.radius) if self.kind == "sphere" else Box(center, half)


@dataclass(frozen=True, eq=False)
class SelectRequest:
    """One wish to select; the next one like it is another request."""

    base: Scene
    """Without any edit."""
    view: ViewRequest
    """As it is seen, edited."""
    wish: Region | Around | None
    """None: only the limits are wanted."""
    how: Combination = "replace"


@dataclass(frozen=True, eq=False)
class Selected:
    """The Gaussians in the region."""

    mask: Mask | None
    """None: no surface is there, or nothing was wished for."""
    center: Vector | None
    """Of a sphere or a box."""
    limits: dict[Trait, Limits]
    """Lowest and highest value of each trait."""


@dataclass
class Selector:
    """Answers requests; keeps what the next one of the same view needs again."""

    _trail: Trail | None = None
    _sight: Sight | None = None
    _seen: tuple[object, ...] = ()

    def select(self, request: SelectRequest) -> Iterator[Selected]:
        sight = self._at(request)
        wish, center = request.wish, None
        if isinstance(wish, Around):
            center = surface(request.view, wish.pixel)
            wish = wish.region(center) if center is not None else None
        mask = found(wish, sight) if wish is not None else None
        yield Selected(mask, center, {trait: _limits(sight.trait(trait)) for trait in TRAITS})

    def _at(self, request: SelectRequest) -> Sight:
        base, view = request.base, request.view
        if self._trail is None or self._trail.model is not base.model:
            self._trail = Trail(base.model, tuple(np.linspace(0, 1, min(len(base.cameras), MOST_TIMES))))
        seen = (base, view.camera, view.time)
        if self._sight is None or self._seen != seen:
            self._sight = Sight.of(self._trail, view.camera, view.time, view.near)
            self._seen = seen
        return self._sight


def _limits(values: np.ndarray[Any, np.dtype[np.float32]]) -> Limits:
    finite = values[np.isfinite(values)]
    return (float(finite.min()), float(finite.max())) if len(finite) else (0.0, 0.0)


@dataclass
class Editing:
    """A part of the state: edit actions change it, drawing reads it."""

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
    waiting: list[Change] = field(default_factory=list)
    """Changes that were asked for after it."""
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
    return replace(edited, model=highlighted(edited.model, chosen))
