"""Windows and exponents of the paper's method, one a scale: adding, removing, setting apart."""

from __future__ import annotations

from dataclasses import replace

from enhance import EnhanceParams

MOST_SCALES = 5
LARGEST_RADIUS = 512


def exponents(params: EnhanceParams, used: tuple[float, ...]) -> tuple[float, ...]:
    """P of each scale: as set, or as used where it is automatic, or 0.5 where nothing is known."""
    count = len(params.radii)
    if isinstance(params.p, tuple):
        return params.p
    if params.p is not None:
        return (params.p,) * count
    return used if len(used) == count else (0.5,) * count


def with_scale(params: EnhanceParams) -> EnhanceParams:
    """One more scale, twice as wide as the widest."""
    if len(params.radii) >= MOST_SCALES:
        return params
    radii = (*params.radii, min(2 * max(params.radii), LARGEST_RADIUS))
    p = (*params.p, params.p[-1]) if isinstance(params.p, tuple) else params.p
    return replace(params, radii=radii, p=p)


def without_scale(params: EnhanceParams, index: int) -> EnhanceParams:
    """Without that scale; the last one stays."""
    if len(params.radii) < 2:
        return params
    kept = [place for place in range(len(params.radii)) if place != index]
    p = tuple(params.p[place] for place in kept) if isinstance(params.p, tuple) else params.p
    return replace(params, radii=tuple(params.radii[place] for place in kept), p=p)


def with_radius(params: EnhanceParams, index: int, radius: int) -> EnhanceParams:
    radii = list(params.radii)
    radii[index] = radius
    return replace(params, radii=tuple(radii))


def with_exponent(params: EnhanceParams, index: int, p: float, used: tuple[float, ...]) -> EnhanceParams:
    """P of one scale; those of the others become their own, too."""
    values = list(exponents(params, used))
    values[index] = p
    return replace(params, p=tuple(values))


def together(params: EnhanceParams) -> EnhanceParams:
    """One P for all scales: the mean of what they had."""
    if not isinstance(params.p, tuple):
        return params
    return replace(params, p=round(sum(params.p) / len(params.p), 2))
