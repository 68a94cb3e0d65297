"""Vectors of 512 bits where the CPU has them: LLVM of its own takes 256, since early CPUs slowed down at 512.

No sum is reordered, so results stay bit for bit. On two cores with AVX-512 a frame of `vessel` takes four
fifths of the time, one of the paper's method nine tenths; on other CPUs nothing changes.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final, cast

from numba import types
from numba.extending import intrinsic

WIDE: Final = '"prefer-vector-width"="512"'
"""An attribute of functions in LLVM."""


def _ask(typing_context: Any) -> Any:
    def codegen(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        # A set, whose own `add` takes no attributes with values.
        set.add(builder.function.attributes, WIDE)
        return context.get_dummy_value()

    return types.void(), codegen


wide_vectors = cast(Callable[[], None], intrinsic(_ask))
"""For the loops of the kernel that calls it, before it is inlined anywhere; not those of a `prange`."""
