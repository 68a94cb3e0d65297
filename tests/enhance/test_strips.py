"""What is measured a few rows at a time is what is measured of the whole image."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from enhance import strips
from enhance.metrics import dvbv_local, dvbv_otsu
from enhance.noise import chroma_noise_gain, noise_gain
from tests.enhance.pictures import vessels


def test_strips_are_all_rows_once_with_those_beside() -> None:
    found = list(strips.strips((2000, 500), beside=3))
    assert [row for strip in found for row in range(2000)[strip.own]] == list(range(2000))
    assert len(found) > 2
    for strip in found:
        own, rows = range(2000)[strip.own], range(2000)[strip.rows]
        assert rows[strip.inner] == own
        assert (rows.start, rows.stop) == (max(own.start - 3, 0), min(own.stop + 3, 2000))


@pytest.mark.parametrize("measure", [dvbv_local, dvbv_otsu, noise_gain, chroma_noise_gain])
@pytest.mark.parametrize("pixels", [1, 3000])
def test_measures_do_not_depend_on_the_strips(
    measure: Callable[..., object], pixels: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    original = vessels()
    image = np.clip(1.4 * original.astype(np.float64) - 20, 0, 255).astype(np.uint8)
    given = (image,) if measure is dvbv_otsu else (image, original)
    monkeypatch.setattr(strips, "PIXELS", image.size)
    whole = measure(*given)
    monkeypatch.setattr(strips, "PIXELS", pixels)
    if measure is dvbv_local:
        # Sums that run from row to row are rounded on their way.
        np.testing.assert_allclose(list(vars(measure(*given)).values()), list(vars(whole).values()), 1e-9)
    else:
        assert measure(*given) == whole
