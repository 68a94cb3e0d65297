"""A live stream's statistics: steady through a flash, anew after a cut."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from numpy.typing import NDArray

from enhance import EnhanceParams, Enhancer, LiveStatistics, VesselEnhancer, enhance, enhance_vessels
from tests.enhance.pictures import vessels

DARK, BRIGHT = vessels(60, 80) // 3, vessels(60, 80)


def levels(enhancer: Enhancer | VesselEnhancer, images: list[NDArray[np.uint8]]) -> list[float]:
    """L as used for each image."""
    found = []
    for image in images:
        enhancer.show(image)
        found.append(enhancer.enhance().statistics.level)
    return found


@pytest.mark.parametrize("kind", [Enhancer, VesselEnhancer])
def test_the_second_image_of_another_scene_begins_anew(kind: type[Enhancer | VesselEnhancer]) -> None:
    alone = levels(kind(), [DARK, BRIGHT])
    live = levels(kind(LiveStatistics()), [DARK] * 3 + [BRIGHT] * 2)
    assert live[:3] == [alone[0]] * 3
    assert alone[0] < live[3] < alone[0] + 0.1 * (alone[1] - alone[0])
    assert live[4] == alone[1]


@pytest.mark.parametrize("kind", [Enhancer, VesselEnhancer])
def test_a_flash_hardly_moves_a_stream(kind: type[Enhancer | VesselEnhancer]) -> None:
    alone = levels(kind(), [DARK, BRIGHT])
    live = levels(kind(LiveStatistics()), [DARK] * 3 + [BRIGHT] + [DARK] * 3)
    assert max(live) < alone[0] + 0.1 * (alone[1] - alone[0])
    assert live[-1] < live[3]


def test_a_scene_that_changes_slowly_is_one_scene() -> None:
    """No step of the light is a cut: the statistics lag behind it."""
    fading = [np.rint(BRIGHT * share).astype(np.uint8) for share in np.linspace(1 / 3, 1, 20)]
    live = levels(Enhancer(LiveStatistics()), fading)
    last = enhance(fading[-1]).statistics.level
    assert live[-1] < 0.9 * last
    assert all(later >= earlier for earlier, later in pairwise(live))


def test_vessel_is_smoothed_in_its_picture_too() -> None:
    """The tone follows the smoothed level, not that of the image alone."""
    enhancer = VesselEnhancer(LiveStatistics())
    enhancer.show(DARK)
    enhancer.enhance()
    enhancer.show(np.rint(DARK * 1.2).astype(np.uint8))
    live = enhancer.enhance()
    assert np.array_equal(
        live.image, enhance_vessels(np.rint(DARK * 1.2).astype(np.uint8), statistics=live.statistics).image
    )
    assert live.statistics.scope == "live"


def test_a_cut_of_zero_is_refused() -> None:
    with pytest.raises(ValueError, match="cut"):
        LiveStatistics(cut=0)


def test_a_set_p_is_smoothed_as_well() -> None:
    enhancer = Enhancer(LiveStatistics())
    enhancer.show(DARK)
    first = enhancer.enhance(EnhanceParams(p=0.5)).statistics.level
    enhancer.show(np.rint(DARK * 1.2).astype(np.uint8))
    second = enhancer.enhance(EnhanceParams(p=0.5)).statistics.level
    assert first < second < first * 1.1
