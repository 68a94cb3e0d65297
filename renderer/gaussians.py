"""Dynamic Gaussians: raw parameters and a shared-knot cubic B-spline in time. Numpy only."""

from __future__ import annotations

from dataclasses import dataclass, fields
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from safetensors import SafetensorError, safe_open
from safetensors.numpy import save_file

from renderer.deformation.spline import spline_taps
from renderer.splats import Float32Array, Splats


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
            means=self.means + self._displacement(time),
            quats=self.quats,
            scales=np.exp(self.log_scales),
            opacities=(1.0 / (1.0 + np.exp(-self.opacity_logits))).astype(np.float32),
            colors=self.colors + _curve(self.color_controls, time),
        )

    def _displacement(self, time: float) -> Float32Array | float:
        own = _curve(self.position_controls, time)
        if len(self.node_indices) == 0:
            return own
        nodes = _curve(self.node_controls, time)
        assert isinstance(nodes, np.ndarray)
        shared: Float32Array = np.einsum("nk,nkc->nc", self.node_weights, nodes[self.node_indices])
        return own + shared

    def arrays(self) -> dict[str, NDArray[np.float32] | NDArray[np.int32]]:
        """Every array by field name, in a fixed order."""
        return {item.name: getattr(self, item.name) for item in fields(self)}

    def save(self, path: Path, metadata: dict[str, str] | None = None) -> None:
        save_file(
            {name: np.ascontiguousarray(value) for name, value in self.arrays().items()}, path, metadata
        )

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


def _curve(controls: Float32Array, time: float) -> Float32Array | float:
    """(R, K, C) control values to their (R, C) values at `time`; 0 where the channel has no rows."""
    if controls.shape[0] == 0 or controls.shape[1] == 0:
        return 0.0
    first, weights = spline_taps(time, controls.shape[1])
    taps = controls[:, first : first + 4]
    values: Float32Array = np.einsum("k,nkc->nc", weights, taps)
    return values
