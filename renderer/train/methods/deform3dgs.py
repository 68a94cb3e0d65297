"""`deform3dgs`: Deform3DGS (Yang et al., MICCAI 2024), moving tissue by bumps in time for each Gaussian.

Its rates were published for millimetres; divided by the scene size of the clip that they were published
for, they are free of the unit. Departures:

* centres stay, widths start so that no time lies between two bumps; published: 0.01, with gaps of 9 frames;
* the points are of the frames to fit alone; published: of the test frames too;
* depth is expected depth, moves Gaussians along the view; published: not divided by alpha, no gradient to z;
* depth is supervised as it is read, where it is measured alone; published: each frame's is clipped to its 3rd
  to 99.8th percentile, which takes unknown depth (0) for near tissue and supervises it;
* the moments of bumps that do not count at a frame's time rest; published: they decay;
* spherical harmonics for a moving camera alone; published: for every camera;
* every frame once an epoch; published: drawn with replacement;
* no reset of opacities; published: at the last step.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

from renderer.clip import Frame
from renderer.deformation.fdm import FlexibleMotion
from renderer.raw_gaussians import RawGaussians
from renderer.train.config import TrainConfig
from renderer.train.densify import DensityControl
from renderer.train.fdm_trainer import FdmRates, FdmTrainer
from renderer.train.fusion import fused
from renderer.train.losses import LossWeights
from renderer.train.needs import Needs
from renderer.train.rates import Rate, RowRates
from renderer.train.recipe import Recipe, Stage

FUNCTIONS = 17
INITIAL_WIDTH = 1 / (FUNCTIONS - 1)
"""As wide as centres are apart."""
MILLIMETRES = 68.0
"""Scene size of the pulling clip, for which lengths and rates were published."""
FALL, FALL_STEPS = 100.0, 4 / 3
"""Rates of positions and bumps fall by this over so many runs of the configured length."""
PER_COLOR = 0.28209479177387814
"""RGB by the harmonic coefficient of degree 0, whose rate is published."""


def recipe(config: TrainConfig, needs: Needs) -> Recipe:
    """Uses `iterations`, `n_gaussians` and `seed`; all else is as published."""

    def make_trainer(raw: RawGaussians, frames: Sequence[Frame], size: float) -> FdmTrainer:
        motion = FlexibleMotion.at_rest(len(raw), FUNCTIONS, INITIAL_WIDTH)
        position = _falling(1.6e-3 / MILLIMETRES * size, config)
        return FdmTrainer(motion, FdmRates(position=position, other=_falling(1.6e-3, config)))

    return Recipe(
        initialize=partial(fused, config=config),
        make_trainer=make_trainer,
        rates=RowRates(
            means=_falling(1.6e-3 / MILLIMETRES, config),
            quats=Rate.constant(1e-3),
            log_scales=Rate.constant(5e-3),
            opacity_logits=Rate.constant(5e-2),
            colors=Rate.constant(2.5e-3 * PER_COLOR),
            harmonics=Rate.constant(2.5e-3 / 20),
        ),
        stages=(Stage(config.iterations),),
        sh_degree=needs.sh_degree,
        losses=LossWeights(inverse_depth=1 / MILLIMETRES),
        density=DensityControl(seed=config.seed),
    )


def _falling(start: float, config: TrainConfig) -> Rate:
    return Rate(start, start / FALL, round(FALL_STEPS * config.iterations))
