"""Settings of a tuning grid in the interface's words: its names of parameters, and their amounts."""

from __future__ import annotations

from app.enhancement.parameter_grid import Setting
from app.gui.state.amounts import AMOUNTS

VESSEL_LABELS = {
    "radius": "Radius", "lift": "Lift", "d_factor": "Colour", "shading": "Shading",
    "coring": "Coring", "gamma": "Gamma", "most_color": "Most colour",
}  # fmt: skip
LABELS = VESSEL_LABELS | {
    "strength": "Strength", "z": "Brightness", "p": "Detail", "eps": "Smoothing", "subsample": "Subsample",
}  # fmt: skip


def said(setting: Setting) -> str:
    """The values of what is varied, as sliders show them."""
    return " · ".join(_value(setting, *one.split(" ", 1)) for one in setting.label.split(" · "))


def _value(setting: Setting, name: str, told: str) -> str:
    value, shown = getattr(setting.params, name), AMOUNTS.get(name)
    amount = f"{shown.of_parameter(value):.2f}" if shown is not None and value is not None else told
    return f"{LABELS.get(name, name)} {amount}"


def in_the_paper(setting: Setting) -> str:
    """The values that sliders show as amounts, in the paper's sense; empty where there are none."""
    names = (one.partition(" ")[0] for one in setting.label.split(" · "))
    values = ((AMOUNTS[name], getattr(setting.params, name)) for name in names if name in AMOUNTS)
    return " · ".join(f"{shown.symbol} {value:.2f}" for shown, value in values if value is not None)
