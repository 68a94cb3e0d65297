from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from app.enhancement.frame_enhancer import PictureMaker, PictureRequest, Pictures
from enhance import EnhanceParams, Statistics, enhance
from renderer.clip import ByteImage, Clip, Frame
from tests.app.gui.conftest import make_clip
from tests.enhance.test_surround import round_view


@pytest.fixture
def clip(tmp_path: Path) -> Clip:
    return make_clip(tmp_path / "clip")


def statistics(pictures: Pictures) -> Statistics:
    assert pictures.statistics is not None
    return pictures.statistics


def last(request: PictureRequest) -> Pictures:
    return list(PictureMaker().make(request))[-1]


def test_the_enhanced_picture_is_the_library_s_own(clip: Clip) -> None:
    request = PictureRequest(clip, 1, EnhanceParams(z=0.3))
    first, whole = PictureMaker().make(request)
    assert first.enhanced is None
    expected = enhance(clip.read_image(1), EnhanceParams(z=0.3))
    np.testing.assert_array_equal(whole.enhanced, expected.image)
    assert whole.statistics == expected.statistics


def test_white_light_is_the_frame_alone(clip: Clip) -> None:
    (only,) = PictureMaker().make(PictureRequest(clip, 1, None))
    np.testing.assert_array_equal(only.original, clip.read_image(1))


def test_pooled_statistics_are_measured_once_for_all_sliders(clip: Clip) -> None:
    read: list[int] = []

    def counted(index: int) -> ByteImage:
        read.append(index)
        return clip.read_image(index)

    counting = replace(clip, read_image=counted)
    maker = PictureMaker()
    request = PictureRequest(counting, 0, EnhanceParams(), "clip")
    list(maker.make(request))
    first = len(read)
    list(maker.make(replace(request, frame_index=3, params=EnhanceParams(z=0.1, p=1.0, d_factor=0.5))))
    assert len(read) == first + 1
    list(maker.make(replace(request, params=EnhanceParams(radii=(2, 8)))))
    assert len(read) > first + 2


def test_tools_and_surround_do_not_count_when_tissue_alone_shall(clip: Clip) -> None:
    image, circle = round_view()

    def frame(index: int) -> Frame:
        every = np.ones(circle.shape, dtype=bool)
        return Frame(index, 0.0, image, clip.cameras[0].fitted(*every.shape[::-1]), every, every)  # type: ignore[call-arg]

    scope = replace(clip, read_frame=frame, read_image=lambda index: image)
    request = PictureRequest(scope, 0, EnhanceParams(), pixels="all")
    everything, tissue = last(request), last(replace(request, pixels="tissue"))
    assert statistics(everything).z == 0.0
    assert statistics(tissue).z > statistics(everything).z
    pooled = last(replace(request, pixels="tissue", scope="clip"))
    assert statistics(pooled).saturation_mean == pytest.approx(statistics(tissue).saturation_mean)


def test_a_black_frame_is_still_a_picture(clip: Clip) -> None:
    black = np.zeros((40, 48, 3), np.uint8)

    def frame(index: int) -> Frame:
        return replace(clip.read_frame(index), image=black)

    dark = replace(clip, read_frame=frame)
    whole = last(PictureRequest(dark, 0, EnhanceParams(), pixels="tissue"))
    np.testing.assert_array_equal(whole.enhanced, black)


def test_statistics_of_other_windows_do_not_go_along(clip: Clip) -> None:
    request = PictureRequest(clip, 0, EnhanceParams(), scope="clip", of_clip="own")
    assert request.with_params(EnhanceParams(z=0.1)).of_clip == "own"
    for other in (EnhanceParams(radii=(2,)), EnhanceParams(eps=0.1), EnhanceParams(subsample=4)):
        assert request.with_params(other).of_clip is None
