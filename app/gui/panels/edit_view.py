"""Editing with the mouse in the 3D view: what is drawn around, and what says so."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations, product

from imgui_bundle import ImVec2, ImVec2Like, imgui, imgui_ctx

from app.files.legible import grouped
from app.gui.actions import edit_actions
from app.gui.panels.scene_marks import Sight
from app.gui.state.app_state import AppState
from app.gui.style import theme
from app.gui.style.widgets import Area, em, tag
from app.scenes.free_camera import Vector
from renderer.editing.edits import Combination

LINE = theme.MARK


def draw_edit_tools(state: AppState) -> None:
    """Over the item before, which is the 3D view."""
    request = state.plain_view_request
    low, high = imgui.get_item_rect_min(), imgui.get_item_rect_max()
    if text := said(state):
        tag(text, ImVec2(low.x + em(0.4), high.y - em(1.9)), theme.TAG_CAUTION)
    if not state.editing.active or request is None:
        return
    sight = Sight(request.camera, Area(low, high - low))
    _follow_mouse(state, sight)
    with imgui_ctx.push_clip_rect(low, high, True):
        _draw_stroke(state, sight)
        _draw_solid(state, sight)


def said(state: AppState) -> str:
    """That this is not the model as it was trained, and how much is selected; empty where neither is so."""
    editing = state.editing
    seen, chosen = len(editing.edits.visible), len(editing.edits.selected)
    selected = f"EDIT MODE · {grouped(chosen)} of {grouped(seen)} selected" if editing.active else ""
    left_out = f"EDITED · {grouped(editing.edits.count - seen)} removed" if not editing.edits.is_empty else ""
    unsaved = "UNSAVED" if editing.is_unsaved else ""
    return " · ".join(part for part in (selected, left_out, unsaved) if part)


def combination(chosen: Combination) -> Combination:
    """With Shift added, with Ctrl taken away, with both what is in both; else as chosen."""
    io = imgui.get_io()
    if io.key_shift and io.key_ctrl:
        return "intersect"
    if io.key_shift or io.key_ctrl:
        return "add" if io.key_shift else "subtract"
    return chosen


def _follow_mouse(state: AppState, sight: Sight) -> None:
    if imgui.is_item_active() and imgui.is_mouse_down(imgui.MouseButton_.left):
        if state.editing.takes_drags and not imgui.get_io().key_alt:
            edit_actions.draw_on(state, sight.mouse())
    elif state.editing.stroke:
        edit_actions.end_stroke(state, combination(state.editing.how))


def _draw_stroke(state: AppState, sight: Sight) -> None:
    points: list[ImVec2Like] = [sight.at(x, y) for x, y in state.editing.stroke]
    draw, line = imgui.get_window_draw_list(), imgui.get_color_u32(LINE)
    if state.editing.tool == "rectangle" and len(points) == 2:
        draw.add_rect_filled(*_ends(points), imgui.get_color_u32(theme.grey(1.0, 0.08)))
        draw.add_rect(*_ends(points), line, thickness=em(0.1))
    elif state.editing.tool == "lasso" and len(points) > 1:
        draw.add_polyline(points, line, thickness=em(0.1), flags=imgui.ImDrawFlags_.closed)


def _ends(points: Sequence[ImVec2Like]) -> tuple[ImVec2, ImVec2]:
    one, other = (ImVec2(*point) for point in points)
    low = ImVec2(min(one.x, other.x), min(one.y, other.y))
    return low, ImVec2(max(one.x, other.x), max(one.y, other.y))


def _draw_solid(state: AppState, sight: Sight) -> None:
    """The outline of the last sphere or box, where it is in space."""
    editing = state.editing
    if editing.center is None or editing.base is None or editing.tool not in ("sphere", "box"):
        return
    radius = editing.radius * editing.base.distance
    draw, line, at = imgui.get_window_draw_list(), imgui.get_color_u32(LINE), sight.point(editing.center)
    if at is None:
        return
    if editing.tool == "sphere":
        pose = sight.camera.camera_from_world
        depth = float(pose[2, :3] @ editing.center + pose[2, 3])
        draw.add_circle(at, sight.place.zoom * sight.camera.fx * radius / depth, line, thickness=em(0.1))
        return
    for one, other in EDGES:
        start, end = (sight.point(_moved(editing.center, radius, signs)) for signs in (one, other))
        if start is not None and end is not None:
            draw.add_line(start, end, line, em(0.1))


EDGES = tuple(
    (one, other)
    for one, other in combinations(product((-1, 1), repeat=3), 2)
    if sum(a != b for a, b in zip(one, other, strict=True)) == 1
)
"""Of a box, between its corners."""


def _moved(center: Vector, radius: float, signs: tuple[int, ...]) -> Vector:
    x, y, z = (value + radius * sign for value, sign in zip(center, signs, strict=True))
    return x, y, z
