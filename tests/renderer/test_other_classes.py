"""Arguments of another class are refused in one sentence: what was expected, and what came."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from renderer import (
    Camera,
    Clip,
    ClipError,
    PhantomParams,
    Splats,
    TrainConfig,
    open_clip,
    psnr,
    rasterize,
    render,
    ssim,
    train,
    write_phantom,
    write_splats,
)

IMAGE = np.zeros((16, 16, 3), np.float32)
SPLATS = Splats(
    means=np.float32([[0, 0, 5]]),
    quats=np.float32([[1, 0, 0, 0]]),
    scales=np.full((1, 3), 0.3, np.float32),
    opacities=np.float32([0.9]),
    colors=np.float32([[0.8, 0.2, 0.2]]),
)
CAMERA = Camera.from_fov(60, 16, 16)
WRONG: Any = "x"
CLIP = Clip("none", Path("none"), "images", (), WRONG, WRONG, (), has_depth=True, unit="mm")
MOMENT: Any = SPLATS


@pytest.mark.parametrize(
    ("call", "says"),
    [
        (lambda: write_splats("a.ply", MOMENT), "expected RawGaussians, as model.raw gives them, got Splats"),
        (lambda: render(SPLATS, WRONG), "expected Splats and a Camera, got Splats and str"),
        (lambda: render(WRONG, CAMERA), "expected Splats and a Camera, got str and Camera"),
        (lambda: write_phantom("a", WRONG), "expected params to be PhantomParams, got str"),
        (lambda: open_clip("a", WRONG), "expected options to be ClipOptions, got str"),
        (lambda: next(train(CLIP, WRONG)), "expected a TrainConfig, got str"),
        (lambda: rasterize(*[IMAGE] * 5, CAMERA), "expected five tensors and a Camera, got ndarray, ndarray"),
        (lambda: psnr(IMAGE, IMAGE, WRONG), "as numpy arrays, got ndarray, ndarray, str"),
        (lambda: ssim(WRONG, IMAGE, WRONG), "as numpy arrays, got str, ndarray, str"),
    ],
)
def test_arguments_of_another_class_are_refused(call: Callable[[], object], says: str) -> None:
    with pytest.raises(TypeError, match=says):
        call()


def test_a_layout_that_no_phantom_has_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="expected a layout among endonerf, scared, got 'hamlyn'"):
        write_phantom(tmp_path / "clip", PhantomParams(), "hamlyn")  # type: ignore[arg-type]
    assert not [*tmp_path.iterdir()]


def test_colours_of_bytes_are_refused_and_whole_numbers_are_not() -> None:
    with pytest.raises(ValueError, match=r"Splats\.colors must be floats in \[0, 1\], got uint8"):
        replace(SPLATS, colors=np.uint8([[200, 50, 50]]))
    assert replace(SPLATS, colors=np.array([[1, 0, 0]])).colors.tolist() == [[1, 0, 0]]


def test_a_clip_without_frames_is_refused() -> None:
    with pytest.raises(ClipError, match="expected a clip of at least one frame, got none: none"):
        next(train(CLIP, TrainConfig()))
