"""Faults of the 2D enhancement: its statistics, first pass and filters."""

from __future__ import annotations

from typing import Any

import numpy as np

from tests.benchmarks.stability_faults.faults import Fault, Kind, edited, replaced

KERNELS, FILTER, FIRST_PASS = "enhance.second_pass", "enhance.guided_filter", "enhance.first_pass"
RECOLOR, ROWS = "enhance.recolor", "enhance.window_rows"
ENHANCER, SURVEY, POWERS = "enhance.enhancer", "enhance.survey", "enhance.powers"
REDNESS = "enhance.redness"
DENSITY = "enhance.vessel_density"


def parts_of(*names: str) -> tuple[str, ...]:
    return tuple(f"enhancement, {name}" for name in names)


def edit_of(
    kernel: str, kind: Kind, what: str, module: str, old: str, new: str, *parts: str, quick: bool = False
) -> Fault:
    also = (KERNELS,) if module == RECOLOR else ()
    return Fault(kernel, kind, what, parts_of(*parts), edited(module, old, new, *also), quick)


def in_half(whole: Any) -> Any:
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
        return edit_of("statistics", kind, what, module, old, new, "statistics", quick=quick)

    return [
        edit("sign", "of z", "enhance.brightness", "(level - 50) / 100", "(50 - level) / 100", quick=True),
        edit(
            "other",
            "L at another share",
            "enhance.brightness",
            "-tenths * int(cumulative[-1]) // 10",
            "-tenths * int(cumulative[-1]) // 4",
        ),
        edit("dropped", "the mean of Q", SURVEY, "sums[1] - count * drift**2", "sums[1]"),
        edit(
            "swapped", "sums and squares of Q", SURVEY, "drift = sums[0] / count", "drift = sums[1] / count"
        ),
        edit(
            "float16",
            "S_m",
            "enhance.statistics",
            "saturation_mean=saturation / count",
            "saturation_mean=float(np.float16(saturation / count))",
        ),
        edit("sign", "of P", "enhance.detail", "(27 - 2 * sigma)", "(27 + 2 * sigma)"),
        edit("sign", "of red beside green", REDNESS, "red += one[0] - one[1]", "red -= one[0] - one[1]"),
        edit("dropped", "the mask", "enhance.shown", "if tissue_mask is not None or picture", "if picture"),
        edit("dropped", "the divisor of S", FIRST_PASS, "/ (most if most > LEAST else LEAST)", ""),
        Fault(
            "statistics",
            "other",
            "sigma in another unit",
            parts_of("statistics"),
            edited(SURVEY, "255 * math.sqrt(self.squares", "256 * math.sqrt(self.squares"),
        ),
    ]


def _jumps() -> list[Fault]:
    def edit(kind: Kind, what: str, old: str, new: str) -> Fault:
        return edit_of("exponent", kind, what, "enhance.detail", old, new, "exponents", "statistics")

    return [
        edit("dropped", "a factor of sigma", "(27 - 2 * sigma)", "(27 - sigma)"),
        edit(
            "other",
            "a jump at 2",
            "if sigma <= 2:\n        return 1.75",
            "if sigma <= 2:\n        return 2.5",
        ),
        edit("other", "a jump at 10", "middle if sigma < 10 else 0.5", "middle if sigma < 10 else 0.0"),
        edit(
            "sign", "none where none is printed", "min(max(middle, 0.5), 1.75)", "max(min(middle, 0.5), 1.75)"
        ),
        edit(
            "other",
            "jumps where none should be",
            "min(max(middle, 0.5), 1.75)",
            "min(max(middle - 0.04 * (sigma > 2), 0.5), 1.75)",
        ),
        edit(
            "other",
            "another where none should be",
            "min(max(middle, 0.5), 1.75)",
            "min(max(middle + 0.04 * (sigma > 10), 0.5), 1.75)",
        ),
    ]


def _first_pass() -> list[Fault]:
    def edit(kind: Kind, what: str, old: str, new: str, *parts: str) -> Fault:
        return edit_of("first pass", kind, what, FIRST_PASS, old, new, *parts)

    def low_in_half(whole: Any) -> Any:
        def first_pass(*args: Any) -> None:
            whole(*args)
            for grid in args[5:7]:
                grid[...] = grid.astype(np.float16)

        return first_pass

    return [
        edit(
            "sign",
            "of a block's variance",
            "within += spreads[i] * share - drift",
            "within += spreads[i] * share + drift",
            "ends",
        ),
        edit("dropped", "the variance between columns", "(within + between)", "within", "ends"),
        edit(
            "swapped",
            "blocks of the coarse grid",
            "left, right = 2 * x, min(2 * x + 1, last)",
            "left, right = min(2 * x + 1, last), 2 * x if x else min(1, last)",
            "ends",
            "sizes",
        ),
        Fault(
            "first pass",
            "float16",
            "block means",
            parts_of("ends"),
            replaced(f"{FIRST_PASS}:first_pass", low_in_half),
        ),
        edit(
            "other",
            "an odd edge repeats the first column",
            "lines[plane, x] = lines[plane, columns - 1]",
            "lines[plane, x] = lines[plane, 0]",
            "sizes",
        ),
    ]


