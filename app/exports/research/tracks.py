"""Where points of the surface go: lifted from pixels at one moment, followed as the surface mesh is, one row
a point and moment."""

from __future__ import annotations

import csv
import io
from collections.abc import Generator
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from app.errors import UserError
from app.exports.records import Tracks
from app.exports.research.clock import frames_of, span_of
from app.files.atomic import together, write_bytes
from app.files.provenance import write_sidecar
from app.scenes.records import MomentRecord
from app.scenes.scene import Scene
from renderer.camera import Camera
from renderer.model_windows import ModelWindow, handover, window_at, windows_of
from renderer.picking import surface_point
from renderer.splats import Float32Array
from renderer.surface.following import NEAR, Follower
from renderer.surface.maps import Maps, maps_of, read
from renderer.surface.mesh import Mesh

COLUMNS: Final = ("point", "frame", "time", "x", "y", "z", "column", "row", "seen")
DEFINITIONS: Final = {
    "point": "its place in the lists that were asked for, pixels before places, from 0",
    "frame": "{frames}; empty: a moment that is none of its frames",
    "time": "in [0, 1] over {span}",
    "x, y, z": "in the world, in {unit}; x right, y down, z forward; a point that is hidden where one window "
    "of a long clip goes over into the next stays there",
    "column, row": "where the camera of the moment sees it, in pixels; the middle of the first is at 0.5",
    "seen": f"1: inside the image, and within {NEAR:.0%} of the depth that is rendered there; else 0",
}


def write_tracks(record: Tracks, scene: Scene, target: Path) -> Generator[int, None, None]:
    """The table as CSV, and what its columns mean beside it with the record; yields moments done.

    Raises:
        UserError: a pixel where there is no surface, or a splat file per moment.
    """
    scene.require_same_tissue()
    if not (record.points or record.places) or not record.moments:
        raise UserError(f"expected a point and a moment at least: {scene.name}")
    points = _Points(record, scene)
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerow(COLUMNS)
    rows = []
    for done, moment in enumerate(record.moments, start=1):
        rows.append(_rows(points.at(moment.time), moment, scene))
        yield done
    for of_point in zip(*rows, strict=True):
        table.writerows(of_point)
    words = {"unit": scene.unit, "frames": frames_of(scene), "span": span_of(scene)}
    told = {name: meaning.format(**words) for name, meaning in DEFINITIONS.items()}
    with together(target) as place:
        write_bytes(place, text.getvalue().encode())
        write_sidecar(place, record.signed | {"definitions": told})


@dataclass(frozen=True, eq=False)
class _Start:
    """Points from which they are followed through a window."""

    window: ModelWindow
    points: Float32Array
    """(P, 3) in the world, at `time`."""
    time: float
    """Of the clip."""
    camera: Camera
    seen: NDArray[np.bool_]
    """(P,) those that the camera sees; the others stay where they are."""


class _Points:
    """Followed through time, in windows from one to the next; the motion of one window is held."""

    def __init__(self, record: Tracks, scene: Scene) -> None:
        start = record.start
        lifted = [_lifted(pixel, start, scene) for pixel in record.points]
        points = np.array([*lifted, *record.places], np.float32)
        self._scene, self._near = scene, _near(start, scene)
        self._windows = windows_of(scene.model)
        first = _Start(
            window_at(scene.model, start.time),
            points,
            start.time,
            start.camera,
            np.ones(len(points), np.bool_),
        )
        self._first, self._starts = first.window.index, {first.window.index: first}
        self._held = first.window.index, self._follower(first)

    def at(self, time: float) -> Float32Array:
        """(P, 3) in the world at a time in [0, 1] of the clip."""
        return self._in(window_at(self._scene.model, time), time)

    def _in(self, window: ModelWindow, time: float) -> Float32Array:
        start = self._start_of(window)
        if self._held[0] != window.index:
            self._held = window.index, self._follower(start)
        return self._held[1].at(window.local(time)).vertices

    def _start_of(self, window: ModelWindow) -> _Start:
        """Where the points are when the window beside it, nearer to the first one, hands them over."""
        if window.index not in self._starts:
            beside = self._windows[window.index + (1 if window.index < self._first else -1)]
            time = handover(self._windows[min(window.index, beside.index)])
            points, camera = self._in(beside, time), self._scene.camera_at(time)
            view = maps_of(window.model, window.local(time), camera, self._near, self._scene.mode)
            self._starts[window.index] = _Start(window, points, time, camera, _seen(points, view))
        return self._starts[window.index]

    def _follower(self, start: _Start) -> Follower:
        """Of points alone, through one camera."""
        time = start.window.local(start.time)
        return Follower(
            model=start.window.model,
            cameras=(start.camera,),
            near=self._near,
            mode=self._scene.mode,
            mesh=Mesh(start.points, np.zeros((0, 3), np.int32), np.zeros_like(start.points)),
            time=time,
            sights=(start.seen.astype(np.float32),),
            taken=(time,),
        )


def _lifted(pixel: tuple[int, int], start: MomentRecord, scene: Scene) -> NDArray[np.float64]:
    splats, camera = scene.model.at(start.time), start.camera
    found = surface_point(splats, camera, pixel, _near(start, scene), scene.mode)
    if found is None:
        when = f"time {start.time:g}" if start.frame is None else f"frame {start.frame}, counted from 0"
        raise UserError(
            f"expected a pixel of {camera.width}x{camera.height} where the model has a surface, "
            f"got {pixel[0]},{pixel[1]} at {when}"
        )
    return found.point


def _near(moment: MomentRecord, scene: Scene) -> float:
    return scene.near if moment.near is None else moment.near


def _rows(points: Float32Array, moment: MomentRecord, scene: Scene) -> list[tuple[object, ...]]:
    camera = moment.camera
    pixels, _ = camera.project(points.astype(np.float64))
    seen = _seen(points, maps_of(scene.model, moment.time, camera, _near(moment, scene), scene.mode))
    frame = "" if moment.frame is None else moment.frame
    return [
        (point, frame, moment.time, *(f"{value:.6g}" for value in (*place, *pixel)), int(is_seen))
        for point, (place, pixel, is_seen) in enumerate(zip(points, pixels, seen, strict=True))
    ]


def _seen(points: Float32Array, view: Maps) -> NDArray[np.bool_]:
    """(P,) inside the picture, and where it shows a surface."""
    pixels, depths = view.camera.project(points.astype(np.float64))
    size = [view.camera.width, view.camera.height]
    inside = ((pixels >= 0) & (pixels < size)).all(axis=1) & (depths > 0)
    seen: NDArray[np.bool_] = inside & (np.abs(read(view.depth, pixels) - depths) < NEAR * depths)
    return seen
