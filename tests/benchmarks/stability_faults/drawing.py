"""Faults of projection, rasterising and harmonics, and of drawing with OpenGL."""

from __future__ import annotations

from typing import Any

import numpy as np

from tests.benchmarks.stability_faults.faults import Change, Fault, edited, replaced, rounded

PROJECTION, TILES = "renderer.projection", "renderer.rasterize.tiles"
BINNING, CPU, HARMONICS = "renderer.rasterize.binning", "renderer.rasterize.cpu", "renderer.harmonics"
BLENDING = "renderer.measuring.stability.blending"
PICTURE = "renderer.rasterize.picture"
DRAWN, SLOPES = ("projection", "pictures"), ("gradients",)
BROKEN = ("broken splat",)


def _shader(old: str, new: str) -> Change:
    """Edits the shaders of OpenGL."""

    def make(whole: Any) -> Any:
        def shader(name: str) -> str:
            source: str = whole(name)
            return source.replace(old, new)

        return shader

    return replaced("renderer.draw.splat_view:_shader", make)


def _depths_in_half(whole: Any) -> Any:
    def order(records: Any, visible: Any) -> Any:
        coarse = records.copy()
        with np.errstate(over="ignore"):
            coarse[:, 9] = records[:, 9].astype(np.float16)
        return whole(coarse, visible)

    return order


def _reversed(whole: Any) -> Any:
    return lambda *args: np.ascontiguousarray(whole(*args)[::-1])


def _projection() -> list[Fault]:
    def edit(kind: Any, what: str, old: str, new: str, parts: Any = DRAWN, quick: bool = False) -> Fault:
        return Fault("projection", kind, what, parts, edited(PROJECTION, old, new), quick)

    return [
        edit("sign", "the shear", "[SHEAR] = -xy / yy", "[SHEAR] = xy / yy", quick=True),
        edit("sign", "a turn", "- w * z), 2 * (x * z + w * y)", "+ w * z), 2 * (x * z + w * y)"),
        edit("dropped", "the low-pass", "LOW_PASS = 0.3", "LOW_PASS = 0.0"),
        edit("dropped", "the middle of the picture", "/ local[2] + view[2]", "/ local[2]"),
        edit("dropped", "the slope of depth", "(x - across * depth)", "x"),
        edit("dropped", "the translation", "+ view[row + 3]", ""),
        edit("swapped", "the height by itself", "[DOWN] = -0.5 * LOG2_E / yy", "[DOWN] = -0.5 * LOG2_E / xx"),
        edit("swapped", "width and height", "math.sqrt(reach * xx)", "math.sqrt(reach * yy)"),
        Fault(
            "projection", "float16", "records", (*DRAWN, *BROKEN), rounded(f"{PROJECTION}:project", 7), True
        ),
        edit(
            "guard",
            "the guard band",
            "across = min(max(local[0] / z, view[4]), view[5])",
            "across = local[0] / z",
        ),
        edit(
            "guard",
            "a quaternion of 0",
            "if length == 0.0:\n        w = length = np.float64(1.0)",
            "if length < 0.0:\n        w = length = np.float64(1.0)",
        ),
        # Two that change nothing, as what is not a number has no reach either: no row can notice them.
        edit(
            "guard",
            "a determinant that is no number",
            "determinant > 0.0 and determinant < np.inf",
            "True",
            BROKEN,
        ),
        edit(
            "guard",
            "an opacity that is no number",
            "and opacity >= ALPHA_CUT):",
            "and not opacity < ALPHA_CUT):",
            BROKEN,
        ),
        edit(
            "guard",
            "what has no extent",
            "record[HALF_WIDTH] < np.inf and record[HALF_HEIGHT] < np.inf",
            "True",
            BROKEN,
        ),
        edit("other", "a cut of 1/510", "ALPHA_CUT = 1.0 / 255.0", "ALPHA_CUT = 0.5 / 255.0"),
        edit("other", "the near plane lets in what lies on it", "local[2] > view[8]", "local[2] >= view[8]"),
        edit("other", "all are behind the near plane", "local[2] > view[8]", "local[2] > 1e30"),
        edit("other", "a cut of 2/255", "ALPHA_CUT = 1.0 / 255.0", "ALPHA_CUT = 2.0 / 255.0"),
        edit(
            "other",
            "a determinant that cancels",
            "_sharp_determinant(axes) + LOW_PASS * (xx + yy - LOW_PASS)",
            "xx * yy - xy * xy",
        ),
        edit(
            "other",
            "colours out of place",
            "= colors[n, 0], colors[n, 1]",
            "= colors[n, 1], colors[n, 0]",
            ("pictures",),
        ),
    ]


