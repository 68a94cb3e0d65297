"""Scale and shift are exact without noise, blind to a minority, and the minimum of Huber's loss."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from renderer.depth.alignment import aligned

EVERYWHERE = np.ones((30, 40), dtype=bool)


def inverse_depth(seed: int = 0) -> np.ndarray:
    return np.random.default_rng(seed).uniform(0.01, 0.03, (30, 40))


@given(
    scale=st.floats(1e-3, 1e3),
    sign=st.sampled_from([-1, 1]),
    shift=st.floats(-10, 10),
)
def test_a_line_is_found_exactly(scale, sign, shift):
    prior = inverse_depth()
    found = aligned(prior, sign * scale * prior + shift, EVERYWHERE)
    assert found[0] == pytest.approx(sign * scale, rel=1e-6, abs=1e-10 * (1 + abs(shift)))
    assert found[1] == pytest.approx(shift, rel=1e-6, abs=1e-9 * (1 + scale))


@pytest.mark.parametrize("share", [0.05, 0.2, 0.3])
def test_a_minority_that_disagrees_hardly_counts(share):
    """Least squares is off by many times as much."""
    rng = np.random.default_rng(1)
    prior = inverse_depth()
    known = 2.5 * prior + 0.01 + rng.normal(0, 1e-4, prior.shape)
    wrong = rng.uniform(size=prior.shape) < share
    known[wrong] += rng.uniform(0.02, 0.1, wrong.sum())
    scale, shift = aligned(prior, known, EVERYWHERE)
    plain_scale, plain_shift = np.polyfit(prior.ravel(), known.ravel(), 1)
    error = np.abs(scale * prior + shift - 2.5 * prior - 0.01).max()
    plain_error = np.abs(plain_scale * prior + plain_shift - 2.5 * prior - 0.01).max()
    assert error < 6e-4
    assert error < plain_error / 5


def test_the_result_is_stationary():
    """Huber's bounded residuals sum to zero, alone and against the prior."""
    rng = np.random.default_rng(2)
    prior = inverse_depth()
    known = 1.7 * prior - 0.002 + 1e-3 * rng.standard_t(2, prior.shape)
    scale, shift = aligned(prior, known, EVERYWHERE)
    residuals = known - scale * prior - shift
    threshold = 1.345 * 1.4826 * np.median(np.abs(residuals))
    bounded = np.clip(residuals, -threshold, threshold) / threshold
    away = (prior - prior.mean()) / prior.std()
    assert 0.05 < (np.abs(bounded) == 1).mean() < 0.5
    assert abs(bounded.mean()) < 1e-6
    assert abs((bounded * away).mean()) < 1e-6


def test_it_follows_a_change_of_units():
    rng = np.random.default_rng(3)
    prior = inverse_depth()
    known = 1.7 * prior - 0.002 + 1e-3 * rng.standard_t(2, prior.shape)
    scale, shift = aligned(prior, known, EVERYWHERE)
    other_scale, other_shift = aligned(4 * prior + 7, 1000 * known + 3, EVERYWHERE)
    assert other_scale == pytest.approx(250 * scale, rel=1e-6)
    assert other_shift == pytest.approx(1000 * shift + 3 - 7 * other_scale, rel=1e-6)


def test_only_the_mask_counts():
    prior = inverse_depth()
    known = 3 * prior + 1
    mask = EVERYWHERE.copy()
    mask[:, :30] = False
    known[~mask] = np.nan
    assert aligned(prior, known, mask) == pytest.approx((3, 1))


@pytest.mark.parametrize("kind", [np.float32, np.float64])
def test_a_constant_prior_has_no_scale(kind):
    known = inverse_depth().astype(kind)
    scale, shift = aligned(np.full((30, 40), 0.3, kind), known, EVERYWHERE)
    assert scale == 0
    assert shift == pytest.approx(np.mean(known), rel=1e-2)
    one = np.zeros((30, 40), dtype=bool)
    one[3, 4] = True
    assert aligned(known, known, one) == pytest.approx((0, known[3, 4]))


def test_what_cannot_be_aligned_is_refused():
    prior = inverse_depth()
    with pytest.raises(ValueError, match="got none"):
        aligned(prior, prior, ~EVERYWHERE)
    with pytest.raises(ValueError, match="finite"):
        aligned(np.full_like(prior, np.nan), prior, EVERYWHERE)
