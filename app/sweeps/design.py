"""Points drawn from ranges of settings: at random, or as a Latin hypercube."""

from __future__ import annotations

import math
from typing import Annotated, Final, Literal, Self

import numpy as np
from annotated_types import Interval, Len
from pydantic import ConfigDict, Field, model_validator
from pydantic.dataclasses import dataclass

from app.sweeps.names import BY_NAME

STRICT: Final = ConfigDict(extra="forbid", allow_inf_nan=False, use_attribute_docstrings=True)


@dataclass(frozen=True, kw_only=True, config=STRICT)
class Range:
    """Of a setting, both ends included."""

    first: Annotated[float, Field(alias="from")]
    last: Annotated[float, Field(alias="to")]
    scale: Literal["linear", "log"] = "linear"
    whole: bool = False
    """Whole numbers only."""

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        if not self.first < self.last:
            raise ValueError(f"expected from < to, got {self.first:g} and {self.last:g}")
        if self.scale == "log" and self.first <= 0:
            raise ValueError(f"expected from > 0 on a log scale, got {self.first:g}")
        if self.whole and math.ceil(self.first) > math.floor(self.last):
            raise ValueError(f"expected a whole number between, got {self.first:g} and {self.last:g}")
        return self

    def at(self, share: float) -> float | int:
        """The value so far along the range, share in [0, 1]; to six digits, so that it can be typed again."""
        if self.scale == "log":
            value = self.first * (self.last / self.first) ** share
        else:
            value = self.first + share * (self.last - self.first)
        if self.whole:
            return int(min(max(round(value), math.ceil(self.first)), math.floor(self.last)))
        return min(max(float(f"{value:.6g}"), self.first), self.last)


@dataclass(frozen=True, kw_only=True, config=STRICT)
class Sample:
    """Points in the box of all ranges."""

    count: Annotated[int, Interval(ge=1, le=100_000)]
    ranges: Annotated[dict[str, Range], Len(1, 100), BY_NAME]
    design: Literal["random", "latin hypercube"] = "latin hypercube"
    """A Latin hypercube has one point in each of `count` equal parts of every range (McKay et al. 1979)."""
    seed: Annotated[int, Interval(ge=0, le=2**31 - 1)] = 0

    def points(self) -> list[dict[str, float | int]]:
        """The same for the same seed."""
        random = np.random.default_rng(self.seed)
        shares = random.random((len(self.ranges), self.count))
        if self.design == "latin hypercube":
            parts = np.stack([random.permutation(self.count) for _ in self.ranges])
            shares = (parts + shares) / self.count
        columns = [
            [one.at(share) for share in row] for one, row in zip(self.ranges.values(), shares, strict=True)
        ]
        return [dict(zip(self.ranges, point, strict=True)) for point in zip(*columns, strict=True)]
