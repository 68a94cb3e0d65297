"""`vesselsplat export RUN --npz FILE.npz | --tracks FILE.csv --points X,Y ...`: arrays and tables."""

from __future__ import annotations

import argparse
import re
import sys
from collections.abc import Sequence
from pathlib import Path

from app.commands.view_selection import Moment
from app.console.progress import progress
from app.errors import UserError
from app.exports.make import make
from app.exports.records import ModelArrays, Tracks
from app.exports.sources import Opened
from app.files.records import extended
from app.scenes.drawer import Drawer
from app.scenes.records import MomentRecord
from app.scenes.scene import Scene
from renderer.listing import count
from renderer.near_plane import near_plane

MOST_POINTS = 10_000
POINT = re.compile(r"(\d{1,9}),(\d{1,9})")


def add_flags(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--points",
        nargs="+",
        metavar="X,Y",
        help="pixels of the first moment, column and row from 0, whose surface --tracks follows",
    )


def check(flags: argparse.Namespace) -> None:
    """Raises UserError: one of tracks and points without the other, or pixels that are none."""
    if bool(flags.tracks) != bool(flags.points):
        raise UserError("expected --tracks FILE.csv with --points X,Y ..., got one of the two")
    _points(flags)


def write(flags: argparse.Namespace, scene: Scene, wanted: Sequence[Moment], pen: Drawer) -> None:
    """What of the two is asked for. Raises UserError: there is no surface behind one of the points."""
    moments = tuple(_moment(one, scene) for one in wanted)
    # First what may be refused.
    if flags.tracks:
        points = _points(flags)
        tracks = extended(Tracks, scene.record, points=points, start=moments[0], moments=moments)
        _write(tracks, Opened(model=scene), flags.tracks, wanted)
        sys.stdout.write(f"{flags.tracks}: {count(len(points), 'point')} at {count(len(wanted), 'moment')}\n")
    if flags.npz:
        arrays = extended(ModelArrays, scene.record, renderer=pen.name, moments=moments)
        _write(arrays, Opened(model=scene, pen=pen), flags.npz, wanted)
        said = f"{len(scene.model)} Gaussians at {count(len(wanted), 'moment')}"
        sys.stdout.write(f"{flags.npz}: {said}, {flags.npz.stat().st_size / 1e6:.1f} MB\n")


def _moment(one: Moment, scene: Scene) -> MomentRecord:
    near = near_plane(scene.model, one.camera)
    return MomentRecord(time=one.time, camera=one.camera, frame=one.frame, near=near)


def _write(record: ModelArrays | Tracks, sources: Opened, path: Path, wanted: Sequence[Moment]) -> None:
    with progress("export", len(wanted)) as report:
        for done in make(record, sources, path):
            report(done, wanted[done - 1].name)


def _points(flags: argparse.Namespace) -> tuple[tuple[int, int], ...]:
    given = flags.points or []
    if len(given) > MOST_POINTS:
        raise UserError(f"--points: expected up to {MOST_POINTS}, got {len(given)}")
    found = [POINT.fullmatch(text) for text in given]
    if None in found:
        raise UserError(
            f"--points: expected column,row as whole numbers from 0, got {given[found.index(None)]}"
        )
    return tuple((int(one[1]), int(one[2])) for one in found if one)
