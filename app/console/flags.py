"""Flags made from the fields of parameter dataclasses: name, type, range and text from one source."""

from __future__ import annotations

import argparse
import math
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Literal, TypeVar, cast, get_args, get_origin

from annotated_types import Interval, Unit
from pydantic import ValidationError
from pydantic.fields import FieldInfo
from pydantic_core import ErrorDetails

from app.errors import UserError
from renderer.readers.lenses.calibration import Calibration

AUTO = "auto"
LONGEST = 120
"""Characters of a wrong value that are shown."""
KINDS = r"str|bool|int|float|list\[.*"
"""How pydantic names those of a value that may be of several."""


T = TypeVar("T")


def add_fields(parser: argparse._ActionsContainer, kind: type[Any], names: Sequence[str]) -> None:
    """Add a flag for each named field of the pydantic dataclass `kind`: --d-factor for d_factor.

    Values stay text until `parameters` hands them to the dataclass, so that it alone validates.
    """
    for name in names:
        field = _fields(kind)[name]
        flag = f"--{name.replace('_', '-')}"
        options = _options(field.annotation)
        parser.add_argument(flag, dest=name, default=argparse.SUPPRESS, help=_help(field), **options)


def parameters(kind: type[T], flags: argparse.Namespace, spelled: Mapping[str, str] | None = None) -> T:
    """`kind` built from the flags that were given and its own defaults.

    `spelled` has the flags of fields that are not called as their flag.

    Raises:
        UserError: a value that the dataclass refuses; the line names the flag.
    """
    known = _fields(kind)
    given = {name: meant(kind, name, text) for name, text in vars(flags).items() if name in known}
    try:
        return kind(**given)
    except ValidationError as error:
        flag_of = {name: f"--{name.replace('_', '-')}" for name in known} | dict(spelled or {})
        raise UserError(problem(error, flag_of)) from error


def refuse(flags: argparse.Namespace, absent: Mapping[str, object], beside: str) -> None:
    """`absent`: what flags are where they are not given. Raises UserError: one is, without effect beside
    another."""
    for name, value in absent.items():
        if getattr(flags, name) != value:
            raise UserError(f"--{name.replace('_', '-')} has no effect with {beside}")


def problem(error: ValidationError, flag_of: Mapping[str, str] | None = None) -> str:
    """The first thing wrong, in one line: which field or flag, what was expected, what came."""
    first, at = _first(error)
    wanted = first["msg"].replace("Value error, ", "").replace(" after validation", "")
    wanted = re.sub(r"^\w+ should (be|have)", "expected", wanted)
    wanted = re.sub(r", unable to parse .*", "", wanted)
    if not first["loc"]:
        return wanted if flag_of else f"{error.title}: {wanted}"
    shown = flag_of[str(at[0])] if flag_of else ".".join(map(str, at))
    if first["type"] == "missing":  # What came is all that stands beside it.
        return f"expected {shown}, got none"
    if first["type"] == "unexpected_keyword_argument":
        wanted = "expected nothing of this name"
    if isinstance(first["input"], Path):  # What is wrong is said of its content.
        return f"{shown}: {wanted}"
    return f"{shown}: {wanted}, got {shortened(first['input'])}"


def _first(error: ValidationError) -> tuple[ErrorDetails, tuple[int | str, ...]]:
    """The first mistake and its place. A value that may be of several kinds is refused once as each, with the
    kind behind its place: what counts is the kind that it is."""
    errors = error.errors(include_url=False, include_context=False)
    first, place = errors[0], errors[0]["loc"]
    if len(place) < 2 or not re.fullmatch(KINDS, str(place[-1])):
        return first, place
    each = [one for one in errors if one["loc"][:-1] == place[:-1]]
    return next((one for one in each if not one["type"].endswith("_type")), first), place[:-1]


def shortened(given: object) -> str:
    """As Python writes it, cut where it is long: a file may hold anything."""
    try:
        text = repr(given)
    except ValueError:  # In hexadecimal, whole numbers are read that are too long to be written.
        text = "a number of thousands of digits"
    return text if len(text) <= LONGEST else f"{text[:LONGEST]}…"


def positive(text: str) -> float:
    """The finite number above 0 that a flag is given. Raises ArgumentTypeError."""
    try:
        number = float(text)
    except ValueError:
        number = math.nan
    if not 0 < number < math.inf:
        raise argparse.ArgumentTypeError(f"expected a number above 0, got {text!r}")
    return number


def _fields(kind: Any) -> dict[str, FieldInfo]:
    fields: dict[str, FieldInfo] = kind.__pydantic_fields__
    return fields


def meant(kind: type[Any], name: str, given: Any) -> Any:
    """The value given for a field, ready for the dataclass: `auto` is None where the field takes that, one
    number of several may stand alone."""
    parts = _alternatives(_fields(kind)[name].annotation)
    if given in (AUTO, [AUTO]) and type(None) in parts:
        return None
    alone = isinstance(given, list) and len(given) == 1 and float in parts
    return given[0] if alone else given


def _options(hint: Any) -> dict[str, Any]:
    """How argparse reads a field of this type."""
    parts = _alternatives(hint)
    if bool in parts:
        return {"action": argparse.BooleanOptionalAction}
    several = any(get_origin(part) is tuple for part in parts)
    if Calibration in parts:
        return {"metavar": "FILE", "type": Path}
    if choices := _choices(hint):
        return {"metavar": "NAME", "nargs": "+"} if several else {"metavar": "|".join(choices)}
    number = "F" if float in parts else "N"
    metavar = f"{AUTO}|{number}" if type(None) in parts else number
    return {"metavar": metavar, "nargs": "+"} if several else {"metavar": metavar}


def _alternatives(hint: Any) -> list[Any]:
    """The plain types of a union, without their annotations."""
    if hasattr(hint, "__metadata__"):
        return _alternatives(hint.__origin__)
    if get_origin(hint) is None or get_origin(hint) in (tuple, Literal):
        return [hint]
    return [plain for part in get_args(hint) for plain in _alternatives(part)]


def _choices(hint: Any) -> list[str]:
    """The words that a field takes, one or several of them."""
    inner = [get_args(part)[0] if get_origin(part) is tuple else part for part in _alternatives(hint)]
    return [str(value) for part in inner if get_origin(part) is Literal for value in get_args(part)]


def _help(field: FieldInfo) -> str:
    parts = [" ".join((field.description or "").split())]
    if isinstance(field.default, tuple) and (choices := _choices(field.annotation)):
        parts.append(f"[{', '.join(choices)}]")
    for mark in dict.fromkeys([*field.metadata, *marks(field.annotation)]):
        if isinstance(mark, Interval):
            parts.append(f"[{mark.ge} to {mark.le}]")
        elif isinstance(mark, Unit):
            parts.append(f"in {mark.unit}")
    default = field.default if isinstance(field.default, tuple) else (field.default,)
    if default and Calibration not in _alternatives(field.annotation):
        parts.append("default " + " ".join(AUTO if value is None else str(value) for value in default))
    return " ".join(part for part in parts if part).replace("%", "%%")


def highest(kind: type[Any], name: str) -> float:
    """The highest value of a field that has one."""
    field = _fields(kind)[name]
    found = (*field.metadata, *marks(field.annotation))
    return next(float(cast(float, mark.le)) for mark in found if isinstance(mark, Interval))


def marks(hint: Any) -> list[Any]:
    """What is annotated anywhere within a type: its ranges and units."""
    inner = [mark for part in get_args(hint) for mark in marks(part)]
    return [*getattr(hint, "__metadata__", ()), *inner]