def _project_backward() -> list[Fault]:
    def edit(kind: Any, what: str, old: str, new: str, quick: bool = False) -> Fault:
        return Fault("gradient of projection", kind, what, SLOPES, edited(PROJECTION, old, new), quick)

    outputs = rounded(f"{PROJECTION}:project_backward", 8, 9, 10, 11)
    return [
        edit("sign", "by depth", "by_z -= (gx * row_x", "by_z += (gx * row_x", quick=True),
        edit("sign", "of a turn", "y * (g[0, 2] - g[2, 0])", "y * (g[0, 2] + g[2, 0])"),
        edit("dropped", "the depth that is drawn", "total[SUM_DEPTH] - (", "- ("),
        edit("dropped", "the quaternion's length", "(gw - along * w) / length", "gw / length"),
        edit(
            "swapped",
            "across and down",
            "by_u = (yy * total[SUM_QX] - xy * total[SUM_QY])",
            "by_u = (yy * total[SUM_QY] - xy * total[SUM_QX])",
        ),
        Fault("gradient of projection", "float16", "what it gives", (*SLOPES, *BROKEN), outputs),
        edit("sign", "by the covariance", "out[1] = -(left_a * b", "out[1] = (left_a * b"),
        edit("other", "by the opacity", "total[SUM_Q] / opacities[n]", "total[SUM_Q]"),
        edit("sign", "by the centres", "[n, 0] = -LN_2", "[n, 0] = LN_2"),
        edit("dropped", "by the centres, a factor of two", "two * record[DOWN]", "record[DOWN]"),
        edit("swapped", "by the centres", "two * record[ACROSS]", "two * record[DOWN]"),
        Fault(
            "gradient of projection",
            "float16",
            "by the centres",
            SLOPES,
            rounded(f"{PROJECTION}:center_gradients", 3),
        ),
    ]


