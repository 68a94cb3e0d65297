"""Faults of the 2D enhancement: its statistics, filters, equations and edges."""

from __future__ import annotations

from typing import Any

import numpy as np

from tests.benchmarks.stability_faults.faults import Fault, Kind, edited, replaced, rounded

KERNELS, FILTER, SURVEY = "enhance.kernels", "enhance.guided_filter", "enhance.survey"
ENHANCER, POWERS = "enhance.enhancer", "enhance.powers"


def _parts(*names: str) -> tuple[str, ...]:
    return tuple(f"enhancement, {name}" for name in names)


def _edit(
    kernel: str, kind: Kind, what: str, module: str, old: str, new: str, *parts: str, quick: bool = False
) -> Fault:
    return Fault(kernel, kind, what, _parts(*parts), edited(module, old, new), quick)


def _in_half(whole: Any) -> Any:
    """Of a table or model that the second pass reads."""

    def made(*args: Any, **named: Any) -> Any:
        result = whole(*args, **named)
        with np.errstate(all="ignore"):
            if isinstance(result, np.ndarray):
                return result.astype(np.float16).astype(result.dtype)
            return type(result)(*(part.astype(np.float16).astype(part.dtype) for part in result))

    return made


def _statistics() -> list[Fault]:
    def edit(kind: Kind, what: str, module: str, old: str, new: str, quick: bool = False) -> Fault:
        return _edit("statistics", kind, what, module, old, new, "statistics", quick=quick)

    return [
        edit("sign", "of z", "enhance.brightness", "(level - 50) / 100", "(50 - level) / 100", quick=True),
        edit("other", "L at another share", "enhance.brightness", "10 * cumulative", "4 * cumulative"),
        edit("dropped", "the mean of Q", ENHANCER, "float(sums[1] - count * drift**2)", "float(sums[1])"),
        edit("swapped", "sums and squares of Q", ENHANCER, "drift = sums[0] / count", "drift = sums[1] / count"),
        edit("float16", "S_m", "enhance.statistics", "mean = saturation / count", "mean = float(np.float16(saturation / count))"),
        edit("sign", "of P", "enhance.detail", "(27 - 2 * sigma)", "(27 + 2 * sigma)"),
        edit("dropped", "the mask", ENHANCER, "if tissue_mask is not None or picture", "if picture"),
        edit("dropped", "the divisor of S", SURVEY, "/ (most if most > LEAST else LEAST)", ""),
        Fault("statistics", "other", "sigma in another unit", _parts("statistics"),
              edited(ENHANCER, "255 * math.sqrt(self.squares", "256 * math.sqrt(self.squares")),
    ]  # fmt: skip


def _jumps() -> list[Fault]:
    def edit(kind: Kind, what: str, old: str, new: str) -> Fault:
        return _edit("exponent", kind, what, "enhance.detail", old, new, "exponents", "statistics")

    return [
        edit("dropped", "a factor of sigma", "(27 - 2 * sigma)", "(27 - sigma)"),
        edit("other", "a jump at 2", "if sigma <= 2:\n        return 1.75", "if sigma <= 2:\n        return 2.5"),
        edit("other", "a jump at 10", "middle if sigma < 10 else 0.5", "middle if sigma < 10 else 0.0"),
        edit("sign", "none where none is printed", "min(max(middle, 0.5), 1.75)", "max(min(middle, 0.5), 1.75)"),
        edit("other", "jumps where none should be", "min(max(middle, 0.5), 1.75)",
             "min(max(middle - 0.04 * (sigma > 2), 0.5), 1.75)"),
        edit("other", "another where none should be", "min(max(middle, 0.5), 1.75)",
             "min(max(middle + 0.04 * (sigma > 10), 0.5), 1.75)"),
    ]  # fmt: skip


