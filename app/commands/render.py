"""`vesselsplat render RUN --out DIR`: pictures of a finished run, each with its provenance."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from app.atomic import filled
from app.drawers import drawer
from app.drawing import Drawn, colored_depth
from app.errors import UserError
from app.pictures import write_image
from app.progress import progress
from app.provenance import digest, provenance, write_png
from app.run_folder import RunFolder, RunRecord
from renderer.camera import Camera
from renderer.near_plane import near_plane

MOST_PIXELS = 16384
"""Each way: the largest framebuffer of common graphics cards."""
SPLAT_FILES = frozenset({".ply", ".splat", ".spz", ".sog"})


def add_flags(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("run", metavar="RUN", type=Path, help="folder of a finished run")
    parser.add_argument("--out", type=Path, required=True, metavar="DIR", help="folder to write into")
    parser.add_argument("--frames", nargs="+", metavar="all|test|I", help="frames to draw (default all)")
    parser.add_argument("--time", type=float, metavar="T", help="one moment in [0, 1] in place of frames")
    parser.add_argument("--camera", type=Path, metavar="FILE", help="JSON of the camera to see it from")
    parser.add_argument("--size", type=int, nargs=2, metavar=("W", "H"), help="pixels (default the clip's)")
    parser.add_argument(
        "--with", dest="renderer", choices=("gl", "cpu", "reference"), default="cpu", help="default cpu"
    )
    parser.add_argument("--depth", action="store_true", help="write expected depth too: float32 and coloured")


def run(flags: argparse.Namespace) -> None:
    if flags.run.suffix.lower() in SPLAT_FILES:
        raise UserError(f"expected a run folder; splat files cannot be drawn in this version: {flags.run}")
    folder = RunFolder(flags.run)
    record, model = folder.record(), folder.model()
    moments = list(_moments(flags, record))
    draw, name = drawer(flags.renderer)
    facts = {
        "run": {"name": folder.path.absolute().name, "model_sha256": digest(folder.model_path)},
        "clip": {"name": record.clip.name, "sha256": record.clip.sha256},
        "input": record.input,
        "enhancement": record.enhancement,
        "config": record.config,
        "renderer": name,
        "background": (0.0, 0.0, 0.0),
    }
    with filled(flags.out) as staging, progress("render", len(moments)) as report:
        for done, moment in enumerate(moments, start=1):
            near = near_plane(model, moment.camera)
            drawn = draw(model.at(moment.time), moment.camera, near)
            _write(staging, moment, drawn, facts | moment.facts | {"near": near}, depth=flags.depth)
            report(done, moment.name)
    sys.stdout.write(f"{flags.out}: {len(moments)} pictures drawn with {name}\n")


@dataclass(frozen=True)
class _Moment:
    name: str
    frame: int | None
    time: float
    camera: Camera

    @property
    def facts(self) -> dict[str, Any]:
        return {"frame": self.frame, "time": self.time, "camera": self.camera.to_json()}


def _moments(flags: argparse.Namespace, record: RunRecord) -> Iterator[_Moment]:
    """When and from where to draw. Raises UserError for what the run does not have."""
    fixed = _read_camera(flags.camera) if flags.camera else None
    if flags.time is not None:
        if flags.frames or not 0 <= flags.time <= 1:
            raise UserError(f"expected --time in [0, 1] and then no --frames, got {flags.time}")
        nearest = min(round(flags.time * record.clip.frames), record.clip.frames - 1)
        camera = _resized(fixed or record.camera(nearest), flags.size)
        yield _Moment(f"time-{flags.time:.4f}", None, flags.time, camera)
        return
    for index in _indices(flags.frames or ["all"], record):
        camera = _resized(fixed or record.camera(index), flags.size)
        yield _Moment(f"frame-{index:06d}", index, record.time(index), camera)


def _indices(frames: list[str], record: RunRecord) -> Sequence[int]:
    count = record.clip.frames
    if frames == ["all"]:
        return range(count)
    if frames == ["test"]:
        if not record.test_indices:
            raise UserError(f"--frames test: a clip of {count} frame holds none out, use --frames all")
        return record.test_indices
    for text in frames:
        if not text.isdecimal() or int(text) >= count:
            raise UserError(f"--frames: expected all, test or numbers from 0 to {count - 1}, got {text!r}")
    return [int(text) for text in frames]


def _read_camera(path: Path) -> Camera:
    try:
        return Camera.from_json(json.loads(path.read_text(encoding="utf-8")))
    except OSError as error:
        raise UserError(f"expected a camera file, {error.strerror}: {path}") from error
    except ValueError as error:
        raise UserError(f"expected the JSON of a camera, got {error}: {path}") from error


def _resized(camera: Camera, size: list[int] | None) -> Camera:
    """Raises UserError for a size, of the flag or the camera file, that no renderer draws."""
    width, height = size or (camera.width, camera.height)
    if min(width, height) < 1 or max(width, height) > MOST_PIXELS:
        raise UserError(f"--size: expected 1 to {MOST_PIXELS} pixels each way, got {width} {height}")
    return camera.resized(width, height) if size else camera


def _write(folder: Path, moment: _Moment, drawn: Drawn, facts: dict[str, Any], *, depth: bool) -> None:
    write_png(folder / f"{moment.name}.png", drawn.bytes, provenance(**facts))
    if depth:
        picture, (nearest, farthest) = colored_depth(drawn.depth)
        shown = facts | {"shows": "expected depth", "nearest": nearest, "farthest": farthest}
        depth_facts = provenance(**facts, holds="expected depth in scene units, 0 where nothing is")
        write_image(folder / f"{moment.name}-depth.npy", drawn.depth, depth_facts)
        write_png(folder / f"{moment.name}-depth.png", picture, provenance(**shown))
