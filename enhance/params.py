"""Parameters of the 2D vascular enhancement: one declaration for checks, sliders, flags and JSON."""

from __future__ import annotations

from typing import Annotated, Final, Literal

from annotated_types import Interval, Len, Unit
from pydantic import ConfigDict, model_validator
from pydantic.dataclasses import dataclass

PForm = Literal["literal", "continuous"]
Exponent = Annotated[float, Interval(ge=0.0, le=4.0)]
Radius = Annotated[int, Interval(ge=1, le=512), Unit("px")]
DFactor = Annotated[float, Interval(ge=0.0, le=4.0)]


@dataclass(
    frozen=True,
    kw_only=True,
    config=ConfigDict(extra="forbid", allow_inf_nan=False, use_attribute_docstrings=True),
)
class EnhanceParams:
    """Parameters of Eqs 1-12 of the paper, with their ranges; each is described below its field.

    Raises:
        pydantic.ValidationError: (a ValueError) a value out of its range, or another number of P than of
            scales.

    Example:
        >>> from enhance import EnhanceParams
        >>> params = EnhanceParams(z=0.4, p=(0.5, 0.5, 1.0))  # brightness given, stronger large-scale detail
        >>> params.radii
        (4, 16, 64)
    """

    z: Annotated[float, Interval(ge=0.0, le=1.0)] | None = None
    """Brightness factor of Eq 1: 0 lifts dark areas most, 1 leaves brightness unchanged. Auto: from the
    image, by Eq 2."""
    p: Exponent | tuple[Exponent, ...] | None = None
    """Strength of local detail, the exponent P of Eq 7: 0 is off. One number, or one for each scale.
    Auto: from the image, by Eq 9."""
    p_form: PForm = "literal"
    """Eq 9 as printed, or the middle branch continued until it meets the outer two (no jumps)."""
    radii: Annotated[tuple[Radius, ...], Len(1, 6)] = (4, 16, 64)
    """Window radii of the guided filters, one for each scale; a window is 2 r + 1 pixels wide."""
    eps: Annotated[float, Interval(ge=1e-6, le=1.0)] = 0.0025
    """Regularisation of the guided filter, a variance on [0, 1]: larger smooths stronger edges away."""
    subsample: Annotated[int, Interval(ge=1, le=8)] = 2
    """The guided filter's coefficients are computed on an image this many times smaller, those of wide
    windows on one half that size. 1: at full size."""
    d_factor: DFactor | None = None
    """Multiplies d in Eq 11: smaller means more colour. 0 leaves saturation unchanged. Auto: 1, but less of
    the stretch where colours are faint beside their noise."""
    keep_black: bool = True
    """Keep the black surround of an endoscope black; without it, black becomes grey 51 at z = 0."""
    omit_below: Annotated[float, Interval(ge=0.0, le=1.0)] = 0.5
    """Leave out steps known to change the result by less than this, in grey levels. 0: only steps that
    change nothing."""
    strength: Annotated[float, Interval(ge=0.0, le=2.0)] = 1.0
    """How much of the whole enhancement: 1 is the paper's, 0 leaves the image as it is. Multiplies 1 - z, P
    and, up to 1, the change of saturation, set or automatic."""

    @property
    def k(self) -> float:
        """d_factor as given, else 1."""
        return 1.0 if self.d_factor is None else self.d_factor

    @model_validator(mode="after")
    def _one_p_a_scale(self) -> EnhanceParams:
        if isinstance(self.p, tuple) and len(self.p) != len(self.radii):
            raise ValueError(f"expected one p, or one for each of {len(self.radii)} radii, got {self.p}")
        return self


DEFAULTS: Final = EnhanceParams()
