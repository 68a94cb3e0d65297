"""EndoGaussian's deformation: features of a HexPlane at each position and time, offsets by small heads."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, ClassVar, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from renderer.deformation.heads import OFFSETS, PARTS, ROWS, WIDTH, Activations, Heads
from renderer.deformation.hexplane import LANES, Layout, lines_at, sample, within_box
from renderer.raw_gaussians import RawGaussians
from renderer.splats import Float32Array
from renderer.stored_arrays import Arrays, Stored, check


class Trace(NamedTuple):
    """How the offsets at a time came about, for the backward pass."""

    points: Float32Array
    """(N, 3) within the box."""
    line_cells: Float32Array
    activations: Activations
    offsets: Float32Array
    """(P, OFFSETS), P >= N a multiple of ROWS."""


@dataclass(frozen=True, eq=False)
class HexplaneMotion:
    """Offsets that are added to raw positions, log-scales and quaternions; nothing is per Gaussian."""

    NAMES: ClassVar[tuple[str, ...]] = (
        "box", "unit", "resolutions", "plane_cells", "trunk_weight", "trunk_bias", "hidden_weight",
        "hidden_bias", "output_weight", "output_bias", "time_cells",
    )  # fmt: skip

    box: Float32Array
    """(2, 3) lowest and highest corner of the space that the planes span; beyond, their border goes on."""
    unit: Float32Array
    """(1,) length that a position offset of 1 means, in the clip's unit."""
    resolutions: NDArray[np.int32]
    """(L, 3) cells of each level along x, y, z."""
    plane_cells: Float32Array
    """(B, cells of all planes in space, LANES), see hexplane.Layout."""
    time_cells: Float32Array
    """(T, B, cells of a row of all planes in time, LANES): rows from time 0 to time 1."""
    heads: Heads

    def traced(self, means: Float32Array, time: float) -> Trace:
        """The offsets of Gaussians at rest at `means` (N, 3)."""
        points = within_box(means, self.box)
        lines = lines_at(self.time_cells, time)
        rows = -(-len(means) // ROWS) * ROWS
        features = np.zeros((rows, len(self.resolutions) * len(lines) * LANES), np.float32)
        layout = Layout.of(self.resolutions)
        sample(self.plane_cells, lines, layout.resolutions, layout.planes, layout.lines, points, features)
        offsets, activations = self.heads.offsets(features)
        return Trace(points, lines, activations, offsets)

    def offset(self, raw: RawGaussians, offsets: Float32Array) -> RawGaussians:
        """The Gaussians with offsets (P, OFFSETS) added."""
        position, log_scale, quat = (offsets[: len(raw), part] for part in PARTS)
        return replace(
            raw,
            means=raw.means + self.unit * position,
            log_scales=raw.log_scales + log_scale,
            quats=raw.quats + quat,
        )

    def moved(self, raw: RawGaussians, time: float) -> RawGaussians:
        """See Motion."""
        return self.offset(raw, self.traced(raw.means, time).offsets)

    def rows(self, index: NDArray[np.int64]) -> Self:
        """See Motion."""
        return self

    def arrays(self) -> Arrays:
        """Every array by name, in a fixed order."""
        own = {name: getattr(self, name) for name in ("box", "unit", "resolutions", "plane_cells")}
        return own | self.heads.arrays() | {"time_cells": self.time_cells}

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray[Any]]) -> Self:
        """See Motion."""
        own = {name: arrays[name] for name in cls.NAMES}
        heads = Heads(**{name: own.pop(name) for name in cls.NAMES[4:-1]})
        return cls(**own, heads=heads)

    @classmethod
    def check(cls, arrays: Mapping[str, NDArray[Any]], count: int) -> None:
        """See Motion."""
        lengths: dict[str, int] = {}
        check(arrays, LAYOUT, lengths)
        resolutions = arrays["resolutions"]
        if not lengths["L"] or resolutions.max() > MOST_CELLS or lengths["T"] < 2:
            raise ValueError(f"expected levels of 2 to {MOST_CELLS} cells a side, and 2 rows in time")
        cells = Layout.of(resolutions)
        if (lengths["P"], lengths["Q"]) != (cells.n_plane_cells, cells.n_line_cells):
            expected = f"{cells.n_plane_cells} and {cells.n_line_cells}"
            raise ValueError(
                f"expected {expected} cells in space and time, got {lengths['P']}, {lengths['Q']}"
            )
        if lengths["F"] != lengths["L"] * lengths["C"] * LANES:
            raise ValueError(f"expected {lengths['L'] * lengths['C'] * LANES} features, got {lengths['F']}")


MOST_CELLS = 2**14
"""Of a level, along a side."""
LAYOUT = {
    "box": Stored("2 3"),
    "unit": Stored("1"),
    "resolutions": Stored("L 3", np.int32, least=2),
    "plane_cells": Stored(f"C P {LANES}"),
    "time_cells": Stored(f"T C Q {LANES}"),
    "trunk_weight": Stored(f"F {WIDTH}"),
    "trunk_bias": Stored(f"{WIDTH}"),
    "hidden_weight": Stored(f"{WIDTH} {3 * WIDTH}"),
    "hidden_bias": Stored(f"{3 * WIDTH}"),
    "output_weight": Stored(f"{WIDTH} {OFFSETS}"),
    "output_bias": Stored(f"{OFFSETS}"),
}
