"""What the first page's images are cut around."""

from __future__ import annotations

import numpy as np
import pytest

from app.gui.style import theme
from tests.benchmarks.guide_images import cut_around, end_of_label


def test_the_label_of_a_distance_lies_within_what_is_cut() -> None:
    view, colour = np.full((100, 400, 3), 90, np.uint8), theme.TAG_CAUTION
    label = [round(255 * value) for value in (colour.z, colour.y, colour.x)]
    view[2:14, :150] = label  # What the tool is, in the corner.
    view[44:58, 240:351] = label
    assert end_of_label(view) == 351
    start = cut_around(180, 351, 200)
    assert (180 - start, start + 200 - 351) == (14, 15)
    assert cut_around(10, 60, 200) == 0
    with pytest.raises(AssertionError, match="at most 200 columns, got 210"):
        cut_around(100, 310, 200)
