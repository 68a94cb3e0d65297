"""A chunk: a run of pixels of one row that the kernels work on at once.

Its constant number of pixels, held in one local block whose planes cannot overlap, float32 alone, and selects
instead of branches let LLVM turn each loop into straight vector code. Lanes past the end of a row hold what
came before; nobody counts or reads them.

Parts of kernels are inlined by LLVM (`forceinline`): to inline them itself, numba takes minutes to compile.
"""

from __future__ import annotations

from typing import Any, cast

import numpy as np
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic
from numba.np.arrayobj import populate_array
from numpy.typing import NDArray

from enhance.interleave import deinterleave
from enhance.part import part
from enhance.wide_vectors import wide_vectors

CHUNK = 256
"""Pixels: loops are long beside what it costs to begin them, and the planes stay in the first-level cache. A
multiple of 32."""
LINE = 64
"""Bytes of a line of the cache."""
STEP = LINE // 4
"""Float32 in a line: rows of as many, or of a multiple, begin with one each."""
BLOCK = 16
"""Low-resolution rows of one task: a fixed number, so that no result depends on the number of threads."""
BINS = 256

ZERO, QUARTER, HALF, ONE, TWO, THREE = (np.float32(x) for x in (0.0, 0.25, 0.5, 1.0, 2.0, 3.0))
LEVELS = np.float32(255.0)
LEAST = np.float32(1e-30)
"""In place of a divisor of 0."""
LUMA = (np.float32(0.299), np.float32(0.587), np.float32(0.114))

# Planes of a chunk.
RED, GREEN, BLUE, MOST, LEAST_COLOR, VALUE, LOG, INVERSE, SLOPE, OFFSET, TOTAL, KEEP, PLANES = range(13)


def _zeros(context: Any, builder: Any, kind: Any, shape: tuple[Any, ...], strides: tuple[Any, ...]) -> Any:
    """An array that begins with a line of the cache.

    Half of what numba allocates itself begins amid a line: vectors as wide as a line then lie in two of them,
    and a pass takes a tenth longer.
    """
    whole = builder.mul(shape[0], strides[0])
    owner = context.nrt.meminfo_alloc_aligned(builder, whole, LINE)
    data = context.nrt.meminfo_data(builder, owner)
    data = builder.bitcast(data, context.get_data_type(kind.dtype).as_pointer())
    cast(Any, cgutils).memset(builder, data, whole, 0)
    array = context.make_array(kind)(context, builder)
    cast(Any, populate_array)(array, data, shape, strides, itemsize=strides[-1], meminfo=owner)
    return array._getvalue()


@intrinsic
def zero_chunk(typing_context: Any) -> Any:
    """(PLANES, CHUNK) float32 zeros that begin with a line of the cache."""
    kind = types.Array(types.float32, 2, "C")

    def codegen(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        planes, width, step = (context.get_constant(types.intp, size) for size in (PLANES, CHUNK, 4))
        return _zeros(context, builder, kind, (planes, width), (builder.mul(width, step), step))

    return kind(), codegen


@intrinsic
def zero_row(typing_context: Any, count: Any, dtype: Any) -> Any:
    """(count,) zeros of this type that begin with a line of the cache; to be reshaped."""
    kind = types.Array(dtype.dtype, 1, "C")

    def codegen(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        step = context.get_constant(types.intp, context.get_abi_sizeof(context.get_data_type(kind.dtype)))
        return _zeros(context, builder, kind, (arguments[0],), (step,))

    return kind(types.intp, dtype), codegen


@part(forceinline=True, fastmath={"contract"})
def load(pixels: NDArray[Any], apart: NDArray[Any], chunk: NDArray[np.float32]) -> None:
    """Colours apart in their own, narrow type, and of each pixel the largest and the smallest, MOST and
    LEAST_COLOR, as they come."""
    wide_vectors()
    deinterleave(pixels, apart)
    for i in range(CHUNK):
        red, green, blue = apart[0, i], apart[1, i], apart[2, i]
        most = red if red > green else green
        least = red if red < green else green
        apart[3, i] = most if most > blue else blue
        apart[4, i] = least if least < blue else blue
    for plane in (MOST, LEAST_COLOR):
        for i in range(CHUNK):
            chunk[plane, i] = np.float32(apart[plane, i])


@part(forceinline=True, fastmath={"contract"})
def load_keep(keep: NDArray[np.uint8], y: int, x0: int, count: int, chunk: NDArray[np.float32]) -> None:
    """1 where a pixel counts, 0 elsewhere; an empty `keep` keeps all."""
    wide_vectors()
    if keep.shape[0] == 0:
        for i in range(CHUNK):
            chunk[KEEP, i] = ONE if i < count else ZERO
    else:
        for i in range(CHUNK):
            chunk[KEEP, i] = ZERO
        for i in range(count):
            chunk[KEEP, i] = np.float32(keep[y, x0 + i])


@part(forceinline=True, fastmath={"contract"})
def keep_within(first: int, end: int, x0: int, chunk: NDArray[np.float32]) -> None:
    """Only columns from `first` on and before `end` count."""
    wide_vectors()
    for i in range(CHUNK):
        chunk[KEEP, i] = chunk[KEEP, i] if first <= x0 + i < end else ZERO


@part()
def copy_pixels(pixels: NDArray[Any], out: NDArray[Any]) -> None:
    """(n, 3) pixels, both C-contiguous."""
    copy_row(pixels.reshape(-1), out.reshape(-1))


@part()
def copy_row(source: NDArray[Any], target: NDArray[Any]) -> None:
    """As many as `target` has: a loop becomes vector code where an assignment of slices does not."""
    wide_vectors()
    for i in range(len(target)):
        target[i] = source[i]
