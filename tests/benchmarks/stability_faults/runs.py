"""Faults of whole runs: of what joins the kernels, and of what refuses a run."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, get_args

import numpy as np

from renderer.train.config import Method
from renderer.train.trainer import TrainingError
from tests.benchmarks.stability_faults.faults import Change, Fault, Kind, edited, replaced, rounded

METHODS: tuple[str, ...] = tuple(f"whole run, {method}" for method in get_args(Method))
VESSELSPLAT, DEFORM3DGS, ENDOGAUSSIAN, STATIC = ((part,) for part in METHODS)
STEP, UNSEEN = ("one step",), ("unseen",)
REFUSED, UNITS = ("whole run, refused",), ("whole run, units",)
ALL = (*METHODS, *REFUSED, *UNITS)
MODEL, PICTURES, FRAMES = "renderer.train.model", "renderer.train.gradient_backend", "renderer.train.frames"
TRAINER, GUARDS, INITIALIZE = "renderer.train.trainer", "renderer.train.guards", "renderer.train.initialize"
TILES, ADAM = "renderer.rasterize.tiles", "renderer.train.adam"


def _changed(change: Any) -> Change:
    """The gradients of each step."""

    def make(whole: Any) -> Any:
        def loss_and_gradients(*args: Any, **named: Any) -> Any:
            found = whole(*args, **named)
            return replace(found, by=change(found.by))

        return loss_and_gradients

    return replaced(f"{PICTURES}:CpuBackend.loss_and_gradients", make)


def _raises(_: Any) -> Any:
    def train(*_: Any, **__: Any) -> Any:
        raise TrainingError("the card is gone")
        yield

    return train


def _in_half(by: Any) -> Any:
    with np.errstate(over="ignore"):
        return type(by)(
            **{name: value.astype(np.float16).astype(np.float32) for name, value in by.arrays().items()}
        )


def _edit(
    kind: Kind, what: str, module: str, old: str, new: str, parts: tuple[str, ...], quick: bool = False
) -> Fault:
    return Fault("whole run", kind, what, parts, edited(module, old, new), quick)


FAULTS: tuple[Fault, ...] = (
    Fault(
        "whole run",
        "other",
        "it always fails",
        ALL,
        replaced("renderer.train.training:train", _raises),
        quick=True,
    ),
    # Gradients.
    _edit(
        "sign",
        "of the step",
        ADAM,
        "return value - rate * first",
        "return value + rate * first",
        (*METHODS, *UNITS),
    ),
    Fault("whole run", "float16", "gradients", (*METHODS, *STEP), _changed(_in_half)),
    Fault(
        "whole run",
        "swapped",
        "axes of the means' gradients",
        METHODS,
        _changed(lambda by: replace(by, means=np.ascontiguousarray(by.means[:, [1, 0, 2]]))),
    ),
    Fault(
        "whole run",
        "sign",
        "of colours' gradients",
        METHODS,
        _changed(lambda by: replace(by, colors=-by.colors)),
    ),
    Fault(
        "whole run",
        "dropped",
        "gradients of scales",
        (*ENDOGAUSSIAN, *STEP),
        _changed(lambda by: replace(by, log_scales=0 * by.log_scales)),
    ),
    Fault(
        "whole run",
        "sign",
        "of scales' gradients",
        (*VESSELSPLAT, *STATIC),
        _changed(lambda by: replace(by, log_scales=-by.log_scales)),
    ),
    Fault(
        "whole run",
        "dropped",
        "gradients of opacities",
        (*STATIC, *DEFORM3DGS),
        _changed(lambda by: replace(by, opacity_logits=0 * by.opacity_logits)),
    ),
    Fault(
        "whole run",
        "sign",
        "of means' gradients",
        (*VESSELSPLAT, *DEFORM3DGS),
        _changed(lambda by: replace(by, means=-by.means)),
    ),
    Fault(
        "whole run",
        "dropped",
        "gradients of means",
        (*STATIC, *ENDOGAUSSIAN),
        _changed(lambda by: replace(by, means=0 * by.means)),
    ),
    Fault(
        "whole run",
        "sign",
        "of quaternions' gradients",
        (*ENDOGAUSSIAN, *STEP),
        _changed(lambda by: replace(by, quats=-by.quats)),
    ),
    Fault(
        "whole run",
        "dropped",
        "gradients of quaternions",
        (*STATIC, *STEP),
        _changed(lambda by: replace(by, quats=0 * by.quats)),
    ),
    _edit(
        "dropped",
        "the logistic's slope",
        PICTURES,
        "by.opacities * splats.opacities * (1 - splats.opacities)",
        "by.opacities",
        METHODS,
    ),
    _edit(
        "dropped",
        "the exponential's slope",
        PICTURES,
        "by.scales * splats.scales",
        "by.scales",
        (*METHODS, *STEP),
    ),
    Fault(
        "whole run",
        "sign",
        "of harmonics' gradients",
        (*STATIC, *STEP),
        _changed(lambda by: replace(by, harmonics=-by.harmonics)),
    ),
    Fault(
        "whole run",
        "dropped",
        "harmonics",
        STATIC,
        edited("renderer.train.recipe", "min(self.sh_degree, 6 * iteration // self.iterations)", "0"),
    ),
    # Pictures.
    Fault("whole run", "float16", "planes", METHODS, rounded(f"{TILES}:blend", 5)),
    _edit(
        "swapped",
        "colours of frames",
        FRAMES,
        "colors.transpose(2, 0, 1)",
        "colors.transpose(2, 0, 1)[::-1]",
        METHODS,
        quick=True,
    ),
    _edit(
        "dropped",
        "depth",
        "renderer.train.methods.vesselsplat",
        "config.depth_weight if needs.has_depth else 0.0",
        "0.0",
        (*VESSELSPLAT, *STATIC, *STEP),
    ),
    _edit(
        "dropped",
        "inverse depth of deform3dgs",
        "renderer.train.methods.deform3dgs",
        "LossWeights(inverse_depth=1 / MILLIMETRES)",
        "LossWeights()",
        (*DEFORM3DGS, *STEP),
    ),
    _edit(
        "dropped",
        "inverse depth of endogaussian",
        "renderer.train.methods.endogaussian",
        "            inverse_depth=1 / MILLIMETRES,\n",
        "",
        (*ENDOGAUSSIAN, *STEP),
    ),
    _edit(
        "other",
        "half resolution is off by a pixel",
        FRAMES,
        "camera = frame.camera.resized(*half)",
        "camera = frame.camera.resized(*half)\n    colors = np.roll(colors, 1, axis=1)",
        (*VESSELSPLAT, *STATIC),
    ),
    _edit(
        "swapped",
        "halves of depth",
        FRAMES,
        "known = np.rint(colors).astype(np.uint8), np.where(tissue, depth, 0.0)",
        "known = np.rint(colors).astype(np.uint8), np.where(tissue, depth[:, ::-1], 0.0)",
        (*VESSELSPLAT, *STATIC),
    ),
    # What moves.
    _edit(
        "sign",
        "of time",
        MODEL,
        "self._motion.moved(self.raw, frame.time)",
        "self._motion.moved(self.raw, 1 - frame.time)",
        (*VESSELSPLAT, *DEFORM3DGS, *ENDOGAUSSIAN),
    ),
    _edit(
        "dropped",
        "the motion is not trained",
        MODEL,
        "self._motion.update(frame.time, by, updated, iteration)",
        "pass",
        (*VESSELSPLAT, *DEFORM3DGS, *ENDOGAUSSIAN),
    ),
    _edit(
        "dropped",
        "nodes are not trained",
        "renderer.train.spline_trainer",
        "touched |= rates.every_moment",
        "touched[:] = False",
        VESSELSPLAT,
    ),
    _edit(
        "dropped",
        "colour curves are not trained",
        "renderer.train.spline_trainer",
        "by.colors, seen, rates.color",
        "0 * by.colors, seen, rates.color",
        VESSELSPLAT,
    ),
    # What is trained.
    _edit(
        "dropped",
        "all frames but the first",
        TRAINER,
        "return frames[int(order[place])]",
        "return frames[0]",
        METHODS,
    ),
    _edit(
        "dropped",
        "the scene's size in a rate",
        MODEL,
        'rate * self._size if name == "means" else rate',
        "rate",
        (*METHODS, *UNITS),
    ),
    _edit(
        "dropped",
        "the scene's size in the loss",
        "renderer.train.losses",
        "(max(frame.n_depths, 1) * size)",
        "max(frame.n_depths, 1)",
        UNITS,
        quick=True,
    ),
    _edit(
        "other",
        "one Gaussian's share is trained",
        MODEL,
        "moments, seen, rate)",
        "moments, seen & (np.arange(len(seen)) < 1), rate)",
        METHODS,
    ),
    _edit(
        "dropped",
        "rates that fall",
        "renderer.train.rates",
        "self.start * (self.end / self.start) ** min(gone, 1.0)",
        "self.start",
        METHODS,
    ),
    _edit(
        "sign",
        "seen Gaussians are left out at the end",
        "renderer.train.unseen",
        "gaussians.rows(np.flatnonzero(seen))",
        "gaussians.rows(np.flatnonzero(~seen))",
        UNSEEN,
    ),
    _edit(
        "dropped",
        "Gaussians that no frame shows stay",
        "renderer.train.unseen",
        "if lost == 0:",
        "if lost >= 0:",
        UNSEEN,
    ),
    Fault("whole run", "float16", "values", METHODS, rounded(f"{ADAM}:update_rows", 0)),
    # What refuses a run.
    _edit("dropped", "the loss is not watched", GUARDS, "WORSE = 2.0", "WORSE = 1e30", REFUSED),
    _edit(
        "sign",
        "a loss that falls is refused",
        GUARDS,
        "recent > WORSE * first",
        "recent < WORSE * first",
        (*METHODS, *REFUSED),
    ),
    _edit(
        "other",
        "another kind of refusal",
        TRAINER,
        'raise TrainingError(f"{watch.problem}',
        'raise ClipError(f"{watch.problem}',
        REFUSED,
    ),
    _edit(
        "other",
        "another line for no depth",
        INITIALIZE,
        "reconstruction expects measured depth",
        "expects depth",
        REFUSED,
    ),
    _edit(
        "other",
        "depth of 1 where there is none",
        INITIALIZE,
        "if not medians:",
        "if not medians:\n        return 1.0\n    if not medians:",
        REFUSED,
    ),
)
