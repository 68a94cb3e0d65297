"""The packages of this program have names that others may have, too: those found must be its own."""

from __future__ import annotations

import sys
from importlib.machinery import ModuleSpec
from importlib.util import find_spec
from pathlib import Path

from app.errors import UserError

PACKAGES = ("app", "renderer", "enhance", "assets")


def require_one_place() -> None:
    """Nothing is imported, only looked up.

    Raises:
        UserError: one of the packages is missing, or is somebody else's: it lies elsewhere than `app`.
    """
    if getattr(sys, "frozen", False):
        return  # A bundle holds nothing but itself.
    home = Path(__file__).resolve().parents[2]
    for name in PACKAGES:
        spec = find_spec(name)
        if spec is None:
            raise UserError(
                f"expected {_listed()} in one folder, got no {name} in {home}: reinstall VesselSplat"
            )
        found = _path(spec)
        if found.parent != home:
            raise UserError(
                f"expected {_listed()} in one folder, {home}, got another {name}: {found} "
                "(start from another folder, or leave that one out of PYTHONPATH)"
            )


def _path(spec: ModuleSpec) -> Path:
    """Folder of a package, or file of a module; nowhere, of what Python itself holds."""
    places = list(spec.submodule_search_locations or ())
    return Path(places[0] if places else spec.origin or "").resolve()


def _listed() -> str:
    *most, last = PACKAGES
    return f"{', '.join(most)} and {last}"
