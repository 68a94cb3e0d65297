"""The question for another name."""

from __future__ import annotations

from collections.abc import Callable

from imgui_bundle import imgui

from app.gui.style.asking import close_question, question
from app.gui.style.widgets import button, in_line, muted, shortened


def ask_name(
    title: str,
    label: str,
    name: str,
    type_name: Callable[[str], None],
    why_not: Callable[[], str],
    becomes: str,
) -> bool | None:
    """Whether what stands in the field is agreed to; None as long as nothing is decided.

    `type_name` takes what is typed; `why_not` says why it cannot be the name, empty when it can.
    """
    with question(title, 27) as opened:
        if not opened:
            return None
        imgui.text_unformatted(label)
        if imgui.is_window_appearing():
            imgui.set_keyboard_focus_here()
        imgui.set_next_item_width(-1)
        entered, typed = imgui.input_text("##name", name, imgui.InputTextFlags_.enter_returns_true)
        type_name(typed)
        reason = why_not()
        # A line either way: the buttons stay where they are.
        muted(shortened(becomes, imgui.get_content_region_avail().x) or " ")
        agreed, given_up = entered and not reason, imgui.is_key_pressed(imgui.Key.escape)
        for reply, width in in_line(("Rename", "Cancel")):
            if button(reply, width=width, reason=reason if reply == "Rename" else ""):
                agreed, given_up = reply == "Rename", reply == "Cancel"
        if not (agreed or given_up):
            return None
        close_question()
        return agreed
