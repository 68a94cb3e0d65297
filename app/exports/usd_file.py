"""USD in one binary file, by usd-core: what files of surfaces and of splats have in common.

In the clip's unit, which the file tells, y up and z towards the viewer; a frame of the clip is a time code.
"""

from __future__ import annotations

import errno
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from app.errors import UserError
from app.exports.gltf import METRES
from app.files.atomic import replaced
from app.files.embedded import KEYWORD
from app.files.provenance import NOTICE, ascii_json, facts_of

NO_USD: Final = "a .usdc file needs usd-core: pip install usd-core"


def require_usd() -> None:
    """Raises UserError: the package is not there."""
    try:
        import pxr  # noqa: F401
    except ImportError as error:
        raise UserError(NO_USD) from error


@cache
def has_usd() -> bool:
    """Looked for once, and not loaded."""
    return find_spec("pxr") is not None


@contextmanager
def new_stage(
    target: Path, unit: str, frames: int, seconds: float, facts: Mapping[str, Any]
) -> Iterator[Any]:
    """An empty Usd.Stage, which is the file at `target` when the block ends well; `facts`: provenance.

    Whoever fills it keeps no prim or attribute of it, since Windows renames no file that is open.

    Raises:
        UserError: the package is not there.
        OSError: the file cannot be written, such as on a full disk.
    """
    require_usd()
    from pxr import Tf, Usd, UsdGeom

    with replaced(target) as temporary:
        temporary.unlink(missing_ok=True)
        try:
            stage = Usd.Stage.CreateNew(str(temporary))
            UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.y)
            UsdGeom.SetStageMetersPerUnit(stage, METRES.get(unit, 1.0))
            stage.SetTimeCodesPerSecond(frames / seconds)
            stage.SetFramesPerSecond(frames / seconds)
            stage.SetStartTimeCode(0)
            stage.SetEndTimeCode(frames - 1)
            layer = stage.GetRootLayer()
            layer.comment = NOTICE
            layer.customLayerData = {KEYWORD: ascii_json(facts), "unit": unit}
            yield stage
            layer.Save()
        except Tf.ErrorException as error:  # Of usd-core's own, without a number and of many lines.
            said = "the file cannot be written, the disk may be full"
            raise OSError(errno.EIO, said, str(temporary)) from error
        del stage, layer


def defined(stage: Any, schema: Any, root: str, shown: Sequence[range], index: int) -> Any:
    """A prim at `root`, which is the default one; where those that are `shown` are not one that is there
    at all times, the prim of that index below it, visible at its own frames."""
    from pxr import UsdGeom

    if list(shown) == [range(round(stage.GetEndTimeCode()) + 1)]:
        prim = schema.Define(stage, root)
        stage.SetDefaultPrim(prim.GetPrim())
        return prim
    if index == 0:
        stage.SetDefaultPrim(UsdGeom.Xform.Define(stage, root).GetPrim())
    prim, there = schema.Define(stage, f"{root}/window_{index + 1}"), shown[index]
    visibility = UsdGeom.Imageable(prim).CreateVisibilityAttr()
    visibility.Set(UsdGeom.Tokens.invisible, stage.GetStartTimeCode())
    visibility.Set(UsdGeom.Tokens.inherited, there[0])
    if there[-1] < stage.GetEndTimeCode():
        visibility.Set(UsdGeom.Tokens.invisible, there[-1] + 1)
    return prim


def read_usd(path: Path) -> tuple[dict[str, Any], list[NDArray[Any]]]:
    """Provenance and arrays of a file of ours. Raises UserError: it is none, or cannot be read here."""
    require_usd()
    from pxr import Tf

    try:
        return _read(path)
    except Tf.ErrorException as error:
        raise UserError(f"expected a USD file written by VesselSplat, got a damaged one: {path}") from error


def _read(path: Path) -> tuple[dict[str, Any], list[NDArray[Any]]]:
    from pxr import Usd

    stage = Usd.Stage.Open(str(path))
    text = stage.GetRootLayer().customLayerData.get(KEYWORD)
    prim = stage.GetDefaultPrim()
    if not isinstance(text, str) or not prim:
        raise UserError(f"expected a USD file written by VesselSplat, found no provenance in {path}")
    arrays = []
    for attribute in (one for part in Usd.PrimRange(prim) for one in part.GetAuthoredAttributes()):
        codes = attribute.GetTimeSamples()
        values = [attribute.Get(code) for code in codes] if codes else [attribute.Get()]
        found = [np.array(one) for one in (codes, *values) if one is not None]
        arrays += [one for one in found if one.dtype.kind in "biuf"]
    return facts_of(text, path), arrays
