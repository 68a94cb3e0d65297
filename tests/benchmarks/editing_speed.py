"""How fast half a million moving Gaussians are selected and edited, in milliseconds and in units of one sum
over as many float64.

The model has one curve of motion each and a view that holds about half of the centres; the lasso has 100
corners. What is seen from a camera at a time is worked out once for all selections there.
"""

from __future__ import annotations

from collections.abc import Callable
from time import perf_counter

import numpy as np

from renderer.camera import Camera
from renderer.deformation.spline_motion import SplineMotion
from renderer.editing.edits import Edits
from renderer.editing.regions import Box, Lasso, Range, Rectangle, Region, Sphere, found
from renderer.editing.sight import Sight, Trail
from renderer.gaussians import DynamicGaussians
from renderer.raw_gaussians import RawGaussians

COUNT, CONTROLS, ROUNDS = 500_000, 8, 9


def model() -> DynamicGaussians:
    rng = np.random.default_rng(0)
    raw = RawGaussians(
        means=rng.uniform((-60, -60, 40), (60, 60, 80), (COUNT, 3)).astype(np.float32),
        quats=rng.normal(size=(COUNT, 4)).astype(np.float32),
        log_scales=rng.normal(size=(COUNT, 3)).astype(np.float32),
        opacity_logits=rng.normal(size=COUNT).astype(np.float32),
        colors=rng.uniform(size=(COUNT, 3)).astype(np.float32),
        harmonics=np.zeros((COUNT, 0, 3), np.float32),
    )
    nothing = np.zeros((0, CONTROLS, 3), np.float32)
    motion = SplineMotion(
        position_controls=rng.normal(size=(COUNT, CONTROLS, 3)).astype(np.float32),
        color_controls=nothing, opacity_controls=nothing[..., :1], node_controls=nothing,
        node_indices=np.zeros((0, 4), np.int32), node_weights=np.zeros((0, 4), np.float32),
    )  # fmt: skip
    return DynamicGaussians(raw, motion)


def median_ms(act: Callable[[], object]) -> float:
    """After one that does not count."""
    act()
    taken = []
    for _ in range(ROUNDS):
        start = perf_counter()
        act()
        taken.append(perf_counter() - start)
    return 1000 * float(np.median(taken))


def main() -> None:
    trail = Trail(model(), tuple(np.linspace(0, 1, 16)))
    camera = Camera.from_fov(60.0, 640, 512)
    sight = Sight.of(trail, camera, 0.4, 0.1)
    turns = np.linspace(0, 2 * np.pi, 100, endpoint=False)
    reach = 150 + 40 * np.sin(7 * turns)
    corners = tuple(zip(320 + reach * np.cos(turns), 256 + reach * np.sin(turns), strict=True))
    regions: dict[str, Region] = {
        "rectangle": Rectangle(100, 100, 400, 300),
        "lasso": Lasso(corners),
        "sphere": Sphere((0, 0, 60), 15),
        "box": Box((0, 0, 60), (10, 10, 10)),
        "opacity": Range("opacity", 0.2, 0.5),
        "size": Range("size", 1, 2),
        "depth": Range("depth", 50, 60),
    }
    numbers = np.random.default_rng(1).normal(size=COUNT)
    unit = median_ms(lambda: numbers.sum())
    edits = Edits.none(COUNT).selecting(found(regions["lasso"], sight), "replace")
    acts: dict[str, Callable[[], object]] = {
        "what is seen": lambda: Sight.of(trail, camera, 0.4, 0.1),
        **{name: (lambda region=region: found(region, sight)) for name, region in regions.items()},
        "motion of 16 times, once": lambda: Trail(trail.model, trail.times).amplitudes,
        "combine two selections": lambda: edits.selecting(edits.visible, "intersect"),
        "delete": lambda: edits.deleting(),
        "the model without": lambda: edits.deleting().applied(trail.model),
    }
    print(f"{COUNT} Gaussians; unit {unit:.3f} ms; {len(edits.selected)} in the lasso")
    for name, act in acts.items():
        taken = median_ms(act)
        print(f"{name:26}{taken:9.3f} ms{taken / unit:9.1f}")


if __name__ == "__main__":
    main()
