"""Colours that stand for values can be read by colour-blind viewers.

Simulated by the matrices of Machado, Oliveira and Fernandes, "A Physiologically-based Model for Simulation
of Color Vision Deficiency", IEEE Transactions on Visualization and Computer Graphics 15(6), 2009, severity 1,
on linear RGB.
"""

from __future__ import annotations

import re
from itertools import combinations
from pathlib import Path
from typing import Any, get_args

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from app.gui.style import theme
from app.gui.views.resample import OVER, UNDER
from app.report.colors import COLORS
from app.scenes.view_kinds import ColorMap, Scale

ROOT = Path(__file__).parents[3]
VISION: dict[str, list[list[float]]] = {
    "normal": [[1, 0, 0], [0, 1, 0], [0, 0, 1]],
    "protanopia": [
        [0.152286, 1.052583, -0.204868],
        [0.114503, 0.786281, 0.099216],
        [-0.003882, -0.048116, 1.051998],
    ],
    "deuteranopia": [
        [0.367322, 0.860646, -0.227968],
        [0.280085, 0.672501, 0.047413],
        [-0.011820, 0.042940, 0.968881],
    ],
    "tritanopia": [
        [1.255528, -0.076749, -0.178779],
        [-0.078411, 0.930809, 0.147602],
        [0.004733, 0.691367, 0.303900],
    ],
}
STEPS = 9
"""Colours of a map that are to be told apart."""
NOTICED = 8.0
"""CIE 1976 colour difference; some 2.3 are just noticeable side by side."""
RISE = 60.0
"""Of the lightness L*, from one end of a map to the other."""
Floats = NDArray[np.floating[Any]]


def seen(rgb: Any, vision: str) -> Floats:
    """(N, 3) L*a*b* of colours (N, 3) of 0 to 255, as such a viewer sees them."""
    share = np.asarray(rgb, float).reshape(-1, 3) / 255
    linear = np.where(share <= 0.04045, share / 12.92, ((share + 0.055) / 1.055) ** 2.4)
    shown = np.clip(linear @ np.array(VISION[vision]).T, 0, 1)
    # OpenCV takes linear RGB by another name for the same conversion.
    lab = cv2.cvtColor(shown[None].astype(np.float32), cv2.COLOR_LRGB2Lab)[0]
    return np.asarray(lab, float)


def lightness(table: Any, vision: str) -> Floats:
    return seen(table, vision)[:, 0]


def least_difference(colors: Any, vision: str) -> float:
    """Between any two."""
    lab = seen(colors, vision)
    return min(float(np.linalg.norm(one - other)) for one, other in combinations(lab, 2))


def is_safe(table: Any, vision: str) -> bool:
    """It becomes lighter all the way, by much, and its steps can be told apart."""
    light = lightness(table, vision)
    rises = bool((np.diff(light[::5]) > -0.2).all()) and light[-1] - light[0] >= RISE
    return rises and least_difference(table[np.linspace(0, 255, STEPS).astype(int)], vision) >= NOTICED


@pytest.mark.parametrize("vision", VISION)
@pytest.mark.parametrize("colors", get_args(ColorMap))
def test_maps_become_lighter_all_the_way_for_every_viewer(colors: ColorMap, vision: str) -> None:
    assert is_safe(Scale(0.0, 1.0, "mm", colors).table, vision)
    assert is_safe(Scale(0.0, 1.0, "mm", colors, reversed=True).table[::-1], vision)


@pytest.mark.parametrize("vision", ["protanopia", "deuteranopia"])
def test_a_rainbow_and_red_to_green_would_be_noticed(vision: str) -> None:
    levels = np.arange(256, dtype=np.uint8)
    jet = cv2.applyColorMap(levels[:, None], cv2.COLORMAP_JET)[:, 0, ::-1]
    assert not is_safe(jet, vision)
    assert not is_safe(np.stack([255 - levels, levels, 0 * levels], axis=1), vision)


def test_no_other_map_is_used() -> None:
    used = {
        name
        for package in ("app", "renderer", "enhance")
        for path in (ROOT / package).rglob("*.py")
        for name in re.findall(r"COLORMAP_(\w+)|cmap=\"(\w+)\"", path.read_text(encoding="utf-8"))
    }
    assert used == {("VIRIDIS", ""), ("INFERNO", "")}


@pytest.mark.parametrize("vision", VISION)
def test_lines_of_a_diagram_can_be_told_apart(vision: str) -> None:
    """By colour, beside the names that stand at each."""
    colors = [[int(color[at : at + 2], 16) for at in (1, 3, 5)] for color in COLORS]
    assert least_difference(colors, vision) >= NOTICED


@pytest.mark.parametrize("vision", VISION)
def test_marks_on_an_image_can_be_told_apart(vision: str) -> None:
    """Stripes where it is clipped, and the camera path from where it stands now."""
    path, mark = ([255 * part for part in (color.x, color.y, color.z)] for color in (theme.PATH, theme.MARK))
    assert least_difference([OVER, UNDER], vision) >= 3 * NOTICED
    assert least_difference([path, mark], vision) >= 3 * NOTICED


@pytest.mark.parametrize("vision", VISION)
@pytest.mark.parametrize("colors", theme.THEMES.values(), ids=theme.THEMES)
def test_a_button_that_is_on_differs_from_one_that_is_off(colors: theme.Colors, vision: str) -> None:
    """In lightness or hue: words beside it say it as well."""
    on, off = ([255 * part for part in (c.x, c.y, c.z)] for c in (colors.lit, colors.shade(0.25)))
    assert least_difference([on, off], vision) >= 2 * NOTICED
