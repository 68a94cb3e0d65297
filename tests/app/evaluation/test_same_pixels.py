"""Two runs are compared only where both are measured over the same pixels."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from app.runs.train_run import run_training
from renderer.phantom import PhantomParams, write_phantom
from renderer.readers.clip_options import ClipOptions
from tests.app.conftest import CONFIG, Cli, request_of


@pytest.fixture(scope="module")
def two_kinds(clip_path: Path, tmp_path_factory: pytest.TempPathFactory) -> Callable[[ClipOptions], Path]:
    """Of one clip whose masks/ leave out more than its gt_masks/: a run for any options."""
    folder = tmp_path_factory.mktemp("kinds")
    clip = folder / "small"
    shutil.copytree(clip_path, clip)
    _leave_out_more(clip / "masks")

    def trained(options: ClipOptions) -> Path:
        path = folder / f"{options.evaluation_masks}-{options.mask_polarity}"
        if not path.exists():
            config = replace(CONFIG, iterations=4, n_gaussians=300)
            list(run_training(request_of(clip, path, config=config, clip_options=options)))
        return path

    return trained


def _leave_out_more(masks: Path) -> None:
    for path in masks.iterdir():
        mask = cv2.imread(str(path), cv2.IMREAD_GRAYSCALE)
        assert mask is not None
        mask[:, :12] = 255
        cv2.imwrite(str(path), mask)


def test_runs_evaluated_over_other_masks_are_not_compared(
    two_kinds: Callable[[ClipOptions], Path], vesselsplat: Cli
) -> None:
    own, other = two_kinds(ClipOptions()), two_kinds(ClipOptions(evaluation_masks="gt_masks"))
    call = vesselsplat("evaluate", own, "--against", other)
    assert (call.code, call.out, call.error.count("\n")) == (2, "", 1)
    assert "--evaluation-masks masks" in call.error
    assert "got one of --evaluation-masks gt_masks" in call.error


def test_the_same_masks_asked_for_in_other_words_are_compared(
    two_kinds: Callable[[ClipOptions], Path], vesselsplat: Cli
) -> None:
    own, other = two_kinds(ClipOptions()), two_kinds(ClipOptions(mask_polarity="tool"))
    assert vesselsplat("evaluate", own, "--against", other).code == 0


@pytest.fixture
def by_bits(clip_path: Path, tmp_path: Path) -> Callable[[int | None], Path]:
    """Of images of a camera of 12 bits: a run that reads them by any number of bits."""
    for path in sorted((clip_path / "images").iterdir())[:3]:
        levels = cv2.imread(str(path)).astype(np.uint16) * 16
        (tmp_path / "deep").mkdir(exist_ok=True)
        cv2.imwrite(str(tmp_path / "deep" / path.name), levels)

    def trained(bits: int | None) -> Path:
        path = tmp_path / f"bits-{bits}"
        config = replace(CONFIG, iterations=2, n_gaussians=100)
        options = ClipOptions(depth="brightness", bits=bits)
        list(run_training(request_of(tmp_path / "deep", path, config=config, clip_options=options)))
        return path

    return trained


def test_runs_on_frames_of_other_bits_are_not_compared(
    by_bits: Callable[[int | None], Path], vesselsplat: Cli
) -> None:
    found, told, stored = by_bits(None), by_bits(12), by_bits(14)
    assert vesselsplat("evaluate", found, "--against", told).code == 0
    call = vesselsplat("evaluate", found, "--against", stored)
    assert (call.code, call.out, call.error.count("\n")) == (2, "", 1)
    assert "expected a run on frames that were read in the same way" in call.error


@pytest.mark.parametrize(("count", "frames"), [(1, "training"), (3, "held-out")])
def test_the_comparison_says_which_frames_it_is_over(
    count: int, frames: str, tmp_path: Path, vesselsplat: Cli
) -> None:
    clip, run = tmp_path / "clip", tmp_path / "run"
    write_phantom(clip, PhantomParams(n_frames=count, width=64, height=48), "endonerf")
    list(run_training(request_of(clip, run, config=replace(CONFIG, iterations=2, n_gaussians=100))))
    out = " ".join(vesselsplat("evaluate", run, "--against", run).out.split())
    assert f"Means over the {frames} frames" in out
    assert ("measured on training frames" in out) == (frames == "training")
