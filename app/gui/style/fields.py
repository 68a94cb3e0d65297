"""Controls made from the declared fields of parameters."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache, partial
from typing import Any, TypeVar

from annotated_types import Interval
from imgui_bundle import imgui, imgui_ctx
from pydantic.fields import FieldInfo

from app.console.flags import marks
from app.enhancement.amounts import AMOUNTS, Amount
from app.enhancement.methods import EnhancementSettings
from app.gui.style import theme
from app.gui.style.widgets import NAMES, checkbox, em, explain, row
from enhance import EnhanceParams

L = TypeVar("L", bound=EnhancementSettings)
S = TypeVar("S")
T = TypeVar("T")
NUMBERS = 3.9
"""Text heights at the right end that the numbers of sliders have, with the gap before them."""
LEAST = 3.5
"""Text heights that a slider has at least."""
AUTO = 4.3
"""Text heights that an Auto switch has, with the gap before it."""


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


def amount(kind: type[Any], name: str) -> Amount:
    """How a slider shows a field: as an amount where there is one, else as it is declared."""
    about = declared(kind, name)
    return AMOUNTS.get(name) or Amount(about.lo, about.hi, about.text)


def slide(params: L, name: str, label: str, form: str = "%.2f", *, log: bool = False) -> L:
    """A slider for a number; a double click on it or its reset entry gives the default."""
    shown, value = amount(type(params), name), getattr(params, name)
    flags = imgui.SliderFlags_.logarithmic if log else 0
    with_number = form % shown.of_parameter(value) if isinstance(value, float) else form % value
    text, draw = shown.explained(value), partial(resettable, name, value, shown, form, flags)
    (changed, new, reset), _ = with_beside(label, text, NUMBERS, draw, partial(number, with_number))
    if reset:
        return _with(params, name, declared(type(params), name).default)
    return _with(params, name, new) if changed else params


def resettable(name: str, value: Any, shown: Amount, form: str, flags: int = 0) -> tuple[bool, Any, bool]:
    """A slider: whether it is moved, to what, and whether its default is asked for."""
    changed, new = slider(f"##{name}", value, shown, form, flags)
    return changed, new, wants_default(name)


def with_beside(
    label: str, text: str, width: float, draw: Callable[[], S], draw_beside: Callable[[], T]
) -> tuple[S, T]:
    """A row of a name, a slider and what stands beside it, `width` em across; where that leaves no room for
    a slider, it is below. Returns what both give."""
    if imgui.get_content_region_avail().x >= em(NAMES + LEAST + width):
        row(label, text, -width)
        drawn = draw()
        imgui.same_line()
        return drawn, draw_beside()
    row(label, text)
    beside = draw_beside()
    imgui.set_next_item_width(em(-0.1))
    return draw(), beside


def _with(params: L, name: str, value: Any) -> L:
    changed: L = replace(params, **{name: value})
    return changed


def slider(label: str, value: Any, shown: Amount, form: str, flags: int = 0) -> tuple[bool, Any]:
    """A whole number or a fraction, as an amount but given and taken as the parameter; explained.

    Its number is for the caller to draw beside it: a handle would cover it.
    """
    flags |= imgui.SliderFlags_.always_clamp
    # A number that is being typed, after Ctrl+click, is in the slider's place and to be seen.
    ink = theme.now().text
    typing = imgui.internal.temp_input_is_active(imgui.get_id(label))
    with imgui_ctx.push_style_color(imgui.Col_.text, ink if typing else theme.CLEAR):
        drawn: tuple[bool, Any]
        if isinstance(value, int):
            drawn = imgui.slider_int(label, value, int(shown.lo), int(shown.hi), form, flags)
        else:
            drawn = _fraction(label, value, shown, form, flags)
    explain(shown.explained(value))
    return drawn


def _fraction(label: str, value: float, shown: Amount, form: str, flags: int) -> tuple[bool, float]:
    changed, new = imgui.slider_float(label, shown.of_parameter(value), shown.lo, shown.hi, form, flags)
    return changed, round(shown.to_parameter(round(new, 6)), 6)  # The control counts in single precision.


def number(text: str, *, quiet: bool = False) -> None:
    """The value of a slider, in a column at the right end."""
    room = imgui.get_content_region_avail().x - imgui.calc_text_size(text).x - em(0.1)
    imgui.set_cursor_pos_x(imgui.get_cursor_pos_x() + max(room, 0))
    imgui.align_text_to_frame_padding()
    imgui.text_colored(theme.now().muted if quiet else theme.now().text, text)


def slide_auto(
    params: EnhanceParams, name: str, label: str, used: float | None, start: float
) -> EnhanceParams:
    """A slider with an Auto switch; on automatic it shows the value in use, or else `start`. Moving it sets
    the value by hand."""
    shown, value = amount(type(params), name), getattr(params, name)
    automatic = value is None
    now = float(value) if value is not None else start if used is None else used
    is_known = not automatic or used is not None
    text = f"{shown.of_parameter(now):.2f}" if is_known else "…"
    about, draw = shown.explained(now if is_known else None), partial(resettable, name, now, shown, "%.2f")
    drawn = with_beside(label, about, NUMBERS + AUTO, draw, partial(_auto, name, automatic, text))
    (changed, new, reset), (switched, switch) = drawn
    if reset:
        return _with(params, name, declared(type(params), name).default)
    if switched:
        return _with(params, name, None if switch else round(now, 2))
    return _with(params, name, new) if changed else params


def _auto(name: str, automatic: bool, text: str) -> tuple[bool, bool]:
    """The switch, whether it was clicked, and the number."""
    switched = checkbox(f"Auto##{name}", automatic)
    explain("Automatic: from the image. Off, or once the slider is moved: set by hand.")
    imgui.same_line()
    number(text, quiet=automatic)
    return switched


def wants_default(name: str) -> bool:
    """The item before was double-clicked, or reset from its context menu."""
    typing = imgui.internal.temp_input_is_active(imgui.get_item_id())
    if imgui.is_item_hovered() and imgui.is_mouse_double_clicked(imgui.MouseButton_.left) and not typing:
        # The button is still down: a slider that was held on would be moved to the pointer again.
        imgui.internal.clear_active_id()
        return True
    return asks_for_default(name)


def asks_for_default(name: str) -> bool:
    """The item before was reset from its context menu, where a double click chooses text or is two clicks."""
    if not imgui.begin_popup_context_item(f"reset {name}"):
        return False
    chosen = imgui.menu_item_simple("Reset to default")
    imgui.end_popup()
    return chosen
