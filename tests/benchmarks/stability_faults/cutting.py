"""Faults of splats that the sides of an image or a field cut off, and of which Gaussians frames show."""

from __future__ import annotations

from typing import Any

from tests.benchmarks.stability_faults.faults import Fault, edited, rounded

CROSSINGS, WITHIN = "renderer.rasterize.crossings", "renderer.rasterize.within"
SHOWN = "renderer.shown"


def _cuts() -> list[Fault]:
    def edit(kind: Any, what: str, old: str, new: str, quick: bool = False, module: str = CROSSINGS) -> Fault:
        return Fault("cut splats", kind, what, ("cut splats",), edited(module, old, new), quick)

    return [
        edit("sign", "of the shear", "/ across - shear * down", "/ across + shear * down", quick=True),
        edit("sign", "without size", "out=2 * np.sign", "out=-2 * np.sign"),
        edit("dropped", "the low-pass", "sharp + LOW_PASS * (xx + yy + LOW_PASS)", "sharp"),
        edit("dropped", "the shear", "along[:, 1] - shear * along[:, 0]", "along[:, 1]"),
        edit(
            "dropped",
            "the offset of a side",
            "means @ sides[:, :3].T + sides[:, 3]",
            "means @ sides[:, :3].T",
        ),
        edit("dropped", "half a pixel", "lines[side, 2] * dy + HALF", "lines[side, 2] * dy", module=WITHIN),
        edit(
            "swapped", "rows and columns", "growth.transpose(0, 2, 1)", "growth[:, ::-1].transpose(0, 2, 1)"
        ),
        edit(
            "guard", "the guard band", "local[:, 2:], view[[4, 6]], view[[5, 7]])", "local[:, 2:], -9e9, 9e9)"
        ),
        edit("guard", "needles", "LONGEST = 1e5", "LONGEST = 1e30"),
        edit(
            "other",
            "the farthest sides",
            "NEAREST - 1, axis=1)[:, :NEAREST]",
            "-NEAREST, axis=1)[:, -NEAREST:]",
        ),
        edit("other", "a reach of a tenth", "REACH = 3.4", "REACH = 0.3"),
        edit("other", "none that is cut is drawn", "margin > -1", "margin > 1", module=WITHIN),
        Fault("cut splats", "float16", "lines", ("cut splats",), rounded(f"{CROSSINGS}:crossings")),
    ]


def _shown() -> list[Fault]:
    def edit(kind: Any, what: str, old: str, new: str, quick: bool = False) -> Fault:
        return Fault("Gaussians that frames show", kind, what, ("shown",), edited(SHOWN, old, new), quick)

    return [
        edit("sign", "behind", "(1 - BEHIND)", "(1 + BEHIND)", quick=True),
        edit("guard", "the near plane", "& (depths > near)", ""),
        edit("dropped", "what reaches into the image", "(pixels < size + reach[:, None])", "(pixels < size)"),
        Fault("Gaussians that frames show", "float16", "depth", ("shown",), rounded(f"{SHOWN}:_farthest")),
        edit("swapped", "rows and columns", "column, row = np.clip", "row, column = np.clip"),
    ]


FAULTS: tuple[Fault, ...] = (*_cuts(), *_shown())
