"""The file of a sweep, written: what `read_spec` reads."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path

from app.console.flags import AUTO
from app.sweeps.settings import Enhancing


def spec_text(clip: Path, settings: Enhancing, grid: Mapping[str, Sequence[object]]) -> str:
    """TOML: `clip` enhanced by these settings and by all combinations of the values of the grid.
    Texts and numbers are written in TOML as in JSON, but for the character DEL, which TOML escapes."""
    fixed = {name: value for name, value in settings.told().items() if name not in grid}
    return "\n".join(
        (
            f"clips = {_toml([str(clip)])}",
            'task = "enhance"',
            "",
            "[settings]",
            *(f"{name} = {_toml(AUTO if value is None else value)}" for name, value in fixed.items()),
            "",
            "[grid]",
            *(f"{name} = {_toml(list(values))}" for name, values in grid.items()),
            "",
        )
    )


def _toml(value: object) -> str:
    return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
