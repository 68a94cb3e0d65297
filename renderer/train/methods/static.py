"""`static`: plain 3D Gaussian splatting, for tissue at rest or a single frame."""

from __future__ import annotations

from functools import partial

from renderer.train.config import TrainConfig
from renderer.train.initialize import DETAIL, sampled
from renderer.train.methods.vesselsplat import AVERAGED, losses, row_rates, stages
from renderer.train.needs import Needs
from renderer.train.recipe import Recipe
from renderer.train.still_trainer import StillTrainer


def recipe(config: TrainConfig, needs: Needs) -> Recipe:
    """`vesselsplat` without its motion."""
    return Recipe(
        initialize=partial(sampled, config=config, detail=DETAIL),
        make_trainer=lambda raw, frames, size: StillTrainer(),
        rates=row_rates(config, needs),
        stages=stages(config),
        losses=losses(config, needs),
        averaged_share=AVERAGED,
        sh_degree=needs.sh_degree,
    )
