"""What a window has written is whole, file by file; and what of its work is still about."""

from __future__ import annotations

import hashlib
import re
import shutil
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import cv2

from app.enhancement.records import EnhancedVideo
from app.errors import UserError
from app.exports.records import EXPORT, Export, MeasuresTable, PanesVideo, ViewVideo
from app.exports.replay.again import replay
from app.files.image_files import read_image
from app.files.provenance import read_provenance
from app.gui.session_file import SUFFIX, mended_session
from app.gui.work.opened_run import request_of
from app.gui.work.presets import OWN
from app.gui.work.settings import SETTINGS
from app.runs.run_folder import RunFolder
from app.runs.train_run import TrainRequest, run_training
from enhance import ImageError
from renderer.clip import ClipError
from tests.benchmarks.attack.writers import hidden

SHARED = Path("/dev/shm")
WITH_RECORD = (".mp4", ".csv")
"""Ends of names of files whose record lies beside them."""
WRONG = (OSError, ValueError, KeyError, UserError, ClipError, ImageError)
"""What a file that is not whole raises."""


def broken(folder: Path) -> Iterator[str]:
    """Of all files below that a person sees, those that are not whole, and what is wrong with them."""
    for path in sorted(folder.rglob("*")):
        name = path.relative_to(folder).as_posix()
        look = _look(path)
        if look is None or path.is_dir() or "/." in f"/{name}":
            continue
        try:
            if wrong := look(path):
                yield f"{_steady(name)}: {wrong}"
        except WRONG as error:
            yield f"{_steady(name)}: {type(error).__name__}: {str(error)[:200]}"


def _steady(name: str) -> str:
    """Without the moment at which it was made, and by which process."""
    return re.sub(r"\d{8}-\d{6}(-\d{3})?|-[0-9a-f]{8}-\d+-[0-9a-f]{8}|-\d+-[0-9a-f]{8}", "*", name)


def _look(path: Path) -> Callable[[Path], str] | None:
    named: dict[str, Callable[[Path], str]] = {"settings.json": _settings, "presets.json": _presets}
    if path.parent.name == "config":
        named_so = named.get(path.name)
        return named_so or (_session if path.suffix == SUFFIX else None)
    if path.parent.parent.name == "runs":
        return None
    kinds: dict[str, Callable[[Path], str]] = {
        ".png": _picture, ".mp4": _recorded, ".csv": _recorded, ".json": _beside, SUFFIX: _session,
    }  # fmt: skip
    return kinds.get(path.suffix)


def _settings(path: Path) -> str:
    SETTINGS.validate_json(path.read_bytes())
    return ""


def _presets(path: Path) -> str:
    OWN.validate_json(path.read_bytes())
    return ""


def _session(path: Path) -> str:
    """Beside a copy: what is damaged would be put aside."""
    copy = Path(shutil.copy(path, path.with_name(f"looked at{SUFFIX}")))
    try:
        return mended_session(copy)[1]
    finally:
        copy.unlink(missing_ok=True)


def _picture(path: Path) -> str:
    read_image(path)
    EXPORT.validate_python(read_provenance(path))
    return ""


def _beside(path: Path) -> str:
    return "" if path.with_suffix("").is_file() else "its file is not there"


def _recorded(path: Path) -> str:
    """It has as many frames, or rows, as its own record says."""
    record = EXPORT.validate_json(path.with_name(f"{path.name}.json").read_bytes())
    said, there = _steps(record), _rows(path) if path.suffix == ".csv" else _frames(path)
    return "" if there == said else f"{there} frames, its JSON says {said}"


def _steps(record: Export) -> int:
    match record:
        case PanesVideo():
            return len(record.frames)
        case MeasuresTable():
            return len(record.frames) * len(record.panes)
        case ViewVideo():
            return len(record.moments)
        case EnhancedVideo():
            return len(record.pictures)
    return -1


def _frames(path: Path) -> int:
    capture = cv2.VideoCapture(str(path))
    count = 0
    while capture.read()[0]:
        count += 1
    capture.release()
    return count


def _rows(path: Path) -> int:
    return sum(1 for line in path.read_text().splitlines() if not line.startswith("#")) - 1


def unlike_its_record(pictures: Path, seeds: Path, scratch: Path) -> Iterator[str]:
    """Of the newest export that has its record beside it: whether the record makes the same once more."""
    exports = sorted(path for path in pictures.glob("*") if path.suffix in WITH_RECORD)
    for path in exports[-1:]:
        try:
            again = replay(path, (seeds / "vesselsplat", seeds / "endonerf"), scratch / f"again{path.suffix}")
        except WRONG as error:
            yield f"cannot be made again: {type(error).__name__}: {str(error)[:200]}"
        else:
            if not again.difference.is_none:
                yield f"made again it is another: {again.sentence}"


def half_enhanced(pictures: Path, wanted: dict[str, int]) -> Iterator[str]:
    """Folders of a batch with some of the pictures alone."""
    for name, count in wanted.items():
        for folder in pictures.glob(f"enhanced-*/{name}"):
            if (there := len(list(folder.glob("*.png")))) not in (0, count):
                yield f"{there} of {count} pictures in {_steady(folder.name)}"


def cannot_go_on(runs: Path, known: list[str]) -> Iterator[str]:
    """Runs that cannot be opened, cannot be gone on with, or end in another model than one never cut off.

    That one's fingerprint is made once, and then known.
    """
    for path in sorted(runs.glob("*")):
        try:
            run = RunFolder(path)
            if not run.is_run:
                yield f"a folder without a run: {[each.name for each in path.iterdir()][:3]}"
                continue
            request = request_of(run, run.record())
            list(run_training(replace(request, resume=True)))
            if not known:
                known.append(_undisturbed(request, path))
            if _model(path) != known[0]:
                yield "the resumed run ends in another model"
            if run.events()[-1]["event"] != "Finished":
                yield "the resumed run's log does not end"
        except WRONG as error:
            yield f"cannot be gone on with: {type(error).__name__}: {str(error)[:200]}"


def _undisturbed(request: TrainRequest, path: Path) -> str:
    beside = path.parent.parent / "undisturbed"
    list(run_training(replace(request, run_path=beside, resume=False)))
    return _model(beside)


def _model(run: Path) -> str:
    return hashlib.sha256(RunFolder(run).model_path.read_bytes()).hexdigest()


def staged(folder: Path) -> list[str]:
    """Names of what is still, or was, being written."""
    return [_steady(name) for name in hidden(folder)]


def shared_memory() -> set[str]:
    """Blocks and semaphores of all processes."""
    return {path.name for path in SHARED.iterdir()} if SHARED.is_dir() else set()


def shared_by(processes: set[int], before: set[str]) -> list[str]:
    """Blocks that bear a number of one of these processes, and semaphores that were not there before."""
    new = shared_memory() - before
    numbered = {name for name in new if processes & {int(number) for number in re.findall(r"\d+", name)}}
    return sorted(numbered | {name for name in new if name.startswith("sem.")})
