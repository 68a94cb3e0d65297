"""Fetching rows of an array ahead of their use: what comes in no order hides its way from memory."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, cast

from llvmlite import ir
from numba import types
from numba.extending import intrinsic
from numba.np.arrayobj import make_array
from numpy.typing import NDArray

_READ, _KEPT_CLOSE, _DATA = 0, 3, 1
"""What llvm.prefetch is asked for."""


@intrinsic
def _prefetch_row(typing_context: Any, array: Any, row: Any) -> Any:
    """See prefetch_row."""

    def codegen(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        view = make_array(signature.args[0])(context, builder, arguments[0])
        byte, word = ir.IntType(8).as_pointer(), ir.IntType(32)
        fetch = builder.module.declare_intrinsic(
            "llvm.prefetch", [byte], ir.FunctionType(ir.VoidType(), [byte, word, word, word])
        )
        stride = builder.extract_value(view.strides, 0)
        index = context.cast(builder, arguments[1], signature.args[1], types.intp)
        start = builder.mul(stride, index)
        last = builder.sub(builder.add(start, stride), context.get_constant(types.intp, 1))
        for offset in (start, last):
            place = builder.gep(builder.bitcast(view.data, byte), [offset])
            builder.call(fetch, [place, *(ir.Constant(word, how) for how in (_READ, _KEPT_CLOSE, _DATA))])
        return context.get_dummy_value()

    return types.void(array, row), codegen


prefetch_row = cast("Callable[[NDArray[Any], int], None]", _prefetch_row)
"""For kernels only: `prefetch_row(array, row)` fetches the cache lines at both ends of array[row]:
all of a row of at most 64 bytes."""
