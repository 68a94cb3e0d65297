"""Spherical harmonics of degree 1 to 3 in torch, as in renderer/harmonics.py."""

from __future__ import annotations

import math

import torch
from torch import Tensor

_P1 = math.sqrt(3 / (4 * math.pi))
_D2, _D0, _D22 = (math.sqrt(x / math.pi) for x in (15 / 4, 5 / 16, 15 / 16))
_F3, _F2, _F1, _F0, _F22 = (math.sqrt(x / math.pi) for x in (35 / 32, 105 / 4, 21 / 32, 7 / 16, 105 / 16))


def seen_colors(means: Tensor, harmonics: Tensor, colors: Tensor, center: Tensor) -> Tensor:
    """Colours (N, 3) of means (N, 3) with harmonics (N, B, 3) and colors (N, 3) from `center` (3,)."""
    count = harmonics.shape[1]
    if count == 0:
        return colors
    away = means - center
    # The direction is 0 where the two coincide, and then has no gradient.
    square = (away * away).sum(dim=1, keepdim=True)
    length = torch.where(square > 0, square, 1.0).sqrt()
    functions = _functions(torch.where(square > 0, away / length, 0.0))[:, :count]
    return colors + torch.einsum("nb,nbc->nc", functions, harmonics)


def _functions(directions: Tensor) -> Tensor:
    """(N, 15) at unit vectors (N, 3)."""
    x, y, z = directions.unbind(1)
    xx, yy, zz = x * x, y * y, z * z
    values = [
        -_P1 * y, _P1 * z, -_P1 * x,
        _D2 * x * y, -_D2 * y * z, _D0 * (2 * zz - xx - yy), -_D2 * x * z, _D22 * (xx - yy),
        -_F3 * y * (3 * xx - yy), _F2 * x * y * z, -_F1 * y * (4 * zz - xx - yy),
        _F0 * z * (2 * zz - 3 * xx - 3 * yy), -_F1 * x * (4 * zz - xx - yy), _F22 * z * (xx - yy),
        -_F3 * x * (xx - 3 * yy),
    ]  # fmt: skip
    return torch.stack(values, dim=1)
