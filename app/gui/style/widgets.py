"""Controls, text and sizes that the panels share."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from typing import TypeVar

from imgui_bundle import ImVec2, ImVec4, imgui, imgui_ctx

from app.files.legible import legible
from app.gui.style import theme
from app.gui.views.key_words import with_keys

IN_SIGHT = 16
"""Lines of a list to choose from, before it scrolls."""
NAMES = 6.0
"""Text heights that the names of controls have, before the controls."""
EXPLANATION = 24.0
"""Text heights across that a tooltip has at most."""
LINE = 2.5
"""Text heights that no control of one line has."""
T = TypeVar("T")
FLAT = imgui.ChildFlags_.nav_flattened
"""Of a part of a panel that scrolls by itself: keys lead to its controls as to all others."""
EXPLAINED = imgui.HoveredFlags_.delay_normal | imgui.HoveredFlags_.allow_when_disabled

STATES = ((imgui.Col_.button, 0.0), (imgui.Col_.button_hovered, 0.15), (imgui.Col_.button_active, 0.25))
"""Of a button in a colour, which it keeps below the pointer: the share that it changes by."""


@dataclass(frozen=True)
class Area:
    """A rectangle of the screen, in the window system's units."""

    corner: ImVec2
    size: ImVec2

    @classmethod
    def here(cls, size: ImVec2) -> Area:
        """From where the next control begins."""
        return cls(imgui.get_cursor_screen_pos(), size)

    @property
    def end(self) -> ImVec2:
        return self.corner + self.size

    @property
    def inside(self) -> tuple[float, float]:
        """Width and height."""
        return self.size.x, self.size.y

    def mouse(self) -> tuple[float, float]:
        """Where the pointer is, from the corner on."""
        at = imgui.get_mouse_pos() - self.corner
        return at.x, at.y


def fill_around(area: Area, low: ImVec2, high: ImVec2, color: ImVec4) -> None:
    """The area without the rectangle from `low` to `high`, which a picture covers.

    Each pixel that is painted twice costs a software driver as much as one that is painted once.
    """
    draw, ink, corner, end = imgui.get_window_draw_list(), imgui.get_color_u32(color), area.corner, area.end
    for first, last in (
        (corner, ImVec2(end.x, low.y)),
        (ImVec2(corner.x, high.y), end),
        (ImVec2(corner.x, low.y), ImVec2(low.x, high.y)),
        (ImVec2(high.x, low.y), ImVec2(end.x, high.y)),
    ):
        if last.x > first.x and last.y > first.y:
            draw.add_rect_filled(first, last, ink)


def em(lines: float = 1.0) -> float:
    """Pixels of that many font heights: every size on screen follows the font."""
    return lines * imgui.get_font_size()


TALL = 2.5
"""Font heights of the buttons and the strip at the bottom of the window."""


def tall() -> ImVec2:
    """Padding of such buttons."""
    return ImVec2(imgui.get_style().frame_padding.x, (em(TALL) - em()) / 2)


def row(label: str, tooltip: str, width: float = -0.1) -> None:
    """The name of a control on a line of its own column; the control follows to its right, `width` em across,
    or up to so many before the right end."""
    start = imgui.get_cursor_pos_x()
    imgui.align_text_to_frame_padding()
    imgui.text(label)
    explain(tooltip)
    imgui.same_line(start + em(NAMES))
    imgui.set_next_item_width(em(width))


def choose(name: str, now: T, values: Mapping[T, str], text: str, width: float = -0.1) -> T:
    """The one that is chosen from a list of what `values` are called, which is `width` em across.

    It shows the first while `now` is none of them.
    """
    keys = [*values]
    imgui.set_next_item_width(em(width))
    place = keys.index(now) if now in values else 0
    changed, place = imgui.combo(f"##{name}", place, [*values.values()], IN_SIGHT)
    explain(text)
    return keys[place] if changed else now


def choose_row(label: str, now: T, values: Mapping[T, str], text: str, width: float = -0.1) -> T:
    """The same behind its name."""
    row(label, text)
    return choose(label, now, values, text, width)


def explain(text: str) -> None:
    """A tooltip on the item before, also when that is disabled; not while something is dragged.

    Below the item, so that it stays to be read; on what is tall beside the pointer.
    """
    if not _is_asked(text):
        return
    if imgui.get_item_rect_size().y < em(LINE):
        imgui.set_next_window_pos(_below(with_keys(legible(text))))
    _tooltip(text)


