"""What a person is asked to choose in a dialog, and for what. A part of the state."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Final, Literal

from app.gui.session_file import SUFFIX
from renderer.readers.dicom.opening import SUFFIXES as DICOM
from renderer.readers.image_files.coded_picture import CODED
from renderer.readers.image_files.file_kinds import RARER_VIDEOS, SUFFIXES, VIDEOS
from renderer.splat_files import SUFFIXES as SPLATS

Kind = Literal["folder", "file", "save"]
"""An existing folder, an existing file, or a file to be written."""
Purpose = Literal[
    "folder",
    "file",
    "run",
    "splats",
    "views",
    "inputs",
    "results",
    "export",
    "session",
    "picture",
    "masks",
    "network",
    "calibration",
]
"""Each remembers its own folder."""


@dataclass(frozen=True)
class Filter:
    """Which files are listed."""

    label: str
    suffixes: tuple[str, ...] = ()
    """Empty: all."""

    def passes(self, path: Path) -> bool:
        return not self.suffixes or path.suffix.lower() in self.suffixes


@dataclass(frozen=True)
class Question:
    """A dialog, in words."""

    title: str
    filters: tuple[Filter, ...] = ()
    """The first is in force at first."""
    keeps_itself: bool = False
    """The chosen folder is where the next such dialog begins, not the one that it is in."""
    takes_files: bool = False
    """Of folders: a file opens as well where its path is typed."""

    @property
    def verb(self) -> str:
        """What is done with what is chosen; its button says it, too."""
        return self.title.split()[0]


ALSO_READ: Final = (".apng", *sorted(RARER_VIDEOS))
"""Rarer names of what the reader of videos opens."""
ALL: Final = Filter("All files")
IMAGES: Final = Filter("Images", (*sorted(SUFFIXES | CODED), ".npy"))
VIDEO: Final = Filter("Videos", tuple(sorted(VIDEOS | DICOM)))
PICTURED: Final = Filter("Images and videos", (*IMAGES.suffixes, *sorted(VIDEOS)))
MODELS: Final = Filter("Splat files", SPLATS)
SAVED: Final = Filter("Saved images", (".png", ".jpg", ".jpeg"))
SESSIONS: Final = Filter("Sessions", (SUFFIX,))
NETWORKS: Final = Filter("ONNX networks", (".onnx",))
CALIBRATIONS: Final = Filter("Calibrations", (".yml", ".yaml", ".xml", ".json", ".ini", ".txt"))
VIEWS: Final = Filter("Views and cameras", (".json", ".txt"))
OPENED: Final = Filter(
    "Everything that opens",
    (*PICTURED.suffixes, *ALSO_READ, *MODELS.suffixes, *SESSIONS.suffixes, *VIEWS.suffixes),
)
QUESTIONS: Final[dict[Purpose, Question]] = {
    "folder": Question("Open a folder", takes_files=True),
    "file": Question("Open a file", (OPENED, IMAGES, VIDEO, MODELS, SESSIONS, ALL)),
    "run": Question("Choose a run folder"),
    "splats": Question("Choose a splat file", (MODELS, ALL)),
    "views": Question("Import views or cameras", (VIEWS, ALL)),
    "masks": Question("Choose a folder of tool masks"),
    "network": Question("Choose a network", (NETWORKS, ALL)),
    "calibration": Question("Choose a calibration", (CALIBRATIONS, ALL)),
    "inputs": Question("Add to the list", (PICTURED, IMAGES, VIDEO, ALL)),
    "results": Question("Choose a folder for the results", keeps_itself=True),
    "export": Question("Choose a folder for exports", keeps_itself=True),
    "picture": Question("Add a saved image", (SAVED, ALL)),
    "session": Question("Save the session", (SESSIONS, ALL)),
}


@dataclass(frozen=True, eq=False)
class Choosing:
    """What a person is to choose, and what is done with it."""

    kind: Kind
    then: Callable[[Path], object]
    purpose: Purpose
    start: Path
    """The folder that the dialog begins in."""
    name: str = ""
    """Of a file to be written, as proposed."""

    @property
    def question(self) -> Question:
        return QUESTIONS[self.purpose]
