"""Curves, histograms and measures of what is on screen; scales added and removed."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from app.enhancement.frame_enhancer import PictureMaker, PictureRequest, Pictures
from app.enhancement.measures import METRICS
from app.gui.actions import enhancement_actions
from app.gui.panels.enhancement_measured import misleads
from app.gui.panels.tuning import SORT_LABELS
from app.gui.state import scales
from app.gui.state.app_state import AppState
from app.gui.update.channels import Channels
from app.gui.update.update import update
from app.gui.update.wishes import REST
from app.gui.work.measuring import BINS, Measurer, curves, spread
from enhance import EnhanceParams, enhance
from enhance.metrics import dvbv_otsu, saturated_share
from enhance.vessel import VesselParams
from renderer.clip import Clip
from tests.app.gui.settling import served


def made(clip: Clip, params: EnhanceParams | VesselParams) -> Pictures:
    return list(PictureMaker().make(PictureRequest(clip, 1, params)))[-1]


def test_the_measures_are_the_library_s(clip: Clip) -> None:
    pictures = made(clip, EnhanceParams(z=0.2))
    (seen,) = Measurer().measure(pictures)
    assert pictures.enhanced is not None
    assert seen.pictures is pictures
    assert seen.after.dv == dvbv_otsu(pictures.enhanced).dv
    assert seen.before.bv == dvbv_otsu(pictures.original).bv
    assert seen.after.saturated_share == saturated_share(pictures.enhanced)
    assert seen.before.noise_gain == pytest.approx(1.0) or math.isnan(seen.before.noise_gain)


def test_a_histogram_counts_every_pixel_once() -> None:
    picture = np.zeros((10, 10, 3), np.uint8)
    picture[:5] = (255, 255, 255)
    picture[5, 0] = (128, 0, 0)
    shares = spread(picture)
    assert shares.value.shape == (BINS,)
    np.testing.assert_allclose(shares.value[[0, 32, 63]], [49 / 50, 1 / 50, 1])
    assert shares.saturation[63] == pytest.approx(1 / 99)


@pytest.mark.parametrize("params", [EnhanceParams(z=0.3, d_factor=0.5), EnhanceParams(), VesselParams()])
def test_curves_keep_their_ends_and_rise(clip: Clip, params: EnhanceParams | VesselParams) -> None:
    used = made(clip, params).statistics
    assert used is not None
    drawn = curves(params, used)
    for values in (drawn.value, drawn.saturation):
        assert (np.diff(values) >= 0).all()
        assert values[-1] == pytest.approx(1.0, abs=1e-6)
    assert drawn.saturation[0] == 0


def test_the_v_curve_is_what_happens_to_a_grey_picture_without_detail(clip: Clip) -> None:
    """Oracle: the library on one flat grey level after the other."""
    params = EnhanceParams(z=0.3, p=0.0, keep_black=False, d_factor=0.0)
    used = made(clip, params).statistics
    assert used is not None
    drawn = curves(params, used)
    for place in (8, 30, 60):
        level = round(255 * float(drawn.given[place]))
        result = np.asarray(enhance(np.full((16, 16, 3), level, np.uint8), params).image)
        assert abs(int(result[8, 8, 0]) - 255 * drawn.value[place]) <= 2.0


def test_measuring_waits_for_the_hand_and_never_twice(state: AppState) -> None:
    channels = Channels()
    state.enhancement.scope = "image"

    def settle(now: float) -> None:
        for _ in range(4):
            update(state, channels, now)
            for channel in (*served(channels), *channels.of("third")):
                while channel.run_waiting():
                    pass

    settle(0.0)
    assert state.picture.measured is None
    settle(REST + 0.01)
    first = state.picture.measured
    assert first is not None
    assert first.pictures is state.picture.pictures
    settle(2.0)
    assert state.picture.measured is first
    enhancement_actions.set_params(state, EnhanceParams(z=0.1))
    settle(2.1)
    assert state.picture.measured is first  # Of the setting before: shown grey.
    settle(2.1 + REST + 0.01)
    assert state.picture.measured is not None
    assert state.picture.measured.pictures is state.picture.pictures


def test_what_was_left_out_comes_with_the_picture(clip: Clip) -> None:
    pictures = made(clip, EnhanceParams(z=1.0, omit_below=1.0))
    assert any(omission.what == "brightness" for omission in pictures.omitted)


def test_scales_come_and_go_with_their_exponents() -> None:
    params = EnhanceParams(p=(0.5, 1.0, 1.5))
    more = scales.with_scale(params)
    assert more.radii == (4, 16, 64, 128)
    assert more.p == (0.5, 1.0, 1.5, 1.5)
    assert scales.without_scale(more, 0).p == (1.0, 1.5, 1.5)
    while more.radii != (more := scales.with_scale(more)).radii:
        pass
    assert len(more.radii) == scales.MOST_SCALES
    while len(more.radii) > 1:
        more = scales.without_scale(more, 0)
    assert scales.without_scale(more, 0) == more
    assert scales.together(params).p == 1.0


def test_one_exponent_moved_leaves_the_automatic_others_where_they_were() -> None:
    params = scales.with_exponent(EnhanceParams(), 1, 2.0, (0.5, 0.5, 0.6))
    assert params.p == (0.5, 2.0, 0.6)
    assert scales.exponents(EnhanceParams(p=0.7), ()) == (0.7, 0.7, 0.7)
    assert scales.exponents(EnhanceParams(), (0.5,)) == (0.5, 0.5, 0.5)


def test_a_rise_of_dv_bv_while_contrast_falls_is_called_misleading(clip: Clip) -> None:
    (answer,) = Measurer().measure(made(clip, EnhanceParams()))
    before = replace(answer.before, dv_bv=2.0, vessel_contrast=0.3)
    risen, fainter = replace(before, dv_bv=9 * before.dv_bv), {"vessel_contrast": before.vessel_contrast / 2}
    assert misleads(before, replace(risen, **fainter))
    assert not misleads(before, risen)
    assert not misleads(before, replace(before, **fainter))


def test_every_measure_can_be_sorted_by_and_the_paper_s_come_last() -> None:
    assert {"", *METRICS} == SORT_LABELS.keys()
    assert [*SORT_LABELS][-3:] == ["dv_bv", "dv", "bv"]
