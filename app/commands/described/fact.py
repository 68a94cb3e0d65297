"""One thing that is known of a path, for people and for programs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from app.console.shell import command

WIDTH = 13
"""Of the names at the left of a text."""


@dataclass(frozen=True)
class Fact:
    name: str
    """Words apart, such as "held out"."""
    text: str | tuple[str, ...]
    """For people; several are a line each."""
    value: Any = None
    """For programs; None: the text."""


def as_text(facts: Sequence[Fact]) -> str:
    """Aligned lines."""
    lines = []
    for fact in facts:
        texts = (fact.text,) if isinstance(fact.text, str) else fact.text
        names = (fact.name, *("" for _ in texts[1:]))
        lines += [f"{name:<{WIDTH}}{text}\n" for name, text in zip(names, texts, strict=bool(texts))]
    return "".join(lines)


def as_values(facts: Sequence[Fact]) -> dict[str, Any]:
    """By name, with underscores."""
    return {fact.name.replace(" ", "_"): fact.text if fact.value is None else fact.value for fact in facts}


def next_steps(path: Path, *steps: tuple[str, ...]) -> Fact:
    """The commands that go on from here; "PATH" in a step stands for the path."""
    lines = tuple(command(*(path if word == "PATH" else word for word in step)) for step in steps)
    return Fact("next", lines, list(lines))


def notices(said: Sequence[str]) -> tuple[Fact, ...]:
    """Each once, a line each; nothing where nothing was said."""
    lines = tuple(dict.fromkeys(said))
    return (Fact("notices", lines, list(lines)),) if lines else ()


def made(utc: Any, version: Any) -> Fact:
    """When, and by which version of the program."""
    when = "at an unrecorded time" if utc is None else utc
    return Fact("made", f"{when} by version {version}", {"utc": utc, "version": version})
