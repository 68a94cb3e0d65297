"""Colours of pixels apart and together again, 16 pixels a step: LLVM's own code for stride three is slow."""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba import types
from numba.extending import intrinsic
from numpy.typing import NDArray

from enhance.part import part

STEP = 16


def _vector(kind: Any, length: int, context: Any) -> Any:
    return ir.VectorType(context.get_data_type(kind.dtype), length)


def _at(context: Any, builder: Any, kind: Any, array: Any, index: Any, vector: Any) -> Any:
    """Pointer to a vector that starts at element `index` of a C-contiguous array's memory."""
    data = context.make_array(kind)(context, builder, array).data
    return builder.bitcast(builder.gep(data, [index]), vector.as_pointer())


def _shuffled(builder: Any, first: Any, second: Any, lanes: list[int]) -> Any:
    word = ir.IntType(32)
    mask = ir.Constant(ir.VectorType(word, len(lanes)), [ir.Constant(word, lane) for lane in lanes])
    return builder.shuffle_vector(first, second, mask)


@intrinsic
def _take_16(typing_context: Any, pixels: Any, start: Any, planes: Any, at: Any, stride: Any) -> Any:
    """planes.flat[at + c stride + i] = pixels.flat[start + 3 i + c] for 16 i and 3 c."""

    def codegen(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        source, begin, target, first, step = arguments
        long, short = _vector(pixels, 3 * STEP, context), _vector(planes, STEP, context)
        size = context.get_abi_sizeof(long.element)
        whole = builder.load(_at(context, builder, pixels, source, begin, long), align=size)
        for color in range(3):
            plane = _shuffled(builder, whole, whole, [3 * i + color for i in range(STEP)])
            index = builder.add(first, builder.mul(step, ir.Constant(step.type, color)))
            builder.store(plane, _at(context, builder, planes, target, index, short), align=size)
        return context.get_dummy_value()

    return types.void(pixels, types.intp, planes, types.intp, types.intp), codegen


@intrinsic
def _put_16(typing_context: Any, planes: Any, at: Any, stride: Any, pixels: Any, start: Any) -> Any:
    """pixels.flat[start + 3 i + c] = planes.flat[at + c stride + i] for 16 i and 3 c."""

    def codegen(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        source, first, step, target, begin = arguments
        long, short = _vector(pixels, 3 * STEP, context), _vector(planes, STEP, context)
        size = context.get_abi_sizeof(long.element)
        parts = []
        for color in range(3):
            index = builder.add(first, builder.mul(step, ir.Constant(step.type, color)))
            parts.append(builder.load(_at(context, builder, planes, source, index, short), align=size))
        pair = _shuffled(builder, parts[0], parts[1], list(range(2 * STEP)))
        third = _shuffled(builder, parts[2], parts[2], list(range(2 * STEP)))
        lanes = [i + color * STEP for i in range(STEP) for color in range(3)]
        whole = _shuffled(builder, pair, third, lanes)
        builder.store(whole, _at(context, builder, pixels, target, begin, long), align=size)
        return context.get_dummy_value()

    return types.void(planes, types.intp, types.intp, pixels, types.intp), codegen


@part(forceinline=True, fastmath={"contract"})
def deinterleave(pixels: NDArray[Any], planes: NDArray[Any]) -> None:
    """(n, 3) pixels to the first n of the first three rows of `planes`; both C-contiguous, of one type."""
    width = planes.shape[1]
    whole = len(pixels) // STEP * STEP
    for i in range(0, whole, STEP):
        _take_16(pixels, 3 * i, planes, i, width)  # type: ignore[call-arg]
    for i in range(whole, len(pixels)):
        for color in range(3):
            planes[color, i] = pixels[i, color]


@part(forceinline=True, fastmath={"contract"})
def interleave(planes: NDArray[Any], pixels: NDArray[Any]) -> None:
    """The other way round."""
    width = planes.shape[1]
    whole = len(pixels) // STEP * STEP
    for i in range(0, whole, STEP):
        _put_16(planes, i, width, pixels, 3 * i)  # type: ignore[call-arg]
    for i in range(whole, len(pixels)):
        for color in range(3):
            pixels[i, color] = planes[color, i]
