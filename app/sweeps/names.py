"""Names of settings in the file of a sweep: written as the flags are, or as the settings are."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TypeVar

from pydantic import AfterValidator

T = TypeVar("T")


def name_of(written: str) -> str:
    """Of a setting: `n_gaussians` of `n-gaussians`."""
    return written.replace("-", "_")


def names_of(written: Iterable[str]) -> tuple[str, ...]:
    """Of settings, each once."""
    return tuple(dict.fromkeys(map(name_of, written)))


def _by_name(given: Mapping[str, T]) -> dict[str, T]:
    """Raises ValueError: one setting is there in both spellings."""
    named: dict[str, T] = {}
    for written, value in given.items():
        if name_of(written) in named:
            raise ValueError(f"expected {name_of(written)} once")
        named[name_of(written)] = value
    return named


BY_NAME = AfterValidator(_by_name)
"""Of a dictionary that names settings: its keys are those of the settings."""