def explain_entry(text: str) -> None:
    """The same on an entry of a menu or list, or above a button that is pressed next: beside that, where it
    covers no other; on its left, or on its right where the screen ends."""
    if not _is_asked(text):
        return
    gap, left, top = em(0.25), imgui.get_window_pos().x, imgui.get_item_rect_min().y
    fits = left - gap - _size(with_keys(legible(text))).x >= imgui.get_main_viewport().pos.x
    beside = left - gap if fits else left + imgui.get_window_width() + gap
    imgui.set_next_window_pos(ImVec2(beside, top), imgui.Cond_.always, ImVec2(1 if fits else 0, 0))
    _tooltip(text)


def _is_asked(text: str) -> bool:
    """Nor while it is typed in, where a tooltip lies over what is below."""
    hovered = bool(text) and imgui.is_item_hovered(EXPLAINED) and not imgui.is_item_active()
    return hovered and not imgui.is_mouse_down(imgui.MouseButton_.left)


def _tooltip(text: str) -> None:
    with imgui_ctx.begin_tooltip(), imgui_ctx.push_text_wrap_pos(em(EXPLANATION)):
        imgui.text_unformatted(with_keys(legible(text)))


def _size(text: str) -> ImVec2:
    """Of a tooltip."""
    padding = imgui.get_style().window_padding
    return imgui.calc_text_size(text, wrap_width=em(EXPLANATION) - padding.x) + padding * 2


def _below(text: str) -> ImVec2:
    """Where a tooltip on the item before goes: below it, or above where the screen ends."""
    screen, size = imgui.get_main_viewport(), _size(text)
    low, high, gap = imgui.get_item_rect_min(), imgui.get_item_rect_max(), em(0.25)
    end = screen.pos + screen.size
    y = high.y + gap if high.y + gap + size.y <= end.y else low.y - gap - size.y
    return ImVec2(max(min(low.x, end.x - size.x), screen.pos.x), max(y, screen.pos.y))


def text_within(area: Area, text: str, color: ImVec4) -> None:
    """Text in the middle of an area."""
    at = area.corner + (area.size - imgui.calc_text_size(text)) / 2
    imgui.get_window_draw_list().add_text(at, imgui.get_color_u32(color), text)


def muted(text: str) -> None:
    """A line of quiet text."""
    imgui.text_colored(theme.now().muted, text)


def note(text: str, color: ImVec4 | None = None) -> None:
    """A line of text, or more where it is too long for one; quiet unless in a colour."""
    with imgui_ctx.push_text_wrap_pos(0):
        imgui.text_colored(color or theme.now().muted, text)


def shortened(text: str, room: float) -> str:
    """So that it fits in so many pixels: its middle gives way, as both ends of a name tell most."""
    return _cut(text, room, lambda kept: f"{text[: (kept + 1) // 2]}…{text[len(text) - kept // 2 :]}")


def end_of(path: str, room: float) -> str:
    """The same of a path, of which the end tells most."""
    return _cut(path, room, lambda kept: f"…{path[len(path) - kept :]}")


def _cut(text: str, room: float, short: Callable[[int], str]) -> str:
    """With as many letters kept as fit. All of this is done in each frame: half of them is tried first."""
    if imgui.calc_text_size(text).x <= room:
        return text
    wide = bisect_right(range(1, len(text)), room, key=lambda kept: imgui.calc_text_size(short(kept)).x)
    return short(wide)


def centered(text: str, color: ImVec4 | None = None) -> None:
    """A line of text in the middle of the window's width; more lines where it is too long for that."""
    text, color = legible(text), color or theme.now().muted
    space = imgui.get_content_region_avail().x - imgui.calc_text_size(text).x
    with imgui_ctx.push_text_wrap_pos(0):
        imgui.set_cursor_pos_x(imgui.get_cursor_pos_x() + max(space / 2, 0))
        imgui.text_colored(color, text)


def beside(label: str, gap: float = 0.5) -> None:
    """The next control, a button of this label, stands beside the one before; below it where room ends."""
    beside_of(width_of(label), gap)


def width_of(label: str) -> float:
    """Pixels of a button of this label."""
    return imgui.calc_text_size(label, True).x + 2 * imgui.get_style().frame_padding.x


def beside_of(width: float, gap: float = 0.5) -> None:
    """The same for a control of so many pixels; `gap` in em."""
    end = imgui.get_cursor_screen_pos().x + imgui.get_content_region_avail().x
    if imgui.get_item_rect_max().x + em(gap) + width <= end:
        imgui.same_line(0, em(gap))


def within(width: float, height: float) -> ImVec2:
    """So many em, but never larger than the window."""
    most = imgui.get_main_viewport().work_size
    return ImVec2(min(em(width), most.x - em(1)), min(em(height), most.y - em(1)))


