"""2**x, log2(x) and rounding in float32 that LLVM vectorises: numba brings no vector maths library."""

from __future__ import annotations

from typing import Any

import numpy as np
from llvmlite import ir
from numba import njit, types
from numba.extending import intrinsic

ONE = np.float32(1.0)
LEAST_EXPONENT = np.float32(-126.0)
"""2**-126 is the smallest normal float32, and as good as 0 in a picture."""
SQRT_HALF_BITS = np.int32(0x3F3504F3)
LOG2_ZERO = np.float32(-1e30)
"""Stands for the logarithm of 0: any power of 0 that is used here ends as 0."""
LEAST_NORMAL = np.float32(2.0**-126)

# Minimax fits in the relative error: 2**f on [-1/2, 1/2] and log2(1 + f) / f on [sqrt(1/2) - 1, sqrt(2) - 1].
E1 = np.float32(0.6931472057375826)
E2 = np.float32(0.24022646890554789)
E3 = np.float32(0.055503287762682665)
E4 = np.float32(0.009618488963207335)
E5 = np.float32(0.0013399931504075235)
E6 = np.float32(0.0001534581103025138)
L0 = np.float32(1.44269500365168)
L1 = np.float32(-0.7213473468160237)
L2 = np.float32(0.4809106431374955)
L3 = np.float32(-0.3607036818811115)
L4 = np.float32(0.28791624028173707)
L5 = np.float32(-0.23894483608187722)
L6 = np.float32(0.2157157031554143)
L7 = np.float32(-0.20726969667795436)
L8 = np.float32(0.1258366935541082)

_FLOAT, _WORD = ir.FloatType(), ir.IntType(32)


@intrinsic
def rounded(typing_context: Any, value: Any) -> Any:
    """Nearest whole number, ties to even, as float32: one vector instruction."""

    def codegen(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return builder.call(builder.module.declare_intrinsic("llvm.rint", [_FLOAT]), arguments)

    return types.float32(types.float32), codegen


@intrinsic
def _times_power_of_two(typing_context: Any, value: Any, exponent: Any) -> Any:
    """value * 2**exponent by adding the whole number to the float's exponent bits."""

    def codegen(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        steps = builder.shl(builder.fptosi(arguments[1], _WORD), ir.Constant(_WORD, 23))
        return builder.bitcast(builder.add(builder.bitcast(arguments[0], _WORD), steps), _FLOAT)

    return types.float32(types.float32, types.float32), codegen


@intrinsic
def _binade(typing_context: Any, value: Any) -> Any:
    """k as float32, where value = m 2**k with m in [sqrt(1/2), sqrt(2))."""

    def codegen(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        above = builder.sub(builder.bitcast(arguments[0], _WORD), ir.Constant(_WORD, int(SQRT_HALF_BITS)))
        return builder.sitofp(builder.ashr(above, ir.Constant(_WORD, 23)), _FLOAT)

    return types.float32(types.float32), codegen


@njit(forceinline=True, error_model="numpy")
def exp2(x: np.float32) -> np.float32:
    """2**x for float32 x <= 127, as 2**-126 below that; relative error below 2e-7, exactly 1 at 0."""
    x = x if x > LEAST_EXPONENT else LEAST_EXPONENT
    whole: np.float32 = rounded(x)  # type: ignore[call-arg]
    f = x - whole
    fraction = ONE + f * (E1 + f * (E2 + f * (E3 + f * (E4 + f * (E5 + f * E6)))))
    result: np.float32 = _times_power_of_two(fraction, whole)
    return result


@njit(forceinline=True, error_model="numpy")
def log2(x: np.float32) -> np.float32:
    """log2(x) for float32 x >= 0; error below 2e-7 (|log2 x| + 1), exactly 0 at 1; of 0, LOG2_ZERO."""
    whole: np.float32 = _binade(x)  # type: ignore[call-arg]
    mantissa: np.float32 = _times_power_of_two(x, -whole)
    f = mantissa - ONE
    slope = L0 + f * (L1 + f * (L2 + f * (L3 + f * (L4 + f * (L5 + f * (L6 + f * (L7 + f * L8)))))))
    result: np.float32 = whole + f * slope
    return result if x >= LEAST_NORMAL else LOG2_ZERO
