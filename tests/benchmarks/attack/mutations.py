"""Damage to a file, the same for the same seed: bytes, lengths, and values of JSON."""

from __future__ import annotations

import json
import re
from typing import Any

import numpy as np

HEAD = 400
"""Bytes in which most formats keep their sizes."""
WORDS = (b"\xff\xff\xff\xff", b"\xff\xff\xff\x7f", b"\0\0\0\x80", b"\0\0\0\0", b"\1\0\0\0", b"\0\0\xc0\x7f")
VALUES: tuple[Any, ...] = (
    None, True, -1, 0, 1, 2**31, 10**8, 10**12, -(10**12), 1e-300, 1e300, 1e30, -1e-30, "", "x", "../x",
    [], {}, [[]], [0, 0, 0], {"x": 1}, "9" * 400,
)  # fmt: skip
NUMBER = re.compile(rb"-?\d+(\.\d+)?([eE][-+]?\d+)?")
NUMBERS = (b"-1", b"0", b"1e308", b"1e-300", b"nan", b"inf", b"1000000000000", b"x", b"", b"4294967295")


def mutated(content: bytes, seed: int) -> bytes:
    """One of the kinds of damage, chosen and placed by `seed`."""
    rng = np.random.default_rng(seed)
    kinds = [_flip, _word, _cut, _blank, _twice, _insert]
    if content[:1] in b"{[":
        kinds = [_json, _json, _json, *kinds]
    elif content and _is_text(content[:HEAD]):
        kinds = [_number, _number, *kinds]
    return kinds[int(rng.integers(len(kinds)))](content, rng)


def _is_text(content: bytes) -> bool:
    return all(byte in b"\t\r\n" or 32 <= byte < 127 for byte in content)


def _place(content: bytes, rng: np.random.Generator) -> int:
    """Mostly in the head."""
    reach = min(HEAD, len(content)) if rng.random() < 0.7 else len(content)
    return int(rng.integers(max(reach, 1)))


def _flip(content: bytes, rng: np.random.Generator) -> bytes:
    changed = bytearray(content)
    for _ in range(int(rng.integers(1, 6))):
        if changed:
            changed[_place(content, rng)] = int(rng.integers(256))
    return bytes(changed)


def _word(content: bytes, rng: np.random.Generator) -> bytes:
    at = _place(content, rng)
    return content[:at] + WORDS[int(rng.integers(len(WORDS)))] + content[at + 4 :]


def _cut(content: bytes, rng: np.random.Generator) -> bytes:
    return content[: _place(content, rng)]


def _blank(content: bytes, rng: np.random.Generator) -> bytes:
    at, length = _place(content, rng), int(rng.integers(1, 200))
    return content[:at] + bytes(min(length, len(content) - at)) + content[at + length :]


def _twice(content: bytes, rng: np.random.Generator) -> bytes:
    at, length = _place(content, rng), int(rng.integers(1, 400))
    return content[: at + length] + content[at:]


def _insert(content: bytes, rng: np.random.Generator) -> bytes:
    at = _place(content, rng)
    return content[:at] + rng.bytes(int(rng.integers(1, 40))) + content[at:]


def _number(content: bytes, rng: np.random.Generator) -> bytes:
    """One of the numbers of a text is another."""
    found = list(NUMBER.finditer(content[:100_000]))
    if not found:
        return _flip(content, rng)
    one = found[int(rng.integers(len(found)))]
    return content[: one.start()] + NUMBERS[int(rng.integers(len(NUMBERS)))] + content[one.end() :]


def _json(content: bytes, rng: np.random.Generator) -> bytes:
    """One of the values is another, or left out; of lines, in one of them."""
    lines = content.splitlines(keepends=True)
    try:
        whole = json.loads(content)
        before, after = b"", b""
    except ValueError:
        place = int(rng.integers(len(lines)))
        before, after = b"".join(lines[:place]), b"\n" + b"".join(lines[place + 1 :])
        try:
            whole = json.loads(lines[place])
        except ValueError:
            return _flip(content, rng)
    if rng.random() < 0.03:
        return before + b"[" * 100_000 + after
    places = list(_places(whole))
    if not places:
        return _flip(content, rng)
    holder, key = places[int(rng.integers(len(places)))]
    if rng.random() < 0.15 and isinstance(holder, dict):
        del holder[key]
    else:
        holder[key] = VALUES[int(rng.integers(len(VALUES)))]
    return before + json.dumps(whole).encode() + after


def _places(value: Any) -> list[tuple[Any, Any]]:
    found: list[tuple[Any, Any]] = []
    keys = list(value) if isinstance(value, dict) else range(len(value)) if isinstance(value, list) else ()
    for key in keys:
        found.append((value, key))
        found += _places(value[key])
    return found
