"""Every command that writes, twice with other parameters, and what its files are told apart by."""

from __future__ import annotations

import csv
import hashlib
import json
import os
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np

from app.files.image_files import read_image

Which = Literal["old", "new"]
Prints = dict[str, str]
"""Of files, by their names within a folder."""
VOLATILE = ("created", "utc", "seconds", "milliseconds", "ms", "wall", "time_", "date", "memory")
"""Parts of names of facts that differ from run to run."""


@dataclass(frozen=True)
class Writer:
    """`arguments` of seeds, an output folder and which of two sets of parameters."""

    name: str
    arguments: Callable[[Path, Path, Which], list[str]]
    fresh: bool = False
    """It writes into a folder of its own, which must be new."""
    goes_on: tuple[str, ...] = ()
    """Flags with which it is gone on with after it was cut off."""


def command(seeds: Path, out: Path, writer: Writer, which: Which) -> list[str]:
    return [sys.executable, "-m", "app", *writer.arguments(seeds, out, which)]


def run(words: list[str], folder: Path, seconds: float = 300) -> subprocess.CompletedProcess[str]:
    """To its end."""
    return subprocess.run(
        words, cwd=folder, env=environment(), capture_output=True, text=True, timeout=seconds, check=False,
        errors="replace",
    )  # fmt: skip


def environment() -> dict[str, str]:
    return os.environ | {"PYTHONPATH": str(Path(__file__).resolve().parents[3])}


def prints(folder: Path) -> Prints:
    """Fingerprints of all files that a person sees: of pixels, of facts without times, else of bytes."""
    return {
        path.relative_to(folder).as_posix(): _print_of(path)
        for path in sorted(folder.rglob("*"))
        if path.is_file() and not _is_hidden(path.relative_to(folder))
    }


def hidden(folder: Path) -> list[str]:
    """Names that begin with a dot, or end as partial files do."""
    found = (path.relative_to(folder) for path in sorted(folder.rglob("*")))
    return [path.as_posix() for path in found if _is_hidden(path) or path.name.endswith(".partial")]


def _is_hidden(path: Path) -> bool:
    return any(part.startswith(".") for part in path.parts)


def _print_of(path: Path) -> str:
    if path.suffix in (".json", ".jsonl"):
        texts = path.read_text().splitlines() if path.suffix == ".jsonl" else [path.read_text()]
        return _digest(json.dumps([_steady(json.loads(text)) for text in texts], sort_keys=True).encode())
    if path.suffix == ".csv":
        rows = list(csv.DictReader(path.read_text().splitlines()))
        return _digest(json.dumps(_steady(rows)).encode())
    if path.suffix in (".png", ".tiff"):
        return _digest(np.ascontiguousarray(read_image(path)).tobytes())
    return _digest(path.read_bytes())


def _steady(facts: Any) -> Any:
    if isinstance(facts, dict):
        kept = {name: value for name, value in facts.items() if not any(each in name for each in VOLATILE)}
        return {name: _steady(value) for name, value in kept.items()}
    return [_steady(one) for one in facts] if isinstance(facts, list) else facts


def _digest(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()[:16]


def _enhance(source: str, target: str) -> Callable[[Path, Path, Which], list[str]]:
    def arguments(seeds: Path, out: Path, which: Which) -> list[str]:
        amount = "0.5" if which == "old" else "2"
        return ["enhance", str(seeds / source), str(out / target), "--d-factor", amount]

    return arguments


def _of_run(name: str, *flags: str) -> Callable[[Path, Path, Which], list[str]]:
    """The two models are of two runs."""

    def arguments(seeds: Path, out: Path, which: Which) -> list[str]:
        run = seeds / ("vesselsplat" if which == "old" else "deform3dgs")
        return [name, str(run), *(flag.replace("OUT", str(out)) for flag in flags)]

    return arguments


def _cameras(seeds: Path, out: Path, which: Which) -> list[str]:
    few = ["--frames", "0"] if which == "old" else []
    return ["export", str(seeds / "vesselsplat"), "--cameras", str(out / "cameras.json"), *few]


def _tune(seeds: Path, out: Path, which: Which) -> list[str]:
    values = "0,1" if which == "old" else "0,2"
    return ["tune", str(seeds / "picture.png"), "--out", str(out), "--vary", f"d_factor={values}"]


def _phantom(seeds: Path, out: Path, which: Which) -> list[str]:
    return ["phantom", str(out / "phantom"), "--frames", "4", "--size", "64", "48"]


def _train(method: str) -> Callable[[Path, Path, Which], list[str]]:
    def arguments(seeds: Path, out: Path, which: Which) -> list[str]:
        flags = ["--iterations", "60", "--method", method]
        return ["train", str(seeds / "endonerf"), "--run", str(out / "run"), *flags]

    return arguments


WRITERS = (
    Writer("enhance a picture", _enhance("picture.png", "a.tiff")),
    Writer("enhance a folder", _enhance("endonerf/images", "")),
    Writer("enhance a video", _enhance("export.mp4", "a.mp4")),
    Writer("tune", _tune),
    Writer("render", _of_run("render", "--out", "OUT", "--view", "depth")),
    Writer("export a video", _of_run("export", "--video", "OUT/a.mp4")),
    Writer("export splats", _of_run("export", "--ply", "OUT")),
    Writer("export cameras", _cameras),
    Writer("phantom", _phantom, fresh=True),
    Writer("train", _train("vesselsplat"), fresh=True, goes_on=("--resume",)),
    Writer("train deform3dgs", _train("deform3dgs"), fresh=True, goes_on=("--resume",)),
)
