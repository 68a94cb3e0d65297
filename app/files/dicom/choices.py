"""What a person decides of a DICOM object that is written."""

from __future__ import annotations

from pydantic.dataclasses import dataclass

from app.files.records import LENIENT, Record


@dataclass(frozen=True, kw_only=True, config=LENIENT)
class DicomChoices(Record):
    """By default nothing tells whose pictures they are but, perhaps, text in them."""

    keep_identity: bool = False
    """Of the source, which has to be DICOM: patient, study and its UIDs."""
    burned_in: bool | None = None
    """Whether text in the pictures may tell who it is; None: as the source says, else that it may."""


DEIDENTIFIED = DicomChoices()
