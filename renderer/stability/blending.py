"""Eq 16: pictures, expected depth and gradients of splats that are hard to draw, against float64."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, Final

import numpy as np
from numba import njit
from numpy.typing import NDArray

from renderer.camera import Camera
from renderer.rasterize.cpu import BLACK, Rasterizer, render
from renderer.rasterize.exp2 import exp2
from renderer.splats import Float32Array, Splats
from renderer.stability.row import Row
from renderer.stability.scenes import CAMERA, NEAR, SCENES, joined, ordinary, stacked
from renderer.torch_presence import has_torch

if TYPE_CHECKING:
    from torch import Tensor

Draw = Callable[[Splats, Camera, float], Float32Array]
"""Splats, camera and near plane to a picture (H, W, 3) over black."""
NAMES: Final = ("means", "quats", "scales", "opacities", "colors")
MILLION: Final = 1_000_000
STOPPED: Final = 0.03
"""Grey levels: what lies behind a transmittance of 1e-4 may add so much."""
CUT: Final = 1.0
"""Grey levels: a contribution at the cut of 1/255 falls to either side of it."""


def rows() -> Iterator[Row]:
    """Of the CPU rasteriser; without torch, those that need no float64 oracle."""
    yield _exponential()
    if has_torch():
        yield from pictures("blending (16): picture", lambda *scene: render(*scene[:2], near=scene[2]).image)
        yield from _depths()
        yield from _gradients()
    yield from _overlapping()
    yield from _poisoned()


def pictures(hazard: str, draw: Draw) -> Iterator[Row]:
    """The largest error of each scene, colours cut to [0, 1] as on a screen."""
    for name, make in SCENES.items():
        got = np.clip(draw(make(), CAMERA, NEAR).astype(np.float64), 0, 1)
        wanted = np.clip(_exact(name).image, 0, 1)
        yield Row(hazard, name, 255 * float(np.abs(got - wanted).max()), CUT, "grey levels")


def _exponential() -> Row:
    powers = np.linspace(-9, 0, 20_001, dtype=np.float32)
    error = np.abs(_powers(powers) / np.exp2(powers.astype(np.float64)) - 1).max()
    return Row("blending (16): exp by a polynomial", "2^x, x from -9 to 0", float(error), 3e-7, "of itself")


@njit(cache=True)
def _powers(x: NDArray[np.float32]) -> NDArray[np.float32]:
    out = np.empty_like(x)
    for i in range(len(x)):
        out[i] = exp2(x[i])
    return out


def _depths() -> Iterator[Row]:
    for name, make in SCENES.items():
        got, wanted = render(make(), CAMERA, near=NEAR), _exact(name)
        seen = wanted.alpha > 0.05
        apart = np.abs(got.depth[seen] - wanted.depth[seen]) / wanted.depth[seen]
        empty = np.abs(got.depth[wanted.alpha == 0])
        worst = max(float(apart.max(initial=0.0)), float(empty.max(initial=0.0)))
        yield Row(
            "expected depth", name, worst, 1e-4, "of itself", "" if seen.any() else "0: nothing is seen"
        )


def _gradients() -> Iterator[Row]:
    """Largest relative error of the five inputs' gradients, of a loss with random slopes."""
    for name, make in SCENES.items():
        splats, (by_image, by_depth) = make(), _slopes()
        rasterizer = Rasterizer(CAMERA.width, CAMERA.height)
        rasterizer.forward(splats, CAMERA, NEAR)
        drawn = rasterizer.rendered(CAMERA.width, CAMERA.height, BLACK)
        rasterizer.set_adjoint(by_image, np.zeros_like(by_depth), by_depth, drawn, BLACK)
        found, wanted = rasterizer.backward(splats), _exact(name).gradients
        floor = FAINT * max(float(np.linalg.norm(wanted[field])) for field in NAMES)
        worst = max(_relative(getattr(found, field), wanted[field], floor) for field in NAMES)
        yield Row("gradients of (13)-(16)", name, worst, 1e-2, "of their length", LIMITS.get(name, ""))


