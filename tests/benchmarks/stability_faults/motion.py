"""Faults of what moves Gaussians in time (splines, nodes, bumps, planes, heads) and of its training."""

from __future__ import annotations

from typing import Any

from tests.benchmarks.stability_faults.faults import Fault, edited, replaced, rounded

SPLINE, NODES = "renderer.deformation.spline", "renderer.deformation.nodes"
SPLINE_MOTION, SPLINE_TRAINER = "renderer.deformation.spline_motion", "renderer.train.spline_trainer"
ADAM, FDM = "renderer.train.adam", "renderer.deformation.fdm"
FLEXIBLE = "renderer.train.fdm_trainer"
PLANES, PLANE_MOTION = "renderer.deformation.hexplane", "renderer.deformation.hexplane_motion"
HEADS, PLANE_TRAINER = "renderer.deformation.heads", "renderer.train.hexplane_trainer"
PRODUCTS = "renderer.deformation.row_products"


def _splines() -> list[Fault]:
    def edit(kind: Any, what: str, module: str, old: str, new: str, quick: bool = False) -> Fault:
        return Fault("splines", kind, what, ("splines",), edited(module, old, new), quick)

    return [
        edit("sign", "of a weight", SPLINE, "3 * u**3 - 6 * u**2 + 4", "3 * u**3 + 6 * u**2 + 4", quick=True),
        edit("dropped", "times are not held to the clip", SPLINE, "min(max(time, 0.0), 1.0)", "time"),
        edit(
            "swapped",
            "weights",
            SPLINE,
            "return first, (weights / 6.0)",
            "return first, (weights[::-1] / 6.0)",
        ),
        edit(
            "float16",
            "weights",
            SPLINE,
            "(weights / 6.0).astype(np.float32)",
            "(weights / 6.0).astype(np.float16).astype(np.float32)",
        ),
        edit(
            "other", "one segment too few", SPLINE, "segments = n_controls - 3", "segments = n_controls - 4"
        ),
        edit(
            "guard", "too few control values", SPLINE, "if n_controls < MIN_CONTROLS:", "if n_controls < 0:"
        ),
        edit("dropped", "the last tap", SPLINE, "for tap in range(4):", "for tap in range(3):"),
        Fault("splines", "float16", "curves", ("splines",), rounded(f"{SPLINE}:add_curve", 3)),
        edit(
            "other",
            "time goes by whole knots",
            SPLINE,
            "u = position - first",
            "u = position - int(position)",
        ),
        edit(
            "sign",
            "of colours",
            SPLINE_MOTION,
            "add_curve(self.color_controls, *taps, colors)",
            "add_curve(-self.color_controls, *taps, colors)",
        ),
        edit(
            "dropped",
            "opacities",
            SPLINE_MOTION,
            "add_curve(self.opacity_controls, *taps, logits[:, None])",
            "pass",
        ),
        edit("dropped", "what nodes share", SPLINE_MOTION, "add_shared(nodes", "add_shared(0 * nodes"),
        edit(
            "swapped",
            "corners of nodes",
            NODES,
            "nodes[indices[n, corner], c]",
            "nodes[indices[n, 3 - corner], c]",
        ),
        Fault("splines", "float16", "shared motion", ("splines",), rounded(f"{NODES}:add_shared", 3)),
        edit(
            "sign",
            "of a gradient of nodes",
            NODES,
            "value += weights[i] * gradients",
            "value -= weights[i] * gradients",
        ),
        edit(
            "dropped",
            "the last link of a node",
            NODES,
            "range(starts[m], starts[m + 1])",
            "range(starts[m], starts[m + 1] - 1)",
        ),
        Fault(
            "splines", "float16", "gradients of nodes", ("splines",), rounded(f"{NODES}:gather_gradients", 4)
        ),
        edit(
            "dropped", "a tap's weight in training", ADAM, "weights[tap] * gradients[n, c]", "gradients[n, c]"
        ),
        edit(
            "dropped",
            "smoothing",
            SPLINE_TRAINER,
            "smoothing = rates.smoothing.at(iteration)",
            "smoothing = 0.0",
        ),
        edit(
            "sign",
            "of smoothing",
            ADAM,
            "pull * (middle - controls[n, k, c])",
            "pull * (controls[n, k, c] - middle)",
        ),
        edit(
            "swapped",
            "colours and positions in training",
            SPLINE_TRAINER,
            '("color_controls", by.colors',
            '("color_controls", by.means',
        ),
        Fault(
            "splines",
            "float16",
            "control values in training",
            ("splines",),
            rounded(f"{ADAM}:update_taps", 0),
        ),
        edit(
            "other",
            "steps of a control value are those of the run",
            SPLINE_TRAINER,
            "int(steps)) for steps in",
            "iteration + 1) for steps in",
        ),
    ]


