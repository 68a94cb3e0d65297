"""Faults of the training loss, Adam, density control and initialisation."""

from __future__ import annotations

from typing import Any

from tests.benchmarks.stability_faults.faults import Fault, edited, rounded

LOSSES, VARIATION = "renderer.train.losses", "renderer.train.variation"
ADAM, GUARDS = "renderer.train.adam", "renderer.train.guards"
DENSIFY, INITIALIZE = "renderer.train.densify", "renderer.train.initialize"
FRAMES = "renderer.train.frames"


def _losses() -> list[Fault]:
    def edit(kind: Any, what: str, module: str, old: str, new: str, quick: bool = False) -> Fault:
        return Fault("loss", kind, what, ("losses",), edited(module, old, new), quick)

    return [
        edit("sign", "of depth", LOSSES, "slope * _sign(error)", "-slope * _sign(error)"),
        edit(
            "dropped",
            "inverse depth's slope",
            LOSSES,
            "depth_gradient + inverse_gradient / (expected * expected)",
            "depth_gradient",
        ),
        edit("dropped", "depth that is not compared", LOSSES, "and weight > HALF", ""),
        edit(
            "dropped", "the scene's size", LOSSES, "(max(frame.n_depths, 1) * size)", "max(frame.n_depths, 1)"
        ),
        edit("swapped", "red and blue", LOSSES, "image[channel, lane] =", "image[2 - channel, lane] ="),
        Fault(
            "loss", "float16", "the adjoint", ("losses",), rounded(f"{LOSSES}:masked_loss", 12), quick=True
        ),
        Fault("loss", "float16", "sums of rows", ("losses",), rounded(f"{LOSSES}:masked_loss", 13)),
        edit("dropped", "the mask", LOSSES, "ONE if color_mask[left + lane] else ZERO", "ONE"),
        edit(
            "sign", "of the total", LOSSES, "adjoint[TOTAL, y, x] += planes", "adjoint[TOTAL, y, x] -= planes"
        ),
        edit(
            "dropped",
            "the number of channels",
            LOSSES,
            "max(3 * frame.n_colors, 1)",
            "max(frame.n_colors, 1)",
        ),
        # Changes nothing, as the errors that it multiplies are 0: no row can notice it.
        edit(
            "guard",
            "next to nothing in place of one pixel",
            LOSSES,
            "max(3 * frame.n_colors, 1)",
            "max(3 * frame.n_colors, 1e-30)",
        ),
        edit("guard", "an empty mask", LOSSES, "max(3 * frame.n_colors, 1)", "(3 * frame.n_colors)"),
        edit(
            "sign",
            "of variation's slope",
            VARIATION,
            "extra[3, y, x] -= inverse_weight",
            "extra[3, y, x] += inverse_weight",
        ),
        edit(
            "dropped",
            "neighbours below",
            VARIATION,
            "abs(here - picture[y, right]) + abs(here - picture[below, x])",
            "abs(here - picture[y, right])",
        ),
        edit("swapped", "across and down", VARIATION, "near, inverse[below, x])", "near, inverse[y, right])"),
        Fault("loss", "float16", "inverse depth", ("losses",), rounded(f"{VARIATION}:_invert", 1)),
        edit(
            "guard",
            "places where nothing is drawn",
            VARIATION,
            "if weight > HALF and depth > ZERO else ZERO",
            "if weight > -ONE else ZERO",
        ),
        edit(
            "other",
            "depth beyond tissue",
            FRAMES,
            "np.where(frame.depth_mask, depth, np.float32(0.0))",
            "depth",
        ),
    ]


def _adam() -> list[Fault]:
    def edit(kind: Any, what: str, module: str, old: str, new: str, quick: bool = False) -> Fault:
        return Fault("Adam", kind, what, ("adam",), edited(module, old, new), quick)

    return [
        edit(
            "sign",
            "of the step",
            ADAM,
            "return value - rate * first",
            "return value + rate * first",
            quick=True,
        ),
        edit(
            "dropped",
            "the smallest divisor",
            ADAM,
            "(np.sqrt(second) + np.float32(EPSILON))",
            "np.sqrt(second)",
        ),
        edit("other", "a larger smallest divisor", ADAM, "EPSILON = 1e-15", "EPSILON = 1e-8"),
        edit("dropped", "the root", ADAM, "(np.sqrt(second) +", "(second +"),
        edit("dropped", "a bias correction", ADAM, "/ (1.0 - BETA_1**steps)", ""),
        edit(
            "swapped",
            "columns",
            ADAM,
            "values[n, c], gradients[n, c], first",
            "values[n, c], gradients[n, 0], first",
        ),
        Fault("Adam", "float16", "second moments", ("adam",), rounded(f"{ADAM}:update_rows", 3)),
        Fault("Adam", "float16", "values", ("adam",), rounded(f"{ADAM}:update_rows", 0)),
        edit("other", "other averages", ADAM, "BETA_1, BETA_2 = 0.9, 0.999", "BETA_1, BETA_2 = 0.9, 0.99"),
        edit("guard", "gradients that are no numbers", GUARDS, "if not np.isfinite(total):", "if total < 0:"),
        edit(
            "dropped",
            "quaternions' gradients",
            GUARDS,
            "total += by_quats[n, c] * by_quats[n, c]",
            "total += 0",
        ),
        edit(
            "dropped", "scales are not held", GUARDS, "np.clip(log_scales, low, high, out=log_scales)", "pass"
        ),
        edit("sign", "of the least scale", GUARDS, "np.log(SMALLEST * size)", "-np.log(SMALLEST * size)"),
    ]


