"""Editing of the reconstruction: tools, ranges, what to do with the selection."""

from __future__ import annotations

from typing import get_args

from imgui_bundle import ImVec2, imgui, imgui_ctx

from app.files.legible import grouped
from app.gui.actions import edit_actions
from app.gui.state.app_state import AppState
from app.gui.state.editing import TOOLS, Editing, Tool
from app.gui.style import theme
from app.gui.style.widgets import button, em, explain, question, row
from app.gui.work.selecting import TRAITS, Limits
from renderer.editing.edits import Combination
from renderer.editing.sight import Trait

PANEL = "Edit"
HOWS: tuple[Combination, ...] = get_args(Combination)
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
    "motion": ("Motion", "Largest distance from its position at the start of the clip, in the clip's unit."),
}
HOW_TEXT = (
    "What a tool does to the selection. Shift adds, Ctrl subtracts, Shift+Ctrl intersects, "
    "whatever is set here."
)


def draw_editing(state: AppState) -> None:
    """Everything that has a key has a button here."""
    editing = state.editing
    if editing.base is None:
        imgui.text_colored(theme.now().muted, "No finished reconstruction to edit.")
        return
    _draw_tools(state, editing)
    _draw_counts(editing)
    _draw_changes(state, editing)
    imgui.separator_text("Select by range")
    for trait in TRAITS:
        _draw_range(state, editing, trait)


def _draw_tools(state: AppState, editing: Editing) -> None:
    width = _share(len(TOOLS), 0.25)
    for place, tool in enumerate(TOOLS):
        if place:
            imgui.same_line(0, em(0.25))
        chosen = tool == editing.tool
        with imgui_ctx.push_style_color(imgui.Col_.button, theme.switch(chosen)):
            label = {"rectangle": "Rect"}.get(tool, tool.capitalize())
            button(f"{label}###tool {tool}", lambda t=tool: edit_actions.choose_tool(state, t), width=width)  # type: ignore[misc]
        explain(TOOL_TEXTS[tool])
    row("Result", HOW_TEXT)
    imgui.set_next_item_width(-em(0.1))
    _, index = imgui.combo("##how", HOWS.index(editing.how), [how.capitalize() for how in HOWS])
    explain(HOW_TEXT)
    edit_actions.choose_how(state, HOWS[index])
    if editing.tool in ("sphere", "box"):
        _draw_radius(state, editing)


def _draw_radius(state: AppState, editing: Editing) -> None:
    text = "Radius of the sphere, or half the edge of the box, in the clip's unit. Release to select again."
    distance = editing.base.distance if editing.base else 1.0
    row("Radius", text)
    imgui.set_next_item_width(-em(0.1))
    flags = imgui.SliderFlags_.logarithmic | imgui.SliderFlags_.always_clamp
    shown = editing.radius * distance
    changed, radius = imgui.slider_float("##radius", shown, 1e-3 * distance, distance, "%.3g", flags)
    explain(text)
    if changed:
        edit_actions.choose_radius(state, radius / distance)
    if imgui.is_item_deactivated_after_edit():
        edit_actions.select_again(state)


def _draw_counts(editing: Editing) -> None:
    edits = editing.edits
    chosen, seen = len(edits.selected), len(edits.visible)
    imgui.text_colored(
        theme.now().warning if chosen else theme.now().text, f"{grouped(chosen)} of {grouped(seen)} selected"
    )
    gone = f"{grouped(len(edits.deleted))} deleted, {grouped(len(edits.hidden - edits.deleted))} hidden"
    imgui.same_line(em(11))
    imgui.text_colored(theme.now().muted, gone)


