"""Working arrays of a kernel on its stack, at addresses that whole vectors never straddle."""

from __future__ import annotations

from collections.abc import Callable
from math import prod
from typing import Any, cast

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic
from numba.np.arrayobj import make_array, populate_array

from renderer.camera import FloatArray
from renderer.splats import Float32Array

_LINE = 64
"""Bytes of a cache line and of the widest vector; heap arrays begin at any multiple of 32."""


def _stack_arrays(of: types.Float, item: ir.Type) -> Any:
    """The function that makes stack arrays of this number type."""
    item_size = of.bitwidth // 8

    @intrinsic(prefer_literal=True)
    def stack_array(typing_context: Any, *shape: Any) -> Any:
        sizes = tuple(int(each.literal_value) for each in shape)
        array_type = types.Array(of, len(sizes), "C")

        def codegen(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            memory = cgutils.alloca_once(builder, ir.ArrayType(item, prod(sizes)))
            memory.align = _LINE
            array = make_array(array_type)(context, builder)
            strides = [item_size * prod(sizes[axis + 1 :]) for axis in range(len(sizes))]
            populate_array(
                array,
                data=builder.bitcast(memory, item.as_pointer()),
                shape=[context.get_constant(types.intp, size) for size in sizes],
                strides=[context.get_constant(types.intp, stride) for stride in strides],
                itemsize=context.get_constant(types.intp, item_size),
                meminfo=None,
            )
            return array._getvalue()

        return array_type(types.StarArgTuple.from_types(shape)), codegen

    return stack_array


stack_array = cast("Callable[..., Float32Array]", _stack_arrays(types.float32, ir.FloatType()))
"""For kernels only: `stack_array(2, 16)` is a float32 array of that constant shape, not initialised, that
lives as long as the calling function. LLVM knows that it overlaps nothing else, which it cannot know of
arrays from the heap."""
stack_array64 = cast("Callable[..., FloatArray]", _stack_arrays(types.float64, ir.DoubleType()))
"""The same in float64."""
