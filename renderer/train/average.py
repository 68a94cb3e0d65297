"""The mean of a model over the last steps of its training (Polyak & Juditsky 1992; Izmailov et al. 2018).

Steps from single frames leave every value astray by about the learning rate, each frame towards itself; the
mean of many steps lies closer to what all frames agree on than any one of them.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from renderer.gaussians import DynamicGaussians
from renderer.stored_arrays import Arrays

EVERY: Final = 5
"""Steps from one model that counts to the next."""
PREFIX, COUNT = "average.", "average_count"
"""Of the names in a checkpoint."""


class Average:
    """Of the models after every fifth of the last `steps` of `iterations`; none where `steps` is 0."""

    def __init__(self, iterations: int, steps: int) -> None:
        self._end, self._steps = iterations, steps
        self._count = np.zeros(1, np.int64)
        self._mean: Arrays = {}

    def add(self, model: DynamicGaussians, done: int) -> None:
        """The model after `done` steps, if it counts. Its arrays are as large from the first that does on."""
        left = self._end - done
        if left >= self._steps or left % EVERY:
            return
        self._count += 1
        if self._count[0] == 1:
            self._mean = {name: value.copy() for name, value in model.arrays().items()}
            return
        share = np.float32(1 / self._count[0])
        for name, value in model.arrays().items():
            if np.issubdtype(value.dtype, np.floating):
                self._mean[name] += share * (value - self._mean[name])

    def of(self, model: DynamicGaussians) -> DynamicGaussians:
        """The mean, or the model where nothing counted."""
        return DynamicGaussians.from_arrays(self._mean) if self._count[0] else model

    def state(self) -> Arrays:
        """All that the next step depends on; nothing before the first model that counts."""
        if not self._count[0]:
            return {}
        return {f"{PREFIX}{name}": value for name, value in self._mean.items()} | {COUNT: self._count}

    def restore(self, arrays: Arrays) -> None:
        """Take over what `state` gave, beside the arrays of the model that it is a mean of.

        Raises:
            ValueError: these are not the arrays of such a model.
        """
        mean = {name.removeprefix(PREFIX): value for name, value in arrays.items() if name.startswith(PREFIX)}
        if not mean and COUNT not in arrays:
            return
        count = arrays.get(COUNT)
        if count is None or count.shape != (1,) or count.dtype != np.int64 or count[0] < 1:
            raise ValueError(f"expected an array {COUNT} of one whole number above 0")
        for name, value in mean.items():
            own = arrays.get(name)
            if own is None or own.shape != value.shape or own.dtype != value.dtype:
                raise ValueError(f"expected {PREFIX}{name} as {name} is")
        DynamicGaussians.checked(mean)
        self._mean, self._count = {name: value.copy() for name, value in mean.items()}, count.copy()
