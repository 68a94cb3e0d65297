from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from enhance import EnhanceParams, detail, enhance
from enhance.params import PForm
from tests.enhance.pictures import vessels

JUST = 1e-9


def jump(sigma: float, form: PForm) -> float:
    return detail.exponent(sigma + JUST, form) - detail.exponent(sigma - JUST, form)


@pytest.mark.parametrize(
    ("sigma", "p"), [(0, 1.75), (2, 1.75), (3, 21 / 13), (6, 15 / 13), (9.5, 8 / 13), (10, 0.5), (100, 0.5)]
)
def test_p_as_printed(sigma: float, p: float) -> None:
    assert detail.exponent(sigma, "literal") == pytest.approx(p)


def test_literal_p_jumps_where_the_paper_does_and_nowhere_else() -> None:
    assert jump(2, "literal") == pytest.approx(23 / 13 - 7 / 4, abs=1e-6)
    assert jump(10, "literal") == pytest.approx(1 / 2 - 7 / 13, abs=1e-6)
    assert abs(jump(6, "literal")) < 1e-6


@given(st.floats(0, 127.5))
def test_continuous_p_has_no_jump_and_differs_little(sigma: float) -> None:
    assert abs(jump(max(sigma, 1e-6), "continuous")) < 1e-6
    literal, continuous = detail.exponent(sigma, "literal"), detail.exponent(sigma, "continuous")
    assert abs(literal - continuous) <= 1 / 26 + 1e-12
    assert 0.5 <= continuous <= 1.75


def values(image: NDArray[np.float64], **changes: Any) -> NDArray[np.float32]:
    """V* of a grey float image with Eq 1 and the fade off."""
    params = EnhanceParams(z=1.0, keep_black=False, omit_below=0.0, **changes)
    return np.asarray(enhance(image.astype(np.float32), params).image)


def spots() -> NDArray[np.float64]:
    """Mid-grey with a dark and a bright pixel that the filter blurs away."""
    image = np.full((40, 60), 0.5)
    image[20, 20], image[20, 40] = 0.44, 0.56
    return image


@pytest.mark.parametrize("p", [0.0, 0.5, 1.0, 1.75, 4.0])
def test_darker_than_around_gets_darker_and_brighter_gets_brighter(p: float) -> None:
    image = spots()
    enhanced = values(image, p=p, radii=(4,))
    if p == 0:
        np.testing.assert_allclose(enhanced, image, atol=2e-7)
        return
    assert enhanced[20, 20] < 0.44 - 0.005 * p
    assert enhanced[20, 40] > 0.56 + 0.005 * p
    assert enhanced[2, 2] == pytest.approx(0.5, abs=1e-6)


def test_square_root_is_the_power_of_a_half() -> None:
    rng = np.random.default_rng(8)
    image = rng.random((30, 40))
    np.testing.assert_allclose(values(image, p=0.5), values(image, p=0.5 + 1e-7), atol=2e-6)


def test_scales_weigh_the_same() -> None:
    image = vessels(60, 80)[..., 1] / 255
    p = (0.5, 1.0, 1.75)
    alone = [values(image, p=(one,), radii=(r,)) for one, r in zip(p, (2, 5, 16), strict=True)]
    together = values(image, p=p, radii=(2, 5, 16))
    np.testing.assert_allclose(together, np.mean(alone, axis=0), atol=1e-6)
