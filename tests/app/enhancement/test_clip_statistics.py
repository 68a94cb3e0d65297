"""The statistics of a clip: of which clips, measured step by step, and what stands for them until then."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from app.enhancement.clip_statistics import ClipMeasurer, ClipStatistics, StatisticsRequest, measured
from app.enhancement.enhance_files import Setting, enhance_into
from app.enhancement.frame_enhancer import PictureMaker, PictureRequest
from app.enhancement.recording import is_recording
from app.enhancement.settable import Scope
from app.errors import UserError
from app.files.image_files import read_image, write_image
from app.files.image_series import open_series
from enhance import EnhanceParams, Pool, enhance, measure
from enhance.vessel import VesselParams
from renderer.clip import ByteImage, Clip
from renderer.sources import open_clip
from tests.app.gui.conftest import make_clip
from tests.enhance.pictures import vessels

WINDOWS = EnhanceParams()


@pytest.fixture
def clip(tmp_path: Path) -> Clip:
    return make_clip(tmp_path / "clip")


def moved(index: int) -> ByteImage:
    """The same vessels, three pixels further on each time, in light that grows."""
    image = np.roll(vessels(120, 160), 3 * index, axis=1)
    return np.clip(image.astype(np.float32) * (0.6 + 0.05 * index), 0, 255).astype(np.uint8)


def unlike(index: int) -> ByteImage:
    """Another subject each time."""
    rng = np.random.default_rng(index)
    return rng.integers(20, 200, (15, 20, 3), dtype=np.uint8).repeat(8, axis=0).repeat(8, axis=1)


def images(clip: Clip, read: object) -> Clip:
    return replace(clip, format="images", read_image=read)


def test_neighbours_that_look_alike_are_a_recording() -> None:
    assert is_recording(8, moved)
    assert is_recording(8, lambda index: moved(index)[..., 0])
    assert is_recording(8, lambda index: moved(index).astype(np.uint16) * 257)
    assert not is_recording(8, unlike)
    assert not is_recording(1, moved)
    assert not is_recording(4, lambda index: moved(index)[: 60 + index])


def test_flat_images_are_alike_where_they_are_equal() -> None:
    assert is_recording(4, lambda index: np.zeros((40, 50, 3), np.uint8))
    assert not is_recording(4, lambda index: np.zeros((40, 50), np.uint8) if index % 2 else moved(0))


@pytest.mark.parametrize(("read", "pools"), [(moved, True), (unlike, False)])
def test_automatic_pools_a_folder_of_frames_and_no_other(clip: Clip, read: object, pools: bool) -> None:
    request = StatisticsRequest(images(clip, read), "automatic", WINDOWS, "automatic")
    assert (measured(request) is not None) == pools
    assert measured(replace(request, scope="clip")) is not None
    assert measured(replace(request, scope="image")) is None


@pytest.mark.parametrize("scope", ["automatic", "clip", "image"])
def test_the_command_gives_what_the_window_shows(tmp_path: Path, scope: Scope) -> None:
    """Of a light that fades, so that other frames would give other statistics."""
    folder, params = tmp_path / "in", EnhanceParams(d_factor=0.5)
    folder.mkdir()
    for index in range(18):
        faded = (vessels(64, 80) * (1 - 0.045 * index)).astype(np.uint8)
        write_image(folder / f"{index:02d}.png", faded, {})
    steps = enhance_into(tmp_path / "out", open_series(folder), Setting("paper", params, scope))
    list(steps)
    clip, maker = open_clip(folder), PictureMaker()
    for index in range(18):
        *_, shown = maker.make(PictureRequest(clip, index, params, scope, "automatic"))
        np.testing.assert_array_equal(read_image(tmp_path / f"out/{index:02d}.png"), shown.enhanced)


def test_the_command_gives_what_the_window_shows_of_tissue_alone(tmp_path: Path) -> None:
    """`vessel`, which takes its noise from each image whatever the statistics, in a wide dark surround."""
    folder, params = tmp_path / "in", VesselParams()
    folder.mkdir()
    framed = cv2.copyMakeBorder(vessels(120, 160), 60, 60, 80, 80, cv2.BORDER_CONSTANT)
    for index in range(2):
        write_image(folder / f"{index}.png", framed, {})
    list(enhance_into(tmp_path / "out", open_series(folder), Setting("vessel", params, "clip", "tissue")))
    *_, shown = PictureMaker().make(PictureRequest(open_clip(folder), 1, params, "clip", "tissue"))
    np.testing.assert_array_equal(read_image(tmp_path / "out/1.png"), shown.enhanced)


def test_a_folder_of_which_nothing_is_visible_is_named(tmp_path: Path) -> None:
    for index in range(2):
        write_image(tmp_path / f"{index}.png", np.zeros((20, 30, 4), np.uint8), {})
    with pytest.raises(UserError, match=f"hides all: {re.escape(str(tmp_path))}$"):
        list(enhance_into(tmp_path / "out", open_series(tmp_path), Setting("paper", EnhanceParams(), "clip")))


def test_a_clip_of_a_known_layout_is_pooled_without_a_look(clip: Clip) -> None:
    known = replace(clip, format="endonerf", read_image=unlike)
    request = StatisticsRequest(known, "automatic", WINDOWS, "all")
    count = len(clip)
    assert measured(request) == measure(map(unlike, range(count)), pixels="all")
    alone = replace(known, cameras=clip.cameras[:1])
    assert measured(replace(request, clip=alone)) is None


def test_measuring_that_was_given_up_goes_on_where_it_was(clip: Clip) -> None:
    read: list[int] = []

    def counted(index: int) -> ByteImage:
        read.append(index)
        return moved(index)

    request = StatisticsRequest(replace(clip, read_image=counted), "clip", WINDOWS, "automatic")
    measurer = ClipMeasurer()
    steps = measurer.measure(request)
    assert [next(steps) for _ in range(3)] == [None] * 3
    steps.close()  # type: ignore[attr-defined]
    *others, last = measurer.measure(request)
    assert isinstance(last, ClipStatistics)
    assert others == [None] * (len(clip) - 3)
    assert read == list(range(len(clip)))
    assert last.statistics == measure(map(moved, range(len(clip))))


def test_a_pool_is_what_is_measured_at_once() -> None:
    pool = Pool()
    for index in range(5):
        pool.add(moved(index))
        assert pool.statistics() == measure(map(moved, range(index + 1)))


def test_until_they_are_known_the_first_frame_s_stand_for_them(clip: Clip) -> None:
    maker = PictureMaker()
    request = PictureRequest(
        replace(clip, read_image=moved), 2, EnhanceParams(), "automatic", of_clip="later"
    )
    first = measure([moved(2)])
    for index, params in ((2, EnhanceParams()), (5, EnhanceParams()), (3, EnhanceParams(d_factor=0.3))):
        *_, made = maker.make(replace(request, frame_index=index, params=params))
        np.testing.assert_array_equal(made.enhanced, enhance(moved(index), params, statistics=first).image)
    *_, known = maker.make(replace(request, of_clip=measure(map(moved, range(6)))))
    assert known.statistics is not None
    assert known.statistics.saturation_mean != first.saturation_mean
    *_, own = maker.make(replace(request, frame_index=4, of_clip="own"))
    np.testing.assert_array_equal(own.enhanced, enhance(moved(4)).image)
