"""Pixels beside a tool that are in part of its colour teach nothing where other frames show the tissue."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from numpy.typing import NDArray

from renderer.camera import Camera
from renderer.clip import Clip, Frame
from renderer.rasterize.cpu import render
from renderer.train import outlines
from renderer.train.config import Part, TrainConfig
from renderer.train.frames import away_from_tools
from renderer.train.outlines import MIXED, are_tight, seen_apart, without_mixed
from tests.renderer.sheet import finished, moving_sheet

WIDTH, HEIGHT = 32, 24
CAMERA = Camera(40.0, 40.0, WIDTH / 2, HEIGHT / 2, WIDTH, HEIGHT)
STEEL = 128


def frame(tissue: NDArray[np.bool_]) -> Frame:
    return Frame(0, 0.0, np.zeros((*tissue.shape, 3), np.uint8), CAMERA, tissue, tissue)


def tool(first: int, last: int) -> NDArray[np.bool_]:
    """Tissue but for the columns from first to last."""
    tissue = np.ones((HEIGHT, WIDTH), bool)
    tissue[:, first : last + 1] = False
    return tissue


def test_distance_is_from_tools_and_not_from_the_border_of_the_image() -> None:
    away = away_from_tools(tool(0, 9))
    assert (away[:, :10] == 0).all()
    np.testing.assert_allclose(away[:, 10:], np.broadcast_to(np.arange(1, 23), (HEIGHT, 22)), rtol=0.02)
    assert away_from_tools(np.ones((HEIGHT, WIDTH), bool)).min() > MIXED


def test_tissue_beside_a_tool_is_left_out_where_another_frame_shows_it_apart() -> None:
    here, there = frame(tool(10, 14)), frame(tool(15, 19))
    apart = seen_apart([here, there])
    assert not apart[:, 13:17].any()  # Within two pixels of the tool, or behind it, in both.
    kept = without_mixed(here, apart).tissue_mask
    assert np.array_equal(kept[0], tool(8, 14)[0])
    assert np.array_equal(without_mixed(here, np.zeros_like(apart)).tissue_mask, here.tissue_mask)
    bare = frame(np.ones((HEIGHT, WIDTH), bool))
    assert without_mixed(bare, apart).tissue_mask.all()


@pytest.mark.parametrize(("margin", "tight"), [(0, True), (12, False)])
def test_a_mask_is_tight_where_color_steps_at_its_edge(margin: int, tight: bool) -> None:
    """Tissue of its own grain, and steel in the middle; a mask that reaches beyond it ends on tissue."""
    rng, shape = np.random.default_rng(0), (96, 128)
    camera = Camera(100.0, 100.0, 64, 48, 128, 96)
    image = rng.normal((180, 90, 80), 8, (*shape, 3)).clip(0, 255).astype(np.uint8)
    image[:, 54:74] = STEEL
    mask = np.ones(shape, bool)
    mask[:, 54 - margin : 74 + margin] = False
    frame = Frame(0, 0.0, image, camera, mask, mask)
    assert are_tight([frame]) == tight
    assert not list(outlines.told([frame], seen_apart([frame])))  # No other one shows what it hides.
    assert not are_tight([Frame(0, 0.0, image, camera, np.ones(shape, bool), mask)])


def with_tool(clip: Clip) -> Clip:
    """One that rests, in three of four frames; what is beside it has its colour."""
    first, last, beside = 20, 27, 2

    def read_frame(index: int) -> Frame:
        seen = clip.read_frame(index)
        if index % 4 == 3:
            return seen
        image, mask = seen.image.copy(), seen.tissue_mask.copy()
        image[8:24, first - beside : last + 1 + beside] = STEEL
        mask[8:24, first : last + 1] = False
        return replace(seen, image=image, tissue_mask=mask, evaluation_mask=mask)

    return replace(clip, read_frame=read_frame, read_image=lambda index: read_frame(index).image)


@pytest.mark.parametrize(("keep", "ghost"), [((), False), (("beside_tools",), True)])
def test_no_outline_of_a_tool_is_left(
    monkeypatch: pytest.MonkeyPatch, keep: tuple[Part, ...], ghost: bool
) -> None:
    """But where what is beside it is kept."""
    monkeypatch.setattr(outlines, "TIGHT", 0.0)  # The sheet is as motley as a tool is grey.
    bare = moving_sheet(shift=0.0)
    clip = with_tool(bare)
    model, _ = finished(clip, TrainConfig(iterations=200, n_gaussians=600, keep=keep))
    shares, near = [], partial(render, near=1.0)
    for index in (4, 5, 8):
        seen, truth = clip.read_frame(index), bare.read_frame(index).image / 255
        ring = (seen.image == STEEL).all(axis=2) & seen.tissue_mask
        to_steel = STEEL / 255 - truth[ring]
        off = near(model.at(seen.time), seen.camera).image[ring] - truth[ring]
        shares.append((off * to_steel).sum() / (to_steel**2).sum())
    assert (np.mean(shares) > 0.4) == ghost
