"""Flags of the methods that have settings, alike in every command that enhances."""

from __future__ import annotations

import argparse
from dataclasses import fields

from app.console.flags import add_fields, highest, parameters
from app.enhancement.methods import PAPER, VESSEL, Params
from app.enhancement.settable import PIXELS
from app.errors import UserError
from enhance import EnhanceParams
from enhance.vessel import VesselParams

OWN_FIELDS = {
    PAPER: [one.name for one in fields(EnhanceParams) if one.name != "p_form"],
    VESSEL: [one.name for one in fields(VesselParams)],
}
FIELDS = OWN_FIELDS[PAPER]
VESSEL_FIELDS = [name for name in OWN_FIELDS[VESSEL] if name not in FIELDS]
MOST = {PAPER: highest(EnhanceParams, "strength"), VESSEL: highest(VesselParams, "strength")}
"""Of the strength, by the method."""


def add_settings(parser: argparse.ArgumentParser, shared: str) -> None:
    """Those of either method; `shared`: which of the first method the second one has, too."""
    add_fields(parser, EnhanceParams, FIELDS)
    group = parser.add_argument_group("with --method vessel", shared)
    add_fields(group, VesselParams, VESSEL_FIELDS)


def params_of(flags: argparse.Namespace) -> Params:
    """Of the method asked for. Raises UserError when flags of another one are given."""
    for name in (*FIELDS, *VESSEL_FIELDS):
        if name in flags and name not in OWN_FIELDS.get(flags.method, ()):
            raise UserError(f"--{name.replace('_', '-')} has no effect with --method {flags.method}")
    if "strength" in flags:
        _require_strength(flags.method, flags.strength)
    if flags.method == PAPER:
        return parameters(EnhanceParams, flags)
    if flags.method == VESSEL:
        return parameters(VesselParams, flags)
    for name, value in (("statistics", "automatic"), ("pixels", PIXELS[0])):
        if (given := getattr(flags, name)) != value:
            raise UserError(f"--{name} {given} has no effect with --method {flags.method}")
    return None


def _require_strength(method: str, text: str) -> None:
    """Raises UserError: the method does not take that much; which one does, if one does."""
    try:
        strength = float(text)
    except ValueError:
        return  # Its dataclass says what is wrong.
    if not 0 <= strength <= MOST[method]:
        takes = [
            f" (--method {one} takes up to {most:g})" for one, most in MOST.items() if 0 < strength <= most
        ]
        expected = f"expected 0 to {MOST[method]:g} for the method {method}"
        raise UserError(f"--strength: {expected}, got {strength:g}{''.join(takes)}")
