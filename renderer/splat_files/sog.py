"""PlayCanvas' SOG (Spatially Ordered Gaussians), version 2: pictures whose pixels are splats, row by row.

Layout: https://developer.playcanvas.com/user-manual/gaussian-splatting/formats/sog. `meta.json` names the
pictures. Positions: 16 bits in two pictures, from `mins` to `maxs` of sign(x) log(1 + |x|). Rotations: the
largest of w, x, y, z is named by alpha - 252 and left out; the others are bytes over sqrt(2). Sizes (natural
logarithms), colours (coefficients of degree 0) and harmonics are places in code books of 256 values; alpha is
opacity. A splat's harmonics are a row of a palette: 64 rows lie side by side in a line of its picture.
Converters keep the axes of the PLY file, so values are taken as those of a PLY file.
"""

from __future__ import annotations

from typing import Annotated, Any, Final, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field, FiniteFloat, ValidationError

from renderer.budget import budget
from renderer.harmonics import BANDS
from renderer.json_files import parsed
from renderer.raw_gaussians import RawGaussians, logits
from renderer.sog_list import LIST
from renderer.splat_files.other_kinds import CONVERT
from renderer.splat_files.packed_ply import smallest_three
from renderer.splat_files.sog_members import Read
from renderer.splat_files.sog_pictures import MOST_ROWS, Bytes, Pictures
from renderer.splat_files.splat_file import SplatFile, SplatFileError, colors_of, repaired

VERSION: Final = 2
LEVELS: Final = 256
LARGEST: Final = 252
"""Alpha of a rotation whose largest part is w; x, y, z follow."""
MOST_LIST: Final = 1 << 20
"""Bytes of a list; those of converters have 16,000."""

Triple = tuple[FiniteFloat, FiniteFloat, FiniteFloat]
Codes = Annotated[list[FiniteFloat | None], Field(min_length=LEVELS, max_length=LEVELS)]


class _Part(BaseModel):
    model_config = ConfigDict(frozen=True, strict=True)


class _Means(_Part):
    mins: Annotated[Triple, Field(strict=False)]
    maxs: Annotated[Triple, Field(strict=False)]
    files: Annotated[list[str], Field(min_length=2, max_length=2)]


class _Quats(_Part):
    files: Annotated[list[str], Field(min_length=1, max_length=1)]


class _Coded(_Quats):
    codebook: Codes


class _Palette(_Part):
    count: Annotated[int, Field(ge=1, le=MOST_ROWS)]
    bands: Annotated[int, Field(ge=1, lt=len(BANDS))]
    codebook: Codes
    files: Annotated[list[str], Field(min_length=2, max_length=2)]
    """Of the palette, and of each splat's row in it."""


class _List(_Part):
    version: Literal[2]
    count: Annotated[int, Field(ge=0)]
    antialias: bool = False
    means: _Means
    scales: _Coded
    quats: _Quats
    sh0: _Coded
    shN: _Palette | None = None


def read_sog(read: Read) -> SplatFile:
    """The Gaussians. No picture is decoded that has far more pixels than the list names splats.

    Raises:
        SplatFileError: another version, or a file is damaged or missing.
        OverBudget: too many splats.
    """
    said = _list(read(LIST, MOST_LIST))
    budget().require(splats=said.count)
    pictures = Pictures(read, said.count)
    quats = pictures.splats(said.quats.files[0])
    colors = pictures.splats(said.sh0.files[0])
    raw = RawGaussians(
        means=_means(said.means, pictures),
        quats=_rotations(quats),
        log_scales=_decoded(said.scales.codebook, pictures.splats(said.scales.files[0])[:, :3]),
        opacity_logits=logits(colors[:, 3] / 255),
        colors=colors_of(_decoded(said.sh0.codebook, colors[:, :3])),
        harmonics=_harmonics(said.shN, pictures),
    )
    return repaired(raw, "mip" if said.antialias else "default")


def _list(content: bytes) -> _List:
    try:
        said: Any = parsed(content)
    except ValueError as error:
        raise SplatFileError(f"expected the list of a SOG in {LIST}, got damaged JSON") from error
    if isinstance(said, dict) and "lodLevels" in said:
        raise SplatFileError(f"expected a SOG of one level of detail, got several: {CONVERT}")
    version = said.get("version", 1) if isinstance(said, dict) else None
    if version != VERSION:
        raise SplatFileError(f"expected a SOG of version {VERSION}, got {str(version)[:20]}: {CONVERT}")
    try:
        return _List.model_validate(said)
    except ValidationError as error:
        first = error.errors(include_url=False, include_input=False)[0]
        where = ".".join(map(str, first["loc"]))
        raise SplatFileError(f"expected the list of a SOG, got {where}: {first['msg']}") from error


def _means(said: _Means, pictures: Pictures) -> NDArray[np.float32]:
    low, high = (pictures.splats(name)[:, :3] for name in said.files)
    ends = np.array([said.mins, said.maxs])
    with np.errstate(over="ignore", invalid="ignore"):
        bent = ends[0] + (low + 256.0 * high) / 65535 * (ends[1] - ends[0])
        return np.asarray(np.sign(bent) * np.expm1(np.abs(bent)), np.float32)


def _rotations(pixels: Bytes) -> NDArray[np.float32]:
    """No rotation (all 0) where alpha names no part."""
    largest = pixels[:, 3].astype(np.int64) - LARGEST
    quats = smallest_three((pixels[:, :3] / 127.5 - 1) / np.sqrt(2), np.maximum(largest, 0))
    quats[largest < 0] = 0
    return quats


def _decoded(codes: list[float | None], places: Bytes) -> NDArray[np.float32]:
    """Of a first code that is none, which early converters wrote, one step before the second."""
    values = np.array([np.nan if code is None else code for code in codes])
    if codes[0] is None:
        values[0] = values[1] + (values[1] - values[-1]) / (LEVELS - 1)
    with np.errstate(over="ignore"):
        return np.asarray(values.astype(np.float32)[places])


def _harmonics(said: _Palette | None, pictures: Pictures) -> NDArray[np.float32]:
    if said is None:
        return np.zeros((pictures.count, 0, 3), np.float32)
    palette = _decoded(said.codebook, pictures.palette(said.files[0], said.count, BANDS[said.bands]))
    labels = pictures.splats(said.files[1])
    rows = labels[:, 0] + 256 * labels[:, 1].astype(np.int64)
    if len(rows) and rows.max() >= said.count:
        raise SplatFileError(f"expected rows of a palette of {said.count}, got {rows.max()}")
    return np.ascontiguousarray(palette[rows])
