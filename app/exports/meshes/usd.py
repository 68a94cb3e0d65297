"""USD in one binary file: the surface with its way through time as samples of its points, by usd-core.

In the clip's unit, which the file tells, y up and z towards the viewer.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from app.errors import UserError
from app.exports.gltf import METRES, TO_GLTF, linear
from app.exports.meshes.film import Film
from app.files.atomic import replaced
from app.files.embedded import KEYWORD
from app.files.provenance import NOTICE, ascii_json, facts_of

SURFACE: Final = "/surface"
NO_USD: Final = "a .usdc file needs usd-core: pip install 'vesselsplat[usd]'"


def require_usd() -> None:
    """Raises UserError: the package is not there."""
    try:
        import pxr  # noqa: F401
    except ImportError as error:
        raise UserError(NO_USD) from error


def write_usd(
    target: Path, film: Film, unit: str, frames: int, seconds: float, facts: Mapping[str, Any]
) -> None:
    """A frame of the clip is a time code; `facts`: provenance. Raises UserError as `require_usd`."""
    require_usd()
    from pxr import Sdf, Usd, UsdGeom, Vt

    with replaced(target) as temporary:
        temporary.unlink(missing_ok=True)
        stage = Usd.Stage.CreateNew(str(temporary))
        UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.y)
        UsdGeom.SetStageMetersPerUnit(stage, METRES.get(unit, 1.0))
        stage.SetTimeCodesPerSecond(frames / seconds)
        stage.SetStartTimeCode(0)
        stage.SetEndTimeCode(frames - 1)
        layer = stage.GetRootLayer()
        layer.comment = NOTICE
        layer.customLayerData = {KEYWORD: ascii_json(facts), "unit": unit}
        mesh = UsdGeom.Mesh.Define(stage, SURFACE)
        stage.SetDefaultPrim(mesh.GetPrim())
        mesh.CreateFaceVertexCountsAttr(Vt.IntArray.FromNumpy(np.full(len(film.mesh.faces), 3, np.int32)))
        mesh.CreateFaceVertexIndicesAttr(Vt.IntArray.FromNumpy(np.ascontiguousarray(film.mesh.faces.ravel())))
        mesh.CreateSubdivisionSchemeAttr(UsdGeom.Tokens.none)
        mesh.CreateDoubleSidedAttr(True)
        points, extent = mesh.CreatePointsAttr(), mesh.CreateExtentAttr()
        for time, positions in zip(film.times, film.positions, strict=True):
            placed = np.ascontiguousarray(positions * TO_GLTF)
            code = Usd.TimeCode(round(time * frames, 6))
            points.Set(Vt.Vec3fArray.FromNumpy(placed), code)
            bounds = np.stack([placed.min(axis=0), placed.max(axis=0)])
            extent.Set(Vt.Vec3fArray.FromNumpy(bounds), code)
        colors = UsdGeom.PrimvarsAPI(mesh).CreatePrimvar(
            "displayColor", Sdf.ValueTypeNames.Color3fArray, UsdGeom.Tokens.vertex
        )
        colors.Set(Vt.Vec3fArray.FromNumpy(linear(film.mesh.colors)))
        layer.Save()
        del stage, layer, mesh, points, extent, colors  # The file is closed.


def read_usd(path: Path) -> tuple[dict[str, Any], list[NDArray[Any]]]:
    """Provenance and arrays of a file of ours. Raises UserError: it is none, or cannot be read here."""
    require_usd()
    from pxr import Tf

    try:
        return _read(path)
    except Tf.ErrorException as error:
        raise UserError(f"expected a USD file written by VesselSplat, got a damaged one: {path}") from error


def _read(path: Path) -> tuple[dict[str, Any], list[NDArray[Any]]]:
    from pxr import Usd, UsdGeom

    stage = Usd.Stage.Open(str(path))
    text = stage.GetRootLayer().customLayerData.get(KEYWORD)
    mesh = UsdGeom.Mesh(stage.GetPrimAtPath(SURFACE))
    if not isinstance(text, str) or not mesh:
        raise UserError(f"expected a USD file written by VesselSplat, found no provenance in {path}")
    points = mesh.GetPointsAttr()
    codes = points.GetTimeSamples()
    faces, colors = mesh.GetFaceVertexIndicesAttr().Get(), mesh.GetDisplayColorAttr().Get()
    arrays = (faces, codes, *map(points.Get, codes), colors)
    return facts_of(text, path), [np.array(one) for one in arrays if one is not None]
