"""Windows along a row of sums over their columns: by running sums, or added up where they are narrow."""

from __future__ import annotations

from typing import Any, Final, cast

import numpy as np
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic
from numpy.typing import NDArray

from enhance.part import part
from enhance.wide_vectors import wide_vectors

NARROW: Final = 1
"""Pixels on each side, counted in full, of a window that is added up."""
EDGE: Final = NARROW + 1
"""Sums beyond each end of its row, which are 0."""


@intrinsic
def _add_fours(typing_context: Any, rows: Any, more: Any, fours: Any, out: Any, out_more: Any) -> Any:
    """out[x] = the sum of rows[: x + 1] for the x of so many fours, and the same of `more`: both rows in one
    vector, as each step waits for the one before.

    To the last sum comes what is added up from there on: 0, 0 + 1, (0 + 1) + 2 and (0 + 1) + (2 + 3).
    """
    four, eight = (ir.VectorType(ir.DoubleType(), count) for count in (4, 8))
    nothing = ir.Constant(eight, None)

    def codegen(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        def data(index: int) -> Any:
            return context.make_array(signature.args[index])(context, builder, arguments[index]).data

        def shuffled(one: Any, other: Any, lanes: list[int]) -> Any:
            order = ir.Constant(ir.VectorType(ir.IntType(32), len(lanes)), lanes)
            return builder.shuffle_vector(one, other, order)

        def in_both(sums: Any, lanes: list[int]) -> Any:
            """These lanes of each half; 8: 0."""
            return shuffled(sums, nothing, lanes + [lane if lane == 8 else lane + 4 for lane in lanes])

        sources, targets = (data(0), data(1)), (data(3), data(4))
        total = cast(Any, cgutils).alloca_once_value(builder, nothing)
        with cgutils.for_range(builder, arguments[2]) as loop:
            at = builder.mul(loop.index, ir.Constant(loop.index.type, 4))

            def place(array: Any) -> Any:
                return builder.bitcast(builder.gep(array, [at]), four.as_pointer())

            first, second = (builder.load(place(array), align=8) for array in sources)
            sums = shuffled(first, second, list(range(8)))
            sums = builder.fadd(sums, in_both(sums, [8, 0, 8, 2]))
            sums = builder.fadd(sums, in_both(sums, [8, 8, 1, 1]))
            before = builder.load(total)
            builder.store(builder.fadd(before, in_both(sums, [3] * 4)), total)
            sums = builder.fadd(before, sums)
            for array, lanes in zip(targets, ([0, 1, 2, 3], [4, 5, 6, 7]), strict=True):
                builder.store(shuffled(sums, sums, lanes), place(array), align=8)
        return context.get_dummy_value()

    return types.void(rows, more, types.intp, out, out_more), codegen


@part()
def accumulate(
    first: NDArray[np.float64], second: NDArray[np.float64], whole: int, running: NDArray[np.float64]
) -> None:
    """Running sums of two rows, (2, n): 0 before the row and the total after it, so that no window needs a
    look at the border.

    Four at a time: each step waits for one addition instead of four.
    """
    wide_vectors()
    columns = len(first)
    out, out_2 = running[0, whole + 2 :], running[1, whole + 2 :]
    for x in range(whole + 2):
        running[0, x], running[1, x] = 0.0, 0.0
    fours = columns // 4
    _add_fours(first, second, fours, out, out_2)  # type: ignore[call-arg]
    total, total_2 = (out[4 * fours - 1], out_2[4 * fours - 1]) if fours > 0 else (0.0, 0.0)
    for x in range(4 * fours, columns):
        total += first[x]
        total_2 += second[x]
        out[x], out_2[x] = total, total_2
    for x in range(columns, len(out)):
        out[x], out_2[x] = total, total_2


@part(fastmath={"contract"})
def mean_of(
    running: NDArray[np.float64],
    whole: int,
    part: float,
    shares: NDArray[np.float64],
    tall: float,
    out: NDArray[np.float32],
) -> None:
    wide_vectors()
    inner, last, outer = running[1:], running[2 * whole + 2 :], running[2 * whole + 3 :]
    for x in range(len(out)):
        total = (1.0 - part) * (last[x] - inner[x]) + part * (outer[x] - running[x])
        out[x] = np.float32(total * (shares[x] * tall))


@part(forceinline=True, fastmath={"contract"})
def _variance(share: float, middle: float, square: float) -> np.float32:
    """Of a window with that mean, and that sum of squares over as much as one by `share`."""
    spread = np.float32(square * share - middle * middle)
    # Rounding can leave a flat window's variance slightly negative.
    return spread if spread > np.float32(0.0) else np.float32(0.0)


@part(fastmath={"contract"})
def describe(
    running_first: NDArray[np.float64],
    running_second: NDArray[np.float64],
    whole: int,
    part: float,
    shares: NDArray[np.float64],
    tall: float,
    variance: NDArray[np.float32],
    mean: NDArray[np.float32],
) -> None:
    """Of V in a row of windows."""
    wide_vectors()
    inner, last, outer = running_first[1:], running_first[2 * whole + 2 :], running_first[2 * whole + 3 :]
    inner_2, last_2 = running_second[1:], running_second[2 * whole + 2 :]
    outer_2 = running_second[2 * whole + 3 :]
    for x in range(len(mean)):
        share = shares[x] * tall
        middle = share * ((1.0 - part) * (last[x] - inner[x]) + part * (outer[x] - running_first[x]))
        square = (1.0 - part) * (last_2[x] - inner_2[x]) + part * (outer_2[x] - running_second[x])
        variance[x] = _variance(share, middle, square)
        mean[x] = np.float32(middle)


@part(fastmath={"contract"})
def mean_narrow(
    sums: NDArray[np.float64],  # (columns + 2 EDGE,)
    part: float,
    shares: NDArray[np.float64],
    tall: float,
    out: NDArray[np.float32],
) -> None:
    """As `mean_of`, of a window with NARROW whole pixels on each side."""
    wide_vectors()
    left, near, middle, far, right = sums, sums[1:], sums[2:], sums[3:], sums[4:]
    for x in range(len(out)):
        total = (near[x] + middle[x] + far[x]) + part * (left[x] + right[x])
        out[x] = np.float32(total * (shares[x] * tall))


@part(fastmath={"contract"})
def describe_narrow(
    first: NDArray[np.float64],  # (columns + 2 EDGE,)
    second: NDArray[np.float64],
    part: float,
    shares: NDArray[np.float64],
    tall: float,
    variance: NDArray[np.float32],
    mean: NDArray[np.float32],
) -> None:
    """As `describe`, of a window with NARROW whole pixels on each side."""
    wide_vectors()
    left, near, here, far, right = first, first[1:], first[2:], first[3:], first[4:]
    left_2, near_2, here_2, far_2, right_2 = second, second[1:], second[2:], second[3:], second[4:]
    for x in range(len(mean)):
        share = shares[x] * tall
        middle = share * ((near[x] + here[x] + far[x]) + part * (left[x] + right[x]))
        square = (near_2[x] + here_2[x] + far_2[x]) + part * (left_2[x] + right_2[x])
        variance[x] = _variance(share, middle, square)
        mean[x] = np.float32(middle)
