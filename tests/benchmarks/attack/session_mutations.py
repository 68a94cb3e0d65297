"""Damage to a session, the same for the same seed: mostly values at and beyond the ends of what is taken."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Any

import numpy as np

from tests.benchmarks.attack.mutations import VALUES, mutated

NUMBERS: tuple[Any, ...] = (
    0, -0.0, 1, -1, 0.05, 0.02, 1e-9, 1e-30, 0.5, 0.999999, 1.0000001, 2, 3, 4, 5, 12, 13, 40, 41, 50, 255,
    512, 2**15, 2**31 - 1, 2**31, -(2**31), 2**53, 2**63, 2**64, 10**30, 10**400, 1e5, 1e6, 1e15, 1e30, 3e38,
    4e38, 1e300, 1.7e308, -1e5, -1e30, -1e300,
)  # fmt: skip
SOURCES = ("source", "run")
"""Without which there is nothing to take up: seldom damaged."""
LONG = 100_000
Place = tuple[Any, Any]
Change = Callable[[Place, list[Place], np.random.Generator], None]


def damaged_session(content: bytes, seed: int) -> bytes:
    """Bytes, or one to four values, chosen and placed by `seed`."""
    rng = np.random.default_rng(seed)
    if rng.random() < 0.2:
        return mutated(content, seed)
    told = json.loads(content)
    for _ in range(int(rng.integers(1, 5))):
        places = _places(told, seldom=rng.random() < 0.9)
        if not places:
            break
        _chosen(CHANGES, rng)(_chosen(places, rng), places, rng)
    return json.dumps(told).encode()


def _number(place: Place, places: list[Place], rng: np.random.Generator) -> None:
    """A number is another one, or text is."""
    numbers = [(holder, key) for holder, key in places if isinstance(holder[key], int | float)]
    holder, key = _chosen(numbers, rng) if numbers else place
    holder[key] = _chosen(NUMBERS, rng)


def _close(place: Place, places: list[Place], rng: np.random.Generator) -> None:
    """A number is moved by an order of magnitude or less, so that most are still taken."""
    numbers = [(holder, key) for holder, key in places if isinstance(holder[key], float)]
    holder, key = _chosen(numbers, rng) if numbers else place
    if isinstance(holder[key], float):
        holder[key] = float(holder[key] * rng.choice([-1, 0, 0.1, 0.5, 0.9, 1.1, 2, 10]))


def _camera(place: Place, places: list[Place], rng: np.random.Generator) -> None:
    """A lens, a size or a position, within what a camera may have and a little beyond."""
    cameras = [holder[key] for holder, key in places if isinstance(holder[key], dict) and "fx" in holder[key]]
    if not cameras:
        return
    camera = _chosen(cameras, rng)
    for _ in range(int(rng.integers(1, 4))):
        name = _chosen(("fx", "fy", "cx", "cy", "width", "height", "camera_from_world"), rng)
        if name == "camera_from_world":
            row, column = int(rng.integers(3)), 3 if rng.random() < 0.7 else int(rng.integers(4))
            camera[name][row][column] = _signed(rng, -3, 16) if column == 3 else _signed(rng, -6, 0.2)
        elif name in ("width", "height"):
            camera[name] = int(10 ** rng.uniform(0, 5))
        else:
            camera[name] = abs(_signed(rng, -4, 10)) if name.startswith("f") else _signed(rng, 0, 16)


def _signed(rng: np.random.Generator, least: float, most: float) -> float:
    return float(10 ** rng.uniform(least, most) * rng.choice([-1, 1]))


def _other_type(place: Place, places: list[Place], rng: np.random.Generator) -> None:
    holder, key = place
    holder[key] = _chosen(VALUES, rng)


def _removed(place: Place, places: list[Place], rng: np.random.Generator) -> None:
    holder, key = place
    del holder[key]


def _another(place: Place, places: list[Place], rng: np.random.Generator) -> None:
    """The value of another place."""
    holder, key = place
    other, at = _chosen(places, rng)
    holder[key] = json.loads(json.dumps(other[at]))


def _huge(place: Place, places: list[Place], rng: np.random.Generator) -> None:
    holder, key = place
    item = _chosen((0, "x", [], {}, None, 0.5, holder[key]), rng)
    content = len(json.dumps(item))
    holder[key] = _chosen(([item] * (5_000_000 // max(content, 50)), "x" * LONG, "x\n" * LONG), rng)


def _nested(place: Place, places: list[Place], rng: np.random.Generator) -> None:
    holder, key = place
    for _ in range(int(_chosen((3, 50, 90), rng))):
        holder[key] = [holder[key]] if rng.random() < 0.5 else {"x": holder[key]}


def _repeated(place: Place, places: list[Place], rng: np.random.Generator) -> None:
    """A list holds all of it many times."""
    lists = [(holder, key) for holder, key in places if isinstance(holder[key], list)]
    holder, key = _chosen(lists, rng) if lists else place
    if isinstance(holder[key], list):
        holder[key] = holder[key] * int(_chosen((2, 3, 60, 700), rng))


CHANGES: tuple[Change, ...] = (
    _number, _number, _number, _number, _close, _close, _camera, _camera, _camera, _other_type, _removed,
    _another, _huge, _nested, _repeated,
)  # fmt: skip


def _places(told: Any, *, seldom: bool) -> list[Place]:
    """Every value and what holds it; those of the sources only where they are not `seldom` wanted."""
    found: list[Place] = []
    keys = (
        list(told) if isinstance(told, dict) else range(min(len(told), 50)) if isinstance(told, list) else ()
    )
    for key in keys:
        if not (seldom and key in SOURCES):
            found += [(told, key), *_places(told[key], seldom=False)]
    return found


def _chosen(from_: Any, rng: np.random.Generator) -> Any:
    return from_[int(rng.integers(len(from_)))]
