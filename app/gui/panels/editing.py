"""Editing of the reconstruction: tools, ranges, what to do with the selection; the mouse in the 3D view."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from itertools import combinations, product
from typing import get_args

from imgui_bundle import ImVec2, ImVec2Like, imgui, imgui_ctx

from app.files.legible import grouped
from app.gui.actions import edit_actions
from app.gui.commands.command import Act
from app.gui.panels.scene_marks import Sight
from app.gui.state.app_state import AppState
from app.gui.state.editing import TOOLS, Editing, Tool
from app.gui.style import theme
from app.gui.style.asking import ask
from app.gui.style.handles import slide_labelled
from app.gui.style.labels import tag
from app.gui.style.widgets import Area, button, choose_row, em, explain, in_line, muted, row, toggle
from app.gui.work.selecting import TRAITS, Limits
from app.scenes.free_camera import Vector
from app.scenes.view_kinds import SCENE_UNITS
from renderer.editing.edits import Combination, Edits
from renderer.editing.sight import Trait

PANEL = "Edit"
HOWS: dict[Combination, str] = {how: how.capitalize() for how in get_args(Combination)}
TOOL_TEXTS: dict[Tool, str] = {
    "look": "Shift+V: dragging turns the view, as outside edit mode. Alt+drag turns it with any tool.",
    "rectangle": "Shift+R: drag a rectangle. Selects the Gaussians whose centres are inside, at any depth.",
    "lasso": "Shift+L: drag around the Gaussians to select, at any depth.",
    "sphere": "Shift+S: click on the surface. Selects everything within the radius.",
    "box": "Shift+K: click on the surface. Selects everything inside the box.",
}
TRAIT_TEXTS: dict[Trait, tuple[str, str]] = {
    "opacity": ("Opacity", "Opacity at this time, from 0 (transparent) to 1 (opaque)."),
    "size": ("Size", "Largest standard deviation at this time, in the clip's unit."),
    "depth": ("Depth", "Distance along this view's axis at this time, in the clip's unit."),
    "motion": ("Motion", "Largest distance from its position at the start, in the clip's unit."),
}
HOW_TEXT = (
    "What a tool does to the selection. Shift adds, Ctrl subtracts, Shift+Ctrl intersects, "
    "whatever is set here."
)
HIDE_TEXT = "H: hide the selection; it is neither rendered, exported nor edited until shown again."
WINDOW_TEXT = (
    "Select the Gaussians of the window that this frame lies in, by the rule set above: with Intersect, a "
    "selection is kept in this window alone. Without it, tools select in all windows."
)
UNDO_TEXT = "Ctrl+Z in edit mode: undo an edit or selection."
REDO_TEXT = "Ctrl+Y in edit mode: redo an edit or selection."


def draw_editing(state: AppState) -> None:
    """Everything that has a key has a button here."""
    editing = state.editing
    if editing.base is None:
        muted("No finished reconstruction to edit.")
        return
    _draw_tools(state, editing)
    _draw_counts(editing)
    _draw_changes(state, editing)
    imgui.separator_text("Select by range")
    for trait in TRAITS:
        _draw_range(state, editing, trait)


def _draw_tools(state: AppState, editing: Editing) -> None:
    for tool, width in in_line(TOOLS, 0.25):
        label = {"rectangle": "Rect"}.get(tool, tool.capitalize())
        choose = partial(edit_actions.choose_tool, state, tool)
        toggle(f"{label}###tool {tool}", choose, TOOL_TEXTS[tool], on=tool == editing.tool, width=width)
    edit_actions.choose_how(state, choose_row("Selection", editing.how, HOWS, HOW_TEXT))
    if editing.tool in ("sphere", "box"):
        _draw_radius(state, editing)


def _draw_radius(state: AppState, editing: Editing) -> None:
    text = "Radius of the sphere, or half the edge of the box, in the clip's unit. Release to select again."
    distance = editing.base.distance if editing.base else 1.0
    row("Radius", text)
    flags = imgui.SliderFlags_.logarithmic | imgui.SliderFlags_.always_clamp
    shown = editing.radius * distance
    changed, radius = slide_labelled("##radius", shown, 1e-3 * distance, distance, "%.3g", flags)
    explain(text)
    if changed:
        edit_actions.choose_radius(state, radius / distance)
    if imgui.is_item_deactivated_after_edit():
        edit_actions.select_again(state)


def of_windows(editing: Editing) -> bool:
    """The model has other Gaussians at other times."""
    return editing.base is not None and bool(editing.base.split_by_time)


def _draw_counts(editing: Editing) -> None:
    edits = editing.edits
    chosen, seen = len(edits.selected), len(edits.visible)
    color = theme.now().warning if chosen else theme.now().text
    imgui.text_colored(color, f"{grouped(chosen)} of {grouped(seen)} selected")
    imgui.same_line(em(11))
    muted(gone(edits))
    explain(gone(edits))


def gone(edits: Edits) -> str:
    """What is deleted and what is hidden, as far as anything is: the line is short."""
    counts = {"deleted": len(edits.deleted), "hidden": len(edits.hidden - edits.deleted)}
    return ", ".join(f"{grouped(count)} {word}" for word, count in counts.items() if count)


def _draw_changes(state: AppState, editing: Editing) -> None:
    some, hidden = len(editing.edits.selected) > 0, len(editing.edits.hidden) > 0
    history = editing.history
    kept = "beside the run; the trained model is not changed" if editing.is_of_run else "as a new PLY file"
    rows: tuple[tuple[tuple[str, Act, bool, str], ...], ...] = (
        (
            ("All", edit_actions.select_all, True, "Ctrl+A: select everything visible."),
            ("None", edit_actions.select_none, some, "Ctrl+D: clear the selection."),
            ("Invert", edit_actions.invert, True, "Ctrl+Shift+I: invert the selection."),
            *([("Window", edit_actions.select_present, True, WINDOW_TEXT)] if of_windows(editing) else []),
        ),
        (
            ("Delete", edit_actions.delete, some, "Del: delete the selected Gaussians, at all times."),
            ("Crop", edit_actions.crop, some, "Shift+Del: delete everything visible that is not selected."),
            ("Hide", edit_actions.hide, some, HIDE_TEXT),
            ("Show", edit_actions.show_hidden, hidden, "Shift+H: show everything hidden."),
        ),
        (
            ("Undo", edit_actions.undo, bool(history.past), UNDO_TEXT),
            ("Redo", edit_actions.redo, bool(history.future), REDO_TEXT),
            ("Save", edit_actions.save, editing.is_unsaved, f"Ctrl+Shift+K: save the edits {kept}."),
            ("Done", edit_actions.toggle, True, "Ctrl+E: leave edit mode. Edits stay, saved or not."),
        ),
    )
    for line in rows:
        for (label, act, enabled, text), width in in_line(line, 0.25):
            button(f"{label}###edit {label}", partial(act, state), text, enabled=enabled, width=width)


def _draw_range(state: AppState, editing: Editing, trait: Trait) -> None:
    label, text = TRAIT_TEXTS[trait]
    whole: Limits = (0.0, 1.0) if trait == "opacity" else editing.limits.get(trait, (0.0, 0.0))
    low, high = editing.ranges.get(trait, whole)
    row(label, text)
    enabled = whole[1] > whole[0]
    imgui.begin_disabled(not enabled)
    speed = max(whole[1] - whole[0], 1e-6) / 400
    unit = editing.base.unit if editing.base is not None and trait != "opacity" else ""
    unit = "" if unit == SCENE_UNITS else unit  # Too long for the field, and no length that anything has.
    form, flags = f"%.3g {unit}".rstrip(), imgui.SliderFlags_.always_clamp
    # The field is narrow: the unit is told once.
    ends = ("from %.3g", f"to {form}")
    changed, low, high = imgui.drag_float_range2(f"##{trait}", low, high, speed, *whole, *ends, flags)
    ended = imgui.is_item_deactivated_after_edit()
    imgui.end_disabled()
    explain(f"{text} Drag either end, or double click to type; release to select." if enabled else text)
    if changed:
        edit_actions.move_range(state, trait, (low, high))
    if ended:
        edit_actions.select_range(state, trait, (low, high))


def draw_edit_question(state: AppState) -> None:
    """Before unsaved edits are lost."""
    if state.editing.leaving is None:
        return
    edits = state.editing.edits
    left_out = grouped(edits.count - len(edits.visible))
    said = f"{left_out} of {grouped(edits.count)} Gaussians are removed, and this is not saved."
    if reply := ask("Unsaved edits", (said,), ("Save", "Discard", "Stay")):
        edit_actions.answer(state, reply.lower())


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
    held: dict[tuple[bool, bool], Combination] = {
        (True, True): "intersect", (True, False): "add", (False, True): "subtract"
    }  # fmt: skip
    return held.get((io.key_shift, io.key_ctrl), chosen)


def _follow_mouse(state: AppState, sight: Sight) -> None:
    if imgui.is_item_active() and imgui.is_mouse_down(imgui.MouseButton_.left):
        if state.editing.takes_drags and not imgui.get_io().key_alt:
            edit_actions.draw_on(state, sight.mouse())
    elif state.editing.stroke and not imgui.is_mouse_down(imgui.MouseButton_.left):
        # Escape takes the mouse from the view while the button is still held: it drops the stroke.
        edit_actions.end_stroke(state, combination(state.editing.how))


def _draw_stroke(state: AppState, sight: Sight) -> None:
    points: list[ImVec2Like] = [sight.at(x, y) for x, y in state.editing.stroke]
    draw, line = imgui.get_window_draw_list(), imgui.get_color_u32(theme.MARK)
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
    draw, line = imgui.get_window_draw_list(), imgui.get_color_u32(theme.MARK)
    if (at := sight.point(editing.center)) is None:
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
