"""What enhancement is timed against does the same work, and nothing else."""

from __future__ import annotations

import numpy as np
import pytest

from enhance import EnhanceParams, enhance
from tests.benchmarks.yardstick import enhance_plainly
from tests.enhance.pictures import vessels


@pytest.mark.parametrize(
    "params",
    [
        EnhanceParams(keep_black=False, d_factor=1.0),
        EnhanceParams(keep_black=False, z=0.3, p=1.2, d_factor=0.5),
        EnhanceParams(keep_black=False, d_factor=0, radii=(8,)),
    ],
)
def test_the_yardstick_is_within_a_grey_level_of_the_equations(params: EnhanceParams) -> None:
    """Near the borders, which the yardstick reflects, within 3. `keep_black` would change a black corner."""
    image = vessels(256, 320)
    error = np.abs(enhance_plainly(image, params).astype(int) - enhance(image, params, pixels="all").image)
    inner = error[64:-64, 64:-64]
    assert inner.max() <= 1
    assert error.max() <= 3
    kept = enhance(image, EnhanceParams(d_factor=1.0), pixels="all").image
    assert np.abs(enhance_plainly(image).astype(int) - kept).max() > 10
