"""`vesselsplat`, the default: splines in time on position and colour, motion nodes shared by neighbours."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial

import numpy as np

from renderer.clip import Clip, Frame
from renderer.deformation.nodes import attach, node_grid
from renderer.deformation.spline import controls_for
from renderer.deformation.spline_motion import SplineMotion
from renderer.raw_gaussians import RawGaussians
from renderer.train.config import TrainConfig
from renderer.train.initialize import sampled
from renderer.train.losses import LossWeights
from renderer.train.rates import Rate, RowRates
from renderer.train.recipe import Recipe, Stage
from renderer.train.spline_trainer import SplineRates, SplineTrainer


def recipe(clip: Clip, config: TrainConfig) -> Recipe:
    """See TrainConfig, whose fields it is made of."""
    n_controls = controls_for(len(clip)) if config.n_controls is None else config.n_controls

    def make_trainer(raw: RawGaussians, frames: Sequence[Frame], size: float) -> SplineTrainer:
        return SplineTrainer(_at_rest(raw, frames, n_controls, config), _spline_rates(config, size))

    return Recipe(
        initialize=partial(sampled, config=config),
        make_trainer=make_trainer,
        rates=row_rates(config),
        stages=stages(config),
        losses=losses(config),
    )


def stages(config: TrainConfig) -> tuple[Stage, ...]:
    """Coarse to fine."""
    half = round(config.iterations * config.half_resolution_share)
    return Stage(half, half=True), Stage(config.iterations - half)


def losses(config: TrainConfig) -> LossWeights:
    return LossWeights(depth=config.depth_weight)


def row_rates(config: TrainConfig) -> RowRates:
    falling = _falling(config)
    return RowRates(
        means=falling(config.mean_rate),
        quats=falling(config.quat_rate),
        log_scales=falling(config.scale_rate),
        opacity_logits=falling(config.opacity_rate),
        colors=falling(config.color_rate),
        harmonics=falling(config.color_rate / 20),
    )


def _spline_rates(config: TrainConfig, size: float) -> SplineRates:
    falling = _falling(config)
    return SplineRates(
        position=falling(config.motion_rate * size),
        color=falling(config.color_motion_rate),
        opacity=falling(0.0),
        smoothing=falling(config.smoothing),
    )


def _falling(config: TrainConfig) -> Callable[[float], Rate]:
    """Makes rates that fall by `rate_decay` over the run from their start."""
    return lambda start: Rate(start, start / config.rate_decay, config.iterations)


def _at_rest(
    raw: RawGaussians, frames: Sequence[Frame], n_controls: int, config: TrainConfig
) -> SplineMotion:
    """Curves that are zero, on nodes over the view of the first frame that has depth."""
    camera = next(frame.camera for frame in frames if frame.depth_mask.any())
    grid = node_grid(camera, config.node_columns)
    indices, weights = attach(raw.means, camera, grid)
    return SplineMotion(
        position_controls=np.zeros((len(raw), n_controls, 3), np.float32),
        color_controls=np.zeros((len(raw), n_controls, 3), np.float32),
        opacity_controls=np.zeros((0, n_controls, 1), np.float32),
        node_controls=np.zeros((grid[0] * grid[1], n_controls, 3), np.float32),
        node_indices=indices,
        node_weights=weights,
    )
