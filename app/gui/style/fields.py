"""Controls made from the declared fields of parameters."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache
from typing import Any, TypeVar

from annotated_types import Interval
from imgui_bundle import imgui, imgui_ctx
from pydantic.fields import FieldInfo

from app.console.flags import marks
from app.enhancement.methods import EnhancementSettings
from app.gui.style import theme
from app.gui.style.widgets import explain, row
from enhance import EnhanceParams

L = TypeVar("L", bound=EnhancementSettings)


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


def slide(params: L, name: str, label: str, form: str = "%.2f", *, log: bool = False) -> L:
    """A slider for a number; a double click on it or its reset entry gives the default."""
    about, value = declared(type(params), name), getattr(params, name)
    row(label, about.text)
    flags = imgui.SliderFlags_.always_clamp | (imgui.SliderFlags_.logarithmic if log else 0)
    changed, new = slider(f"##{name}", value, about, form, flags)
    explain(about.text)
    if wants_default(name):
        new, changed = about.default, True
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
    row(label, about.text, -4.3)
    shown = used if used is not None and automatic else (start if automatic else float(value))
    form = "%.2f" if not automatic or used is not None else "…"
    with imgui_ctx.push_style_color(imgui.Col_.text, theme.now().muted if automatic else theme.now().text):
        changed, new = slider(f"##{name}", shown, about, form, imgui.SliderFlags_.always_clamp)
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
