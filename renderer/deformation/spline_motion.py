"""The own deformation: cubic B-splines in time for each Gaussian and for nodes that neighbours share."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from renderer.deformation.nodes import add_shared
from renderer.deformation.spline import MIN_CONTROLS, add_curve, spline_taps
from renderer.raw_gaussians import RawGaussians
from renderer.splats import Float32Array
from renderer.stored_arrays import Arrays, Stored, check


@dataclass(frozen=True, eq=False)
class SplineMotion:
    """K control values span the clip; a channel that does not move has no rows.

    The position is means + spline(position_controls) + the weighted sum of spline(node_controls) over
    the nodes that share their motion with the Gaussian; colours and opacity logits likewise.
    """

    NAMES: ClassVar[tuple[str, ...]] = (
        "position_controls", "color_controls", "opacity_controls", "node_controls", "node_indices",
        "node_weights",
    )  # fmt: skip

    position_controls: Float32Array
    """(N or 0, K, 3)"""
    color_controls: Float32Array
    """(N or 0, K, 3)"""
    opacity_controls: Float32Array
    """(N or 0, K, 1) of the opacity logit: tissue that is cut, or appears."""
    node_controls: Float32Array
    """(M, K, 3) motion nodes."""
    node_indices: NDArray[np.int32]
    """(N or 0, 4) nodes of each Gaussian."""
    node_weights: Float32Array
    """(N or 0, 4), each row sums to 1."""

    @property
    def n_controls(self) -> int:
        return int(self.node_controls.shape[1])

    def moved(self, raw: RawGaussians, time: float) -> RawGaussians:
        """See Motion."""
        self._require_rows(len(raw))
        taps = spline_taps(time, self.n_controls)
        means, colors, logits = raw.means.copy(), raw.colors, raw.opacity_logits
        if len(self.position_controls):
            add_curve(self.position_controls, *taps, means)
        if len(self.node_indices):
            nodes = np.zeros((len(self.node_controls), 3), np.float32)
            add_curve(self.node_controls, *taps, nodes)
            add_shared(nodes, self.node_indices, self.node_weights, means)
        if len(self.color_controls):
            colors = colors.copy()
            add_curve(self.color_controls, *taps, colors)
        if len(self.opacity_controls):
            logits = logits.copy()
            add_curve(self.opacity_controls, *taps, logits[:, None])
        return replace(raw, means=means, colors=colors, opacity_logits=logits)

    def _require_rows(self, count: int) -> None:
        """Before the kernels, which check no bounds, meet them."""
        shared = self.node_indices, self.node_weights
        if len(shared[0]) != len(shared[1]):
            raise ValueError("expected as many rows of node_weights as of node_indices")
        for rows in map(len, (self.position_controls, self.color_controls, self.opacity_controls, *shared)):
            if rows not in (0, count):
                raise ValueError(f"expected a motion of {count} Gaussians, got one of {rows}")

    def rows(self, index: NDArray[np.int64]) -> Self:
        """See Motion."""
        own = {name: value for name, value in self.arrays().items() if name != "node_controls"}
        return replace(self, **{name: value.take(index, axis=0) for name, value in own.items() if len(value)})

    def arrays(self) -> Arrays:
        """Every array by field name, in a fixed order."""
        return {item.name: getattr(self, item.name) for item in fields(self)}

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray[Any]]) -> Self:
        """Files of old have no curve of opacity."""
        own = {name: arrays[name] for name in cls.NAMES if name in arrays}
        own.setdefault("opacity_controls", np.zeros((0, own["node_controls"].shape[1], 1), np.float32))
        return cls(**own)

    @classmethod
    def check(cls, arrays: Mapping[str, NDArray[Any]], count: int) -> None:
        """See Motion."""
        lengths = {"N": count}
        check(arrays, LAYOUT, lengths)
        if lengths["K"] < MIN_CONTROLS:
            raise ValueError(f"expected at least {MIN_CONTROLS} control values a curve, got {lengths['K']}")
        if len(arrays["node_indices"]) != len(arrays["node_weights"]):
            raise ValueError("expected as many rows of node_weights as of node_indices")


LAYOUT = {
    "node_controls": Stored("M K 3"),
    "position_controls": Stored("N? K 3"),
    "color_controls": Stored("N? K 3"),
    "opacity_controls": Stored("N? K 1", optional=True),
    "node_indices": Stored("N? 4", np.int32, least=0, below="M"),
    "node_weights": Stored("N? 4"),
}
