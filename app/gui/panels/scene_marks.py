"""Where things of the scene are on screen, and the marks that lie over the 3D view: centre and distance."""

from __future__ import annotations

import math

import numpy as np
from imgui_bundle import ImVec2, imgui

from app.gui.state.scene import Viewer
from app.gui.style import theme
from app.gui.style.widgets import em, tag
from app.gui.views.picture_view import PictureView, Placement
from app.scenes.free_camera import Vector
from app.scenes.view_request import ViewRequest
from renderer.camera import Camera


def placement(camera: Camera, size: ImVec2) -> Placement:
    """Where a camera's picture lies in the view: as large as fits, in the middle."""
    return PictureView().place((camera.width, camera.height), (size.x, size.y))


def pixel_at(camera: Camera, corner: ImVec2, size: ImVec2) -> tuple[int, int]:
    """Column and row of the picture under the pointer; it may lie outside the picture."""
    mouse = imgui.get_mouse_pos()
    x, y = placement(camera, size).picture_at(mouse.x - corner.x, mouse.y - corner.y)
    return math.floor(x), math.floor(y)


def on_screen(camera: Camera, point: Vector, corner: ImVec2, size: ImVec2) -> ImVec2 | None:
    """Where a point of the world is seen; None behind the camera."""
    (pixel,), (depth,) = camera.project(np.array([point]))
    if depth <= 0:
        return None
    place = placement(camera, size)
    return ImVec2(
        corner.x + place.offset_x + place.zoom * pixel[0], corner.y + place.offset_y + place.zoom * pixel[1]
    )


def bounds(camera: Camera, corner: ImVec2, size: ImVec2) -> tuple[ImVec2, ImVec2]:
    """Upper left and lower right end of a camera's picture on screen."""
    place = placement(camera, size)
    low = ImVec2(corner.x + place.offset_x, corner.y + place.offset_y)
    return low, ImVec2(low.x + place.zoom * camera.width, low.y + place.zoom * camera.height)


def draw_marks(viewer: Viewer, request: ViewRequest, corner: ImVec2, size: ImVec2) -> None:
    """Over a picture of the request: what the view turns around, and the measured distance."""
    if viewer.pivot is not None and not viewer.flying:
        at = on_screen(request.camera, viewer.pivot, corner, size)
        if at is not None:
            _draw_ring(at)
    measured = viewer.measurement
    points = measured.points if measured.of == request.scene.name else ()
    ends = [on_screen(request.camera, point, corner, size) for point in points]
    shown = [end for end in ends if end is not None]
    draw, ink = imgui.get_window_draw_list(), imgui.get_color_u32(theme.MARK)
    if len(shown) == 2:
        first, last = shown
        draw.add_line(first, last, imgui.get_color_u32(theme.grey(0.0, 0.7)), em(0.22))
        draw.add_line(first, last, ink, em(0.1))
    for end in shown:
        draw.add_circle_filled(end, em(0.22), ink)
    if len(shown) == 2:
        text = measured.text(request.scene.unit)
        if request.time != measured.time:
            text += f" at {request.scene.moment(measured.time)}"
        beside = ImVec2((shown[0].x + shown[1].x) / 2 + em(0.5), (shown[0].y + shown[1].y) / 2)
        tag(text, beside, theme.TAG_CAUTION)


def _draw_ring(at: ImVec2) -> None:
    draw, radius = imgui.get_window_draw_list(), em(0.32)
    draw.add_circle(at, radius, imgui.get_color_u32(theme.grey(0.0, 0.7)), thickness=em(0.18))
    draw.add_circle(at, radius, imgui.get_color_u32(theme.grey(1.0, 0.9)), thickness=em(0.08))
