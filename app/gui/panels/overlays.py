"""What lies over the window: the first-start notice, errors, toasts, the help; the log, and notes."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from itertools import groupby

from imgui_bundle import ImVec2, imgui, imgui_ctx

from app.files.legible import capital
from app.files.provenance import NOTICE
from app.gui.actions import actions, floating_windows, notes_actions, recovering
from app.gui.actions.floating_windows import Floating
from app.gui.commands.command import Section
from app.gui.commands.keys import FLIGHT_TEXT, LEAVE_TEXT, MOUSE, PANELS_TEXT, PEEK_TEXT, WALK_TEXT
from app.gui.commands.modes import MASKING_TEXT, PRESENTATION_TEXT, TILE_TEXT
from app.gui.state.app_state import AppState
from app.gui.style import theme
from app.gui.style.asking import close_question, question, take_enter
from app.gui.style.floating import floating
from app.gui.style.widgets import button, cell, em, explain, in_line, in_table, muted, note, within
from app.gui.style.writing import text_area
from app.gui.views.key_words import with_keys

LONG_NOTICE = f"{NOTICE} Not for diagnosis or treatment."
DETAILS = (
    "VesselSplat makes vessels easier to see. It does not detect, measure or assess them, and "
    "enhanced images may show structures that are not there. Screens and cameras are not "
    "calibrated. You are responsible for how you use it. VesselSplat sends nothing to other computers unless "
    "you have live images sent to one; the folder that you save in may be copied by a cloud service, such as "
    "OneDrive or iCloud."
)
BANNER = "##banner"
MIDDLE = ("Images", "Splat file", "Tuning", "Report")
"""Panels of which one is in front there."""
NARROW = 24.0
"""Text heights across that an error needs."""
OFFER = "An earlier session ended unexpectedly"
NOTES_HINT = "Write notes on this case here."
FIXED = (
    imgui.WindowFlags_.no_title_bar | imgui.WindowFlags_.no_resize | imgui.WindowFlags_.no_move
    | imgui.WindowFlags_.no_saved_settings | imgui.WindowFlags_.no_docking
    | imgui.WindowFlags_.always_auto_resize | imgui.WindowFlags_.no_focus_on_appearing
)  # fmt: skip


def draw_notice(state: AppState) -> None:
    """Once, before anything else; the same sentence stays in the status bar."""
    if state.settings.acknowledged:
        return
    with question("Before you begin", 30) as opened:
        if not opened:
            return
        imgui.spacing()
        note(LONG_NOTICE, theme.now().text)
        imgui.spacing()
        note(DETAILS)
        imgui.spacing()
        with imgui_ctx.push_style_color(imgui.Col_.button, theme.now().lit):
            understood = imgui.button("I understand", ImVec2(-1, em(2)))
        take_enter()
        if understood:
            actions.acknowledge(state)
            close_question()


def draw_banner(state: AppState) -> None:
    """An error, at the top, until it is dismissed; everything else stays usable."""
    if state.window.banner is None:
        return
    corner, across = _middle()
    imgui.set_next_window_pos(corner + ImVec2(across / 2, em(0.4)), imgui.Cond_.always, ImVec2(0.5, 0))
    width = min(em(56), across - em(2))
    imgui.set_next_window_size_constraints(ImVec2(min(em(20), width), 0), ImVec2(width, em(20)))
    with (
        imgui_ctx.push_style_color(imgui.Col_.window_bg, theme.now().alarm),
        imgui_ctx.push_style_color(imgui.Col_.border, theme.now().danger),
        imgui_ctx.begin(BANNER, None, FIXED),
    ):
        if not imgui.is_popup_open("", imgui.PopupFlags_.any_popup):
            # Also over a panel that floats there; a menu or a question stays above it.
            imgui.internal.bring_window_to_display_front(imgui.internal.get_current_window())
        message = capital(state.window.banner.message)
        can_stop, find = state.window.banner.can_stop, state.window.banner.find
        beside = em(7 if find is None and not can_stop else 12.5)
        wrap = min(imgui.calc_text_size(message).x + em(1), width - beside)
        with imgui_ctx.begin_group(), imgui_ctx.push_text_wrap_pos(imgui.get_cursor_pos_x() + wrap):
            imgui.align_text_to_frame_padding()
            imgui.text_unformatted(message)
        imgui.same_line(0, em(1))
        button("Dismiss", lambda: actions.dismiss(state))
        if can_stop:
            imgui.same_line()
            button("Stop waiting", lambda: actions.stop_opening(state))
        if find is not None:
            imgui.same_line()
            button("Find it…", find)


def _middle() -> tuple[ImVec2, float]:
    """Upper left corner and width of what lies beside the panels at the side, below its tabs."""
    for name in MIDDLE:
        found: imgui.internal.Window | None = imgui.internal.find_window_by_name(name)
        if found is not None and found.active and not found.hidden and found.size.x > em(NARROW):
            return found.inner_rect.min, found.size.x
    viewport = imgui.get_main_viewport()
    return viewport.work_pos, viewport.work_size.x


def covered(state: AppState, top: float) -> float:
    """Pixels from `top`, on the screen, down to the end of the error, as last shown."""
    banner: imgui.internal.Window | None = imgui.internal.find_window_by_name(BANNER)
    if state.window.banner is None or banner is None or banner.hidden:
        return 0.0
    return max(banner.pos.y + banner.size.y - top, 0.0)


@contextmanager
def floating_window(
    state: AppState, part: Floating, title: str, width: float, flags: int = 0
) -> Iterator[bool]:
    """A window `width` text heights across, below the error, which is in front; whether its content is to be
    drawn, as it is not while folded up. When a user closes it, `part` is no longer shown."""
    flags |= floating(title, width, covered(state, imgui.get_main_viewport().work_pos.y))
    with imgui_ctx.begin(title, True, flags) as window:
        floating_windows.show(part, bool(window.opened))
        yield bool(window.expanded)


def make_room(state: AppState) -> None:
    """At the top of a panel in the middle: the error hides none of its controls."""
    if height := covered(state, imgui.get_cursor_screen_pos().y):
        imgui.dummy(ImVec2(0, height))


def draw_toast(state: AppState) -> None:
    """Good news, beside the menus, where it hides nothing, for a few seconds."""
    if state.window.toast is None:
        return
    viewport, style = imgui.get_main_viewport(), imgui.get_style()
    corner = viewport.pos + ImVec2(viewport.size.x, 0)
    imgui.set_next_window_pos(corner, imgui.Cond_.always, ImVec2(1, 0))
    flags = FIXED | imgui.WindowFlags_.no_inputs
    with (
        imgui_ctx.push_style_color(imgui.Col_.window_bg, theme.now().shade(0.22, 0.97)),
        imgui_ctx.push_style_var(imgui.StyleVar_.window_padding, ImVec2(em(0.6), style.frame_padding.y)),
        imgui_ctx.push_style_var(imgui.StyleVar_.window_min_size, ImVec2(1, 1)),
        imgui_ctx.begin("##toast", None, flags),
    ):
        # Also over the dialog that it answers, which may reach as far up.
        imgui.internal.bring_window_to_display_front(imgui.internal.get_current_window())
        with imgui_ctx.push_text_wrap_pos(_beside_menus() - em(1.2)):
            imgui.text_unformatted(capital(state.window.toast.message))


def _beside_menus() -> float:
    """Pixels across, so far as it is room enough for a sentence."""
    menus: imgui.internal.Window | None = imgui.internal.find_window_by_name("##MainMenuBar")
    across = imgui.get_main_viewport().size.x
    taken = 0.0 if menus is None or not menus.active else menus.content_size.x
    return max(across - taken - em(1), min(em(NARROW), across))


def draw_help(state: AppState, sections: tuple[Section, ...]) -> None:
    """Every key and gesture; nothing is hidden elsewhere."""
    if not state.window.help_open:
        return
    viewport = imgui.get_main_viewport()
    imgui.set_next_window_pos(viewport.get_center(), imgui.Cond_.appearing, ImVec2(0.5, 0.5))
    height = min(em(48), 0.86 * viewport.work_size.y)
    imgui.set_next_window_size(ImVec2(within(36, 48).x, height), imgui.Cond_.appearing)
    flags = imgui.WindowFlags_.no_collapse | imgui.WindowFlags_.no_docking
    with imgui_ctx.begin("Keys and mouse", True, flags) as window:
        actions.show_help(state, bool(window.opened))
        if not window.expanded:
            return
        for menu, grouped in groupby(sections, lambda section: section.menu):
            commands = [command for section in grouped for command in section.commands if command.keys]
            if commands:
                _draw_keys(menu, [(" or ".join(one.keys), one.about) for one in commands])
        _draw_keys("Everywhere", [("Esc", LEAVE_TEXT), ("Shift+Tab", WALK_TEXT), ("F6", PANELS_TEXT)])
        _draw_keys("In a presentation", [*PRESENTATION_TEXT])
        _draw_keys("Masking tools by hand", [*MASKING_TEXT])
        _draw_keys("In the tuning grid, at one image", [*TILE_TEXT])
        _draw_keys("Hold", [("O", PEEK_TEXT), ("W S A D Q E", FLIGHT_TEXT), *MOUSE])
        imgui.spacing()
        note(LONG_NOTICE)


def _draw_keys(title: str, rows: list[tuple[str, str]]) -> None:
    imgui.separator_text(title)
    for keys, text in in_table(title, (11.0, None), rows, imgui.TableFlags_.row_bg):
        cell(with_keys(keys), theme.now().accent)
        imgui.table_next_column()
        imgui.text_wrapped(with_keys(f"{text[:1].upper()}{text[1:]}"))


def draw_log(state: AppState, copy: Callable[[str], None]) -> None:
    """What happened in this session, newest last; the newest stays in sight unless one scrolls back."""
    text = "Copy all lines to the clipboard. Click a line to copy it alone."
    button("Copy all", lambda: copy("\n".join(state.window.log)), text, enabled=bool(state.window.log))
    with imgui_ctx.begin_child("lines"):
        if not state.window.log:
            muted("No messages yet.")
        with imgui_ctx.push_text_wrap_pos(0):
            for line in state.window.log:
                imgui.text_unformatted(capital(line))
                if imgui.is_item_clicked():
                    copy(line)
        if imgui.get_scroll_y() >= imgui.get_scroll_max_y():
            imgui.set_scroll_here_y(1.0)


def draw_notes(state: AppState) -> None:
    """What a person writes down; kept with the session."""
    space = imgui.get_content_region_avail()
    size = ImVec2(-1, max(space.y, em(3)))
    if state.session.begins_writing:
        imgui.set_keyboard_focus_here()
    changed, text = text_area("##notes", NOTES_HINT, state.session.notes, size)
    if imgui.is_item_active():
        notes_actions.begin_writing(state, False)
    explain(
        "Saved with the session (Ctrl+S) and recovered after a crash. Not included in exports: the case "
        "summary can add them."
    )
    if changed:
        notes_actions.write_notes(state, text)


def draw_recovery(state: AppState) -> None:
    """Once at the start, after the notice."""
    if state.session.recoverable is None or not state.settings.acknowledged:
        return
    with question(OFFER, 27) as opened:
        if not opened:
            return
        imgui.spacing()
        if state.session.recoverable_since:
            imgui.text_unformatted(f"It was last saved {state.session.recoverable_since}.")
        imgui.text_unformatted("Restore the open files, settings, views and notes?")
        imgui.spacing()
        ways = (("Restore", recovering.recover), ("Start fresh", recovering.decline))
        for (label, act), width in in_line(ways):
            if imgui.button(label, ImVec2(em(width), em(2))):
                act(state)
                close_question()
            if label == "Restore":
                take_enter()
