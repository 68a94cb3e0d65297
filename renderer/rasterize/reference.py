"""The literal float64 reading of projection (paper Eqs 13-15) and blending (Eq 16): slow, the oracle.

`blend` is the statement: every pixel looks at every splat, with no bounds and no fast exponential. A
picture asks it for one window after another, each with the splats whose alpha can reach the cut-off
there, since the others would add exact zeros. The faster rasterisers and the OpenGL drawing are judged
against it, values and gradients alike.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from typing import Final

import torch
from torch import Tensor

from renderer.camera import Camera
from renderer.in_view import InView
from renderer.rasterize.crossings import crossings
from renderer.splats import RenderMode

LOW_PASS = 0.3
"""Variance in px^2 added to every projected splat, so that none is thinner than a pixel."""
ALPHA_MAX = 0.99
ALPHA_CUT = 1 / 255
STOP = 1e-4
"""A pixel takes no further splat once its transmittance is below this."""
GUARD_BAND = 0.3
"""How far outside the image the Jacobian still follows the mean, in half widths of the image."""

_ENTRIES_PER_WINDOW: Final = 1 << 16
"""Pairs of a pixel and a splat that are blended at once: float64 arrays of them stay in the cache."""
_ROUNDING: Final = 1e-6
"""Of a reach, and pixels beyond it: far more than float64 loses, and splats too many cost time alone."""


@dataclass(frozen=True, eq=False)
class Rendered:
    """One view, float64: image (H, W, 3); alpha (H, W) in [0, 1]; depth (H, W) expected depth along
    +z in scene units, 0 where alpha is 0."""

    image: Tensor
    alpha: Tensor
    depth: Tensor


@dataclass(frozen=True, eq=False)
class Projected:
    """The M splats in front of the near plane, nearest first, float64.

    `indices` (M,) rows of the input; `centers` (M, 2) in pixels; `depths` (M,) along +z;
    `covariances` (M, 2, 2) in px^2, low-pass included; `determinants` (M,) of the covariances, from
    a sum of squares that stays accurate where a c - b^2 cancels; `sharp_determinants` (M,) without low-pass.
    """

    indices: Tensor
    centers: Tensor
    depths: Tensor
    covariances: Tensor
    determinants: Tensor
    sharp_determinants: Tensor

    def among(self, rows: Tensor) -> Projected:
        """Those of `rows` alone, in their order."""
        return Projected(*(getattr(self, item.name)[rows] for item in fields(self)))


def rasterize_reference(
    means: Tensor,
    quats: Tensor,
    scales: Tensor,
    opacities: Tensor,
    colors: Tensor,
    camera: Camera,
    background: Tensor | Sequence[float] = (0.0, 0.0, 0.0),
    *,
    near: float = 0.01,
    mode: RenderMode = "default",
    within: InView | None = None,
) -> Rendered:
    """Render N splats in float64, differentiable by autograd in the first five arguments.

    means (N, 3) world; quats (N, 4) wxyz of any length, the zero quaternion being no rotation;
    scales (N, 3) standard deviations; opacities (N,) in [0, 1]; colors (N, 3) and background (3,) RGB.
    `near` is in scene units; splats with z <= near are dropped. The splats are blended by camera
    depth, ties by row: alpha = min(0.99, o exp(-d' conic d / 2)), none below 1/255, and none once the
    transmittance is below 1e-4. The cut-offs and the sort carry no gradient. `mode` "mip" makes up for the
    low-pass filter, see RenderMode. Splats end at the sides of `within`.

    Raises:
        ValueError: shapes that do not agree.

    Source: paper Eqs 13-16; 3D Gaussian Splatting (Kerbl et al. 2023); EWA splatting (Zwicker et al. 2001);
    Mip-Splatting (Yu et al. 2024).
    """
    behind = torch.as_tensor(background, dtype=torch.float64, device=means.device)
    count, given = len(means), (means, quats, scales, opacities, colors, behind)
    shapes = [tuple(value.shape) for value in given]
    if shapes != [(count, 3), (count, 4), (count, 3), (count,), (count, 3), (3,)]:
        raise ValueError(f"expected values of {count} splats and a background of three numbers, got {shapes}")
    projected = project(means, quats, scales, camera, near=near)
    front = projected.indices
    opaque = opacities.double()[front]
    if mode == "mip":
        opaque = opaque * (projected.sharp_determinants / projected.determinants).sqrt()
    lines = None if within is None else _crossings(means, quats, scales, front, camera, within)
    splats = _Sorted(projected, opaque, colors.double()[front], _reach(projected, opaque), lines)
    everything = torch.arange(len(front), device=means.device)
    return splats.picture(_Window(0, 0, camera.width, camera.height), everything, behind)


def project(means: Tensor, quats: Tensor, scales: Tensor, camera: Camera, *, near: float = 0.01) -> Projected:
    """Centres, depths and image covariances of the splats beyond `near`, nearest first (Eqs 14, 15)."""
    pose = torch.as_tensor(camera.camera_from_world.copy(), device=means.device)
    local = means.double() @ pose[:3, :3].T + pose[:3, 3]
    order = torch.sort(local[:, 2].detach(), stable=True).indices
    order = order[local[order, 2] > near]
    local = local[order]
    x, y, z = local.unbind(1)
    centers = torch.stack([camera.fx * x / z + camera.cx, camera.fy * y / z + camera.cy], dim=1)
    spread = rotations(quats.double()[order]) * scales.double()[order, None, :]
    factor = _jacobians(local, camera) @ pose[:3, :3] @ spread  # (M, 2, 3); Sigma' = factor factor'
    low_pass = LOW_PASS * torch.eye(2, dtype=torch.float64, device=means.device)
    first, second = factor.unbind(1)
    minors = torch.linalg.cross(first, second)
    sharp = (minors**2).sum(1)
    determinants = sharp + LOW_PASS * (factor**2).sum((1, 2)) + LOW_PASS**2
    return Projected(order, centers, z, factor @ factor.mT + low_pass, determinants, sharp)


def _crossings(
    means: Tensor, quats: Tensor, scales: Tensor, rows: Tensor, camera: Camera, within: InView
) -> Tensor:
    """(rows, S, 3) where splats cross the sides, without a gradient: see crossings.py."""
    centers, turns, sizes = (value.detach()[rows].double().cpu().numpy() for value in (means, quats, scales))
    return torch.from_numpy(crossings(centers, turns, sizes, camera, within)).to(means.device)


def rotations(quats: Tensor) -> Tensor:
    """Rotation matrices (N, 3, 3) of quaternions (N, 4) wxyz of any length; zero gives the identity."""
    is_zero = (quats == 0).all(1, keepdim=True)
    identity = quats.new_tensor([1.0, 0.0, 0.0, 0.0])
    quats = torch.where(is_zero, identity, quats)
    w, x, y, z = (quats / quats.norm(dim=1, keepdim=True)).unbind(1)
    entries = [
        1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y),
        2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x),
        2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y),
    ]  # fmt: skip
    return torch.stack(entries, dim=1).reshape(-1, 3, 3)


def _jacobians(local: Tensor, camera: Camera) -> Tensor:
    """(M, 2, 3) derivative of the pixel position at `local`, whose ray is held inside the guard band."""
    x, y, z = local.unbind(1)
    band_x = GUARD_BAND * 0.5 * camera.width / camera.fx
    band_y = GUARD_BAND * 0.5 * camera.height / camera.fy
    right = (camera.width - camera.cx) / camera.fx + band_x
    down = (camera.height - camera.cy) / camera.fy + band_y
    slope_x = (x / z).clamp(-camera.cx / camera.fx - band_x, right)
    slope_y = (y / z).clamp(-camera.cy / camera.fy - band_y, down)
    zero = torch.zeros_like(z)
    along_x = torch.stack([camera.fx / z, zero, -camera.fx * slope_x / z], dim=1)
    along_y = torch.stack([zero, camera.fy / z, -camera.fy * slope_y / z], dim=1)
    return torch.stack([along_x, along_y], dim=1)


@dataclass(frozen=True)
class _Window:
    """Pixels of the picture."""

    left: int
    top: int
    width: int
    height: int

    @property
    def halves(self) -> tuple[_Window, _Window]:
        """Side by side where it is wide, one above the other where it is high."""
        if self.width >= self.height:
            half = self.width // 2
            rest = replace(self, left=self.left + half, width=self.width - half)
            return replace(self, width=half), rest
        half = self.height // 2
        rest = replace(self, top=self.top + half, height=self.height - half)
        return replace(self, height=half), rest

    def centers(self, device: torch.device) -> tuple[Tensor, Tensor]:
        """y (height,) and x (width,) of its pixels."""
        down = torch.arange(self.top, self.top + self.height, dtype=torch.float64, device=device)
        across = torch.arange(self.left, self.left + self.width, dtype=torch.float64, device=device)
        return down + 0.5, across + 0.5


@dataclass(frozen=True, eq=False)
class _Sorted:
    """Splats, nearest first, with what `blend` takes of each and how far it reaches (M, 2)."""

    projected: Projected
    opacities: Tensor
    colors: Tensor
    reach: Tensor
    lines: Tensor | None
    """(M, S, 3) where they cross the sides of what bounds them."""

    def picture(self, window: _Window, rows: Tensor, background: Tensor) -> Rendered:
        """Of the splats `rows`, in their order; in halves where the window has too many entries."""
        down, across = window.centers(rows.device)
        rows = rows[~self._misses(rows, down, across)]
        pixels = window.width * window.height
        if pixels > 1 and pixels * len(rows) > _ENTRIES_PER_WINDOW:
            halves = [self.picture(half, rows, background) for half in window.halves]
            side = int(window.width >= window.height)
            parts = [[getattr(half, item.name) for half in halves] for item in fields(Rendered)]
            return Rendered(*(torch.cat(pair, side) for pair in parts))
        chosen = self.projected.among(rows)
        lines = None if self.lines is None else self.lines[rows]
        return blend(chosen, self.opacities[rows], self.colors[rows], down, across, background, lines)

    def _misses(self, rows: Tensor, down: Tensor, across: Tensor) -> Tensor:
        """(rows,) whether alpha is below the cut-off at all these pixels; a broken splat misses none."""
        first, last = torch.stack([across[0], down[0]]), torch.stack([across[-1], down[-1]])
        centers, reach = self.projected.centers.detach()[rows], self.reach[rows]
        return ((first - centers > reach) | (centers - last > reach)).any(1)


def _reach(projected: Projected, opacities: Tensor) -> Tensor:
    """(M, 2) pixels along x and y from the centre to the farthest point whose alpha is the cut-off: half the
    box of the ellipse d' conic d = 2 ln(opacity / cut-off). Less than any distance where opacity is less."""
    radii = (2 * torch.log(opacities / ALPHA_CUT)).clamp(min=0).sqrt()
    deviations = projected.covariances.diagonal(dim1=1, dim2=2).sqrt()
    reach = radii[:, None] * deviations * (1 + _ROUNDING) + _ROUNDING
    return torch.where((opacities < ALPHA_CUT)[:, None], -torch.inf, reach).detach()


def blend(
    projected: Projected,
    opacities: Tensor,
    colors: Tensor,
    rows: Tensor,
    columns: Tensor,
    background: Tensor,
    lines: Tensor | None = None,
) -> Rendered:
    """Eq 16, literally, over the pixels at `rows` (H,) x `columns` (W,), by which every splat is looked at.

    `opacities` (M,) and `colors` (M, 3) are those of `projected`, nearest first; `background` (3,); `lines`
    (M, S, 3) where they are cut off, see crossings.py.
    """
    dx = columns[None, :, None] - projected.centers[:, 0]
    dy = rows[:, None, None] - projected.centers[:, 1]
    # d' conic d by the Cholesky factor of the covariance, a sum of squares: never negative.
    variance = projected.covariances[:, 0, 0]
    shear = projected.covariances[:, 0, 1] / variance
    distance = dx**2 / variance + (dy - shear * dx) ** 2 * (variance / projected.determinants)
    alphas = (opacities * torch.exp(-0.5 * distance)).clamp(max=ALPHA_MAX)
    if lines is not None:
        distances = lines[..., 0] + dx[..., None] * lines[..., 1] + dy[..., None] * lines[..., 2]
        alphas = alphas * (distances.amin(-1) + 0.5).clamp(0.0, 1.0)
    alphas = torch.where(alphas >= ALPHA_CUT, alphas, 0.0)
    clear = torch.ones_like(alphas[..., :1])
    transmittance = torch.cumprod(torch.cat([clear, 1 - alphas[..., :-1]], dim=2), dim=2)[
        ..., : len(opacities)
    ]
    weights = torch.where(transmittance >= STOP, alphas * transmittance, 0.0)
    alpha = weights.sum(2)
    image = weights @ colors + (1 - alpha)[..., None] * background
    covered = alpha > 0
    depth = torch.where(covered, weights @ projected.depths / torch.where(covered, alpha, 1.0), 0.0)
    return Rendered(image, alpha, depth)