def _survey() -> list[Fault]:
    def edit(kind: Kind, what: str, old: str, new: str, *parts: str) -> Fault:
        return _edit("first pass", kind, what, SURVEY, old, new, *parts)

    def low_in_half(whole: Any) -> Any:
        def survey(*args: Any) -> None:
            whole(*args)
            for grid in args[4:6]:
                grid[...] = grid.astype(np.float16)

        return survey

    return [
        edit("sign", "of a block's variance", "within += spreads[i] * share - drift", "within += spreads[i] * share + drift",
             "ends"),
        edit("dropped", "the variance between columns", "(within + between)", "within", "ends"),
        edit("swapped", "blocks of the coarse grid", "left, right = 2 * x, min(2 * x + 1, last)",
             "left, right = min(2 * x + 1, last), 2 * x if x else min(1, last)", "ends", "sizes"),
        Fault("first pass", "float16", "block means", _parts("ends"), replaced(f"{SURVEY}:survey", low_in_half)),
        edit("other", "an odd edge repeats the first column", "lines[plane, x] = lines[plane, columns - 1]",
             "lines[plane, x] = lines[plane, 0]", "sizes"),
    ]  # fmt: skip


def _filters() -> list[Fault]:
    def edit(kind: Kind, what: str, old: str, new: str, *parts: str) -> Fault:
        return _edit("guided filter", kind, what, FILTER, old, new, *(parts or ("filter",)))

    return [
        edit("sign", "of eps", "eps / (first[x] + eps)", "eps / (first[x] - eps)"),
        edit("dropped", "the variance of blocks", "w0 * (f0 * f0 + np.float64(v0[x]))", "w0 * (f0 * f0)"),
        edit("dropped", "the partial pixels", "gained = _weight(row - y, whole, part)", "gained = _weight(row - y, whole, 0.0)"),
        edit("swapped", "a and b", "_describe(running[0], running[1], reach, rest, shares, tall, variance, mean)",
             "_describe(running[0], running[1], reach, rest, shares, tall, mean, variance)"),
        edit("float16", "the variance", "spread = np.float32(square * share - middle * middle)",
             "spread = np.float32(square * share) - np.float32(middle) * np.float32(middle)"),
        Fault("guided filter", "float16", "what it fits", 
              _parts("filter", "ends", "sizes", "saturation", "exponents", "hues", "types", "constants"),
              replaced(f"{FILTER}:WindowModels.of", _in_half), quick=True),
        edit("dropped", "the border's own width", "float(inside) + part * partly", "2.0 * whole + 1 + 2 * part",
             "filter", "constants", "sizes"),
        edit("other", "windows a pixel too wide", "beyond = max(2 * radius + 1 - grid, 0)", "beyond = max(2 * radius + 3 - grid, 0)",
             "sizes", "ends"),
    ]  # fmt: skip


def _equations() -> list[Fault]:
    def edit(
        kind: Kind, what: str, module: str, old: str, new: str, *parts: str, quick: bool = False
    ) -> Fault:
        return _edit("equations", kind, what, module, old, new, *parts, quick=quick)

    most = ("ends", "sizes", "exponents", "hues")
    return [
        # Eq 1.
        edit("sign", "of Eq 1, bytes", "enhance.brightness", "+ 0.4 * (1 - z)", "- 0.4 * (1 - z)", "precision",
             "constants", quick=True),
        edit("dropped", "a power of Eq 1, bytes", "enhance.brightness", "0.75 * z + 0.25", "0.25", "precision", "constants"),
        edit("sign", "of Eq 1, floats", KERNELS, "root + np.float32(0.4)", "root - np.float32(0.4)", *most),
        Fault("equations", "float16", "Eq 1, bytes", _parts("precision", "constants"),
              replaced(f"{ENHANCER}:Enhancer._curve_of", _in_half)),
        edit("dropped", "what is white stays white", "enhance.brightness", "lift * 0.5", "lift * 0.49", "constants", "precision"),
        edit("other", "what is black is not", "enhance.brightness", "+ value ** (2 - z)", "+ value ** (2 - z) + 0.2",
             "constants", "black"),
        # Eqs 6 to 10.
        edit("sign", "of Eq 6", KERNELS, "slope * chunk[VALUE, i] + offset", "slope * chunk[VALUE, i] - offset", *most),
        edit("dropped", "the floor of Eq 7", KERNELS, "chunk[SLOPE, i] = (chunk[SLOPE, i] + FLOOR) * chunk[INVERSE, i]",
             "chunk[SLOPE, i] = chunk[SLOPE, i] * chunk[INVERSE, i]", "ends", "exponents", "filter"),
        edit("swapped", "ratio of Eq 7", KERNELS, "exp2(p * chunk[SLOPE, i])", "exp2(-p * chunk[SLOPE, i])", "ends", "exponents",
             "filter"),
        edit("dropped", "a root", KERNELS, "exp2(np.sqrt(ratio) * chunk[LOG, i])", "exp2(ratio * chunk[LOG, i])", *most),
        edit("dropped", "a scale's share", KERNELS, "ONE / np.float32(len(exponents)), ", "HALF, ", *most),
        edit("swapped", "rows of models", KERNELS, "below if first % 2 == 0 else ONE - below", "below", "ends"),
        # Eqs 11 and 12.
        edit("sign", "of Eq 12", "enhance.saturation", "(3 - 2 * mean)", "(3 + 2 * mean)", "saturation"),
        edit("dropped", "an infinite pull", "enhance.saturation", "MOST_PULL: Final = 1e30", "MOST_PULL: Final = 1.0", "saturation"),
        edit("dropped", "d-factor", "enhance.saturation", "b = d_factor * mean**2", "b = mean**2", "saturation"),
        edit("swapped", "largest and least", KERNELS, "pull * least * least", "pull * most * most", *most),
        edit("sign", "of colours", KERNELS, "value - fall * (most - chunk[RED, i])", "value + fall * (most - chunk[RED, i])", *most),
        edit("swapped", "colours", KERNELS, "fall * (most - chunk[BLUE, i])", "fall * (most - chunk[GREEN, i])", *most),
        edit("other", "grey gets a hue", KERNELS, "chunk[BLUE, i] = value", "chunk[BLUE, i] = np.float32(0.98) * value", "saturation"),
        # Powers.
        Fault("equations", "float16", "a coefficient of log2", _parts("ends"),
              edited(POWERS, "L1 = np.float32(-0.7213473468160237)", "L1 = np.float32(-0.72119)", KERNELS)),
        Fault("equations", "float16", "a coefficient of exp2", _parts("ends"),
              edited(POWERS, "E1 = np.float32(0.6931472057375826)", "E1 = np.float32(0.69336)", KERNELS)),
    ]  # fmt: skip


