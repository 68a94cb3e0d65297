"""Dynamic Gaussians: raw parameters and a shared-knot cubic B-spline in time. Numpy only."""

from __future__ import annotations

from dataclasses import dataclass, fields
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from safetensors import SafetensorError, safe_open
from safetensors.numpy import save

from renderer.deformation.nodes import add_shared
from renderer.deformation.spline import add_curve, spline_taps
from renderer.splats import Float32Array, Splats


def sigmoid(logits: Float32Array) -> Float32Array:
    """1 / (1 + exp(-x)) without overflow."""
    half = np.float32(0.5)
    values: Float32Array = half + half * np.tanh(half * logits)
    return values


@dataclass(frozen=True, eq=False)
class DynamicGaussians:
    """N Gaussians that move and change colour over time in [0, 1].

    Raw values carry their space in the name. K control values span the clip (K = 0: static); the
    position is means + spline(position_controls) + the weighted sum of spline(node_controls) over
    the nodes that share their motion with the Gaussian; the colour is colors + spline(color_controls).
    A channel that does not move has no rows.
    """

    means: Float32Array
    """(N, 3) in the clip's unit."""
    quats: Float32Array
    """(N, 4) wxyz, not normalised."""
    log_scales: Float32Array
    """(N, 3) natural logarithm of the standard deviations."""
    opacity_logits: Float32Array
    """(N,)"""
    colors: Float32Array
    """(N, 3) RGB."""
    position_controls: Float32Array
    """(N or 0, K, 3)"""
    color_controls: Float32Array
    """(N or 0, K, 3)"""
    node_controls: Float32Array
    """(M, K, 3) motion nodes."""
    node_indices: NDArray[np.int32]
    """(N or 0, 4) nodes of each Gaussian."""
    node_weights: Float32Array
    """(N or 0, 4), each row sums to 1."""

    def __len__(self) -> int:
        return len(self.means)

    @property
    def n_controls(self) -> int:
        channels = (self.position_controls, self.color_controls, self.node_controls)
        return max(int(channel.shape[1]) for channel in channels)

    def at(self, time: float) -> Splats:
        """The activated splats at `time` in [0, 1]."""
        return Splats(
            means=self.means_at(time),
            quats=self.quats,
            scales=np.exp(self.log_scales),
            opacities=sigmoid(self.opacity_logits),
            colors=self.colors_at(time),
        )

    def means_at(self, time: float) -> Float32Array:
        """(N, 3) positions at `time`."""
        means = self.means.copy()
        if self.position_controls.size:
            add_curve(self.position_controls, *spline_taps(time, self.position_controls.shape[1]), means)
        if self.node_indices.size:
            nodes = np.zeros((len(self.node_controls), 3), np.float32)
            add_curve(self.node_controls, *spline_taps(time, self.node_controls.shape[1]), nodes)
            add_shared(nodes, self.node_indices, self.node_weights, means)
        return means

    def colors_at(self, time: float) -> Float32Array:
        """(N, 3) colours at `time`."""
        colors = self.colors.copy()
        if self.color_controls.size:
            add_curve(self.color_controls, *spline_taps(time, self.color_controls.shape[1]), colors)
        return colors

    def arrays(self) -> dict[str, NDArray[np.float32] | NDArray[np.int32]]:
        """Every array by field name, in a fixed order."""
        return {item.name: getattr(self, item.name) for item in fields(self)}

    def save(self, path: Path, metadata: dict[str, str] | None = None) -> None:
        arrays = {name: np.ascontiguousarray(value) for name, value in self.arrays().items()}
        path.write_bytes(save(arrays, metadata))

    @classmethod
    def load(cls, path: Path) -> DynamicGaussians:
        """Read what `save` wrote. Raises ValueError for a file that is no such model."""
        try:
            with safe_open(path, framework="numpy") as file:
                names = set(file.keys())
                missing = [item.name for item in fields(cls) if item.name not in names]
                if missing:
                    raise ValueError(f"expected a VesselSplat model with {', '.join(missing)}: {path}")
                return cls(**{item.name: file.get_tensor(item.name) for item in fields(cls)})
        except (SafetensorError, OSError) as error:
            raise ValueError(f"expected a model in safetensors format, got {error}: {path}") from error
