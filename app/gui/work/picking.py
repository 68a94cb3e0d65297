"""Points on the surface of the reconstruction, asked for by a pixel of the 3D view."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

from app.scenes.free_camera import Vector, vector
from app.scenes.view_request import ViewRequest

Purpose = Literal["orbit", "measure"]


@dataclass(frozen=True, eq=False)
class PickRequest:
    """One wish for the point behind a pixel; a second wish for the same pixel is another request."""

    view: ViewRequest
    pixel: tuple[int, int]
    """Column and row of the view's picture."""
    purpose: Purpose


def pick(request: PickRequest) -> Iterator[Vector | None]:
    """Answers a PickRequest; with None where nothing solid is there."""
    yield surface(request.view, request.pixel)


def surface(view: ViewRequest, pixel: tuple[int, int]) -> Vector | None:
    """Where the expected depth of the view says that the surface is; None where nothing solid is."""
    # Its kernels take seconds to import on a first start; the window must not wait for them.
    from renderer.picking import surface_point

    splats = view.scene.model.at(view.time)
    point = surface_point(splats, view.camera, pixel, view.near, mode=view.scene.mode)
    return None if point is None else vector(point)
