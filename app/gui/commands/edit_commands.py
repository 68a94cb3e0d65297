"""The commands of edit mode."""

from __future__ import annotations

from functools import partial

from app.gui.actions import actions, edit_actions
from app.gui.commands.command import Command, Needs, Section, has_model, menu
from app.gui.state.app_state import AppState
from app.gui.state.editing import Tool

TOOL_KEYS: dict[Tool, str] = {
    "look": "Shift+V", "rectangle": "Shift+R", "lasso": "Shift+L", "sphere": "Shift+S", "box": "Shift+K"
}  # fmt: skip


def edit_sections() -> tuple[Section, ...]:
    """All but the first need edit mode."""
    mode = (
        Command("Edit mode", edit_actions.toggle, ("Ctrl+E",), "edit the reconstruction, or stop editing",
                applies=has_model, refuse=_refuse, ticked=_active,
                synonyms=("clean", "remove", "gaussians", "floaters", "crop")),
    )  # fmt: skip
    select = (
        Command("Select all", edit_actions.select_all, ("Ctrl+A",), applies=_active),
        Command("Select none", edit_actions.select_none, ("Ctrl+D",), applies=_some),
        Command("Invert selection", edit_actions.invert, ("Ctrl+Shift+I",), applies=_active),
    )
    change = (
        Command("Delete", edit_actions.delete, ("Del",), "delete the selected Gaussians", _some,
                synonyms=("remove", "erase")),
        Command("Crop to selection", edit_actions.crop, ("Shift+Del",), "delete all other visible Gaussians",
                _some),
        Command("Hide", edit_actions.hide, ("H",), "hide the selected Gaussians", _some),
        Command("Show hidden", edit_actions.show_hidden, ("Shift+H",), applies=_active),
    )  # fmt: skip
    keep = (
        Command("Undo edit", edit_actions.undo, ("Ctrl+Z",), applies=_can_undo, repeats=True),
        Command("Redo edit", edit_actions.redo, ("Ctrl+Y",), applies=_can_redo, repeats=True),
        Command("Save edits", edit_actions.save, ("Ctrl+Shift+K",), applies=lambda s: s.editing.is_unsaved),
    )
    tools = Section("Edit", tuple(map(_tool, TOOL_KEYS)), "Tool")
    return Section("Edit", mode), tools, *menu("Edit", select, change, keep)


def _tool(tool: Tool) -> Command:
    choose = partial(edit_actions.choose_tool, tool=tool)
    return Command(tool.capitalize(), choose, (TOOL_KEYS[tool],), f"edit: {tool}", _active,
                   lambda s: s.editing.tool == tool)  # fmt: skip


def _refuse(state: AppState) -> None:
    actions.announce(state, edit_actions.why_not_edit(state))


def _none_selected(state: AppState) -> str:
    return _active.why_not(state) or ("" if len(state.editing.edits.selected) else "Select Gaussians first.")


_active = Needs(lambda state: "" if state.editing.active else "Turn on edit mode first (Ctrl+E).")
_some = Needs(_none_selected)


def _can_undo(state: AppState) -> bool:
    return state.editing.active and bool(state.editing.history.past)


def _can_redo(state: AppState) -> bool:
    return state.editing.active and bool(state.editing.history.future)
