"""The model in training: parameters, their Adam moments, and one step on one frame. No torch."""

from __future__ import annotations

from copy import deepcopy
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from renderer.deformation.nodes import Attachment, gather_gradients
from renderer.deformation.spline import spline_taps
from renderer.gaussians import DynamicGaussians
from renderer.rasterize.cpu import Gradients, Rasterizer
from renderer.splats import Splats
from renderer.train.adam import corrected_rate, update_rows, update_taps
from renderer.train.config import TrainConfig
from renderer.train.frames import TrainFrame
from renderer.train.losses import COLOR_LOSS, DEPTH_LOSS, SQUARED_ERROR, masked_loss

Float32Array = NDArray[np.float32]
ROWS = ("means", "quats", "log_scales", "opacity_logits", "colors")
CURVES = ("position_controls", "color_controls", "node_controls")
NEAR_SHARE = 1e-3
"""Near plane as a share of the scene size."""


@dataclass(frozen=True)
class StepResult:
    """What one step measured before its update."""

    loss: float
    squared_error: float
    """Mean over supervised pixels and channels."""


class TrainModel:
    """Trains a DynamicGaussians in place. `size` is the scene size in the clip's unit."""

    def __init__(self, gaussians: DynamicGaussians, config: TrainConfig, size: float) -> None:
        self.gaussians = gaussians
        self._config, self._size = config, size
        self._first = {name: np.zeros_like(getattr(gaussians, name)) for name in (*ROWS, *CURVES)}
        self._second = {name: np.zeros_like(getattr(gaussians, name)) for name in (*ROWS, *CURVES)}
        self._tap_steps = np.zeros(gaussians.n_controls, np.int64)
        n_nodes = len(gaussians.node_controls)
        self._attachment = Attachment.transposed(gaussians.node_indices, gaussians.node_weights, n_nodes)
        self._rasterizers: dict[tuple[int, int], Rasterizer] = {}

    def arrays(self) -> dict[str, NDArray[np.float32] | NDArray[np.int32] | NDArray[np.int64]]:
        """Parameters, moments and counters: all that the next step depends on."""
        state: dict[str, NDArray[np.float32] | NDArray[np.int32] | NDArray[np.int64]] = {}
        state.update(self.gaussians.arrays())
        for name in (*ROWS, *CURVES):
            state[f"first.{name}"], state[f"second.{name}"] = self._first[name], self._second[name]
        state["tap_steps"] = self._tap_steps
        return state

    def restore(self, arrays: dict[str, NDArray[np.float32] | NDArray[np.int32] | NDArray[np.int64]]) -> None:
        """Take over what `arrays` gave."""
        for name, own in self.arrays().items():
            own[...] = arrays[name]

    def snapshot(self) -> DynamicGaussians:
        """A copy that later steps leave alone."""
        return deepcopy(self.gaussians)

    def step(self, frame: TrainFrame, iteration: int) -> StepResult:
        """One update from one frame; `iteration` counts from 0."""
        config = self._config
        splats = self.gaussians.at(frame.time)
        rasterizer = self._rasterizer(frame)
        rasterizer.forward(splats, frame.camera, NEAR_SHARE * self._size, frame.tile_wanted)
        result = self._loss(rasterizer, frame)
        gradients = rasterizer.backward(splats)
        decay = config.rate_decay ** (-iteration / config.iterations)
        self._update_rows(splats, gradients, rasterizer.visible, corrected_rate(decay, iteration + 1))
        self._update_curves(frame.time, gradients, rasterizer.visible, decay)
        return result

    def _rasterizer(self, frame: TrainFrame) -> Rasterizer:
        size = (frame.camera.width, frame.camera.height)
        if size not in self._rasterizers:
            self._rasterizers = {size: Rasterizer(*size)}
        return self._rasterizers[size]

    def _loss(self, rasterizer: Rasterizer, frame: TrainFrame) -> StepResult:
        per_color = 1.0 / max(3 * frame.n_colors, 1)
        per_depth = self._config.depth_weight / (max(frame.n_depths, 1) * self._size)
        rows = np.empty((frame.color_mask.shape[0], 3))
        masked_loss(
            rasterizer.planes, frame.colors, frame.color_mask, frame.depth, frame.tile_wanted,
            per_color, per_depth, rasterizer.adjoint, rows,
        )  # fmt: skip
        sums = rows.sum(axis=0)
        loss = per_color * sums[COLOR_LOSS] + per_depth * sums[DEPTH_LOSS]
        return StepResult(float(loss), float(per_color * sums[SQUARED_ERROR]))

    def _update_rows(
        self, splats: Splats, gradients: Gradients, seen: NDArray[np.bool_], rate: float
    ) -> None:
        config, model = self._config, self.gaussians
        by_logits = gradients.opacities * splats.opacities * (1 - splats.opacities)
        updates = {
            "means": (gradients.means, config.mean_rate * self._size),
            "quats": (gradients.quats, config.quat_rate),
            "log_scales": (gradients.scales * splats.scales, config.scale_rate),
            "colors": (gradients.colors, config.color_rate),
        }
        for name, (gradient, own_rate) in updates.items():
            moments = self._first[name], self._second[name]
            update_rows(getattr(model, name), gradient, *moments, seen, rate * own_rate)
        name = "opacity_logits"
        update_rows(
            model.opacity_logits[:, None], by_logits[:, None], self._first[name][:, None],
            self._second[name][:, None], seen, rate * config.opacity_rate,
        )  # fmt: skip

    def _update_curves(
        self, time: float, gradients: Gradients, seen: NDArray[np.bool_], decay: float
    ) -> None:
        config, model = self._config, self.gaussians
        if not model.n_controls or not len(model.position_controls):
            return
        start, weights = spline_taps(time, model.n_controls)
        self._tap_steps[start : start + 4] += 1
        corrected = [decay * corrected_rate(1.0, int(steps)) for steps in self._tap_steps[start : start + 4]]
        rates = np.array(corrected, np.float32)
        by_nodes = np.empty((len(model.node_controls), 3), np.float32)
        touched = np.empty(len(by_nodes), bool)
        links = self._attachment
        gather_gradients(links.starts, links.gaussians, links.weights, gradients.means, by_nodes, touched)
        motion = config.motion_rate * self._size
        updates = {
            "position_controls": (gradients.means, seen, motion),
            "color_controls": (gradients.colors, seen, config.color_motion_rate),
            "node_controls": (by_nodes, touched, motion),
        }
        for name, (gradient, wanted, own_rate) in updates.items():
            update_taps(
                getattr(model, name), gradient, self._first[name], self._second[name], wanted,
                start, weights, rates * np.float32(own_rate), config.smoothing * decay,
            )  # fmt: skip
