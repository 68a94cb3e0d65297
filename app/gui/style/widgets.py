"""Controls made from the declared fields of parameters, and the small pieces that every panel uses."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import cache
from typing import Any, TypeVar

from annotated_types import Interval
from imgui_bundle import ImVec2, ImVec4, imgui, imgui_ctx
from pydantic.fields import FieldInfo

from app.console.flags import marks
from app.enhancement.methods import EnhancementSettings
from app.files.legible import legible
from app.gui.style import theme
from enhance import EnhanceParams

ROOM = 1e4
"""Pixels that no label needs."""
NAMES = 5.6
"""Text heights that the names of controls have, before the controls."""
L = TypeVar("L", bound=EnhancementSettings)
EXPLAINED = imgui.HoveredFlags_.delay_normal | imgui.HoveredFlags_.allow_when_disabled


def fill_around(corner: ImVec2, end: ImVec2, low: ImVec2, high: ImVec2, color: ImVec4) -> None:
    """The rectangle from `corner` to `end` without the one from `low` to `high`, which a picture covers.

    Each pixel that is painted twice costs a software driver as much as one that is painted once.
    """
    draw, ink = imgui.get_window_draw_list(), imgui.get_color_u32(color)
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


@dataclass(frozen=True)
class Declared:
    """What a field says about itself."""

    lo: float
    hi: float
    text: str
    default: Any


def declared(kind: type[Any], name: str) -> Declared:
    """Range, explanation and default of a pydantic dataclass's field, from its own declaration."""
    a_class: Any = kind  # A class can be hashed also where what it makes cannot.
    return _declared(a_class, name)


@cache
def _declared(kind: type[Any], name: str) -> Declared:
    field: FieldInfo = kind.__pydantic_fields__[name]
    declarations = [*field.metadata, *marks(field.annotation)]
    interval = next((mark for mark in declarations if isinstance(mark, Interval)), Interval(ge=0, le=1))
    text = " ".join((field.description or "").split())
    lo, hi = (float(str(bound)) for bound in (interval.ge, interval.le))
    return Declared(lo, hi, text, field.default)


def row(label: str, tooltip: str) -> None:
    """The name of a control on a line of its own column; the control follows to its right."""
    start = imgui.get_cursor_pos_x()
    imgui.align_text_to_frame_padding()
    imgui.text(label)
    explain(tooltip)
    imgui.same_line(start + em(NAMES))


def choose_row(label: str, index: int, values: list[str], text: str) -> int:
    """A list of `values` behind its name; the place of the chosen one."""
    row(label, text)
    imgui.set_next_item_width(-em(0.1))
    _, index = imgui.combo(f"##{label}", index, values)
    explain(text)
    return index


def explain(text: str) -> None:
    """A tooltip on the item before, also when that is disabled."""
    if text and imgui.is_item_hovered(EXPLAINED):
        with imgui_ctx.begin_tooltip(), imgui_ctx.push_text_wrap_pos(em(24)):
            imgui.text_unformatted(legible(text))


def slide(params: L, name: str, label: str, form: str = "%.2f", *, log: bool = False) -> L:
    """A slider for a number; a double click on it or its reset entry gives the default."""
    about, value = declared(type(params), name), getattr(params, name)
    row(label, about.text)
    imgui.set_next_item_width(-em(0.1))
    flags = imgui.SliderFlags_.always_clamp | (imgui.SliderFlags_.logarithmic if log else 0)
    changed, new = slider(f"##{name}", value, about, form, flags)
    explain(about.text)
    if wants_default(name):
        return _with(params, name, about.default)
    return _with(params, name, new) if changed else params


def _with(params: L, name: str, value: Any) -> L:
    changed: L = replace(params, **{name: value})
    return changed


def slider(label: str, value: Any, about: Declared, form: str, flags: int) -> tuple[bool, Any]:
    """A whole number or a fraction, within its declared range."""
    if isinstance(value, int):
        return imgui.slider_int(label, value, int(about.lo), int(about.hi), form, flags)
    changed, new = imgui.slider_float(label, value, about.lo, about.hi, form, flags)
    return changed, round(new, 6)  # The control counts in single precision.


def slide_auto(
    params: EnhanceParams, name: str, label: str, used: float | None, start: float
) -> EnhanceParams:
    """A slider with an Auto switch; on automatic it shows the value in use, or else `start`. Moving it sets
    the value by hand."""
    about, value = declared(type(params), name), getattr(params, name)
    automatic = value is None
    row(label, about.text)
    shown = used if used is not None and automatic else (start if automatic else float(value))
    imgui.set_next_item_width(-em(4.3))
    imgui.push_style_color(imgui.Col_.text, theme.now().muted if automatic else theme.now().text)
    form = "%.2f" if not automatic or used is not None else "…"
    changed, new = slider(f"##{name}", shown, about, form, imgui.SliderFlags_.always_clamp)
    imgui.pop_style_color()
    explain(about.text)
    reset = wants_default(name)
    imgui.same_line()
    switched, automatic = imgui.checkbox(f"Auto##{name}", automatic)
    explain("Automatic: from the image. Off, or once the slider is moved: set by hand.")
    if reset:
        return _with(params, name, about.default)
    if switched:
        return _with(params, name, None if automatic else round(shown, 2))
    return _with(params, name, new) if changed else params


