"""Eq 16: pictures, expected depth and gradients of splats that are hard to draw, against float64."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Final

import numpy as np
from numba import njit
from numpy.typing import NDArray

from renderer.camera import Camera
from renderer.measuring.stability.exact import BACKDROP, NAMES, Exact, exact, of_scene, slopes
from renderer.measuring.stability.row import Row, worst
from renderer.measuring.stability.scenes import CAMERA, NEAR, SCENES, camera_of, joined, ordinary, stacked
from renderer.rasterize.cpu import Gradients, Rasterizer, render
from renderer.rasterize.exp2 import exp2
from renderer.rasterize.rendered import Rendered
from renderer.splats import Float32Array, Splats

Draw = Callable[[Splats, Camera, float], Float32Array]
"""Splats, camera and near plane to a picture (H, W, 3) over black."""
MILLION: Final = 1_000_000
STOPPED: Final = 0.03
"""Grey levels: what lies behind a transmittance of 1e-4 may add so much."""
CUT: Final = 1.0
"""Grey levels: a contribution at the cut of 1/255 falls to either side of it."""
MEAN: Final = 2e-5
"""Of a picture's mean, what its mean error may be."""
BEYOND_STOP: Final = {"300 opaque ones on one ray": 2e-4}
"""The same where pixels stop at 1e-4 of their light, to either side of it."""
LENGTH: Final = 3e-4
"""Of a gradient's length, what its error may be."""
STIFF: Final = {
    "anisotropy 1e6, a needle over the view": 1e-2,
    "scales of 1e-8 and 1e8": 1e-2,
    "300 opaque ones on one ray": 1e-3,
}
"""The same where float32 loses more."""
LIMITS: Final = {
    "scales of 1e-8 and 1e8": "training holds standard deviations between 1e-7 and 1 of the scene size",
}
"""What is done where float32 fails."""
FAINT: Final = 1e-6
"""Gradients this much shorter than the longest are none: of a turned ball, for example."""


def pictures_on_cpu() -> Iterator[Row]:
    """Of the CPU rasteriser."""
    return pictures("blending (16): image", lambda *scene: render(*scene[:2], near=scene[2]).image)


def pictures(hazard: str, draw: Draw) -> Iterator[Row]:
    """The largest error of each scene, colours cut to [0, 1] as on a screen; and the mean one, of which a
    few pixels at a cut are no part."""
    for name, make in SCENES.items():
        wanted = np.clip(of_scene(name).image, 0, 1)
        apart = np.abs(np.clip(draw(make(), camera_of(name), NEAR).astype(np.float64), 0, 1) - wanted)
        yield Row(hazard, name, 255 * float(apart.max()), CUT, "grey levels")
        mean = float(apart.mean() / wanted.mean())
        yield Row(f"{hazard}, mean error", name, mean, BEYOND_STOP.get(name, MEAN), "of its mean")


def exponential() -> Iterator[Row]:
    """The polynomial in place of the library's function."""
    powers = np.linspace(-9, 0, 20_001, dtype=np.float32)
    error = np.abs(_powers(powers) / np.exp2(powers.astype(np.float64)) - 1).max()
    yield Row("blending (16): exp by a polynomial", "2^x, x from -9 to 0", float(error), 3e-7, "of itself")


@njit(cache=True)
def _powers(x: NDArray[np.float32]) -> NDArray[np.float32]:
    out = np.empty_like(x)
    for i in range(len(x)):
        out[i] = exp2(x[i])
    return out


def depths() -> Iterator[Row]:
    """Where anything is seen; elsewhere 0."""
    for name, make in SCENES.items():
        got, wanted = render(make(), camera_of(name), near=NEAR), of_scene(name)
        seen = wanted.alpha > 0.05
        apart = np.abs(got.depth[seen] - wanted.depth[seen]) / wanted.depth[seen]
        empty = np.abs(got.depth[wanted.alpha == 0])
        yield Row("expected depth", name, worst([*apart, *empty]), 1e-4, "of itself")


