"""Where the sources of an exported file lie now: known by name, recognised by their bytes."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from pathlib import Path, PurePosixPath

from pydantic import ConfigDict
from pydantic.dataclasses import dataclass

from app.errors import UserError
from app.files.provenance import digests
from app.runs.run_folder import RunFolder
from assets import phantom_path


@dataclass(frozen=True, config=ConfigDict(extra="ignore"))
class Named:
    """A file or folder, as provenance names it."""

    name: str
    sha256: str


@dataclass(frozen=True, config=ConfigDict(extra="ignore"))
class NamedRun:
    """A run folder, as provenance names it."""

    name: str
    model_sha256: str | None
    """None: the model was still being trained."""


@dataclass(frozen=True)
class Sources:
    """Looks for them beside the file, in the current folder, and where it is told to."""

    file: Path
    given: tuple[Path, ...] = ()

    def find(self, named: Named) -> Path:
        """The file or folder with these bytes. Raises UserError: missing, or its bytes have changed."""
        return self._found(named.name, named.sha256, digests)

    def find_run(self, run: NamedRun) -> RunFolder:
        """The run with this model. Raises UserError: missing, with another model, or never finished."""
        if run.model_sha256 is None:
            raise UserError(f"{self.file.name} shows {run.name} during training: that model no longer exists")
        return RunFolder(self._found(run.name, run.model_sha256, _digests_of_model))

    def _found(self, name: str, sha256: str, digests_of: Callable[[Path], Iterable[str]]) -> Path:
        candidates = list(dict.fromkeys(path.absolute() for path in self._candidates(name)))
        for path in candidates:
            if sha256 in digests_of(path):
                return path
        if not candidates and not _is_bare(name):
            said = f"{self.file.name} names its source by a path, {name}"
            raise UserError(f"{said}, which is not looked up: give it with --source")
        if not candidates:
            raise UserError(
                f"expected the source {name} beside {self.file.name}, in the current folder or "
                "given with --source, "
                "found none"
            )
        shown = candidates[0]
        raise UserError(
            f"the source has changed since {self.file.name} was made: expected SHA-256 {sha256[:12]}…, "
            f"got {next(iter(digests_of(shown)))[:12]}…: {shown}"
        )

    def _candidates(self, name: str) -> Iterator[Path]:
        """What is there under this name; a source that is given may have another one."""
        bare = PurePosixPath(name.replace("\\", "/")).name
        for path in self.given:
            yield path / bare if bare and (path / bare).exists() else path
        if not _is_bare(name):
            return
        for folder in (self.file.absolute().parent, Path.cwd(), phantom_path().parent):
            path = folder / name
            if (path.is_file() or path.is_dir()) and path != self.file.absolute() and _lies_in(path, folder):
                yield path


def _is_bare(name: str) -> bool:
    """Whether it is a name, as provenance holds: a path might lead anywhere, and the file may be anyone's."""
    return name not in ("", ".", "..") and not any(sign in name for sign in "/\\\0")


def _lies_in(path: Path, folder: Path) -> bool:
    """Whether a link leads out of the folder; where one is meant, --source says so."""
    return path.resolve().is_relative_to(folder.resolve())


def _digests_of_model(path: Path) -> Iterable[str]:
    run = RunFolder(path)
    return digests(run.model_path) if run.is_finished else ("no finished run",)
