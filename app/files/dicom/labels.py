"""All that a derived VL Endoscopic Image or Video Endoscopic Image says beside its pixels (DICOM PS3.3)."""

from __future__ import annotations

import uuid
from importlib.metadata import version
from typing import TYPE_CHECKING, Final, Literal

from app.files.dicom.choices import DicomChoices
from app.files.dicom.sources import PERSON, Sources
from app.files.provenance import NOTICE

if TYPE_CHECKING:
    from pydicom import Dataset

Kind = Literal["still", "video"]
CLASSES: Final = {"still": "1.2.840.10008.5.1.4.1.1.77.1.1", "video": "1.2.840.10008.5.1.4.1.1.77.1.1.1"}
"""UIDs of VL Endoscopic Image Storage and Video Endoscopic Image Storage."""
NAME, NUMBER = "ANONYMOUS^PATIENT", "ANONYMOUS"
PROFILE: Final = "DICOM PS3.15 Basic Application Confidentiality Profile"
LONGEST: Final = 1024
"""Characters of a description."""
CREATOR, GROUP = "VESSELSPLAT", 0x0099
"""Of the private element that carries the record."""


def labelled(kind: Kind, sources: Sources, choices: DicomChoices, description: str, facts: str) -> Dataset:
    """An object without pixels; `facts` is its record as JSON, in ASCII.

    Raises UserError: identity is to be kept, and there is none.
    """
    from pydicom import Dataset
    from pydicom.dataset import FileMetaDataset
    from pydicom.uid import UID, ExplicitVRLittleEndian

    made = Dataset()
    made.SpecificCharacterSet = "ISO_IR 192"
    made.SOPClassUID, made.SOPInstanceUID = UID(CLASSES[kind]), _new_uid()
    made.file_meta = FileMetaDataset()
    made.file_meta.TransferSyntaxUID = ExplicitVRLittleEndian
    made.file_meta.MediaStorageSOPClassUID = made.SOPClassUID
    made.file_meta.MediaStorageSOPInstanceUID = made.SOPInstanceUID
    _person(made, sources, choices)
    _making(made, sources)
    _origin(made, sources, choices, description)
    _region(made, sources)
    block = made.private_block(GROUP, CREATOR, create=True)
    block.add_new(0x01, "UT", facts)
    return made


def _person(made: Dataset, sources: Sources, choices: DicomChoices) -> None:
    """Patient and study: those of the source, or nobody's by the profile."""
    for name in ("PatientBirthDate", "PatientSex", "StudyDate", "StudyTime", "StudyID", "AccessionNumber"):
        setattr(made, name, "")
    made.ReferringPhysicianName = ""
    if choices.keep_identity:
        told = sources.require_identity()
        for name in PERSON:
            if name in told:
                setattr(made, name, told[name].value)
        return
    made.PatientName, made.PatientID = NAME, NUMBER
    made.PatientIdentityRemoved = "YES"
    made.DeidentificationMethod = PROFILE
    made.DeidentificationMethodCodeSequence = [code("113100", "Basic Application Confidentiality Profile")]
    made.LongitudinalTemporalInformationModified = "REMOVED"


def _making(made: Dataset, sources: Sources) -> None:
    """Series and equipment."""
    made.Modality = "ES"
    told = sources.first
    made.SeriesNumber = 1
    made.InstanceNumber = 1 if told is None else told.get("InstanceNumber", 1)
    made.SeriesDescription = "Enhanced by VesselSplat"
    made.Manufacturer = made.ManufacturerModelName = "VesselSplat"
    made.SoftwareVersions = version("vesselsplat")


def _origin(made: Dataset, sources: Sources, choices: DicomChoices, description: str) -> None:
    """What it was made of, and how."""
    keep, told = choices.keep_identity, sources.first
    study = None if told is None else told.get("StudyInstanceUID")
    series = None if told is None else told.get("SeriesInstanceUID")
    made.StudyInstanceUID = _new_uid() if not study else study if keep else _other_uid(study)
    # Those that are made of one series are one series of their own.
    made.SeriesInstanceUID = _other_uid(f"{series} enhanced") if series else _new_uid()
    made.ImageType = ["DERIVED", "SECONDARY"]
    made.PatientOrientation = None
    made.AcquisitionContextSequence = []
    made.DerivationDescription = description[:LONGEST]
    made.DerivationCodeSequence = [code("113086", "Edge enhancement")]
    made.ImageComments = NOTICE
    made.BurnedInAnnotation = "YES" if may_tell(sources, choices) else "NO"
    made.LossyImageCompression = {True: "01", False: "00", None: None}[sources.was_lossy]
    if references := [_reference(one, keep) for one in sources.told]:
        made.SourceImageSequence = references


def _region(made: Dataset, sources: Sources) -> None:
    """What the source says; where nothing is known, the body: without it a side has to be told."""
    told = sources.first
    made.AnatomicRegionSequence = [code("38266002", "Entire body", "SCT")]
    for name in ("AnatomicRegionSequence", "Laterality"):
        if told is not None and told.get(name):
            setattr(made, name, told[name].value)


def may_tell(sources: Sources, choices: DicomChoices) -> bool:
    """Whether text in the pictures may tell who it is: so, unless somebody says that it does not."""
    said = sources.burned_in if choices.burned_in is None else choices.burned_in
    return said is not False


def _reference(told: Dataset, keep: bool) -> Dataset:
    from pydicom import Dataset

    one = Dataset()
    own = str(told.get("SOPInstanceUID", ""))
    one.ReferencedSOPClassUID = told.get("SOPClassUID")
    one.ReferencedSOPInstanceUID = own if keep else _other_uid(own)
    one.PurposeOfReferenceCodeSequence = [code("121322", "Source image for image processing operation")]
    return one


def code(value: str, meaning: str, scheme: str = "DCM") -> Dataset:
    """One of DICOM's own, or of another scheme."""
    from pydicom import Dataset

    one = Dataset()
    one.CodeValue, one.CodingSchemeDesignator, one.CodeMeaning = value, scheme, meaning
    return one


def _new_uid() -> str:
    return f"2.25.{uuid.uuid4().int}"


def _other_uid(own: str) -> str:
    """In place of a UID that tells where it comes from: the same for the same, as the profile asks."""
    return f"2.25.{uuid.uuid5(uuid.NAMESPACE_OID, own).int}"
