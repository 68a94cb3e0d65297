"""Faults of the equations of the 2D enhancement, and of its edges: black, types, refusals."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from enhance.field import FieldOfView
from tests.benchmarks.stability_faults.enhancement import (
    ENHANCER,
    KERNELS,
    POWERS,
    RECOLOR,
    edit_of,
    in_half,
    parts_of,
)
from tests.benchmarks.stability_faults.faults import Fault, Kind, edited, replaced, rounded


def _offset(whole: Any) -> Any:
    def render(*args: Any) -> None:
        whole(*args)
        args[22][...] = args[22] + (0.01 if args[22].dtype.kind == "f" else 2)

    return render


def _equations() -> list[Fault]:
    def edit(
        kind: Kind, what: str, module: str, old: str, new: str, *parts: str, quick: bool = False
    ) -> Fault:
        return edit_of("equations", kind, what, module, old, new, *parts, quick=quick)

    return [
        # Eq 1.
        edit(
            "sign",
            "of Eq 1, bytes",
            "enhance.brightness",
            "+ 0.4 * (1 - z)",
            "- 0.4 * (1 - z)",
            "bytes",
            "constants",
            quick=True,
        ),
        edit(
            "dropped",
            "a power of Eq 1, bytes",
            "enhance.brightness",
            "0.75 * z + 0.25",
            "0.25",
            "bytes",
            "constants",
        ),
        edit(
            "sign",
            "of Eq 1, floats",
            KERNELS,
            "root + np.float32(0.4)",
            "root - np.float32(0.4)",
            "ends",
            "sizes",
        ),
        Fault(
            "equations",
            "float16",
            "Eq 1, bytes",
            parts_of("bytes", "constants"),
            replaced(f"{ENHANCER}:curve_of", in_half),
        ),
        edit(
            "dropped",
            "what is white stays white",
            "enhance.brightness",
            "lift * 0.5",
            "lift * 0.49",
            "constants",
            "bytes",
        ),
        edit(
            "other",
            "what is black is not",
            "enhance.brightness",
            "+ value ** (2 - z)",
            "+ value ** (2 - z) + 0.2",
            "constants",
            "black",
        ),
        # Eqs 6 to 10.
        edit(
            "sign",
            "of Eq 6",
            KERNELS,
            "slope * chunk[VALUE, i] + offset",
            "slope * chunk[VALUE, i] - offset",
            "bytes",
        ),
        edit(
            "dropped",
            "the floor of Eq 7",
            KERNELS,
            "chunk[SLOPE, i] = (chunk[SLOPE, i] + FLOOR) * chunk[INVERSE, i]",
            "chunk[SLOPE, i] = chunk[SLOPE, i] * chunk[INVERSE, i]",
            "ends",
            "exponents",
            "filter",
        ),
        edit(
            "swapped",
            "ratio of Eq 7",
            KERNELS,
            "exp2(p * chunk[SLOPE, i])",
            "exp2(-p * chunk[SLOPE, i])",
            "ends",
            "exponents",
            "filter",
        ),
        edit(
            "dropped",
            "a root",
            KERNELS,
            "exp2(np.sqrt(ratio) * chunk[LOG, i])",
            "exp2(ratio * chunk[LOG, i])",
            "bytes",
        ),
        edit("dropped", "a scale's share", KERNELS, "ONE / np.float32(len(exponents)), ", "HALF, ", "bytes"),
        edit(
            "swapped",
            "rows of models",
            "enhance.upscale",
            "below if first % 2 == 0 else ONE - below",
            "below",
            "bytes",
        ),
        # Eqs 11 and 12.
        edit("sign", "of Eq 12", "enhance.saturation", "(3 - 2 * mean)", "(3 + 2 * mean)", "saturation"),
        edit(
            "dropped",
            "an infinite pull",
            "enhance.saturation",
            "MOST_PULL: Final = 1e30",
            "MOST_PULL: Final = 1.0",
            "saturation",
        ),
        edit(
            "dropped", "d-factor", "enhance.saturation", "b = d_factor * mean**2", "b = mean**2", "saturation"
        ),
        edit("swapped", "largest and least", RECOLOR, "pull * least * least", "pull * most * most", "bytes"),
        edit(
            "sign",
            "of colours",
            RECOLOR,
            "value - fall * (most - np.float32(apart[RED, i]))",
            "value + fall * (most - np.float32(apart[RED, i]))",
            "hues",
        ),
        edit(
            "swapped",
            "colours",
            RECOLOR,
            "fall * (most - np.float32(apart[BLUE, i]))",
            "fall * (most - np.float32(apart[GREEN, i]))",
            "bytes",
        ),
        edit(
            "other",
            "grey gets a hue",
            RECOLOR,
            "chunk[BLUE, i] = value",
            "chunk[BLUE, i] = np.float32(0.98) * value",
            "constants",
        ),
        # Powers.
        Fault(
            "equations",
            "float16",
            "a coefficient of log2",
            parts_of("ends"),
            edited(POWERS, "L1 = np.float32(-0.7213473468160237)", "L1 = np.float32(-0.72119)", KERNELS),
        ),
        Fault(
            "equations",
            "float16",
            "a coefficient of exp2",
            parts_of("ends"),
            edited(POWERS, "E1 = np.float32(0.6931470036506653)", "E1 = np.float32(0.69336)", KERNELS),
        ),
    ]


def _everywhere(field: Callable[[int, int], FieldOfView]) -> Callable[[Any], Any]:
    """Always the same field of view, whatever the picture shows."""

    def make(_: Any) -> Any:
        def find_field(image: Any) -> FieldOfView:
            height, width = image.pixels.shape[:2]
            return field(width, height)

        return find_field

    return make


def _fields() -> list[Fault]:
    field, rim, parts = "enhance.field", "enhance.field_rim", parts_of("fields")
    find, outside = "enhance.field_search:find_field", "copy_pixels(image[y, end:], out[y, end:])"

    def edit(kind: Kind, what: str, old: str, new: str, module: str = field) -> Fault:
        return Fault("edges", kind, what, parts, edited(module, old, new))

    return [
        edit("sign", "the rim of the field is taken in", "found - RIM", "found + 2 * RIM", rim),
        edit("swapped", "middle of the field", "x, y, radius = circle[0]", "y, x, radius = circle[0]"),
        edit(
            "dropped",
            "two looks before the field moves",
            "self._until_next -= 1",
            "self._field = self._other = find_field(picture)",
            "enhance.field_tracker",
        ),
        edit(
            "dropped",
            "a field that moves on is followed",
            "return moves_on and",
            "return False and",
            "enhance.field_tracker",
        ),
        edit("other", "the surround is enhanced", outside, "out[y, end:] = 255", KERNELS),
        edit("other", "vessel in the surround", outside, "out[y, end:] = 255", "enhance.vessel_second_pass"),
        Fault("edges", "other", "a small field everywhere", parts, replaced(find, _everywhere(_small_field))),
        Fault("edges", "other", "no surround anywhere", parts, replaced(find, _everywhere(FieldOfView))),
    ]


def _small_field(width: int, height: int) -> FieldOfView:
    return FieldOfView(width, height, circle=(width / 2, height / 2, 9.0))


def _edges() -> list[Fault]:
    def edit(
        kind: Kind, what: str, module: str, old: str, new: str, *parts: str, quick: bool = False
    ) -> Fault:
        return edit_of("edges", kind, what, module, old, new, *parts, quick=quick)

    image = "enhance.image"
    return [
        edit("sign", "of the fade", RECOLOR, "(THREE - TWO * t)", "(THREE + TWO * t)", "black"),
        edit(
            "dropped",
            "the fade",
            KERNELS,
            "if keep_black and is_dark(chunk):",
            "if False:",
            "black",
            "constants",
        ),
        edit(
            "swapped",
            "the fade's ends",
            RECOLOR,
            "weight * chunk[plane, i] + (ONE - weight)",
            "(ONE - weight) * chunk[plane, i] + weight",
            "black",
            "constants",
        ),
        edit(
            "dropped",
            "rounding",
            RECOLOR,
            "np.int32(rounded(chunk[plane, i]))",
            "np.int32(chunk[plane, i])",
            "constants",
        ),
        Fault(
            "edges",
            "float16",
            "what comes out",
            parts_of("ends", "saturation", "sizes"),
            rounded(f"{KERNELS}:render", 22),
        ),
        edit(
            "other",
            "wide colours",
            image,
            "np.rint(clipped * full)",
            "np.rint(clipped * (full - 600))",
            "types",
        ),
        edit("guard", "NaN is let in", image, "if np.isnan(low):", "if False:", "types", quick=True),
        edit(
            "guard",
            "values beyond 1 are let in",
            image,
            "if low < 0.0 or high > 1.0:",
            "if low < 0.0:",
            "types",
            quick=True,
        ),
        edit(
            "guard",
            "values below 0 are let in",
            image,
            "if low < 0.0 or high > 1.0:",
            "if high > 1.0:",
            "types",
        ),
        edit(
            "other",
            "black does not stay below Eq 1",
            "enhance.brightness",
            "lift * 0.5",
            "lift * 0.8",
            "black",
        ),
        edit(
            "sign", "order is lost", "enhance.brightness", "value ** (0.75", "(1 - value) ** (0.75", "black"
        ),
        edit(
            "other",
            "noise near black is louder",
            RECOLOR,
            "BLACK = np.float32(24 / 255)",
            "BLACK = np.float32(4 / 255)",
            "black",
        ),
        Fault(
            "edges", "other", "an offset of 0.01", parts_of("types"), replaced(f"{KERNELS}:render", _offset)
        ),
        Fault(
            "edges",
            "guard",
            "the logarithm of 0",
            parts_of("ends"),
            edited(POWERS, "LOG2_ZERO = np.float32(-1e30)", "LOG2_ZERO = np.float32(0)", KERNELS),
        ),
    ]


FAULTS: tuple[Fault, ...] = (*_equations(), *_edges(), *_fields())
