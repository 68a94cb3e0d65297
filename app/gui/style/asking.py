"""Questions that everything waits for."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager

from imgui_bundle import ImVec2, imgui, imgui_ctx

from app.gui.style import theme
from app.gui.style.widgets import em, in_line, note, within


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


def take_enter() -> None:
    """The button before is in focus as its question appears: Enter presses it."""
    imgui.set_item_default_focus()
    if imgui.is_window_appearing():
        imgui.set_nav_cursor_visible(True)


def close_question() -> None:
    """Else what lies below has a control in focus, which the next Space presses."""
    imgui.close_current_popup()
    imgui.set_nav_cursor_visible(False)
