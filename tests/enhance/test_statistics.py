from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from enhance import EnhanceParams, ImageError, Statistics, enhance, measure
from enhance.changed import changed
from tests.enhance.pictures import vessels

CLIP = [vessels(30, 44, seed=1), vessels(30, 44, seed=2) // 2, vessels(50, 20, seed=3)]
FULL = EnhanceParams(subsample=1)


def close(one: Statistics, other: Statistics) -> bool:
    numbers = np.array([one.level, one.z, one.saturation_mean, *one.sigmas, *one.p])
    return bool(np.allclose(numbers, [other.level, other.z, other.saturation_mean, *other.sigmas, *other.p]))


def test_clip_of_one_image_has_that_images_statistics() -> None:
    of_clip = measure([CLIP[0]])
    assert replace(of_clip, scope="image") == enhance(CLIP[0]).statistics
    assert of_clip.scope == "clip"


def test_repeating_a_clip_and_its_order_change_nothing() -> None:
    assert close(measure(CLIP), measure(CLIP[::-1] * 2))


def test_pooling_counts_pixels_not_images() -> None:
    params = EnhanceParams(radii=(3,), subsample=1, p=1.0)
    pooled = measure(CLIP, params, pixels="all")
    values = np.concatenate([image.max(axis=2).ravel() for image in CLIP])
    chroma = np.concatenate(
        [((i.max(axis=2) - i.min(axis=2, initial=255)) / np.maximum(i.max(axis=2), 1)).ravel() for i in CLIP]
    )
    assert pooled.level == np.sort(values)[-(-len(values) // 10) - 1]
    assert pooled.saturation_mean == pytest.approx(chroma.mean(), rel=1e-6)


def test_pooled_sigma_includes_the_spread_between_images() -> None:
    dark, bright = (np.full((8, 8), level, np.uint8) for level in (40, 120))
    pooled = measure([dark, bright], FULL)
    np.testing.assert_allclose(pooled.sigmas, 40, rtol=1e-5)
    np.testing.assert_allclose(enhance(dark, FULL).statistics.sigmas, 0, atol=1e-4)


def test_clip_statistics_give_a_colour_the_same_result_in_every_frame() -> None:
    params = EnhanceParams(radii=(1,), p=0.0)
    pooled = measure(CLIP, params)
    first, other = CLIP[0].copy(), np.zeros_like(CLIP[0])
    other[:, :5] = first[:, :5]
    fixed = [enhance(image, params, statistics=pooled) for image in (first, other)]
    assert np.array_equal(fixed[0].image[:, :5], fixed[1].image[:, :5])
    assert fixed[0].statistics == fixed[1].statistics == pooled
    own = [enhance(image, params).image for image in (first, other)]
    assert not np.array_equal(own[0][:, :5], own[1][:, :5])


def test_what_the_user_sets_wins_over_what_was_measured() -> None:
    measured = measure(CLIP)
    params = EnhanceParams(z=0.25, p=(0.5, 1.0, 1.5))
    used = enhance(CLIP[0], params, statistics=measured).statistics
    assert (used.z, used.p) == (0.25, (0.5, 1.0, 1.5))
    assert replace(used, z=measured.z, p=measured.p) == measured
    assert measure(CLIP, EnhanceParams(p=1.25)).p == (1.25, 1.25, 1.25)


def test_statistics_of_other_scales_are_refused() -> None:
    with pytest.raises(ImageError, match=r"2 scales.*got 3"):
        enhance(CLIP[0], EnhanceParams(radii=(4, 16)), statistics=measure(CLIP))


def test_masks_choose_the_pixels() -> None:
    mask = np.zeros((30, 44), bool)
    mask[5:20, 10:30] = True
    cut = np.ascontiguousarray(CLIP[0][5:20, 10:30])
    masked = enhance(CLIP[0], tissue_mask=mask).statistics
    alone = enhance(cut).statistics
    assert masked.level == alone.level
    assert masked.saturation_mean == pytest.approx(alone.saturation_mean)
    assert masked == enhance(CLIP[0], tissue_mask=mask.astype(np.uint8) * 255).statistics
    none = np.zeros((30, 44), bool)
    assert close(measure(CLIP[:2], tissue_masks=[mask, none]), measure(CLIP[:1], tissue_masks=[mask]))


@pytest.mark.parametrize(
    ("images", "masks", "says"),
    [
        ([], None, "at least one image"),
        (CLIP, [None, None], "as many tissue_masks as images"),
        (CLIP[:1], [None, None], "as many tissue_masks as images"),
        ([CLIP[0], CLIP[1] / 100], None, "image 1 of the clip: .*float values"),
        (CLIP[:2], [None, np.ones((2, 2), bool)], "image 1 of the clip: .*tissue_mask"),
        (CLIP[:1], [np.zeros((30, 44), bool)], "at least one pixel"),
    ],
)
def test_bad_clips_are_refused_with_a_reason(
    images: list[NDArray[Any]], masks: list[NDArray[Any] | None] | None, says: str
) -> None:
    with pytest.raises(ImageError, match=says):
        measure(images, tissue_masks=masks)


def test_errors_of_the_reader_pass_untouched() -> None:
    def broken() -> Iterator[NDArray[Any]]:
        yield CLIP[0]
        raise ValueError("frame 1 is missing")

    with pytest.raises(ValueError, match=r"^frame 1 is missing$"):
        measure(broken(), tissue_masks=[None, None])


@pytest.mark.parametrize("wrong", [{"level": np.nan}, {"saturation_mean": np.inf}, {"sigmas": (1.0, np.nan)}])
def test_what_is_no_measurement_is_refused(wrong: dict[str, Any]) -> None:
    with pytest.raises(ImageError, match="expected statistics of finite numbers, got"):
        replace(measure(CLIP[:1]), **wrong)


def test_a_changed_value_is_as_one_that_was_made_anew() -> None:
    before = measure([vessels(48, 64)])
    now = changed(before, sigmas=(1.0, 2.0, 3.0), color=0.25)
    assert now == replace(before, sigmas=(1.0, 2.0, 3.0), color=0.25)
    assert now.__dict__ == replace(before, sigmas=(1.0, 2.0, 3.0), color=0.25).__dict__
    assert before.color != 0.25
