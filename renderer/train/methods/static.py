"""`static`: plain 3D Gaussian splatting, for tissue at rest or a single frame."""

from __future__ import annotations

from functools import partial

from renderer.clip import Clip
from renderer.train.config import TrainConfig
from renderer.train.initialize import sampled
from renderer.train.methods.vesselsplat import losses, row_rates, stages
from renderer.train.recipe import Recipe
from renderer.train.still_trainer import StillTrainer


def recipe(clip: Clip, config: TrainConfig) -> Recipe:
    """`vesselsplat` without its motion."""
    return Recipe(
        initialize=partial(sampled, config=config),
        make_trainer=lambda raw, frames, size: StillTrainer(),
        rates=row_rates(config),
        stages=stages(config),
        losses=losses(config),
    )
