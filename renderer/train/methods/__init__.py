"""The methods of reconstruction: each file is a preset over the same parts, with its departures stated."""

from __future__ import annotations

from collections.abc import Callable

from renderer.clip import Clip
from renderer.train.config import Method, TrainConfig
from renderer.train.methods import deform3dgs, endogaussian, static, vesselsplat
from renderer.train.recipe import Recipe

RECIPES: dict[Method, Callable[[Clip, TrainConfig], Recipe]] = {
    "vesselsplat": vesselsplat.recipe,
    "deform3dgs": deform3dgs.recipe,
    "endogaussian": endogaussian.recipe,
    "static": static.recipe,
}


def recipe_for(clip: Clip, config: TrainConfig) -> Recipe:
    """The method that `config` asks for, as this clip needs it."""
    return RECIPES[config.method](clip, config)