def gradients() -> Iterator[Row]:
    """Largest relative error of the five inputs' gradients, of a loss with random slopes; and of those by
    the centres on screen, which move all together as the middle of the picture does."""
    for name, make in SCENES.items():
        splats = make()
        _, found = _differentiated(Rasterizer(CAMERA.width, CAMERA.height), splats, camera_of(name))
        wanted = of_scene(name)
        error, bar = _error(found, wanted, np.ones(len(splats), bool)), STIFF.get(name, LENGTH)
        yield Row("gradients of (13)-(16)", name, error, bar, "of their length", LIMITS.get(name, ""))
    rasterizer, splats = Rasterizer(CAMERA.width, CAMERA.height), ordinary()
    _differentiated(rasterizer, splats)
    moved = rasterizer.by_centers().sum(axis=0, dtype=np.float64)
    for way, got, wanted_slope in zip(("across", "down"), moved, _by_middle(splats), strict=True):
        error = abs(float(got) - wanted_slope) / abs(wanted_slope)
        yield Row("gradients by the centres", f"all of them {way}", error, 1e-4, "of itself")


def _differentiated(
    rasterizer: Rasterizer, splats: Splats, camera: Camera = CAMERA
) -> tuple[Rendered, Gradients]:
    """The picture over BACKDROP."""
    rasterizer.forward(splats, camera, NEAR)
    drawn = rasterizer.rendered(CAMERA.width, CAMERA.height, BACKDROP)
    rasterizer.set_adjoint(*slopes(), BACKDROP)
    return drawn, rasterizer.backward(splats)


def _error(found: Gradients, wanted: Exact, of: NDArray[np.bool_]) -> float:
    """The worst of the five inputs, over the splats `of`."""
    floor = FAINT * max(float(np.linalg.norm(wanted.gradients[name])) for name in NAMES)
    return worst(_relative(getattr(found, name)[of], wanted.gradients[name], floor) for name in NAMES)


def _relative(got: NDArray[np.float32], wanted: NDArray[np.float64], floor: float) -> float:
    return float(np.linalg.norm(got - wanted)) / max(float(np.linalg.norm(wanted)), floor, 1e-300)


def _by_middle(splats: Splats) -> tuple[float, float]:
    """Of the loss, by the middle of the picture: central differences in float64."""
    step = 1e-7
    ways = (
        [replace(CAMERA, cx=CAMERA.cx + side) for side in (step, -step)],
        [replace(CAMERA, cy=CAMERA.cy + side) for side in (step, -step)],
    )
    across, down = ((exact(splats, more).loss - exact(splats, less).loss) / (2 * step) for more, less in ways)
    return across, down


def overlapping() -> Iterator[Row]:
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
        error = 255 * float(np.abs(render(flat, camera, near=NEAR).image - wanted).max())
        case, done = f"1e6 on one ray, opacity {opacity:.3g}", "a pixel stops at 1e-4 of its light"
        # Two of 0.99 leave just that.
        yield Row("overlap", case, error, STOPPED if alpha == 0.99 else STOPPED / 10, "grey levels", done)


DRAWN: Final = {("quats", 1e38), ("quats", -1.0), ("scales", -1.0), ("opacities", 1e38)}
"""Values that still say how to draw; a splat with another is left out."""
BESIDE: Final = {("means", 1e38)}
"""The same, far beside the view."""
SPOILT: Final = 7
"""Its row."""


def poisoned() -> Iterator[Row]:
    """One splat with a value that is no number or no size: it and the others are drawn as float64 draws
    them, or the others alone, and their gradients are those."""
    clean, others = ordinary(60), np.arange(60) != SPOILT
    left = exact(Splats(*(getattr(clean, name)[others] for name in NAMES)))
    for field in NAMES[:4]:
        for value in (np.nan, np.inf, -np.inf, 1e38, -1.0):
            splats = joined(clean)
            getattr(splats, field)[SPOILT] = value
            is_drawn = (field, value) in DRAWN
            rasterizer = Rasterizer(CAMERA.width, CAMERA.height)
            rasterizer.forward(splats, CAMERA, NEAR)
            told = rasterizer.visible[SPOILT] == ((field, value) in DRAWN | BESIDE)
            drawn, found = _differentiated(rasterizer, splats)
            wanted = exact(splats) if is_drawn else left
            done = "" if is_drawn else "it is not drawn and has no gradient"
            over = wanted.image + (1 - wanted.alpha)[..., None] * np.array(BACKDROP)
            case, error = f"{field} = {value:g}", 255 * float(np.abs(drawn.image - over).max())
            yield Row("one broken splat", case, error if told else np.inf, CUT, "grey levels", done)
            # What is not drawn has no gradient, not even one that is no number.
            own = 0.0 if is_drawn or _is_none(found, SPOILT) else np.inf
            error = _error(found, wanted, others | is_drawn) + own
            yield Row("one broken splat", f"{case}: gradients", error, LENGTH, "of their length", done)


def _is_none(by: Gradients, row: int) -> bool:
    return all(not np.any(getattr(by, name)[row]) for name in NAMES)