def _nodes() -> list[Fault]:
    def edit(kind: Any, what: str, old: str, new: str, quick: bool = False) -> Fault:
        return Fault("nodes", kind, what, ("nodes",), edited(NODES, old, new), quick)

    return [
        edit(
            "sign",
            "of a weight",
            "across * (1 - down), (1 - across) * down",
            "across * (1 + down), (1 - across) * down",
        ),
        edit(
            "dropped",
            "means outside are not held to the view",
            "np.clip(pixels[:, 0]",
            "(lambda x, *_: x)(pixels[:, 0]",
        ),
        edit(
            "swapped",
            "across and down",
            "across, down = x - column, y - row",
            "down, across = x - column, y - row",
            quick=True,
        ),
        edit(
            "float16",
            "weights",
            "weights.astype(np.float32)",
            "weights.astype(np.float16).astype(np.float32)",
        ),
        edit("guard", "a mean that is no number", "np.nan_to_num(pixels, posinf=0.0, neginf=0.0)", "pixels"),
        edit(
            "other",
            "one row of nodes too far",
            "np.minimum(y.astype(np.int64), rows - 2)",
            "y.astype(np.int64)",
        ),
    ]


def _bumps() -> list[Fault]:
    def edit(kind: Any, what: str, module: str, old: str, new: str, quick: bool = False) -> Fault:
        return Fault("bumps", kind, what, ("bumps",), edited(module, old, new), quick)

    return [
        edit(
            "sign",
            "of the exponent",
            FDM,
            "exp2(max(-LOG2_E * u * u, FAINTEST))",
            "exp2(min(LOG2_E * u * u, -FAINTEST))",
        ),
        edit("dropped", "the floor under widths", FDM, "FLOOR = np.float32(1e-4)", "FLOOR = np.float32(0.0)"),
        edit("dropped", "the square of u", FDM, "-LOG2_E * u * u", "-LOG2_E * u"),
        edit(
            "swapped",
            "centre and width",
            FDM,
            "away, width = now - bumps[j, n, CENTRE, c], bumps[j, n, WIDTH, c]",
            "away, width = now - bumps[j, n, WIDTH, c], bumps[j, n, CENTRE, c]",
        ),
        Fault("bumps", "float16", "what they add", ("bumps",), rounded(f"{FDM}:add_bumps", 3), quick=True),
        edit("other", "spans that are too short", FDM, "MAX_U = np.float32(4.0)", "MAX_U = np.float32(1.0)"),
        edit(
            "swapped",
            "scales and quaternions",
            FDM,
            "quats=raw.quats + moves[:, QUATERNION]",
            "quats=raw.quats + moves[:, 6:]",
        ),
        edit("sign", "of a slope", FLEXIBLE, "(CENTRE, slope * away)", "(CENTRE, -slope * away)"),
        edit("dropped", "a factor of a slope", FLEXIBLE, "slope * u * width", "slope * width"),
        edit("swapped", "rates", FLEXIBLE, "rates[WEIGHT, POSITION] =", "rates[CENTRE, POSITION] ="),
        Fault("bumps", "float16", "bumps in training", ("bumps",), rounded(f"{FLEXIBLE}:update_bumps", 0)),
        edit("dropped", "the bias correction", FLEXIBLE, "corrected_rate(1.0, iteration + 1)", "1.0"),
        edit("other", "who was not seen is trained", FLEXIBLE, "if seen[n] and spans", "if spans"),
    ]


