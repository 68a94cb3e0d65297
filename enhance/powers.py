"""2**x, log2(x) and rounding in float32 that LLVM vectorises: numba brings no vector maths library."""

from __future__ import annotations

from typing import Any

import numpy as np
from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from enhance.part import part

ONE = np.float32(1.0)
LEAST_EXPONENT = np.float32(-126.0)
"""2**-126 is the smallest normal float32, and as good as 0 in a picture."""
SQRT_HALF_BITS = np.int32(0x3F3504F3)
LOG2_ZERO = np.float32(-1e30)
"""Stands for the logarithm of 0: any power of 0 that is used here ends as 0."""
LEAST_NORMAL = np.float32(2.0**-126)
LN_2, LOG2_E = np.float32(np.log(2)), np.float32(1 / np.log(2))

# Minimax fits in the relative error: 2**f on [-1/2, 1/2] and log2(1 + f) / f on [sqrt(1/2) - 1, sqrt(2) - 1].
E1 = np.float32(0.6931470036506653)
E2 = np.float32(0.24022242426872253)
E3 = np.float32(0.05550733581185341)
E4 = np.float32(0.009671512991189957)
E5 = np.float32(0.001326472731307149)
L0 = np.float32(1.44269500365168)
L1 = np.float32(-0.7213473468160237)
L2 = np.float32(0.4809106431374955)
L3 = np.float32(-0.3607036818811115)
L4 = np.float32(0.28791624028173707)
L5 = np.float32(-0.23894483608187722)
L6 = np.float32(0.2157157031554143)
L7 = np.float32(-0.20726969667795436)
L8 = np.float32(0.1258366935541082)
# The same, shorter by a term and by three: within a thousandth of a grey level.
BRIEF_E1 = np.float32(0.6931241750717163)
BRIEF_E2 = np.float32(0.24024099111557007)
BRIEF_E3 = np.float32(0.055906426161527634)
BRIEF_E4 = np.float32(0.009582852944731712)
BRIEF_L0 = np.float32(1.4427134990692139)
BRIEF_L1 = np.float32(-0.7211318612098694)
BRIEF_L2 = np.float32(0.47934800386428833)
BRIEF_L3 = np.float32(-0.3674899637699127)
BRIEF_L4 = np.float32(0.32215484976768494)
BRIEF_L5 = np.float32(-0.20659184455871582)

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


@part(forceinline=True)
def exp2(x: np.float32) -> np.float32:
    """2**x for float32 x <= 127, as 2**-126 below that; relative error below 2e-7, exactly 1 at 0."""
    whole, f = _split(x)
    fraction = ONE + f * (E1 + f * (E2 + f * (E3 + f * (E4 + f * E5))))
    result: np.float32 = _times_power_of_two(fraction, whole)  # type: ignore[call-arg]
    return result


@part(forceinline=True)
def brief_exp2(x: np.float32) -> np.float32:
    """As `exp2`; relative error below 3e-6."""
    whole, f = _split(x)
    fraction = ONE + f * (BRIEF_E1 + f * (BRIEF_E2 + f * (BRIEF_E3 + f * BRIEF_E4)))
    result: np.float32 = _times_power_of_two(fraction, whole)  # type: ignore[call-arg]
    return result


@part(forceinline=True)
def _split(x: np.float32) -> tuple[np.float32, np.float32]:
    """The nearest whole number, and what is left."""
    x = x if x > LEAST_EXPONENT else LEAST_EXPONENT
    whole: np.float32 = rounded(x)  # type: ignore[call-arg]
    return whole, x - whole


@part(forceinline=True)
def log2(x: np.float32) -> np.float32:
    """log2(x) for float32 x >= 0; error below 2e-7 (|log2 x| + 1), exactly 0 at 1; of 0, LOG2_ZERO."""
    whole, f = _taken_apart(x)
    slope = L0 + f * (L1 + f * (L2 + f * (L3 + f * (L4 + f * (L5 + f * (L6 + f * (L7 + f * L8)))))))
    result: np.float32 = whole + f * slope
    return result if x >= LEAST_NORMAL else LOG2_ZERO


@part(forceinline=True)
def brief_log2(x: np.float32) -> np.float32:
    """As `log2`; error below 2e-6."""
    whole, f = _taken_apart(x)
    slope = BRIEF_L0 + f * (BRIEF_L1 + f * (BRIEF_L2 + f * (BRIEF_L3 + f * (BRIEF_L4 + f * BRIEF_L5))))
    result: np.float32 = whole + f * slope
    return result if x >= LEAST_NORMAL else LOG2_ZERO


@part(forceinline=True)
def _taken_apart(x: np.float32) -> tuple[np.float32, np.float32]:
    """k and f, where x = (1 + f) 2**k and 1 + f is about 1."""
    whole: np.float32 = _binade(x)  # type: ignore[call-arg]
    mantissa: np.float32 = _times_power_of_two(x, -whole)
    return whole, mantissa - ONE
