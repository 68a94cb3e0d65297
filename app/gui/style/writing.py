"""Fields that a person writes several lines into."""

from __future__ import annotations

from imgui_bundle import ImVec2, imgui

LINES = imgui.internal.InputTextFlagsPrivate_.multiline


def text_area(name: str, hint: str, text: str, size: ImVec2) -> tuple[bool, str]:
    """Whether the text has changed, and the text; the hint shows while there is none.

    Escape ends typing; what was typed stays, where the plain field would take it back.
    """
    # The plain call has no hint.
    changed, typed = imgui.internal.input_text_ex(name, hint, text, size, LINES)
    if changed and imgui.is_key_pressed(imgui.Key.escape):
        return False, text
    return changed, typed
