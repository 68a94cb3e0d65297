"""The surface as USD, with its way through time as samples of its points; of a model in windows a mesh of
each, visible while it is shown."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any, Final

import numpy as np

from app.exports.gltf import linear
from app.exports.meshes.film import Film
from app.exports.records import SurfaceMesh
from app.exports.usd_file import defined, new_stage, require_usd
from app.scenes.scene import Scene
from renderer.splat_files.y_up import AXES

SURFACE: Final = "/surface"


def write_usd(target: Path, films: Sequence[Film], scene: Scene, record: SurfaceMesh) -> None:
    """The file of a record. Raises UserError as `require_usd`."""
    require_usd()
    from pxr import UsdGeom

    frames = len(scene.cameras)
    with new_stage(target, scene.unit, frames, record.seconds, record.signed) as stage:
        shown = [film.frames for film in films]
        for index, film in enumerate(films):
            _write_mesh(defined(stage, UsdGeom.Mesh, SURFACE, shown, index), film, frames)
        del stage  # The file is closed.


def _write_mesh(mesh: Any, film: Film, frames: int) -> None:
    from pxr import Sdf, Usd, UsdGeom, Vt

    mesh.CreateFaceVertexCountsAttr(Vt.IntArray.FromNumpy(np.full(len(film.mesh.faces), 3, np.int32)))
    mesh.CreateFaceVertexIndicesAttr(Vt.IntArray.FromNumpy(np.ascontiguousarray(film.mesh.faces.ravel())))
    mesh.CreateSubdivisionSchemeAttr(UsdGeom.Tokens.none)
    mesh.CreateDoubleSidedAttr(True)
    points, extent = mesh.CreatePointsAttr(), mesh.CreateExtentAttr()
    for time, positions in zip(film.times, film.positions, strict=True):
        placed = np.ascontiguousarray(positions * AXES)
        code = Usd.TimeCode(round(time * frames, 6))
        points.Set(Vt.Vec3fArray.FromNumpy(placed), code)
        bounds = np.stack([placed.min(axis=0), placed.max(axis=0)])
        extent.Set(Vt.Vec3fArray.FromNumpy(bounds), code)
    colors = UsdGeom.PrimvarsAPI(mesh).CreatePrimvar(
        "displayColor", Sdf.ValueTypeNames.Color3fArray, UsdGeom.Tokens.vertex
    )
    colors.Set(Vt.Vec3fArray.FromNumpy(linear(film.mesh.colors)))
