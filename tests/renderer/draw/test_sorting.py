"""Depth order against numpy's own stable sort."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from renderer.draw.sorting import DepthKeys, depth_order

depths = arrays(
    np.float32,
    st.integers(0, 60),
    elements=st.floats(2.0**-120, 2.0**120, width=32) | st.sampled_from([1.0, 2.0]),
)


@given(depths)
def test_float_keys_sort_exactly_and_stably(values: np.ndarray) -> None:
    assert depth_order(values, "float32").tolist() == np.argsort(values, kind="stable").tolist()


@given(depths)
def test_level_keys_sort_to_within_one_level_of_the_range(values: np.ndarray) -> None:
    order = depth_order(values.astype(np.float64), 16)
    assert sorted(order.tolist()) == list(range(len(values)))
    if len(values):
        level = (float(values.max()) - float(values.min())) / 65535
        assert np.diff(values[order].astype(np.float64)).min(initial=0) >= -level * 1.001


@pytest.mark.parametrize("keys", [16, "float32"])
def test_equal_depths_keep_their_order(keys: DepthKeys) -> None:
    assert depth_order(np.full(300, 7.5), keys).tolist() == list(range(300))


@pytest.mark.parametrize("keys", [16, "float32"])
def test_the_nearest_comes_first(keys: DepthKeys) -> None:
    order = depth_order(np.array([30.0, 10.0, 20.0]), keys)
    assert order.tolist() == [1, 2, 0]
    assert order.dtype == np.uint32


def test_an_outlier_coarsens_level_keys_only() -> None:
    values = np.array([2.0, 1.0, 1e6])
    assert depth_order(values, 16).tolist() == [0, 1, 2]
    assert depth_order(values, "float32").tolist() == [1, 0, 2]
