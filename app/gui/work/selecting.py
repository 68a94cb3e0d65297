"""Points on the surface of the shown model, and Gaussians of it selected, off the window's thread."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from app.gui.views.measurement import Located
from app.runs.progress_log import told
from app.runs.run_folder import RunFolder
from app.scenes.cpu_rendering import draw_on_cpu
from app.scenes.free_camera import Vector, vector
from app.scenes.scene import Scene
from app.scenes.view_request import ViewRequest
from renderer.editing.edits import Combination
from renderer.editing.mask import Mask
from renderer.editing.regions import Box, Region, Sphere, found
from renderer.editing.sight import Sight, Trail, Trait

if TYPE_CHECKING:
    from renderer.picking import SurfacePoint

Purpose = Literal["orbit", "measure", "measure on"]
TRAITS: tuple[Trait, ...] = ("opacity", "size", "depth", "motion")
Limits = tuple[float, float]
MOST_TIMES = 32
"""Moments at which the motion over a clip is looked at."""
TIMES_OF_WINDOW = 12
"""The same, over each window of a long clip."""


@dataclass(frozen=True, eq=False)
class PickRequest:
    """One wish for the point behind a pixel; a second wish for the same pixel is another request."""

    view: ViewRequest
    pixel: tuple[int, int]
    """Column and row of the view's picture."""
    purpose: Purpose


def pick(request: PickRequest) -> Iterator[Located | None]:
    """Answers a PickRequest; with None where nothing solid is there.

    A depth errs by the spread of what is blended there, and as the run's depths do on frames that training
    did not see.
    """
    found = surface(request.view, request.pixel)
    if found is None:
        yield None
        return
    # The log of the run is read for a distance alone, not for a centre to turn around.
    of_run = _depth_error(request.view.scene) if request.purpose != "orbit" else 0.0
    error = math.hypot(found.spread, of_run)
    yield Located(vector(found.point), vector(found.ray), error)


def _depth_error(scene: Scene) -> float:
    """Of the run, in scene units, as last evaluated; 0 where that was not measured."""
    evaluated = told(RunFolder(scene.path)).evaluated if scene.is_of_run and scene.path is not None else ()
    return next((one.depth_rmse for one in reversed(evaluated) if one.depth_rmse is not None), 0.0)


def surface(view: ViewRequest, pixel: tuple[int, int]) -> SurfacePoint | None:
    """Where the expected depth of the view says that the surface is; None where nothing solid is."""
    # Its kernels take seconds to import on a first start; the window must not wait for them.
    from renderer.picking import SurfacePoint, surface_point

    found = surface_point(view.splats, view.camera, pixel, view.near, mode=view.scene.mode)
    if view.kind != "surface":
        return found
    # What is seen there is the mesh; how well its depth is known, the Gaussians tell.
    depth = float(view.drawn(draw_on_cpu).depth[pixel[1], pixel[0]]) if _is_inside(view, pixel) else 0.0
    spread = found.spread if found is not None else 0.0
    return SurfacePoint.at(view.camera, pixel, depth, spread) if depth > 0 else None


def _is_inside(view: ViewRequest, pixel: tuple[int, int]) -> bool:
    return 0 <= pixel[0] < view.camera.width and 0 <= pixel[1] < view.camera.height


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
            seen = surface(request.view, wish.pixel)
            center = vector(seen.point) if seen is not None else None
            wish = wish.region(center) if center is not None else None
        mask = found(wish, sight) if wish is not None else None
        yield Selected(mask, center, {trait: _limits(sight.trait(trait)) for trait in TRAITS})

    def _at(self, request: SelectRequest) -> Sight:
        base, view = request.base, request.view
        if self._trail is None or self._trail.model is not base.model:
            most = TIMES_OF_WINDOW if base.split_by_time else MOST_TIMES
            self._trail = Trail(base.model, tuple(np.linspace(0, 1, min(len(base.cameras), most))))
        seen = (base, view.camera, view.time)
        if self._sight is None or self._seen != seen:
            self._sight = Sight.of(self._trail, view.camera, view.time, view.near)
            self._seen = seen
        return self._sight


def _limits(values: np.ndarray[Any, np.dtype[np.float32]]) -> Limits:
    finite = values[np.isfinite(values)]
    return (float(finite.min()), float(finite.max())) if len(finite) else (0.0, 0.0)
