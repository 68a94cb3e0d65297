"""What lies over the 3D view: its centre, what is measured, the camera path, the scale of colours."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
from imgui_bundle import ImVec2, ImVec4, imgui

from app.gui.actions import path_actions
from app.gui.state.app_state import AppState
from app.gui.style import theme
from app.gui.style.labels import tag
from app.gui.style.widgets import Area, em
from app.gui.views.lines import frustum, seen
from app.gui.views.measurement import LEAST_CORNERS, Measurement
from app.gui.views.picture_view import PictureView, Placement
from app.scenes.free_camera import Vector
from app.scenes.view_kinds import Scale
from app.scenes.view_request import ViewRequest
from renderer.camera import Camera, FloatArray

SHARE = 0.12
"""Depth of a small camera, of the scene's distance."""
SEGMENTS = 32
"""Of the scale."""
NEAR_POINT = 0.6
"""Of a line's height, within which a click is on a point."""

NO_DISTANCE = "No distance: depth has no scale"


@dataclass(frozen=True)
class Sight:
    """A camera's picture in an area of the screen: as large as fits, in the middle."""

    camera: Camera
    area: Area

    @cached_property
    def place(self) -> Placement:
        return PictureView().place((self.camera.width, self.camera.height), self.area.inside)

    @property
    def bounds(self) -> tuple[ImVec2, ImVec2]:
        """Upper left and lower right end of the picture on the screen."""
        return self.at(0, 0), self.at(self.camera.width, self.camera.height)

    def at(self, x: float, y: float) -> ImVec2:
        """Where a position of the picture is on the screen."""
        return self.area.corner + self.place.pane_at(x, y)

    def point(self, point: Vector) -> ImVec2 | None:
        """Where a point of the world is seen; None behind the camera."""
        (pixel,), (depth,) = self.camera.project(np.array([point]))
        return self.at(*pixel) if depth > 0 else None

    def mouse(self) -> tuple[float, float]:
        """Position in the picture under the pointer; it may lie outside."""
        return self.place.picture_at(*self.area.mouse())

    def pixel(self) -> tuple[int, int]:
        """Column and row under the pointer."""
        x, y = self.mouse()
        return math.floor(x), math.floor(y)


def draw_marks(state: AppState, request: ViewRequest, area: Area) -> None:
    """Over a picture of the request: the path, what the view turns around, and what is measured."""
    sight, viewer = Sight(request.camera, area), state.scene.viewer
    _draw_path(state, request, sight)
    if viewer.pivot is not None and not viewer.flying and (at := sight.point(viewer.pivot)) is not None:
        for color, weight in ((theme.grey(0.0, 0.7), 0.18), (theme.grey(1.0, 0.9), 0.08)):
            ink = imgui.get_color_u32(color)
            imgui.get_window_draw_list().add_circle(at, em(0.32), ink, thickness=em(weight))
    measured = viewer.measurement
    shown = _points_seen(measured, request, sight)
    _draw_line(shown, measured.closed)
    if len(shown) > 1 and len(shown) == len(measured.points):
        text = NO_DISTANCE if request.scene.is_guessed else measured.text(request.scene.unit)
        if not request.scene.is_guessed and request.time != measured.time:
            text += f" at {request.scene.moment(measured.time)}"
        tag(text, _beside_line(shown, text, area), theme.TAG_CAUTION)


def _points_seen(measured: Measurement, request: ViewRequest, sight: Sight) -> list[ImVec2]:
    """Where points of the view's own model are on the screen; those behind the camera are not."""
    points = measured.points if measured.of == request.scene.identity else ()
    return [end for point in points if (end := sight.point(point)) is not None]


def is_on_first(state: AppState, request: ViewRequest, area: Area) -> bool:
    """Whether the pointer is where a line of the view began, which can be closed there."""
    measured, (x, y) = state.scene.viewer.measurement, area.mouse()
    seen = _points_seen(measured, request, Sight(request.camera, area))
    if measured.closed or request.time != measured.time or len(seen) < LEAST_CORNERS:
        return False
    first = seen[0] - area.corner
    return math.hypot(first.x - x, first.y - y) < em(NEAR_POINT)


