"""The camera path in the 3D view: its line, a small camera at each keyframe, and where it is now."""

from __future__ import annotations

import numpy as np
from imgui_bundle import ImVec2, ImVec4, imgui

from app.gui.actions import path_actions
from app.gui.panels.scene_marks import placement
from app.gui.state.app_state import AppState
from app.gui.style import theme
from app.gui.style.widgets import em
from app.gui.views.lines import frustum, seen
from app.scenes.view_request import ViewRequest
from renderer.camera import FloatArray

SHARE = 0.12
"""Depth of a small camera, of the scene's distance."""


def draw_path_marks(state: AppState, request: ViewRequest, corner: ImVec2, size: ImVec2) -> None:
    """Over a picture of the request, unless it is what the path itself sees."""
    if not path_actions.sees_path(state):
        return
    path, depth = state.scene.cameras.views.path, SHARE * request.scene.distance
    track = path.track
    _draw(np.stack([track[:-1], track[1:]], axis=1), theme.PATH, request, corner, size)
    for key in path.keyframes:
        _draw(frustum(key.camera, depth), theme.PATH, request, corner, size)
    _draw(frustum(path.at(state.scene.cameras.playhead).camera, depth), theme.MARK, request, corner, size)


def _draw(segments: FloatArray, color: ImVec4, request: ViewRequest, corner: ImVec2, size: ImVec2) -> None:
    """With dark edges, since tissue is bright and its surround black."""
    place, draw = placement(request.camera, size), imgui.get_window_draw_list()
    offset = np.array([corner.x + place.offset_x, corner.y + place.offset_y])
    ends = (offset + place.zoom * seen(request.camera, segments, request.near)).tolist()
    for ink, width in ((theme.grey(0.0, 0.6), em(0.2)), (color, em(0.1))):
        for first, last in ends:
            draw.add_line(ImVec2(*first), ImVec2(*last), imgui.get_color_u32(ink), width)