def _raster() -> list[Fault]:
    def edit(kind: Any, what: str, old: str, new: str, parts: Any, quick: bool = False) -> Fault:
        return Fault("blending", kind, what, parts, edited(TILES, old, new), quick)

    first = "slope_y = shear * slope_x + TWO * d * dy\n                    block ="
    then = "slope_y = shear * slope_x - TWO * d * dy\n                    block ="
    seen = ("pictures", "depths")
    exponential = "renderer.rasterize.exp2"
    return [
        edit("sign", "of a slope", first, then, seen),
        edit("dropped", "the bend's shear", "across[lane] + shear * y", "across[lane]", seen),
        edit(
            "swapped",
            "across and down",
            "center_x = record[CENTER_X] - np.float32(left)",
            "center_x = record[CENTER_Y] - np.float32(left)",
            seen,
        ),
        edit("dropped", "the stop", "STOP = np.float32(1e-4)", "STOP = np.float32(-1.0)", ("overlap",)),
        edit(
            "other",
            "a stop at 1e-2",
            "STOP = np.float32(1e-4)",
            "STOP = np.float32(1e-2)",
            ("pictures", "overlap"),
        ),
        edit("other", "a cap of 1", "ALPHA_CAP = np.float32(0.99)", "ALPHA_CAP = np.float32(1.0)", seen),
        Fault("blending", "float16", "planes", seen, rounded(f"{TILES}:blend", 5), quick=True),
        Fault(
            "blending",
            "other",
            "depth is not divided by alpha",
            ("depths",),
            edited(
                PICTURE,
                "depth[y, x] = planes[PLANE_DEPTH, y, x] / seen",
                "depth[y, x] = planes[PLANE_DEPTH, y, x]",
            ),
            quick=True,
        ),
        Fault(
            "blending",
            "float16",
            "the first coefficient of exp",
            ("exponential",),
            edited(
                exponential, "C1 = np.float32(0.6931471880262273)", "C1 = np.float32(0.6933594)", BLENDING
            ),
            quick=True,
        ),
        Fault(
            "blending",
            "dropped",
            "the last coefficient of exp",
            ("exponential",),
            edited(exponential, "C5 = np.float32(0.001339086336353527)", "C5 = np.float32(0.0)", BLENDING),
        ),
        Fault(
            "blending",
            "sign",
            "of a coefficient of exp",
            ("exponential", "pictures"),
            edited(exponential, "C3 = np.float32(", "C3 = -np.float32(", TILES, BLENDING),
        ),
    ]


def _raster_backward() -> list[Fault]:
    def edit(kind: Any, what: str, old: str, new: str) -> Fault:
        return Fault("gradient of blending", kind, what, SLOPES, edited(TILES, old, new))

    return [
        edit("sign", "of what lies behind", "weight * by_weight - behind", "weight * by_weight + behind"),
        edit("dropped", "the capped have no slope", "q = q if alpha < ALPHA_CAP else ZERO", "q = q"),
        edit("dropped", "a factor of two", "x * (TWO * by_x + x * by)", "x * (by_x + x * by)"),
        edit("swapped", "moments", "lanes[_QXX, lane] += q * dxx", "lanes[_QXX, lane] += q * dyy"),
        Fault("gradient of blending", "float16", "entry sums", SLOPES, rounded(f"{TILES}:blend_backward", 7)),
        Fault(
            "gradient of blending",
            "float16",
            "the adjoint",
            SLOPES,
            rounded(f"{CPU}:adjoint_of", 5),
        ),
        Fault(
            "gradient of blending",
            "dropped",
            "the background",
            (*SLOPES, *BROKEN),
            edited(PICTURE, "by_alpha[y, x] - behind - far", "by_alpha[y, x] - far"),
            quick=True,
        ),
        Fault(
            "gradient of blending",
            "dropped",
            "the expected depth's share",
            SLOPES,
            edited(PICTURE, "- behind - far * expected", "- behind"),
        ),
        Fault(
            "gradient of blending",
            "sign",
            "of alpha",
            SLOPES,
            edited(PICTURE, "weight = by_alpha[y, x] - behind", "weight = -by_alpha[y, x] - behind"),
        ),
        Fault(
            "gradient of blending",
            "dropped",
            "all entries but the first",
            SLOPES,
            edited(
                TILES,
                "for slot in range(slot_starts[n], slot_starts[n + 1]):",
                "for slot in range(slot_starts[n], min(slot_starts[n] + 1, slot_starts[n + 1])):",
            ),
        ),
    ]


def _bins() -> list[Fault]:
    def edit(kind: Any, what: str, old: str, new: str) -> Fault:
        return Fault("tile lists", kind, what, ("pictures",), edited(BINNING, old, new))

    order = f"{BINNING}:depth_order"
    return [
        Fault("tile lists", "sign", "back to front", ("pictures", *BROKEN), replaced(order, _reversed), True),
        Fault("tile lists", "float16", "depths", ("pictures",), replaced(order, _depths_in_half)),
        edit("dropped", "the last digit of depth", "(0, _RADIX_BITS, 2 * _RADIX_BITS)", "(0, _RADIX_BITS)"),
        edit(
            "swapped",
            "rows and columns",
            "last_row = _tile_at(math.floor(v + half_height - 0.5), rows)",
            "last_row = _tile_at(math.floor(v + half_width - 0.5), rows)",
        ),
        edit("dropped", "the last column", "min(last_column, columns - 1)", "min(last_column, columns - 2)"),
        edit("dropped", "the last row", "min(last_row, rows - 1)", "min(last_row, rows - 2)"),
    ]


