"""What files hold of the settings of two methods, and what a live stream keeps of both."""

from __future__ import annotations

from dataclasses import asdict

import numpy as np
import pytest
from pydantic import TypeAdapter

from app.enhancement.methods import EnhancementSettings, MethodEnhancer, RecordedSettings
from enhance import EnhanceParams, LiveStatistics, VesselParams


@pytest.mark.parametrize(
    ("told", "kind"),
    [
        ({}, EnhanceParams),
        ({"d_factor": 0.5}, EnhanceParams),
        ({"strength": 0.5, "z": None}, EnhanceParams),
        ({"strength": 3.0}, VesselParams),
        ({"strength": 3.0, "d_factor": 0.5}, VesselParams),
        ({"lift": 0.2}, VesselParams),
    ],
)
def test_what_a_file_holds_says_of_which_method_it_is(told: dict[str, object], kind: type[object]) -> None:
    assert isinstance(TypeAdapter(RecordedSettings).validate_python(told), kind)


def test_records_of_before_are_enhanced_as_they_were() -> None:
    """Underexposed images were left dark until 0.9.0, vessels reddened in all until 0.10.0, coarse noise of
    colour left until 0.13.0, and grey darkened like vessels until 0.14.0; a record since says how much."""
    read = TypeAdapter(RecordedSettings).validate_python
    now = asdict(VesselParams(lift=0.3))
    ways = ("most_exposure", 1.0), ("least_redness", 0.0), ("color_smoothing", 0.0), ("spare_grey", 0.0)
    for since, off in ways:
        before = {name: value for name, value in now.items() if name != since}
        assert read(before) == VesselParams(lift=0.3, **{since: off})
    assert read(now) == read(VesselParams(lift=0.3)) == VesselParams(lift=0.3)
    assert read(now | {"spare_grey": 1.0}) == VesselParams(lift=0.3, spare_grey=1.0)


@pytest.mark.parametrize(
    ("look", "other"), [(EnhanceParams(), VesselParams()), (VesselParams(), EnhanceParams())]
)
def test_a_method_that_is_taken_up_again_knows_nothing_of_a_scene_long_gone(
    look: EnhancementSettings, other: EnhancementSettings
) -> None:
    """The scene gets lighter so slowly that no cut is seen, while the other method is in use."""
    enhancer, alone = MethodEnhancer(LiveStatistics()), MethodEnhancer()
    noise = np.random.default_rng(0).normal(0, 8, (60, 80, 3))

    def enhanced(by: MethodEnhancer, level: float, with_look: EnhancementSettings) -> np.ndarray:
        by.show(np.clip(level + noise, 0, 255).astype(np.uint8))
        return by.enhance(with_look).image

    for _ in range(5):
        first = enhanced(enhancer, 60, look)
    for level in np.linspace(60, 82, 40):
        enhanced(enhancer, level, other)
    np.testing.assert_array_equal(enhanced(enhancer, 82, look), enhanced(alone, 82, look))
    # While it stays in use, and where it is used beside the other, it is smoothed.
    assert not np.array_equal(enhanced(enhancer, 60, look), first)