def _slopes() -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Of a loss by colour (H, W, 3) and by depth (H, W)."""
    rng = np.random.default_rng(5)
    shape = CAMERA.height, CAMERA.width
    return rng.normal(size=(*shape, 3)), 0.05 * rng.normal(size=shape)


FAINT: Final = 1e-6
"""Gradients this much shorter than the longest are none: of a turned ball, for example."""
LIMITS: Final = {
    "scales of 1e-8 and 1e8": "training holds standard deviations between 1e-7 and 1 of the scene size",
}
"""What is done where float32 fails."""


def _relative(got: NDArray[np.float32], wanted: NDArray[np.float64], floor: float) -> float:
    return float(np.linalg.norm(got - wanted)) / max(float(np.linalg.norm(wanted)), floor, 1e-300)


def _overlapping() -> Iterator[Row]:
    """A million of one colour and alpha: 1 - (1 - alpha)^k, k being where the light falls below the stop."""
    camera = Camera(40.0, 40.0, 8.0, 8.0, 16, 16)
    for opacity in (1 / 128, 0.1, 0.99):
        splats = stacked(MILLION, opacity)
        flat = Splats(
            splats.means, splats.quats, 1e6 * splats.scales, splats.opacities, 0 * splats.colors + 1
        )
        alpha = min(float(np.float32(opacity)), 0.99)
        count = int(np.ceil(np.log(1e-4) / np.log1p(-alpha)))
        wanted = -np.expm1(count * np.log1p(-alpha))
        error = np.abs(render(flat, camera, near=NEAR).image - wanted).max()
        case = f"1e6 on one ray, opacity {opacity:.3g}"
        yield Row(
            "overlap", case, 255 * float(error), STOPPED, "grey levels", "a pixel stops at 1e-4 of its light"
        )


def _poisoned() -> Iterator[Row]:
    """One splat with a value that is no number or no size, among others that must be left whole."""
    clean = ordinary(60)
    for field in NAMES[:4]:
        for value in (np.nan, np.inf, -np.inf, 1e38, -1.0):
            splats = joined(clean)
            getattr(splats, field)[7] = value
            rasterizer = Rasterizer(CAMERA.width, CAMERA.height)
            rasterizer.forward(splats, CAMERA, NEAR)
            drawn = rasterizer.rendered(CAMERA.width, CAMERA.height, BLACK)
            ones = np.ones((CAMERA.height, CAMERA.width))
            rasterizer.set_adjoint(np.ones((*ones.shape, 3)), ones, ones, drawn, BLACK)
            found = rasterizer.backward(splats)
            others = np.arange(len(splats)) != 7
            broken = np.count_nonzero(~np.isfinite(drawn.image)) + np.count_nonzero(~np.isfinite(drawn.depth))
            broken += sum(np.count_nonzero(~np.isfinite(getattr(found, name)[others])) for name in NAMES)
            yield Row("one broken splat", f"{field} = {value:g}", float(broken), 0, "broken values",
                      "it is not drawn, or alone; training leaves its gradient out")  # fmt: skip


@dataclass(frozen=True, eq=False)
class _Exact:
    image: NDArray[np.float64]
    alpha: NDArray[np.float64]
    depth: NDArray[np.float64]
    gradients: dict[str, NDArray[np.float64]]


@cache
def _exact(scene: str) -> _Exact:
    """Picture and gradients in float64."""
    import torch

    from renderer.rasterize.reference import rasterize_reference

    splats, (by_image, by_depth) = SCENES[scene](), _slopes()

    def tensor(name: str) -> Tensor:
        return torch.tensor(getattr(splats, name).astype(np.float64), requires_grad=True)

    means, quats, scales, opacities, colors = inputs = [tensor(name) for name in NAMES]
    drawn = rasterize_reference(means, quats, scales, opacities, colors, CAMERA, near=NEAR)
    loss = (drawn.image * torch.tensor(by_image)).sum() + (drawn.depth * torch.tensor(by_depth)).sum()
    loss.backward()  # type: ignore[no-untyped-call]
    zero = torch.zeros(1, dtype=torch.float64)
    gradients = {
        name: (zero.expand_as(value) if value.grad is None else value.grad).numpy()
        for name, value in zip(NAMES, inputs, strict=True)
    }
    image, alpha, depth = (part.detach().numpy() for part in (drawn.image, drawn.alpha, drawn.depth))
    return _Exact(image, alpha, depth, gradients)