def _draw_line(ends: list[ImVec2], closed: bool) -> None:
    """With its points, and a dark rim: tissue can be of their colour."""
    draw = imgui.get_window_draw_list()
    for color, rim in ((theme.grey(0.0, 0.7), 0.06), (theme.MARK, 0.0)):
        ink = imgui.get_color_u32(color)
        for first, second in pairwise([*ends, *ends[:1]] if closed else ends):
            draw.add_line(first, second, ink, em(0.1 + 2 * rim))
        for end in ends:
            draw.add_circle_filled(end, em(0.22 + rim), ink)


def _beside_line(ends: list[ImVec2], text: str, area: Area) -> ImVec2:
    """Where a label covers no point of a line: right of it, or left of it where the area ends."""
    by_side = sorted(ends, key=lambda end: end.x)
    left, right = by_side[0], by_side[-1]
    across = imgui.calc_text_size(text).x + em(0.9)
    if right.x + em(0.6) + across <= area.end.x:
        return right + ImVec2(em(0.6), -em(0.7))
    return ImVec2(max(left.x - em(0.6) - across, area.corner.x), left.y - em(0.7))


def _draw_path(state: AppState, request: ViewRequest, sight: Sight) -> None:
    """Its line, a small camera at each keyframe and where it is now, unless this is what it sees itself."""
    if not path_actions.sees_path(state):
        return
    path, depth = state.scene.cameras.views.path, SHARE * request.scene.distance
    track = path.track
    _draw_lines(np.stack([track[:-1], track[1:]], axis=1), theme.PATH, request, sight)
    for key in path.keyframes:
        _draw_lines(frustum(key.camera, depth), theme.PATH, request, sight)
    _draw_lines(frustum(path.at(state.scene.cameras.playhead).camera, depth), theme.MARK, request, sight)


def _draw_lines(segments: FloatArray, color: ImVec4, request: ViewRequest, sight: Sight) -> None:
    """With dark edges, since tissue is bright and its surround black."""
    draw, corner = imgui.get_window_draw_list(), sight.at(0, 0)
    ends = (sight.place.zoom * seen(request.camera, segments, request.near)).tolist()
    for ink, width in ((theme.grey(0.0, 0.6), em(0.2)), (color, em(0.1))):
        for first, last in ends:
            draw.add_line(corner + first, corner + last, imgui.get_color_u32(ink), width)


def draw_color_bar(scale: Scale, area: Area, texts: Mapping[float, str] | None = None) -> None:
    """The scale of the colours, in the upper right corner of the area; high values above.

    `texts`: what stands at which values, else its ticks.
    """
    texts = texts or {tick: scale.text(tick) for tick in scale.ticks}
    draw, across = imgui.get_window_draw_list(), em(0.9)
    wide = max(imgui.calc_text_size(text).x for text in texts.values()) + across + em(1.0)
    wide = max(wide, imgui.calc_text_size(scale.unit).x) + em(1.0)
    tall = min(area.size.y - em(1.0), em(15))
    if tall < em(6):
        return
    low, high = area.end.x - wide - em(0.5), ImVec2(area.end.x - em(0.5), area.corner.y + em(0.5) + tall)
    corner = ImVec2(low, area.corner.y + em(0.5))
    draw.add_rect_filled(corner, high, imgui.get_color_u32(theme.grey(0.0, 0.62)), em(0.25))
    ink = imgui.get_color_u32(theme.grey(0.92))
    draw.add_text(corner + ImVec2(em(0.5), em(0.3)), ink, scale.unit)
    left, right, first, last = low + em(0.5), low + em(0.5) + across, corner.y + em(1.9), high.y - em(0.8)
    table = scale.table
    for sides in pairwise(index / SEGMENTS for index in range(SEGMENTS + 1)):
        above, below = (theme.packed(*table[int((1 - side) * (len(table) - 1))].tolist()) for side in sides)
        top, bottom = (first + (last - first) * side for side in sides)
        draw.add_rect_filled_multi_color((left, top), (right, bottom), above, above, below, below)
    for tick, text in texts.items():
        y = last - (tick - scale.low) / (scale.high - scale.low) * (last - first)
        draw.add_line((right, y), (right + em(0.25), y), ink)
        draw.add_text((right + em(0.45), y - imgui.get_text_line_height() / 2), ink, text)
