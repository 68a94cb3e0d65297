"""Where points of the surface go: lifted from pixels at one moment, followed as the surface mesh is, one row
a point and moment."""

from __future__ import annotations

import csv
import io
from collections.abc import Generator
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from app.errors import UserError
from app.exports.records import Tracks
from app.files.atomic import together, write_bytes
from app.files.provenance import write_sidecar
from app.scenes.records import MomentRecord
from app.scenes.scene import Scene
from renderer.picking import surface_point
from renderer.splats import Float32Array
from renderer.surface.following import NEAR, Follower
from renderer.surface.maps import maps_of, read
from renderer.surface.mesh import Mesh

COLUMNS: Final = ("point", "frame", "time", "x", "y", "z", "column", "row", "seen")
DEFINITIONS: Final = {
    "point": "its place in the lists that were asked for, pixels before places, from 0",
    "frame": "of the run, from 0; empty: a moment that is none of its frames",
    "time": "in [0, 1] over the clip",
    "x, y, z": "in the world, in {unit}; x right, y down, z forward",
    "column, row": "where the camera of the moment sees it, in pixels; the middle of the first is at 0.5",
    "seen": f"1: inside the image, and within {NEAR:.0%} of the depth that is rendered there; else 0",
}


def write_tracks(record: Tracks, scene: Scene, target: Path) -> Generator[int, None, None]:
    """The table as CSV, and what its columns mean beside it with the record; yields moments done.

    Raises:
        UserError: a pixel where there is no surface, or Gaussians that are others at every moment.
    """
    scene.require_one_model()
    if not (record.points or record.places) or not record.moments:
        raise UserError(f"expected a point and a moment at least: {scene.name}")
    follower = _follower(record, scene)
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerow(COLUMNS)
    rows = []
    for done, moment in enumerate(record.moments, start=1):
        rows.append(_rows(follower.at(moment.time).vertices, moment, scene))
        yield done
    for of_point in zip(*rows, strict=True):
        table.writerows(of_point)
    told = {name: meaning.format(unit=scene.unit) for name, meaning in DEFINITIONS.items()}
    with together(target) as place:
        write_bytes(place, text.getvalue().encode())
        write_sidecar(place, record.signed | {"definitions": told})


def _follower(record: Tracks, scene: Scene) -> Follower:
    """Of the points alone, seen through the camera that they were chosen in."""
    start = record.start
    lifted = [_lifted(pixel, start, scene) for pixel in record.points]
    points = np.array([*lifted, *record.places], np.float32)
    return Follower(
        model=scene.model,
        cameras=(start.camera,),
        near=_near(start, scene),
        mode=scene.mode,
        mesh=Mesh(points, np.zeros((0, 3), np.int32), np.zeros_like(points)),
        time=start.time,
        sights=(np.ones(len(points), np.float32),),
        taken=(start.time,),
    )


def _lifted(pixel: tuple[int, int], start: MomentRecord, scene: Scene) -> NDArray[np.float64]:
    splats, camera = scene.model.at(start.time), start.camera
    found = surface_point(splats, camera, pixel, _near(start, scene), scene.mode)
    if found is None:
        raise UserError(
            f"expected a pixel of {camera.width}x{camera.height} where the model has a surface, "
            f"got {pixel[0]},{pixel[1]} at {scene.moment(start.time)}"
        )
    return found.point


def _near(moment: MomentRecord, scene: Scene) -> float:
    return scene.near if moment.near is None else moment.near


def _rows(points: Float32Array, moment: MomentRecord, scene: Scene) -> list[tuple[object, ...]]:
    camera = moment.camera
    pixels, depths = camera.project(points.astype(np.float64))
    view = maps_of(scene.model, moment.time, camera, _near(moment, scene), scene.mode)
    inside = ((pixels >= 0) & (pixels < [camera.width, camera.height])).all(axis=1) & (depths > 0)
    seen = inside & (np.abs(read(view.depth, pixels) - depths) < NEAR * depths)
    frame = "" if moment.frame is None else moment.frame
    return [
        (point, frame, moment.time, *(f"{value:.6g}" for value in (*place, *pixel)), int(is_seen))
        for point, (place, pixel, is_seen) in enumerate(zip(points, pixels, seen, strict=True))
    ]
