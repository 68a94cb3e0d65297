"""Tools are found by their colour: grey, in from the edge, in one or more pieces, with a sharp end. No tissue
is."""

from __future__ import annotations

import numpy as np
import pytest

from renderer.clip import BoolImage, ByteImage
from renderer.phantom import Phantom, PhantomParams
from renderer.tools.search import MARGIN, REACH, find_tools

WIDTH, HEIGHT = 320, 256
RED, STEEL, FAT, PALE = (150, 70, 60), (120, 122, 126), (190, 150, 70), (200, 168, 160)
ALL = np.ones((HEIGHT, WIDTH), bool)


def tissue(color: tuple[int, int, int] = RED) -> ByteImage:
    """Shaded across, with the noise of a camera."""
    shade = np.linspace(0.5, 1.1, WIDTH)[None, :, None]
    noise = np.random.default_rng(0).normal(0, 3, (HEIGHT, WIDTH, 3))
    return np.clip(np.array(color) * shade + noise, 0, 255).astype(np.uint8)


def with_bar(image: ByteImage, color: tuple[int, int, int], left: int = 0) -> tuple[ByteImage, BoolImage]:
    """A bar of 40 rows from column `left` to the middle."""
    mask = np.zeros((HEIGHT, WIDTH), bool)
    mask[100:140, left : WIDTH // 2] = True
    return np.where(mask[:, :, None], np.array(color, np.uint8), image), mask


@pytest.mark.parametrize("exposure", [0.35, 1.0])
@pytest.mark.parametrize("steel", [STEEL, (230, 231, 228), (110, 122, 150)])
def test_a_grey_bar_from_the_edge_is_a_tool(steel: tuple[int, int, int], exposure: float) -> None:
    image, bar = with_bar(tissue(), steel)
    exposed = np.clip(image * exposure, 0, 255).astype(np.uint8)
    found = find_tools(exposed, ALL)
    assert found[bar].all()
    away = int(2.5 * MARGIN * WIDTH)
    assert not found[: 100 - away].any()
    assert not found[140 + away :].any()
    assert not found[:, WIDTH // 2 + away :].any()


def in_pieces(gap: int, blur: int = 0) -> tuple[ByteImage, BoolImage]:
    """A bar that enters up to column 60, and its jaws `gap` px farther on; the bar fades over `blur` rows."""
    image, bar = with_bar(tissue(), STEEL)
    y = np.arange(HEIGHT)
    share = (
        np.clip(np.minimum(y - 90, 150 - y) / blur, 0, 1) if blur else ((y >= 100) & (y < 140)).astype(float)
    )
    steel = share[:, None, None] * np.array(STEEL) + (1 - share[:, None, None]) * tissue()
    image[:, :60] = steel[:, :60].astype(np.uint8)
    image[:, 60 : 60 + gap] = tissue()[:, 60 : 60 + gap]
    jaws = bar.copy()
    jaws[:, : 60 + gap] = False
    return image, jaws


def test_a_tool_in_pieces_is_one_tool() -> None:
    gap = int(REACH * WIDTH) - 8
    image, jaws = in_pieces(gap)
    assert find_tools(image, ALL)[jaws].all()
    assert find_tools(image, ALL)[100:140, :60].all()
    image, jaws = in_pieces(gap + 20)
    assert find_tools(image, ALL)[jaws].mean() < 0.3, "a stone beside a tool"


def test_pale_tissue_beside_a_tool_is_no_piece_of_it() -> None:
    image, pale = in_pieces(int(REACH * WIDTH) - 8)
    pale[100:114] = False  # A third of it shines grey.
    image[pale] = (138, 119, 120)
    assert find_tools(image, ALL)[pale].mean() < 0.3


def test_what_is_blurred_where_it_enters_leads_to_what_is_sharp() -> None:
    image, jaws = in_pieces(int(REACH * WIDTH) - 8, blur=30)
    found = find_tools(image, ALL)
    assert found[jaws].all()
    assert not found[:, :20].any(), "too blurred to be told from pale tissue"


def test_without_a_reach_every_piece_enters_by_itself() -> None:
    image, jaws = in_pieces(6)
    alone = find_tools(image, ALL, reach=0.0)
    assert alone[100:140, :60].all()
    assert alone[jaws].mean() < 0.3


def test_size_does_not_matter() -> None:
    image, bar = with_bar(tissue(), STEEL)
    for times in (2, 3):
        large = image.repeat(times, axis=0).repeat(times, axis=1)
        found = find_tools(large, np.ones(large.shape[:2], bool))[::times, ::times]
        assert np.mean(found != find_tools(image, ALL)) < 0.005
    assert find_tools(image, ALL)[bar].all()


@pytest.mark.parametrize(
    ("image", "what"),
    [
        (tissue(), "tissue"),
        (with_bar(tissue(), STEEL, left=60)[0], "a grey area that nothing reaches, as gauze or a stone"),
        (with_bar(tissue(), FAT)[0], "fat"),
        (with_bar(tissue(), (255, 255, 255))[0], "a reflection, which has no colour"),
        (tissue((120, 122, 118)), "tissue that is grey itself"),
        (np.zeros((HEIGHT, WIDTH, 3), np.uint8), "black"),
        (np.full((HEIGHT, WIDTH, 3), 255, np.uint8), "white"),
        (np.random.default_rng(1).integers(0, 256, (HEIGHT, WIDTH, 3), dtype=np.uint8), "noise"),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_nothing_is_found_in(image: ByteImage, what: str) -> None:
    assert not find_tools(image, ALL).any(), what


def test_pale_tissue_that_fades_into_red_is_none() -> None:
    fade = np.clip((np.arange(HEIGHT)[:, None, None] - 20) / 90, 0, 1)
    image = (np.array((200, 182, 180)) * (1 - fade) + np.array(RED) * fade) * np.ones((1, WIDTH, 1))
    assert not find_tools(image.astype(np.uint8), ALL).any()


def test_the_edge_of_a_round_view_counts_as_an_edge() -> None:
    y, x = np.mgrid[:HEIGHT, :WIDTH]
    seen = np.hypot(x - WIDTH / 2, y - HEIGHT / 2) < 110
    image, bar = with_bar(tissue(), STEEL)
    image[~seen] = 2
    found = find_tools(image, seen)
    assert found[bar & seen].all()
    assert found.mean() < 2 * (bar & seen).mean()


@pytest.mark.parametrize("shape", [(1, 1), (2, 700), (700, 2), (5, 5)])
def test_odd_sizes(shape: tuple[int, int]) -> None:
    assert not find_tools(np.full((*shape, 3), RED, np.uint8), np.ones(shape, bool)).any()
    assert not find_tools(np.full((*shape, 3), RED, np.uint8), np.zeros(shape, bool)).any()


def test_most_of_the_phantom_s_tools() -> None:
    phantom = Phantom(PhantomParams(n_frames=10, width=256, height=192))
    for index in range(0, 10, 3):
        frame = phantom.view(index).frame
        tool = ~frame.tissue_mask
        found = find_tools(frame.image, np.ones_like(tool))
        assert found[tool].mean() > 0.8
        assert found[~tool].mean() < 0.1