def _harmonics() -> list[Fault]:
    def edit(kind: Any, what: str, old: str, new: str, quick: bool = False) -> Fault:
        return Fault("harmonics", kind, what, ("harmonics",), edited(HARMONICS, old, new), quick)

    return [
        edit("sign", "of the first", "out[2] = -_P1 * y", "out[2] = _P1 * y", quick=True),
        edit("dropped", "a term of the twelfth", "(F(2) * zz - F(3) * (xx + yy))", "(F(2) * zz)"),
        edit("swapped", "x and y", "out[13] = _F2 * x * y * z", "out[13] = _F2 * x * x * z"),
        Fault("harmonics", "float16", "colours", ("harmonics",), rounded(f"{HARMONICS}:add_harmonics", 3)),
        edit("sign", "of a slope", "by_y -= F(2) * y * z", "by_y += F(2) * y * z"),
        edit("dropped", "the turn alone counts", "nearness * (by_x - along * x)", "nearness * by_x"),
        edit("swapped", "slopes along y and z", "(by_y - along * y)", "(by_z - along * y)"),
        Fault(
            "harmonics",
            "float16",
            "gradients by the means",
            ("harmonics",),
            rounded(f"{HARMONICS}:harmonics_backward", 6),
        ),
        Fault(
            "harmonics",
            "float16",
            "gradients by the harmonics",
            ("harmonics",),
            rounded(f"{HARMONICS}:harmonics_backward", 5),
        ),
        edit("guard", "no direction", "if length > 0.0 else 0.0", "if length >= 0.0 else 0.0"),
    ]


def _opengl() -> list[Fault]:
    def edit(kind: Any, what: str, old: str, new: str) -> Fault:
        return Fault("OpenGL", kind, what, ("OpenGL",), _shader(old, new))

    return [
        edit("sign", "of the exponent's shear", "offset.y - shape.x", "offset.y + shape.x"),
        edit("dropped", "the low-pass", "LOW_PASS = 0.3", "LOW_PASS = 0.0"),
        edit("swapped", "across and down", "gl_FragCoord.xy - center", "gl_FragCoord.yx - center"),
        edit("other", "a cap of 1", "ALPHA_MAX = 0.99", "ALPHA_MAX = 1.0"),
        edit(
            "guard",
            "a quaternion of 0",
            "largest > 0.0 ? normalize(quat / largest) :",
            "largest >= 0.0 ? normalize(quat) :",
        ),
        Fault(
            "OpenGL",
            "float16",
            "what is blended in",
            ("OpenGL",),
            replaced("renderer.draw.splat_view:_FORMATS", lambda whole: {**whole, "float": "f2"}),
        ),
        edit("swapped", "colours", "(paint.rgb - pivot)", "(paint.gbr - pivot)"),
        Fault(
            "OpenGL",
            "sign",
            "front to back",
            ("OpenGL",),
            edited("renderer.draw.splat_view", "self._keys)][::-1])", "self._keys)])"),
        ),
        Fault(
            "OpenGL",
            "guard",
            "the near plane",
            ("OpenGL",),
            edited("renderer.draw.splat_view", "depths > self._near", "depths > 0"),
        ),
    ]


FAULTS: tuple[Fault, ...] = (
    *_projection(),
    *_project_backward(),
    *_raster(),
    *_raster_backward(),
    *_bins(),
    *_harmonics(),
    *_opengl(),
)
