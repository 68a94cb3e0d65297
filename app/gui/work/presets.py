"""Settings by name: those that come with the app, and a person's own, kept beside the other settings."""

from __future__ import annotations

import os
from collections.abc import Container, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from itertools import chain, count
from pathlib import Path
from typing import Final

from pydantic import TypeAdapter

from app.enhancement.methods import EnhancementSettings, RecordedSettings, preset_of
from app.enhancement.settable import LONGEST_NAME
from app.errors import UserError
from app.files.atomic import write_bytes
from app.files.legible import named
from app.files.mended import mended
from app.files.provenance import strict_json
from app.gui.work.settings import Places
from app.runs.train_run import RECONSTRUCTION_PARAMS
from enhance import EnhanceParams
from enhance.vessel import VesselParams
from renderer.json_files import read_json

BUILT_IN: Final[Mapping[str, EnhancementSettings]] = {
    "Vessels": VesselParams(),
    "Gentle": VesselParams(strength=1.0, lift=0.12, gamma=0.975, d_factor=0.85, most_color=1.2),
    "Paper": EnhanceParams(),
    "Paper, colour 0.50": EnhanceParams(d_factor=1.0),
    "Paper, colour 0.67 (3D)": RECONSTRUCTION_PARAMS,
    "Brighten dark areas": EnhanceParams(z=0.0, p=0.0, d_factor=0.0),
}
CUSTOM: Final = "Custom"
"""What parameters are called that no preset has."""
RESERVED: Final = frozenset((*BUILT_IN, CUSTOM))
RENAMED: Final = " (own)"
"""Added to an own preset of such a name."""
OWN: TypeAdapter[dict[str, EnhancementSettings]] = TypeAdapter(dict[str, RecordedSettings])
MOST_PRESETS: Final = 500
DAMAGED: Final = "the file is damaged"


def presets_file(places: Places) -> Path:
    return places.config / "presets.json"


def load_presets(path: Path) -> tuple[dict[str, EnhancementSettings], str]:
    """The own presets that can be read and what went wrong with the others, empty when nothing did.

    A file that cannot be understood as a whole is put aside, so that the next save does not destroy it.
    """
    try:
        told = read_json(path)
    except FileNotFoundError:
        return {}, ""
    except OSError as error:
        return {}, _put_aside(path, error.strerror or DAMAGED)
    except ValueError:
        return {}, _put_aside(path, DAMAGED)
    if not isinstance(told, dict):
        return {}, _put_aside(path, DAMAGED)
    told = {_own_name(name, told): look for name, look in told.items()}
    named = [(name, look) for name, look in told.items() if is_preset_name(name)]
    readable = mended(OWN, dict(named[:MOST_PRESETS]))
    found = readable[0]
    if found is None or len(found) == len(told):
        return found or {}, ""
    trouble = _put_aside(path, f"{len(told) - len(found)} of {len(told)} are damaged")
    with suppress(OSError, UserError):
        save_presets(path, found)
    return found, trouble


def _own_name(name: str, taken: Container[str]) -> str:
    """What an own preset is called that has a reserved name; other names stay."""
    if name not in RESERVED:
        return name
    free = f"{name}{RENAMED}"
    numbered = (f"{free} {place}" for place in count(2))
    return next(one for one in chain((free,), numbered) if one not in taken)


def presets_with(own: Mapping[str, EnhancementSettings]) -> dict[str, EnhancementSettings]:
    """Those that come with the app, then a person's own."""
    return {**BUILT_IN, **own}


def is_preset_name(name: str) -> bool:
    """Whether a user's preset may have this name."""
    return 0 < len(name) <= LONGEST_NAME and name not in RESERVED


def _put_aside(path: Path, what: str) -> str:
    aside = path.with_suffix(".damaged.json")
    try:
        os.replace(path, aside)
    except OSError:
        return f"your own presets cannot be read ({what}): {path.name}"
    return f"your own presets cannot be read ({what}); the file is kept as {aside.name}"


def save_presets(path: Path, presets: Mapping[str, EnhancementSettings]) -> None:
    """Atomic. Raises OSError or UserError."""
    write_bytes(path, strict_json(dict(presets), indent=2).encode())


def merged_presets(
    path: Path, mine: Mapping[str, EnhancementSettings], before: Mapping[str, EnhancementSettings]
) -> dict[str, EnhancementSettings]:
    """What other windows have saved meanwhile, with what this one has changed since `before`."""
    others, _ = load_presets(path)
    changed = {name: look for name, look in mine.items() if before.get(name) != look}
    gone = before.keys() - mine.keys()
    return {name: look for name, look in others.items() if name not in gone} | changed


@dataclass(frozen=True, eq=False)
class KeepPresets:
    """All own presets as this window has them; what other windows have saved meanwhile stays."""

    path: Path
    presets: Mapping[str, EnhancementSettings]
    before: Mapping[str, EnhancementSettings]
    """As they were before the change that is to be kept."""
    done: str
    """What is said when they are kept."""


def keep_presets(request: KeepPresets) -> Iterator[dict[str, EnhancementSettings]]:
    """What the file holds now. Raises OSError or UserError."""
    presets = merged_presets(request.path, request.presets, request.before)
    save_presets(request.path, presets)
    yield presets


def loosely_named(look: EnhancementSettings, own: Mapping[str, EnhancementSettings]) -> str:
    """The preset that these parameters are but for their strength, and that: "Vessels, strength 1.0"."""
    name = preset_name(look, own)
    if name == CUSTOM:
        known = (each for each, preset in presets_with(own).items() if _is_like(preset, look))
        name = next(known, f"{named(preset_of(look))}, custom")
    return f"{name}, strength {look.strength:.1f}"


def _is_like(preset: EnhancementSettings, look: EnhancementSettings) -> bool:
    return type(preset) is type(look) and replace(preset, strength=look.strength) == look


def preset_name(look: EnhancementSettings, own: Mapping[str, EnhancementSettings]) -> str:
    """The preset that these parameters are."""
    named = (name for name, preset in presets_with(own).items() if preset == look)
    return next(named, CUSTOM)
