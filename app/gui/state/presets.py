"""Settings by name: those that come with the app, and a person's own, kept beside the other settings."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Final

from pydantic import TypeAdapter, ValidationError

from app.atomic import write_bytes
from app.gui.state.settings import Places
from app.methods import Look
from app.provenance import strict_json
from app.run_folder import RecordedLook
from app.training import RECONSTRUCTION_PARAMS
from enhance import EnhanceParams
from enhance.vessel import VesselParams
from renderer.json_files import read_text

BUILT_IN: Final[Mapping[str, Look]] = MappingProxyType(
    {
        "Paper, d 1 (pictures)": EnhanceParams(),
        "Paper, d 0.5 (3D)": RECONSTRUCTION_PARAMS,
        "Vessel (ours)": VesselParams(),
    }
)
OWN: TypeAdapter[dict[str, Look]] = TypeAdapter(dict[str, RecordedLook])
LONGEST_NAME: Final = 60


def presets_file(places: Places) -> Path:
    return places.config / "presets.json"


def load_presets(path: Path) -> tuple[dict[str, Look], str]:
    """The own presets and what went wrong with them, empty when nothing did.

    A file that cannot be understood is put aside, so that the next save does not destroy it.
    """
    try:
        return OWN.validate_json(read_text(path)), ""
    except FileNotFoundError:
        return {}, ""
    except (OSError, ValidationError) as error:
        return {}, _put_aside(path, error)


def _put_aside(path: Path, error: Exception) -> str:
    aside = path.with_suffix(".damaged.json")
    what = error.strerror if isinstance(error, OSError) else "it is damaged"
    try:
        os.replace(path, aside)
    except OSError:
        return f"your own presets cannot be read ({what}): {path.name}"
    return f"your own presets cannot be read ({what}); the file is kept as {aside.name}"


def save_presets(path: Path, presets: Mapping[str, Look]) -> None:
    """Atomic. Raises OSError or UserError."""
    write_bytes(path, strict_json(dict(presets), indent=2).encode())


def merged_presets(path: Path, mine: Mapping[str, Look], before: Mapping[str, Look]) -> dict[str, Look]:
    """What other windows have saved meanwhile, with what this one has changed since `before`."""
    others, _ = load_presets(path)
    changed = {name: look for name, look in mine.items() if before.get(name) != look}
    gone = before.keys() - mine.keys()
    return {name: look for name, look in others.items() if name not in gone} | changed


def preset_name(look: Look, own: Mapping[str, Look]) -> str:
    """The preset that these parameters are, empty for none."""
    named = (name for name, preset in {**BUILT_IN, **own}.items() if preset == look)
    return next(named, "")
