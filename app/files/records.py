"""What a file says of itself, as typed values: what the records of all kinds of file have in common."""

from __future__ import annotations

from dataclasses import fields
from pathlib import Path
from typing import Annotated, Any, Final, TypeVar

from pydantic import (
    BeforeValidator,
    ConfigDict,
    SerializerFunctionWrapHandler,
    ValidationError,
    ValidatorFunctionWrapHandler,
    WrapValidator,
    model_serializer,
)
from pydantic.dataclasses import dataclass

from app.files.provenance import digest, plain, provenance
from renderer.readers.clip_options import ClipOptions

LENIENT: Final = ConfigDict(extra="ignore")
"""Of the classes of records: what another version may say besides is passed over."""


def _known(given: Any, read: ValidatorFunctionWrapHandler) -> Any:
    try:
        return read(given)
    except ValidationError:
        return None


Told: Final = WrapValidator(_known)
"""Of a field that may be None and that no pixel depends on: what another version has put there otherwise
keeps nobody from making the file again."""


def _as_stored(given: Any) -> Any:
    """Before 0.12.0, 16-bit images that use fewer bits were shown as stored; and before 0.14.0, alpha told
    nothing."""
    return {"bits": 16, "alpha": "ignored"} | given if isinstance(given, dict) else given


RecordedReading = Annotated[ClipOptions, BeforeValidator(_as_stored)]


@dataclass(frozen=True, kw_only=True, config=LENIENT)
class Record:
    """A part of what a file says of itself; what is None by default and in fact is not written."""

    @model_serializer(mode="wrap")
    def _said(self, write: SerializerFunctionWrapHandler) -> dict[str, Any]:
        silent = {field.name for field in fields(self) if field.default is None}
        return {name: value for name, value in write(self).items() if value is not None or name not in silent}

    @property
    def signed(self) -> dict[str, Any]:
        """It below what every export says."""
        return provenance(**plain(self))


Of = TypeVar("Of", bound=Record)


def extended(kind: type[Of], record: Record, **more: Any) -> Of:
    """A record of another kind that says all that `record` does, and more."""
    return kind(**{name: value for name, value in vars(record).items() if name != "kind"} | more)


@dataclass(frozen=True, kw_only=True, config=LENIENT)
class Source(Record):
    """A file or a folder that something was made of."""

    name: str
    """Without the folder that it is in."""
    sha256: str
    """See `app.files.provenance.digest`."""

    @classmethod
    def of(cls, path: Path) -> Source:
        """Raises OSError: it is not there."""
        return cls(name=path.absolute().name, sha256=digest(path))
