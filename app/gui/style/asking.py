"""Questions that everything waits for."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager

from imgui_bundle import ImVec2, imgui, imgui_ctx

from app.gui.style import theme
from app.gui.style.widgets import button, em, in_line, muted, note, shortened, within


@contextmanager
def question(title: str, width: float) -> Iterator[bool]:
    """A window of `width` text heights in the middle, which everything waits for; whether it is drawn."""
    imgui.open_popup(title)
    imgui.set_next_window_pos(imgui.get_main_viewport().get_center(), imgui.Cond_.always, ImVec2(0.5, 0.5))
    imgui.set_next_window_size(ImVec2(within(width, 0).x, 0))
    flags = imgui.WindowFlags_.no_resize | imgui.WindowFlags_.no_move
    with imgui_ctx.begin_popup_modal(title, flags) as opened:
        yield bool(opened)


def ask(title: str, sentences: Iterable[str], replies: Sequence[str], *, moot: bool = False) -> str:
    """A question that everything waits for: the reply that is given in this frame, or nothing.

    Enter and Escape give the last reply, and so does a question that is `moot`.
    """
    reply = ""
    with question(title, 27) as opened:
        if not opened:
            return reply
        for sentence in sentences:
            note(sentence, theme.now().text)
        imgui.spacing()
        for label, width in in_line(replies):
            if imgui.button(label, ImVec2(em(width), em(2))):
                reply = label
            if label == replies[-1]:
                take_enter()
        if moot or imgui.is_key_pressed(imgui.Key.escape):
            reply = reply or replies[-1]
        if reply:
            close_question()
    return reply


def ask_name(
    title: str,
    label: str,
    name: str,
    type_name: Callable[[str], None],
    why_not: Callable[[], str],
    becomes: str,
) -> bool | None:
    """The question for another name: whether what stands in the field is agreed to; None as long as nothing
    is decided.

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


def take_enter() -> None:
    """The button before is in focus as its question appears: Enter presses it."""
    imgui.set_item_default_focus()
    if imgui.is_window_appearing():
        imgui.set_nav_cursor_visible(True)


def close_question() -> None:
    """Else what lies below has a control in focus, which the next Space presses."""
    imgui.close_current_popup()
    imgui.set_nav_cursor_visible(False)