def _filters() -> list[Fault]:
    def edit(kind: Kind, what: str, old: str, new: str, *parts: str) -> Fault:
        return edit_of("guided filter", kind, what, FILTER, old, new, *(parts or ("filter",)))

    return [
        edit("sign", "of eps", "eps / (first[x] + eps)", "eps / (first[x] - eps)"),
        edit("dropped", "the variance of blocks", "w0 * (f0 * f0 + np.float64(v0[x]))", "w0 * (f0 * f0)"),
        edit(
            "dropped",
            "the partial pixels",
            "gained = _weight(row - y, whole, part)",
            "gained = _weight(row - y, whole, 0.0)",
        ),
        edit(
            "swapped",
            "a and b",
            "describe(running[0], running[1], reach, rest, shares, tall, variance, mean)",
            "describe(running[0], running[1], reach, rest, shares, tall, mean, variance)",
        ),
        edit(
            "swapped",
            "a and b of narrow windows",
            "describe_narrow(sums[0], sums[1], rest, shares, tall, variance, mean)",
            "describe_narrow(sums[0], sums[1], rest, shares, tall, mean, variance)",
        ),
        edit_of(
            "guided filter",
            "float16",
            "the variance",
            ROWS,
            "spread = np.float32(square * share - middle * middle)",
            "spread = np.float32(square * share) - np.float32(middle) * np.float32(middle)",
            "filter",
        ),
        edit_of(
            "guided filter",
            "dropped",
            "the partial pixels of narrow windows",
            ROWS,
            "middle = share * ((near[x] + here[x] + far[x]) + part * (left[x] + right[x]))",
            "middle = share * (near[x] + here[x] + far[x])",
            "filter",
        ),
        Fault(
            "guided filter",
            "float16",
            "what it fits",
            parts_of(
                "filter",
                "ends",
                "sizes",
                "saturation",
                "exponents",
                "hues",
                "types",
                "constants",
                "precision",
                "bytes",
            ),
            replaced(f"{FILTER}:WindowModels.of", in_half),
            quick=True,
        ),
        edit(
            "dropped",
            "the border's own width",
            "float(inside) + part * partly",
            "2.0 * whole + 1 + 2 * part",
            "filter",
            "constants",
            "sizes",
        ),
        edit(
            "other",
            "windows a pixel too wide",
            "beyond = max(2 * radius + 1 - grid, 0)",
            "beyond = max(2 * radius + 3 - grid, 0)",
            "sizes",
            "ends",
        ),
    ]


def _noise_gains() -> list[Fault]:
    def edit(kind: Kind, what: str, old: str, new: str) -> Fault:
        return edit_of("noise gains", kind, what, "enhance.noise", old, new, "noise gains")

    return [
        edit("sign", "of green", "red - green, blue - green", "red + green, blue + green"),
        edit("dropped", "what is clipped counts", "unclipped & keep", "(unclipped | True) & keep"),
        edit("dropped", "blocks of pixels", 'SCALES if cut == "unclipped" else SCALES[:1]', "SCALES[:1]"),
        edit("swapped", "before and after", "return after / before", "return before / after"),
        edit("float16", "the mean", ".mean(dtype=np.float64)", ".mean(dtype=np.float16)"),
    ]


def _hues() -> list[Fault]:
    def edit(kind: Kind, what: str, new: str) -> Fault:
        rising = "min(max(2 * redness / least - 1, 0.0), 1.0)"
        return edit_of("edges", kind, what, REDNESS, rising, new, "vessel")

    return [
        edit("dropped", "hues stay where red is faint", "1.0"),
        edit("other", "a jump from no red to all", "float(redness >= least)"),
        edit("other", "red tissue is reddened in part", "min(max(2 * redness / least - 1, 0.0), 0.9)"),
    ]


def _metals() -> list[Fault]:
    def edit(kind: Kind, what: str, module: str, old: str, new: str) -> Fault:
        return edit_of("edges", kind, f"metal, {what}", module, old, new, "vessel")

    rising = "min(max((redness - PALE_IMAGE) / (RED_IMAGE - PALE_IMAGE), 0.0), 1.0)"
    return [
        edit("dropped", "what is faintly red is no metal", REDNESS, rising, "0.0"),
        edit("other", "a jump as images grow pale", REDNESS, rising, "float(redness >= RED_IMAGE)"),
        edit("sign", "blood is left out, not metal", DENSITY, "grey = (high - red)", "grey = (red - low)"),
        edit("swapped", "the bounds", DENSITY, "red) * (ONE / (high - low))", "red) * (ONE / (low - high))"),
    ]


def _contrasts() -> list[Fault]:
    def edit(kind: Kind, what: str, old: str, new: str) -> Fault:
        return edit_of("edges", kind, f"contrast, {what}", DENSITY, old, new, "vessel")

    return [
        edit("guard", "what is bright counts, too", "beyond = beyond if beyond > ZERO else ZERO", ""),
        edit("dropped", "the median", "beyond = absorbed[i] - middle", "beyond = absorbed[i]"),
        edit(
            "sign", "what is bright counts", "beyond = absorbed[i] - middle", "beyond = middle - absorbed[i]"
        ),
        edit("other", "it sets in with an edge", "square = beyond * beyond", "square = beyond"),
        edit("swapped", "the background for what is there", "_add_all(absorbed[y],", "_add_all(lines[0, 0],"),
    ]


FAULTS: tuple[Fault, ...] = (
    *_statistics(), *_jumps(), *_first_pass(), *_filters(), *_noise_gains(), *_hues(), *_metals(),
    *_contrasts(),
)  # fmt: skip
