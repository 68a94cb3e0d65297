"""One step of training of each method: gradients of its whole loss by the raw values, against float64."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Final, get_args

import numpy as np
from numpy.typing import NDArray

from renderer.clip import Frame
from renderer.deformation.motion import Still
from renderer.gaussians import DynamicGaussians
from renderer.measuring.stability.exact_loss import ExactLoss
from renderer.measuring.stability.harmonics import definition
from renderer.measuring.stability.losses import SHAPE, frame
from renderer.measuring.stability.row import Row, worst
from renderer.measuring.stability.scenes import TURNED, elsewhere, joined, ordinary, raw_of, splat
from renderer.near_plane import NEAR_SHARE
from renderer.raw_gaussians import RawGaussians
from renderer.train.config import Method, TrainConfig
from renderer.train.frames import train_frame
from renderer.train.losses import LossWeights
from renderer.train.methods import recipe_for
from renderer.train.methods.vesselsplat import OPACITY
from renderer.train.model import TrainModel
from renderer.train.needs import Needs
from renderer.train.unseen import without_unseen

FloatArray = NDArray[np.float64]
Values = dict[str, FloatArray]
HAZARD: Final = "one step of training"
SIZE: Final = 10.0
NEEDS: Final = Needs(
    sh_degree=3, moves=True, rests=False, recolors=True, n_controls=5, has_depth=True, has_masks=True
)
WEIGHTS: Final[dict[Method, LossWeights]] = {
    "vesselsplat": LossWeights(opacity=OPACITY, depth=0.2),
    "deform3dgs": LossWeights(inverse_depth=1 / 68),
    "endogaussian": LossWeights(
        inverse_depth=1 / 68, image_variation=0.03, inverse_depth_variation=0.03 / 68
    ),
    "static": LossWeights(opacity=OPACITY, depth=0.2),
}
"""As chosen or published, for scenes of 68 mm."""
WAYS: Final = 2
STEP: Final = 1e-7
"""Of the differences that slopes are."""


def rows() -> Iterator[Row]:
    """Along random ways of each array."""
    given, raw = _frame(), _gaussians()
    for method in get_args(Method):
        recipe = recipe_for(TrainConfig(method=method, iterations=60), NEEDS)
        own = RawGaussians.from_arrays({name: value.copy() for name, value in raw.arrays().items()})
        model = TrainModel(own, recipe.make_trainer(own, [given], SIZE), recipe, SIZE)
        model.step(train_frame(given, ~given.tissue_mask), 0)
        # After the first step, a mean gradient is a tenth of the gradient.
        found = {name: model.state()[f"first.{name}"] / 0.1 for name in raw.arrays()}
        loss = _Loss(given, WEIGHTS[method])
        for name, slope in found.items():
            error = loss.off(name, slope.astype(np.float64), raw)
            yield Row(HAZARD, f"{method}: gradient by {name}", error, 1e-4, "of the steepest")


def unseen() -> Iterator[Row]:
    """Those beside the view, behind the camera or before what is no tissue are left out, and no others."""
    beside = joined(splat((1e3, 0, 10)), splat((0, 0, -10)), splat((-4.0, 0.0, 10), scale=(0.01, 0.01, 0.01)))
    raw = raw_of(elsewhere(joined(splat((2.0, 0.0, 10)), beside, splat((3.0, 2.0, 12)))))
    kept, _ = without_unseen(DynamicGaussians(raw, Still()), [train_frame(_frame())], NEAR_SHARE * SIZE)
    wrong = float(not np.array_equal(kept.means, raw.means[[0, 4]]))
    yield Row("Gaussians that no frame shows", "others are left out, or some kept", wrong, 0, "cases",
              "left out at the end, and said")  # fmt: skip


def _frame() -> Frame:
    """A frame of noise from elsewhere, tissue on its right."""
    tissue = np.zeros(SHAPE, bool)
    tissue[:, 17:] = True
    return replace(frame(), camera=TURNED, tissue_mask=tissue)


def _gaussians() -> RawGaussians:
    """Over the view, in colours that depend on the direction."""
    raw, rng = raw_of(elsewhere(ordinary(100))), np.random.default_rng(12)
    return replace(raw, harmonics=(0.1 * rng.normal(size=(len(raw), 15, 3))).astype(np.float32))


@dataclass(frozen=True, eq=False)
class _Loss:
    """Of one frame, by raw values."""

    frame: Frame
    weights: LossWeights

    def value(self, raw: Values) -> float:
        """As the equations have it."""
        import torch

        from renderer.rasterize.reference import rasterize_reference

        ways = raw["means"] - self.frame.camera.position
        ways /= np.linalg.norm(ways, axis=1, keepdims=True)
        colors = raw["colors"] + np.einsum("nb,nbc->nc", definition(ways), raw["harmonics"])
        opacities = 1 / (1 + np.exp(-raw["opacity_logits"]))
        means, quats, scales, alphas, seen = (
            torch.from_numpy(np.ascontiguousarray(each))
            for each in (raw["means"], raw["quats"], np.exp(raw["log_scales"]), opacities, colors)
        )
        near = NEAR_SHARE * SIZE
        drawn = rasterize_reference(means, quats, scales, alphas, seen, self.frame.camera, near=near)
        image, alpha, depth = (part.numpy() for part in (drawn.image, drawn.alpha, drawn.depth))
        planes = np.stack([1 - alpha, *image.transpose(2, 0, 1), alpha * depth])
        ready, inside = train_frame(self.frame, ~self.frame.tissue_mask), np.s_[: SHAPE[0], : SHAPE[1]]
        return ExactLoss(self.frame, self.weights, SIZE, ready.opaque[inside], ready.unseen[inside]).value(
            planes
        )

    def off(self, name: str, found: FloatArray, raw: RawGaussians) -> float:
        """The error of one array's gradient, by differences of the loss."""
        exact: Values = {each: value.astype(np.float64) for each, value in raw.arrays().items()}
        rng, apart, slopes = np.random.default_rng(13), [], []
        for _ in range(WAYS):
            way = rng.normal(size=found.shape)
            more, less = (self.value(exact | {name: exact[name] + step * way}) for step in (STEP, -STEP))
            slopes.append((more - less) / (2 * STEP))
            apart.append(abs(float((found * way).sum()) - slopes[-1]))
        return worst(apart) / worst(abs(slope) for slope in slopes)