def button(
    label: str,
    action: Callable[[], object] | None = None,
    text: str = "",
    *,
    enabled: bool = True,
    reason: str = "",
    color: ImVec4 | None = None,
    width: float = 0.0,
    small: bool = False,
) -> bool:
    """A button that does `action`, and whether it is pressed.

    `width` in em, 0 = as wide as its text, negative = to the right end. Greyed out unless `enabled`, and for
    a `reason` against it, which its tooltip says in place of `text`.
    """
    imgui.begin_disabled(bool(reason) or not enabled)
    grounds = [] if color is None else [(one, theme.touched(color, share)) for one, share in STATES]
    with ExitStack() as colors:
        for state, ground in grounds:
            colors.enter_context(imgui_ctx.push_style_color(state, ground))
        size = ImVec2(em(width) if width >= 0 else width, 0)
        pressed = imgui.small_button(label) if small else imgui.button(label, size)
    imgui.end_disabled()
    explain(reason or text)
    if pressed and action is not None:
        action()
    return pressed


def toggle(
    label: str,
    action: Callable[[], object],
    text: str = "",
    *,
    on: bool,
    caution: bool = False,
    enabled: bool = True,
    reason: str = "",
    width: float = 0.0,
) -> None:
    """A button that says whether something is on, by its colour and by a bar; `caution`: and that it should
    be noticed."""
    color = theme.switched_on(caution=caution) if on else None
    button(label, action, text, enabled=enabled, reason=reason, color=color, width=width)
    if on:
        low, high, inset = imgui.get_item_rect_min(), imgui.get_item_rect_max(), em(0.3)
        corner, end = ImVec2(low.x + inset, high.y - em(0.12)), ImVec2(high.x - inset, high.y)
        imgui.get_window_draw_list().add_rect_filled(corner, end, imgui.get_color_u32(theme.now().text))


def checkbox(label: str, on: bool) -> tuple[bool, bool]:
    """Whether it is clicked, and whether it is on then; with an edge, as an empty box is hardly told from the
    panel by its ground."""
    with (
        imgui_ctx.push_style_var(imgui.StyleVar_.frame_border_size, 1.0),
        imgui_ctx.push_style_color(imgui.Col_.border, theme.now().edge),
    ):
        changed, now = imgui.checkbox(label, on)
    return bool(changed), bool(now)


def mark_row() -> None:
    """A bar at the left end of the row before, which says by more than a shade that it is chosen; at the
    right end where the left one is out of sight."""
    draw, low, high = imgui.get_window_draw_list(), imgui.get_item_rect_min(), imgui.get_item_rect_max()
    right = min(high.x, draw.get_clip_rect_max().x)
    x = low.x if low.x >= draw.get_clip_rect_min().x else right - em(0.2)
    ink = imgui.get_color_u32(theme.now().accent)
    draw.add_rect_filled(ImVec2(x, low.y), ImVec2(x + em(0.2), high.y), ink)


def in_line(controls: Sequence[T], gap: float = 0.5) -> Iterator[tuple[T, float]]:
    """One after the other, to be drawn beside the one before, with the width in em that is an equal share of
    what is left of the line; `gap` in em."""
    width = (imgui.get_content_region_avail().x / em() - gap * (len(controls) - 1)) / len(controls)
    for place, control in enumerate(controls):
        if place:
            imgui.same_line(0, em(gap))
        yield control, width


def in_table(name: str, widths: Sequence[float | None], rows: Iterable[T], flags: int = 0) -> Iterator[T]:
    """One row after the other, to be drawn in a table's cells; none while the table is out of sight.

    `widths` of the columns are in em; 0 = as wide as what is in it, None = what is left.
    """
    with imgui_ctx.begin_table(name, len(widths), flags) as table:
        if not table:
            return
        for place, width in enumerate(widths):
            kind = imgui.TableColumnFlags_
            way = kind.width_stretch if width is None else kind.width_fixed
            imgui.table_setup_column(str(place), way, em(width or 0.0))
        yield from rows


def cell(text: str, color: ImVec4 | None = None, tooltip: str = "") -> None:
    """The next one of a table; quiet unless in a colour."""
    imgui.table_next_column()
    imgui.text_colored(color or theme.now().muted, text)
    explain(tooltip)


def percent(share: float) -> str:
    """Of a share in [0, 1]: 36 %."""
    return f"{100 * share:.0f} %"


def seconds(duration: float) -> str:
    """A duration as a person says it: 42 s, 3 min 05 s, 1 h 12 min."""
    whole = round(duration)
    if whole < 60:
        return f"{whole} s"
    if whole < 3600:
        return f"{whole // 60} min {whole % 60:02d} s"
    return f"{whole // 3600} h {whole % 3600 // 60:02d} min"


def dragged() -> ImVec2:
    """How far the last item has been dragged since the frame before; nowhere as it is pressed, where a tap,
    or a pen, has come from anywhere."""
    held = imgui.is_item_active() and not imgui.is_item_activated()
    return imgui.get_io().mouse_delta if held else ImVec2(0, 0)
