"""`vesselsplat`, the default: splines in time on position and colour, motion nodes shared by neighbours.

The anti-alias filter (`render_mode` "mip") is off: on held-out training frames of the pulling clip (1000
steps, seed 0) it changes nothing that counts, 37.24 dB and 3.18 mm of depth error for 37.26 dB and 3.20 mm.
Phantoms before a moving camera (500 steps, 8000 Gaussians, seed 0) gain 0.2 dB where they rest, 34.39 for
34.20 dB, and 0.02 dB where they move, in up to a sixth more time: one seed each, too little to switch it on.

There are no motion flags: of the Gaussians trained on the pulling clip none stays within 1 pixel of its mean
place (a tenth within 12), and tissue that rests as a whole has no curves at all (`Needs`).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import Final

import numpy as np

from renderer.clip import Frame
from renderer.deformation.nodes import attach
from renderer.deformation.spline_motion import SplineMotion
from renderer.raw_gaussians import RawGaussians
from renderer.splats import Float32Array
from renderer.train.config import TrainConfig
from renderer.train.initialize import DETAIL, sampled
from renderer.train.losses import LossWeights
from renderer.train.needs import Needs
from renderer.train.rates import Rate, RowRates
from renderer.train.recipe import Recipe, Stage
from renderer.train.spline_trainer import SplineRates, SplineTrainer
from renderer.train.starting_motion import StartingMotion, node_view

OPACITY: Final = 0.03
"""Weight of the loss on alpha."""
REST: Final = 100.0
"""By which the rate of positions falls in the second half of the steps where nothing moves: steps from single
frames keep them astray by about the rate.

On held-out training frames, 1000 steps, for a fall by 3 over all steps: phantoms at rest 47.16 -> 49.90 dB
and, of 640 x 512 pixels, 45.04 -> 48.81 dB; before a camera that moves 43.07 -> 43.55 dB. Falling from the
first step gives the last one 44.4 dB, but what few steps find suffers: depth after 60 by up to a half."""
SETTLING: Final = 300
"""Steps over this is by how much the rate of positions falls where curves move them, but by no less than
other rates fall: as REST says, and in few steps they would not get to where they belong.

On held-out training frames, by 10 for 3: pulling (3000 steps) 39.21 -> 39.29 dB, phantom 43.55 -> 44.17 dB,
mesentery (1500) 36.88 -> 37.04 dB; what is seldom seen -.1, +3.4 and +.8 dB; depth 2.39 -> 2.44, .036 -> .046
and 1.05 -> 1.08 mm. By 30, pulling has 39.36 dB and 2.49 mm."""
AVERAGED: Final = 0.25
"""Share of the steps, at the end, whose mean is the model; with it, rates fall by 3 in place of 10.

On held-out training frames, 3000 steps: pulling (seed 1) 38.62 -> 38.73 dB and 2.75 -> 2.69 mm of depth
error, mesentery 32.68 -> 32.90 dB, phantom 36.17 -> 36.81 dB and 0.26 -> 0.20 mm. Falling by 5 and a share of
0.15: 38.74, 32.94, 36.59 dB."""

LONGEST: Final = 8.0
"""Times its middle standard deviation that the largest of a Gaussian may be. Without it, long trainings leave
needles along edges of tools, which show behind them in the colour of a sliver.

On held-out training frames of pulling, 3000 steps, 20, which is as without, 8 and 4: 39.35, 39.34 and
39.33 dB, 39.43, 39.50 and 39.42 dB of what is seldom seen, 1.5, 0.4 and 0 pixels of specks a frame. In 1000
steps mesentery loses 0.01 and 0.07 dB by 8, of seeds 0.2 dB apart; pulling and phantom have no needles."""


def recipe(config: TrainConfig, needs: Needs) -> Recipe:
    """See TrainConfig, whose fields it is made of."""
    # Where tissue is known to go, Gaussians start where it rests, and curves take them to where it is seen.
    start = needs.followed.motion(needs.n_controls) if needs.followed else None

    def make_trainer(raw: RawGaussians, frames: Sequence[Frame], size: float) -> SplineTrainer:
        return SplineTrainer(_curves(raw, frames, config, needs, start), spline_rates(config, size))

    return Recipe(
        initialize=partial(sampled, config=config, detail=DETAIL, at_rest=start.at_rest if start else None),
        make_trainer=make_trainer,
        rates=row_rates(config, needs),
        stages=stages(config),
        losses=losses(config, needs),
        longest=LONGEST,
        averaged_share=AVERAGED,
        sh_degree=needs.sh_degree,
    )


def stages(config: TrainConfig) -> tuple[Stage, ...]:
    """Coarse to fine."""
    half = round(config.iterations * config.half_resolution_share)
    return Stage(half, half=True), Stage(config.iterations - half)


def losses(config: TrainConfig, needs: Needs) -> LossWeights:
    return LossWeights(opacity=OPACITY, depth=config.depth_weight if needs.has_depth else 0.0)


def row_rates(config: TrainConfig, needs: Needs) -> RowRates:
    """What has no curve in time learns at the rate of the curve.

    Harmonics learn as fast as colours, in place of a 20th as in longer runs (Kerbl et al. 2023): on
    held-out training frames of two phantoms at rest before a moving camera that is 1.7 dB better.
    """
    falling = _falling(config)
    mean_rate = config.mean_rate if needs.moves else config.motion_rate
    colors = falling(config.color_rate if needs.recolors else config.color_motion_rate)
    return RowRates(
        means=_to_rest(config) if needs.rests else falling(mean_rate),
        quats=falling(config.quat_rate),
        log_scales=falling(config.scale_rate),
        opacity_logits=falling(config.opacity_rate),
        colors=colors,
        harmonics=colors,
    )


def spline_rates(config: TrainConfig, size: float) -> SplineRates:
    """Of a scene of this size, in the clip's unit."""
    falling, moving = _falling(config), config.motion_rate * size
    fall = max(config.rate_decay, config.iterations / SETTLING)
    return SplineRates(
        position=Rate(moving, moving / fall, config.iterations),
        color=falling(config.color_motion_rate),
        opacity=falling(0.0),
        smoothing=falling(config.smoothing),
        every_moment="moments" in config.keep,
    )


def _to_rest(config: TrainConfig) -> Rate:
    """Of positions that no curve moves, once they are found."""
    rate, steps = config.motion_rate, config.iterations
    return Rate(rate, rate / REST, steps, held=steps // 2)


def _falling(config: TrainConfig) -> Callable[[float], Rate]:
    """Makes rates that fall by `rate_decay` over the run from their start."""
    return lambda start: Rate(start, start / config.rate_decay, config.iterations)


def _curves(
    raw: RawGaussians,
    frames: Sequence[Frame],
    config: TrainConfig,
    needs: Needs,
    start: StartingMotion | None,
) -> SplineMotion:
    """Those of the nodes as they start, else zero; none where nothing moves."""
    camera, grid = node_view(frames, config.node_columns)
    moving = len(raw) if needs.moves else 0
    indices, weights = attach(raw.means[:moving], camera, grid)

    def zero(count: int, channels: int = 3) -> Float32Array:
        return np.zeros((count, needs.n_controls, channels), np.float32)

    return SplineMotion(
        position_controls=zero(moving),
        color_controls=zero(len(raw) if needs.recolors else 0),
        opacity_controls=zero(0, 1),
        node_controls=start.controls.copy() if start else zero(grid[0] * grid[1] if moving else 0),
        node_indices=indices,
        node_weights=weights,
    )