def wants_default(name: str) -> bool:
    """The item before was double-clicked, or reset from its context menu."""
    if imgui.is_item_hovered() and imgui.is_mouse_double_clicked(imgui.MouseButton_.left):
        return True
    if not imgui.begin_popup_context_item(f"reset {name}"):
        return False
    chosen = imgui.menu_item_simple("Reset to default")
    imgui.end_popup()
    return chosen


def tag(text: str, position: ImVec2, color: ImVec4, room: float = ROOM) -> float:
    """A label on a picture, in lines where it has to be; `position` is its upper left corner.

    `room`: pixels from there to the right edge. Returns its height.
    """
    text, pad, wrap = legible(text), ImVec2(em(0.45), em(0.18)), _inner(room)
    size = imgui.calc_text_size(text, wrap_width=wrap)
    corner = ImVec2(position.x + size.x + 2 * pad.x, position.y + size.y + 2 * pad.y)
    draw = imgui.get_window_draw_list()
    draw.add_rect_filled(position, corner, imgui.get_color_u32(color), em(0.2))
    at, ink = ImVec2(position.x + pad.x, position.y + pad.y), imgui.get_color_u32(theme.INK)
    draw.add_text(imgui.get_font(), imgui.get_font_size(), at, ink, text, wrap_width=wrap)
    return corner.y - position.y


def _inner(room: float) -> float:
    """The width that the text of a tag may have, never less than a short word's."""
    return max(room - em(0.9), em(4))


def tag_height(text: str, room: float) -> float:
    """That `tag` would return."""
    return imgui.calc_text_size(legible(text), wrap_width=_inner(room)).y + em(0.36)


def stack_tags(tags: list[tuple[str, ImVec4]], corner: ImVec2, width: float = ROOM) -> None:
    """Labels one below the other in the upper left corner of a picture so wide."""
    y = corner.y + em(0.4)
    for text, color in tags:
        y += tag(text, ImVec2(corner.x + em(0.4), y), color, width - em(0.8)) + em(0.14)


def note(text: str, color: ImVec4 | None = None) -> None:
    """A line of text, or more where it is too long for one; quiet unless in a colour."""
    with imgui_ctx.push_text_wrap_pos(0):
        imgui.text_colored(color or theme.now().muted, text)


def centered(text: str, color: ImVec4 | None = None) -> None:
    """A line of text in the middle of the window's width; more lines where it is too long for that."""
    text, color = legible(text), color or theme.now().muted
    space = imgui.get_content_region_avail().x - imgui.calc_text_size(text).x
    with imgui_ctx.push_text_wrap_pos(0):
        imgui.set_cursor_pos_x(imgui.get_cursor_pos_x() + max(space / 2, 0))
        imgui.text_colored(color, text)


def beside(label: str, gap: float = 0.5) -> None:
    """The next control, a button of this label, stands beside the one before; below it where room ends."""
    beside_of(imgui.calc_text_size(label, True).x + 2 * imgui.get_style().frame_padding.x, gap)


def beside_of(width: float, gap: float = 0.5) -> None:
    """The same for a control of so many pixels; `gap` in em."""
    end = imgui.get_cursor_screen_pos().x + imgui.get_content_region_avail().x
    if imgui.get_item_rect_max().x + em(gap) + width <= end:
        imgui.same_line(0, em(gap))


def within(width: float, height: float) -> ImVec2:
    """So many em, but never larger than the window."""
    most = imgui.get_main_viewport().work_size
    return ImVec2(min(em(width), most.x - em(1)), min(em(height), most.y - em(1)))


def button(label: str, action: Callable[[], object], *, enabled: bool = True, width: float = 0.0) -> None:
    """A button that does `action`; `width` in em, 0 = as wide as its text."""
    imgui.begin_disabled(not enabled)
    if imgui.button(label, ImVec2(em(width) if width >= 0 else width, 0)):
        action()
    imgui.end_disabled()


def seconds(duration: float) -> str:
    """A duration as a person says it: 42 s, 3 min 05 s, 1 h 12 min."""
    whole = round(duration)
    if whole < 60:
        return f"{whole} s"
    if whole < 3600:
        return f"{whole // 60} min {whole % 60:02d} s"
    return f"{whole // 3600} h {whole % 3600 // 60:02d} min"


@contextmanager
def question(title: str, width: float) -> Iterator[bool]:
    """A window of `width` text heights in the middle, which everything waits for; whether it is drawn."""
    imgui.open_popup(title)
    imgui.set_next_window_pos(imgui.get_main_viewport().get_center(), imgui.Cond_.always, ImVec2(0.5, 0.5))
    imgui.set_next_window_size(ImVec2(within(width, 0).x, 0))
    flags = imgui.WindowFlags_.no_resize | imgui.WindowFlags_.no_move
    with imgui_ctx.begin_popup_modal(title, flags) as opened:
        yield bool(opened)


def floating(width: float) -> int:
    """Flags of the next window: `width` text heights across, in the middle at first, as high as its content
    or as there is room."""
    viewport = imgui.get_main_viewport()
    imgui.set_next_window_pos(viewport.get_center(), imgui.Cond_.appearing, ImVec2(0.5, 0.5))
    across = min(em(width), viewport.work_size.x)
    imgui.set_next_window_size_constraints(ImVec2(across, 0), ImVec2(across, viewport.work_size.y - em(3)))
    flags = imgui.WindowFlags_
    return int(flags.no_collapse | flags.no_docking | flags.always_auto_resize)
