"""Still tissue flickers no more enhanced than as it came, by statistics of the clip or live."""

from __future__ import annotations

import numpy as np
import pytest

from enhance import Enhancer, LiveStatistics, VesselEnhancer, VesselParams, enhance_vessels, measure
from tests.benchmarks.flicker import Method, by_paper, by_vessel, flicker_gain, gains, live, still_scene
from tests.enhance.pictures import vessels

BAR = 1.1
SCENE = still_scene(vessels(240, 320))


@pytest.mark.parametrize("method", [by_paper, by_vessel])
def test_by_statistics_of_the_clip_still_tissue_stays_still(method: Method) -> None:
    own, clip = gains(SCENE, method, measure(SCENE))
    assert clip <= BAR
    assert own > clip


def test_contrast_takes_no_tool_that_comes_in_for_tissue() -> None:
    """Its median is that of each frame."""
    known, params = measure(SCENE), VesselParams(contrast=1)
    own = [np.asarray(enhance_vessels(frame, params, statistics=known).image) for frame in SCENE]
    assert flicker_gain(own, SCENE) <= BAR


@pytest.mark.parametrize("method", [Enhancer, VesselEnhancer])
def test_a_live_stream_stays_still(method: type[Enhancer] | type[VesselEnhancer]) -> None:
    assert flicker_gain(live(SCENE, method(LiveStatistics())), SCENE) <= BAR


def test_the_gain_is_that_of_the_steps() -> None:
    frames = [np.full((64, 64, 3), level, np.uint8) for level in (100, 103, 99)]
    doubled = [np.full((64, 64, 3), level, np.uint8) for level in (100, 106, 98)]
    assert flicker_gain(frames, frames) == 1
    assert flicker_gain(doubled, frames) == pytest.approx(2)
    assert flicker_gain([frames[0]] * 3, frames) == 0