def _edges() -> list[Fault]:
    def edit(
        kind: Kind, what: str, module: str, old: str, new: str, *parts: str, quick: bool = False
    ) -> Fault:
        return _edit("edges", kind, what, module, old, new, *parts, quick=quick)

    image = "enhance.image"
    return [
        edit("sign", "of the fade", KERNELS, "(THREE - TWO * t)", "(THREE + TWO * t)", "black"),
        edit("dropped", "the fade", KERNELS, "if keep_black and _is_dark(chunk):", "if False:", "black", "constants"),
        edit("swapped", "the fade's ends", KERNELS, "weight * chunk[plane, i] + (ONE - weight)", "(ONE - weight) * chunk[plane, i] + weight",
             "black", "constants"),
        edit("dropped", "rounding", KERNELS, "np.int32(rounded(chunk[plane, i]))", "np.int32(chunk[plane, i])", "constants"),
        Fault("edges", "float16", "what comes out", _parts("ends", "saturation", "sizes"), rounded(f"{KERNELS}:render", 20)),
        edit("other", "wide colours", image, "np.rint(clipped * full)", "np.rint(clipped * (full - 600))", "types"),
        edit("guard", "NaN is let in", image, "if np.isnan(low):", "if False:", "types", quick=True),
        edit("guard", "values beyond 1 are let in", image, "if low < 0.0 or high > 1.0:", "if low < 0.0:", "types", quick=True),
        edit("guard", "values below 0 are let in", image, "if low < 0.0 or high > 1.0:", "if high > 1.0:", "types"),
        edit("other", "black does not stay below Eq 1", "enhance.brightness", "lift * 0.5", "lift * 0.8", "black"),
        edit("sign", "order is lost", "enhance.brightness", "value ** (0.75", "(1 - value) ** (0.75", "black"),
        edit("other", "noise near black is louder", KERNELS, "BLACK = np.float32(24 / 255)", "BLACK = np.float32(4 / 255)", "black"),
        Fault("edges", "guard", "the logarithm of 0", _parts("ends"),
              edited(POWERS, "LOG2_ZERO = np.float32(-1e30)", "LOG2_ZERO = np.float32(0)", KERNELS)),
    ]  # fmt: skip


FAULTS: tuple[Fault, ...] = (
    *_statistics(),
    *_jumps(),
    *_survey(),
    *_filters(),
    *_equations(),
    *_edges(),
)
