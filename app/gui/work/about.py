"""What the program and its packages are, for licences and bug reports."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from importlib.metadata import Distribution, PackageNotFoundError, distribution, metadata
from typing import Final

from app.runs.system_info import basics

NAME: Final = "vesselsplat"
FONTS: Final = (("Roboto", "Apache-2.0"), ("Font Awesome", "OFL-1.1"))
LONGEST: Final = 60
"""Characters of a licence's name; beyond, it is a whole text."""


@dataclass(frozen=True)
class Package:
    name: str
    version: str
    licence: str


@dataclass(frozen=True)
class About:
    """The program, its packages, and the machine as far as errors may depend on it."""

    purpose: str
    version: str
    licence: str
    facts: tuple[tuple[str, str], ...]
    packages: tuple[Package, ...]

    @property
    def report(self) -> str:
        """For a bug report: no name of a person, a file or a machine."""
        lines = [f"VesselSplat {self.version}", *(f"{name}: {text}" for name, text in self.facts)]
        return "\n".join([*lines, *(f"{one.name} {one.version}" for one in self.packages if one.version)])


def read_about(graphics: str) -> Iterator[About]:
    """`graphics`: what the window knows of its own."""
    told, facts = metadata(NAME), basics()
    machine = (
        ("System", str(facts["system"])),
        ("Python", str(facts["python"])),
        ("CPU cores", str(facts["cores"])),
        ("Graphics", graphics),
    )
    fonts = [Package(name, "", licence) for name, licence in FONTS]
    licence = str(told["License-Expression"] or told["License"] or "")
    yield About(str(told["Summary"]), str(facts["version"]), licence, machine, (*_packages(), *fonts))


def _packages() -> Iterator[Package]:
    """Those that it needs and that are there, without those of its extras."""
    for wanted in distribution(NAME).requires or ():
        if "extra ==" in wanted:
            continue
        try:
            found = distribution(re.split(r"[^\w.-]", wanted, maxsplit=1)[0])
        except PackageNotFoundError:
            continue
        yield Package(str(found.metadata["Name"]), found.version, licence_of(found))


def licence_of(package: Distribution) -> str:
    """By its own words, in short."""
    told = package.metadata
    classified = [
        line.rsplit(" :: ", 1)[-1]
        for line in told.get_all("Classifier") or ()
        if line.startswith("License ::") and not line.endswith("OSI Approved")
    ]
    words = str(told["License-Expression"] or told["License"] or "")
    if words and "\n" not in words and len(words) <= LONGEST:
        return words
    return ", ".join(classified) or "see its own files"
