"""Settings in a line: in the interface's words, as sliders show them, and in the paper's letters."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from app.enhancement.amounts import AMOUNTS
from app.enhancement.methods import PAPER, VESSEL, EnhancementSettings
from app.enhancement.parameter_grid import Setting
from app.files.legible import named
from enhance import EnhanceParams, Statistics
from enhance.vessel import VesselParams

VESSEL_LABELS = {
    "radius": "Radius", "lift": "Brightening", "d_factor": "Colour", "shading": "Shadows",
    "coring": "Noise floor", "contrast": "Contrast", "gamma": "Gamma", "most_color": "Colour limit",
    "most_exposure": "Exposure limit", "least_redness": "Least redness",
    "color_smoothing": "Colour blur", "spare_grey": "Spare grey",
}  # fmt: skip
LABELS = VESSEL_LABELS | {
    "strength": "Strength", "z": "Brightness", "p": "Detail", "eps": "Smoothing", "subsample": "Subsample",
}  # fmt: skip


def worded(look: EnhancementSettings, used: Statistics | None = None) -> str:
    """As sliders show it; what is left to the image as "auto", with what was `used` where known."""
    if isinstance(look, VesselParams):
        names = ("strength", *(("contrast",) if look.contrast > 0 else ()), "lift", "d_factor")
        return " · ".join((named(VESSEL), *(_shown(name, getattr(look, name)) for name in names)))
    whole = None if used is None else before_strength(look, used)
    parts = [_shown("strength", look.strength)] if look.strength != 1 else []
    parts.append(_shown("z", look.z, () if whole is None else (whole.z,)))
    parts.append(_shown("p", look.p, () if whole is None else whole.p))
    # The share of the change of colours, where it is not all.
    share = f" at {whole.color:.0%}" if whole is not None and whole.color < 1 else ""
    parts.append(_shown("d_factor", look.d_factor, () if whole is None else (look.k,)) + share)
    return " · ".join(parts)


def with_method(look: EnhancementSettings, used: Statistics | None = None) -> str:
    """The same after the name of its method, of the paper's as well."""
    said = worded(look, used)
    return said if isinstance(look, VesselParams) else f"{named(PAPER)} · {said}"


def _shown(name: str, chosen: float | tuple[float, ...] | None, used: tuple[float, ...] = ()) -> str:
    amount = AMOUNTS[name].of_parameter if name in AMOUNTS else float
    given = _given(chosen)
    values = [round(amount(value), 2) for value in (used if chosen is None else given)]
    return f"{LABELS[name]} {_value(chosen is None, values)}"


def before_strength(params: EnhanceParams, used: Statistics) -> Statistics:
    """What `used` was before the strength multiplied it: what a person takes over is multiplied again."""
    if params.p is None and len(used.sigmas) != len(params.radii):
        params = replace(params, p=0.5)  # Until the image of these windows is there.
    return used.resolved(replace(params, strength=1.0))


def in_letters(look: EnhancementSettings, used: Statistics | None = None) -> str:
    """In the paper's sense, times the strength; so exports before 0.2.0 say it."""
    if isinstance(look, VesselParams):
        return f"{VESSEL} · strength {look.strength:.2f} · lift {look.lift:.2f} · d {look.d_factor:.2f}"
    z, p = (_given(chosen) for chosen in (look.z, look.p))
    strength = f"strength {look.strength:.2f} · " if look.strength != 1 else ""
    share = f" {used.color:.0%}" if used is not None and used.color < 1 else ""
    z_text = _value(look.z is None, (used.z,) if used is not None else z)
    p_text = _value(look.p is None, used.p if used is not None else p)
    return (
        f"{strength}z {z_text} · P {p_text} · d {_value(look.d_factor is None, _given(look.d_factor))}{share}"
    )


def _given(chosen: float | tuple[float, ...] | None) -> tuple[float, ...]:
    return chosen if isinstance(chosen, tuple) else () if chosen is None else (chosen,)


def _value(automatic: bool, numbers: Sequence[float]) -> str:
    values = "/".join(f"{value:.2f}" for value in dict.fromkeys(numbers))
    return f"auto {values}".rstrip() if automatic else values


def said(setting: Setting) -> str:
    """The values of what is varied, as sliders show them."""
    return " · ".join(_varied(setting, *one.split(" ", 1)) for one in setting.label.split(" · "))


def _varied(setting: Setting, name: str, told: str) -> str:
    value, shown = getattr(setting.params, name), AMOUNTS.get(name)
    amount = f"{shown.of_parameter(value):.2f}" if shown is not None and value is not None else told
    return f"{LABELS.get(name, name)} {amount}"


def in_the_paper(setting: Setting) -> str:
    """The values that sliders show as amounts, in the paper's sense; empty where there are none."""
    names = (one.partition(" ")[0] for one in setting.label.split(" · "))
    values = ((AMOUNTS[name], getattr(setting.params, name)) for name in names if name in AMOUNTS)
    return " · ".join(f"{shown.symbol} {value:.2f}" for shown, value in values if value is not None)