def _planes() -> list[Fault]:
    def edit(kind: Any, what: str, module: str, old: str, new: str, quick: bool = False) -> Fault:
        return Fault("planes", kind, what, ("planes",), edited(module, old, new), quick)

    def edit_slope(kind: Any, what: str, module: str, old: str, new: str) -> Fault:
        return Fault("planes", kind, what, ("heads",), edited(module, old, new))

    return [
        edit(
            "sign",
            "of a weight",
            PLANES,
            "return first, ONE - after, after",
            "return first, ONE + after, after",
        ),
        edit("dropped", "a plane", PLANES, "= (xy * xz * yz) * (xt", "= (xy * yz) * (xt"),
        edit("swapped", "z and y", PLANES, "xz += at.z1 * (at.x0", "xz += at.y1 * (at.x0"),
        edit("swapped", "cells of a row", PLANES, "planes[2] + k * down + j", "planes[2] + j * deep + k"),
        Fault("planes", "float16", "features", ("planes",), rounded(f"{PLANES}:sample", 6), quick=True),
        edit(
            "other",
            "rows of time the other way",
            PLANES,
            "(ONE - share) * time_cells[row] + share",
            "share * time_cells[row] + (ONE - share)",
        ),
        edit(
            "dropped",
            "times are not held to the clip",
            PLANES,
            "min(max(time, 0.0), 1.0) * (rows - 1)",
            "max(time, -9.0) * (rows - 1)",
        ),
        edit(
            "dropped",
            "points are not held to the box",
            PLANES,
            "np.clip(shares, ZERO, ONE)",
            "np.clip(shares, ZERO, ONE + ONE)",
        ),
        edit(
            "guard",
            "a box without extent",
            PLANES,
            "np.where(extent > 0, extent, ONE)",
            "np.maximum(extent, 1e-30)",
        ),
        edit_slope("sign", "of a slope by lines", PLANES, "by_time * xt * zt", "-by_time * xt * zt"),
        edit_slope(
            "dropped", "a factor of a slope by planes", PLANES, "by_space * (xz * yz)", "by_space * xz"
        ),
        edit_slope(
            "swapped",
            "slopes by lines",
            PLANES,
            "_add_line(to_lines, at.x, at.x0, at.x1, by, 3)",
            "_add_line(to_lines, at.x, at.x0, at.x1, by, 4)",
        ),
        Fault("planes", "float16", "slopes by planes", ("heads",), rounded(f"{PLANES}:sample_backward", 8)),
        edit_slope(
            "dropped",
            "a mark of what is touched",
            PLANES,
            "marks[cell] = marks[cell + 1] = True",
            "marks[cell] = True",
        ),
    ]


def _heads() -> list[Fault]:
    def edit(kind: Any, what: str, module: str, old: str, new: str, quick: bool = False) -> Fault:
        return Fault("heads", kind, what, ("heads",), edited(module, old, new), quick)

    return [
        edit("dropped", "a bias", HEADS, "self.trunk_weight) + self.trunk_bias", "self.trunk_weight)"),
        edit("dropped", "what is rectified has no slope", HEADS, "by_hidden *= hidden > 0", "pass"),
        Fault(
            "heads",
            "swapped",
            "quaternions and scales",
            ("heads",),
            replaced(f"{HEADS}:PARTS", lambda whole: (whole[0], slice(7, 10), slice(3, 7))),
        ),
        edit(
            "swapped", "heads", PLANE_MOTION, "position, log_scale, quat = (", "log_scale, position, quat = ("
        ),
        Fault("heads", "float16", "products", ("heads",), rounded(f"{PRODUCTS}:row_products")),
        edit(
            "sign",
            "of the offsets' gradient",
            HEADS,
            "output_bias=by_offsets.sum(axis=0)",
            "output_bias=-by_offsets.sum(axis=0)",
        ),
        edit("dropped", "the unit", PLANE_MOTION, "raw.means + self.unit * position", "raw.means + position"),
        edit("dropped", "the unit in training", PLANE_TRAINER, "(motion.unit * by.means,", "(by.means,"),
        edit(
            "swapped",
            "rows of time",
            PLANE_TRAINER,
            "((row, 1 - share), (row + 1, share))",
            "((row, share), (row + 1, 1 - share))",
        ),
        edit(
            "dropped",
            "the rest of rows in time",
            PLANE_TRAINER,
            "* (len(self._row_steps) / 2) ** 0.5",
            "* 1.0",
        ),
        edit(
            "sign",
            "of the first columns",
            PRODUCTS,
            "sums_0[lane] += a * factor",
            "sums_0[lane] -= a * factor",
        ),
        edit(
            "other",
            "who was not seen has a gradient",
            PLANE_TRAINER,
            "np.where(seen[:, None], values, np.float32(0.0))",
            "values",
        ),
        edit(
            "swapped",
            "rates of cells and heads",
            PLANE_TRAINER,
            "touched, corrected_rate(cell_rate, done + 1)",
            "touched, corrected_rate(head_rate, done + 1)",
        ),
        edit(
            "swapped",
            "rates of heads and cells",
            PLANE_TRAINER,
            "everywhere, corrected_rate(head_rate, done + 1)",
            "everywhere, corrected_rate(cell_rate, done + 1)",
        ),
        edit(
            "dropped",
            "the biases of training's first step",
            ADAM,
            "rate * np.sqrt(1.0 - BETA_2**steps) / (1.0 - BETA_1**steps)",
            "rate",
        ),
    ]


FAULTS: tuple[Fault, ...] = (*_splines(), *_nodes(), *_bumps(), *_planes(), *_heads())
