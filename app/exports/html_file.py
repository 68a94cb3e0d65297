"""HTML files that stand alone: templates filled in, and JSON inside that says how they were made."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any, Final

from app.errors import UserError
from app.files.provenance import ascii_json
from renderer.json_files import parsed

PROVENANCE: Final = "provenance"
"""Id of the element that holds it."""
_PART = r'<script type="{kind}" id="{name}">(.*?)</script>'


def filled_in(template: str, parts: Mapping[str, str]) -> bytes:
    """Each `{{NAME}}` replaced by the part of that name, which is HTML already; what is not UTF-8 in a file's
    name becomes a question mark."""
    return re.sub(r"\{\{(\w+)\}\}", lambda hit: parts[hit[1]], template).encode(errors="replace")


def in_script(value: object) -> str:
    """JSON that cannot end the element it stands in."""
    return ascii_json(value).replace("<", "\\u003c")


def found(text: str, kind: str, name: str) -> str:
    """The content of a script element. Raises ValueError: there is none."""
    hit = re.search(_PART.format(kind=re.escape(kind), name=name), text, re.DOTALL)
    if hit is None:
        raise ValueError(f"no {name} in it")
    return hit[1]


def facts_in(text: str) -> dict[str, Any]:
    """The provenance of a page. Raises UserError: it is none of ours, or damaged."""
    try:
        facts = parsed(found(text, "application/json", PROVENANCE))
    except ValueError as error:
        raise UserError(f"expected an HTML file written by VesselSplat ({error})") from error
    if not isinstance(facts, dict):
        raise UserError(f"expected a JSON object in its provenance, got {type(facts).__name__}")
    return facts