def _draw_changes(state: AppState, editing: Editing) -> None:
    some, history = len(editing.edits.selected) > 0, editing.history
    hidden = len(editing.edits.hidden) > 0
    rows = (
        (
            ("All", edit_actions.select_all, True, "Ctrl+A: select everything visible."),
            ("None", edit_actions.select_none, some, "Ctrl+D: clear the selection."),
            ("Invert", edit_actions.invert, True, "Ctrl+Shift+I: invert the selection."),
        ),
        (
            ("Delete", edit_actions.delete, some, "Del: delete the selected Gaussians, at all times."),
            ("Crop", edit_actions.crop, some, "Shift+Del: delete everything visible that is not selected."),
            (
                "Hide",
                edit_actions.hide,
                some,
                "H: hide the selection; it is neither rendered, exported nor edited until shown again.",
            ),
            ("Show", edit_actions.show_hidden, hidden, "Shift+H: show everything hidden."),
        ),
        (
            (
                "Undo",
                edit_actions.undo,
                bool(history.past),
                "Ctrl+Z in edit mode: undo an edit or selection.",
            ),
            (
                "Redo",
                edit_actions.redo,
                bool(history.future),
                "Ctrl+Y in edit mode: redo an edit or selection.",
            ),
            (
                "Save",
                edit_actions.save,
                editing.is_unsaved,
                f"Ctrl+Shift+S: save the edits {_kept(editing)}.",
            ),
            ("Done", edit_actions.toggle, True, "Ctrl+E: leave edit mode. Edits stay, saved or not."),
        ),
    )
    for line in rows:
        width = _share(len(line), 0.25)
        for place, (label, act, enabled, text) in enumerate(line):
            if place:
                imgui.same_line(0, em(0.25))
            button(f"{label}###edit {label}", lambda act=act: act(state), enabled=enabled, width=width)  # type: ignore[misc]
            explain(text)


def _draw_range(state: AppState, editing: Editing, trait: Trait) -> None:
    label, text = TRAIT_TEXTS[trait]
    whole: Limits = (0.0, 1.0) if trait == "opacity" else editing.limits.get(trait, (0.0, 0.0))
    low, high = editing.ranges.get(trait, whole)
    row(label, text)
    imgui.set_next_item_width(-em(0.1))
    enabled = whole[1] > whole[0]
    imgui.begin_disabled(not enabled)
    speed = max(whole[1] - whole[0], 1e-6) / 400
    unit = editing.base.unit if editing.base is not None and trait != "opacity" else ""
    form, flags = f"%.3g {unit}".rstrip(), imgui.SliderFlags_.always_clamp
    changed, low, high = imgui.drag_float_range2(
        f"##{trait}", low, high, speed, whole[0], whole[1], f"from {form}", f"to {form}", flags
    )
    ended = imgui.is_item_deactivated_after_edit()
    imgui.end_disabled()
    explain(f"{text} Drag either end, or double click to type; release to select." if enabled else text)
    if changed:
        edit_actions.move_range(state, trait, (low, high))
    if ended:
        edit_actions.select_range(state, trait, (low, high))


def _kept(editing: Editing) -> str:
    return "beside the run; the trained model is not changed" if editing.is_of_run else "as a new PLY file"


def _share(parts: int, gap: float) -> float:
    """Width in em of one of so many equal controls in what is left of the line."""
    return (imgui.get_content_region_avail().x / em() - gap * (parts - 1)) / parts


def draw_question(state: AppState) -> None:
    """Before unsaved edits are lost."""
    if state.editing.leaving is None:
        return
    with question("Unsaved edits", 27) as opened:
        if not opened:
            return
        edits = state.editing.edits
        with imgui_ctx.push_text_wrap_pos(0):
            left_out = grouped(edits.count - len(edits.visible))
            imgui.text_unformatted(
                f"{left_out} of {grouped(edits.count)} Gaussians are removed, and this is not saved."
            )
        imgui.spacing()
        width, reply = _share(3, 0.5), ""
        for place, (label, said) in enumerate((("Save", "save"), ("Discard", "discard"), ("Stay", "stay"))):
            if place:
                imgui.same_line(0, em(0.5))
            if imgui.button(label, ImVec2(width * em(), em(2))):
                reply = said
        if reply or imgui.is_key_pressed(imgui.Key.escape):
            imgui.close_current_popup()
            edit_actions.answer(state, reply or "stay")