def _density() -> list[Fault]:
    def edit(kind: Any, what: str, old: str, new: str, quick: bool = False) -> Fault:
        return Fault("density", kind, what, ("density",), edited(DENSIFY, old, new), quick)

    return [
        edit("sign", "of a turn", "local + w[:, None] * across", "local - w[:, None] * across", quick=True),
        edit("dropped", "children do not shrink", "log_scales[first:] -= np.float32(np.log(SHRINK))", "pass"),
        edit(
            "dropped",
            "the quaternion's length",
            "raw.quats[index] / np.where(lengths > 0, lengths, 1)",
            "raw.quats[index]",
        ),
        edit(
            "swapped",
            "axes of a child",
            "np.exp(raw.log_scales[index])",
            "np.exp(raw.log_scales[index, ::-1])",
        ),
        edit(
            "float16",
            "places of children",
            "cross(along, across)).astype(np.float32)",
            "cross(along, across)).astype(np.float16).astype(np.float32)",
        ),
        # Changes nothing, as a turn by 0 / 1 is none, too: no row can notice it.
        edit(
            "guard", "a quaternion of 0 is no turn", "np.where(lengths > 0, raw", "np.where(lengths >= 0, raw"
        ),
        edit(
            "guard",
            "a quaternion of 0",
            "np.where(lengths > 0, raw.quats[index] / np.where(lengths > 0, lengths, 1), (1, 0, 0, 0))",
            "(raw.quats[index] / lengths)",
        ),
        edit(
            "dropped",
            "the faint stay",
            "sigmoid(raw.opacity_logits) >= control.min_opacity",
            "np.ones(len(raw), bool)",
        ),
        edit("dropped", "the room there is", "> control.most:", "> 1e9:"),
        edit(
            "dropped",
            "those who ask for none",
            "wanted = self._sums >= control.gradient",
            "wanted = self._sums >= 0",
        ),
        edit("other", "the smaller are split", "split_above * self._size", "split_above * self._size * 3"),
        edit(
            "swapped",
            "across and down",
            "by_centers[n, 0] * half_width, by_centers[n, 1] * half_height",
            "by_centers[n, 0] * half_height, by_centers[n, 1] * half_width",
        ),
        edit("sign", "of lengths", "lengths[n] += np.sqrt", "lengths[n] -= np.sqrt"),
        edit("dropped", "who was not seen counts", "if seen[n]:", "if True:"),
        Fault("density", "float16", "lengths", ("density",), rounded(f"{DENSIFY}:_add_lengths", 4)),
    ]


def _initialisation() -> list[Fault]:
    def edit(kind: Any, what: str, old: str, new: str, quick: bool = False) -> Fault:
        return Fault("initialisation", kind, what, ("initialisation",), edited(INITIALIZE, old, new), quick)

    def camera(kind: Any, what: str, old: str, new: str) -> Fault:
        return Fault("initialisation", kind, what, ("initialisation",), edited("renderer.camera", old, new))

    return [
        camera("sign", "of a pixel's middle", "np.arange(self.width) + 0.5", "np.arange(self.width) - 0.5"),
        camera("dropped", "the middle of the picture", "+ 0.5 - self.cy)", "+ 0.5)"),
        camera("swapped", "focal lengths", "- self.cx) / self.fx * z", "- self.cx) / self.fy * z"),
        edit(
            "swapped",
            "colours",
            "frame.image.reshape(-1, 3)[chosen]",
            "frame.image.reshape(-1, 3)[chosen, ::-1]",
        ),
        edit(
            "float16", "places", "points.astype(np.float32)", "points.astype(np.float16).astype(np.float32)"
        ),
        edit(
            "dropped",
            "the spacing",
            "config.initial_spacing * spacing, colors",
            "0 * spacing + pixel_sizes, colors",
        ),
        edit(
            "dropped",
            "ends of depth",
            "(frame.depth >= lowest) & (frame.depth <= highest)",
            "(frame.depth > 0)",
        ),
        edit(
            "other",
            "pixels are drawn again",
            "count, replace=False",
            "count, replace=True",
        ),
        edit(
            "dropped",
            "the depth of a pixel's size",
            "depth.reshape(-1)[chosen] / np.float32",
            "np.float32(1) / np.float32",
            quick=True,
        ),
        edit("sign", "of the opacity", "np.log(opacity / (1 - opacity))", "np.log((1 - opacity) / opacity)"),
        edit("guard", "no depth at all", "if not medians:", "if medians is None:"),
        edit("other", "another line for no depth", "reconstruction expects measured depth", "expects depth"),
        edit(
            "other",
            "a length in the scene's unit",
            "config.initial_spacing * spacing, colors",
            "spacing + 0.01, colors",
        ),
        edit(
            "dropped",
            "what is around a pixel without depth",
            "depth = filled_depth(frame.depth, measured)",
            "depth = np.where(measured, frame.depth, np.float32(1))",
        ),
        edit(
            "dropped",
            "how many samples lie in a pixel",
            "np.sqrt(density.expected(len(means)).reshape(-1)[pixels])",
            "np.sqrt(density.expected(1).reshape(-1)[pixels])",
        ),
    ]


FAULTS: tuple[Fault, ...] = (*_losses(), *_adam(), *_density(), *_initialisation())
