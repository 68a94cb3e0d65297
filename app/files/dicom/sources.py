"""What the sources of a DICOM object that is written say of a person, a study and themselves."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Final

from app.errors import UserError
from app.files.image_files import JPEGS
from renderer.clip import ClipError
from renderer.readers.dicom.header import read_dataset
from renderer.readers.dicom.opening import is_dicom, opened_dicom

if TYPE_CHECKING:
    from pydicom import Dataset

PERSON: Final = (
    "PatientName", "PatientID", "IssuerOfPatientID", "PatientBirthDate", "PatientBirthTime", "PatientSex",
    "PatientAge", "PatientSize", "PatientWeight", "EthnicGroup", "PatientComments",
    "PatientIdentityRemoved", "DeidentificationMethod", "DeidentificationMethodCodeSequence",
    "StudyDate", "StudyTime", "StudyID", "StudyDescription", "AccessionNumber", "ReferringPhysicianName",
    "InstitutionName", "InstitutionAddress", "PerformingPhysicianName", "OperatorsName",
    "SeriesDate", "SeriesTime", "AcquisitionDate", "AcquisitionTime", "AcquisitionDateTime",
    "ContentDate", "ContentTime", "BodyPartExamined", "ProtocolName",
)  # fmt: skip
"""Elements that are kept where identity is."""
REFERRED: Final = (
    "SOPClassUID", "SOPInstanceUID", "StudyInstanceUID", "SeriesInstanceUID", "InstanceNumber",
    "AnatomicRegionSequence", "Laterality", "BurnedInAnnotation", "LossyImageCompression",
)  # fmt: skip
LOSSY_SYNTAXES: Final = frozenset(
    {f"1.2.840.10008.1.2.4.{number}" for number in (50, 51, 91, 93, *range(100, 109))}
)


@dataclass(frozen=True, eq=False)
class Sources:
    """The files that a DICOM object is made of."""

    paths: tuple[Path, ...]
    told: tuple[Dataset, ...]
    """Of those that are DICOM objects, their PERSON and REFERRED."""

    @property
    def first(self) -> Dataset | None:
        return self.told[0] if self.told else None

    @property
    def was_lossy(self) -> bool | None:
        """Whether pixels have been compressed with loss before; None: of some nothing tells."""
        by_name = any(path.suffix.lower() in JPEGS for path in self.paths)
        syntaxes = {str(one.file_meta.get("TransferSyntaxUID", "")) for one in self.told}
        if by_name or syntaxes & LOSSY_SYNTAXES or "01" in self._all("LossyImageCompression"):
            return True
        return False if len(self.told) == len(self.paths) else None

    @property
    def burned_in(self) -> bool | None:
        """Whether text in the pictures may tell who it is, by what all of them say; None: they do not."""
        said = self._all("BurnedInAnnotation")
        if "YES" in said:
            return True
        return False if said == {"NO"} and len(self.told) == len(self.paths) else None

    def _all(self, name: str) -> set[str]:
        return {str(one.get(name, "")) for one in self.told}

    def require_identity(self) -> Dataset:
        """The data set of the one source, for its identity. Raises UserError: there is none to keep."""
        if len(self.paths) != 1 or self.first is None:
            files = "several files" if len(self.paths) > 1 else f"{self.paths[0].name}, which is none"
            raise UserError(f"--keep-identity expects one DICOM file as INPUT, got {files}")
        if not str(self.first.get("PatientName", "")) and not str(self.first.get("PatientID", "")):
            raise UserError(f"--keep-identity expects a source with a patient, got none: {self.paths[0]}")
        return self.first


def sources_of(paths: Iterable[Path]) -> Sources:
    """Raises UserError: one of them is a DICOM object whose header is damaged, or pydicom is missing."""
    each = tuple(dict.fromkeys(paths))
    return Sources(each, tuple(_told(path) for path in each if is_dicom(path)))


def _told(path: Path) -> Dataset:
    try:
        with opened_dicom(path) as file:
            told = read_dataset(file, path, (*PERSON, *REFERRED))
            # Values are read now, so that damaged ones are found out here.
            told.decode()
            for element in told:
                str(element.value)
            return told
    except ClipError as error:
        raise UserError(str(error)) from error
