"""The methods of reconstruction: each file is a preset over the same parts, with its departures stated."""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import replace
from inspect import cleandoc

from renderer.train.config import Method, TrainConfig
from renderer.train.methods import deform3dgs, endogaussian, static, vesselsplat
from renderer.train.needs import Needs
from renderer.train.recipe import Recipe
from renderer.train.still_trainer import StillTrainer

RECIPES: dict[Method, Callable[[TrainConfig, Needs], Recipe]] = {
    "vesselsplat": vesselsplat.recipe,
    "deform3dgs": deform3dgs.recipe,
    "endogaussian": endogaussian.recipe,
    "static": static.recipe,
}


def departures(method: Method) -> str:
    """What the method is and where it departs from its publication, as its file says."""
    return cleandoc(sys.modules[RECIPES[method].__module__].__doc__ or "")


def recipe_for(config: TrainConfig, needs: Needs) -> Recipe:
    """The method that `config` asks for, as a clip needs it."""
    recipe = replace(
        RECIPES[config.method](config, needs),
        every_tile="tiles" in config.keep,
        every_moment="moments" in config.keep,
        mode=config.render_mode,
    )
    if needs.moves or needs.recolors:
        return recipe
    return replace(recipe, make_trainer=lambda raw, frames, size: StillTrainer())
