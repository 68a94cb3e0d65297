from __future__ import annotations

import colorsys
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from enhance.saturation import Saturation, recolor, saturation, stretch

UNIT = st.floats(0.0, 1.0, width=32)
FACTORS = st.floats(0.0625, 4.0, width=32)


def of(chroma: float) -> Saturation:
    """One pixel; 1 - S is formed in double precision, as the image's min / max would."""
    return Saturation(
        chroma=np.array([[chroma]], dtype=np.float32), white=np.array([[1 - chroma]], dtype=np.float32)
    )


def exact(chroma: float, mean: float, d_factor: float) -> Fraction:
    """Eqs 11 and 12 as printed, in rational numbers."""
    s, m = Fraction(chroma), Fraction(mean)
    d = (3 * m**2 - 2 * m**3) / (2 * m**3 - 3 * m**2 + 1)
    return 1 / (1 + Fraction(d_factor) * d * (1 / s - 1) ** 2)


@given(st.floats(2**-20, 1.0, width=32), st.floats(0.0, 1.0, exclude_max=True), FACTORS)
@example(0.999, 0.99999, 1.0)
@example(0.5, 1 - 2**-40, 1.0)
@example(1e-4, 1e-6, 4.0)
def test_stretch_is_the_printed_equation_without_its_poles(chroma: float, mean: float, k: float) -> None:
    chroma = float(np.float32(chroma))
    result = float(stretch(of(chroma), mean, k)[0, 0])
    assert result == pytest.approx(float(exact(chroma, mean, k)), rel=1e-6, abs=1e-35)


@given(UNIT, UNIT)
def test_limits_are_fixed_points(chroma: float, mean: float) -> None:
    assert stretch(of(0.0), mean, 1.0)[0, 0] == 0
    assert stretch(of(1.0), mean, 1.0)[0, 0] == 1
    assert stretch(of(chroma), mean, 0.0)[0, 0] == np.float32(chroma)
    assert stretch(of(chroma), 1.0, 1.0)[0, 0] == (chroma == 1)
    assert chroma < 1e-15 or stretch(of(chroma), 0.0, 1.0)[0, 0] == 1


@given(st.floats(0.05, 0.9), FACTORS)
def test_pivot_stays_and_contrast_doubles_there(mean: float, k: float) -> None:
    kd = k * mean**2 * (3 - 2 * mean) / ((1 - mean) ** 2 * (1 + 2 * mean))
    pivot = kd / (1 + kd)
    step = 0.01 * pivot * (1 - pivot)
    low, middle, high = (float(stretch(of(s), mean, k)[0, 0]) for s in (pivot - step, pivot, pivot + step))
    assert middle == pytest.approx(pivot, rel=1e-5)
    assert (high - low) / (2 * step) == pytest.approx(2.0, rel=0.01)


def test_more_d_means_less_colour() -> None:
    results = [float(stretch(of(0.4), 0.5, k)[0, 0]) for k in (0.25, 0.5, 1.0, 2.0, 4.0)]
    assert results == sorted(results, reverse=True)
    assert results[0] > 0.4 > results[-1]


@given(UNIT, UNIT, UNIT, UNIT, UNIT)
def test_recolouring_is_hsv_with_the_old_hue(
    red: float, green: float, blue: float, new_v: float, new_s: float
) -> None:
    if max(red, green, blue) < 1e-30 or max(red, green, blue) - min(red, green, blue) < 1e-30:
        red, green, blue = 0.25, 0.5, 0.125
    colors = np.array([[[red, green, blue]]], dtype=np.float32)
    value = colors.max(axis=2)
    plane = np.ones((1, 1), dtype=np.float32)
    parts = saturation(colors, value)
    result = recolor(colors, value, parts, plane * np.float32(new_v), plane * np.float32(new_s))
    hue, chroma, _ = colorsys.rgb_to_hsv(red, green, blue)
    expected = colorsys.hsv_to_rgb(hue, new_s, new_v)
    assert float(parts.chroma[0, 0]) == pytest.approx(chroma, rel=1e-6)
    assert float(parts.white[0, 0]) == pytest.approx(min(red, green, blue) / max(red, green, blue), rel=1e-6)
    # The hue of nearly grey pixels is ill-conditioned in float32.
    np.testing.assert_allclose(result[0, 0], expected, atol=2e-7 + 2e-7 / max(chroma, 1e-7))


def test_grey_and_black_have_no_colour() -> None:
    colors = np.repeat(np.array([[0, 0.2, 1]], dtype=np.float32)[..., None], 3, axis=2)
    parts = saturation(colors, colors[..., 0])
    assert not parts.chroma.any()
    assert np.all(parts.white == 1)
    new_value = np.array([[0.1, 0.3, 0.9]], dtype=np.float32)
    for mean in (0.0, 0.4, 1.0):
        result = recolor(colors, colors[..., 0], parts, new_value, stretch(parts, mean, 1.0))
        assert np.array_equal(result, np.repeat(new_value[..., None], 3, axis=2))
