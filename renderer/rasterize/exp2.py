"""2**x in float32 arithmetic that LLVM vectorises: numba brings no vector maths library of its own."""

from __future__ import annotations

from typing import Any

import numpy as np
from llvmlite import ir
from numba import njit, types
from numba.extending import intrinsic

C0 = np.float32(1.0000000754548972)
C1 = np.float32(0.6931471880262273)
C2 = np.float32(0.2402210748530968)
C3 = np.float32(0.05550357114222094)
C4 = np.float32(0.009676031918255982)
C5 = np.float32(0.001339086336353527)


@intrinsic
def _round(typing_context: Any, value: Any) -> Any:
    """Nearest whole number as float32: one vector instruction, where round() would give int64."""

    def codegen(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return builder.call(builder.module.declare_intrinsic("llvm.rint", [ir.FloatType()]), arguments)

    return types.float32(types.float32), codegen


@intrinsic
def _times_power_of_two(typing_context: Any, value: Any, exponent: Any) -> Any:
    """value * 2**exponent by adding the whole-number exponent to the float's exponent bits."""

    def codegen(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        word = ir.IntType(32)
        steps = builder.shl(builder.fptosi(arguments[1], word), ir.Constant(word, 23))
        return builder.bitcast(builder.add(builder.bitcast(arguments[0], word), steps), ir.FloatType())

    return types.float32(types.float32, types.float32), codegen


@njit(inline="always", error_model="numpy")
def exp2(x: np.float32) -> np.float32:
    """2**x for float32 x in [-126, 126]; relative error at most 2e-7 (degree-5 Chebyshev fit)."""
    whole: np.float32 = _round(x)  # type: ignore[call-arg]
    f = x - whole
    fraction = C0 + f * (C1 + f * (C2 + f * (C3 + f * (C4 + f * C5))))
    result: np.float32 = _times_power_of_two(fraction, whole)
    return result
