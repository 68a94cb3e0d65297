"""Flags that say how a clip is read are refused where its layout does not heed them."""

from __future__ import annotations

import shutil
from pathlib import Path

import cv2
import numpy as np
import pytest

from tests.app.conftest import Cli

UNHEEDED = [
    ("clip", "--stereo off"),
    ("clip", "--deinterlacing field"),
    ("clip", "--field-of-view 100"),
    ("clip", "--baseline 5"),
    ("still.png", "--pose-convention llff"),
    ("still.png", "--mask-polarity tool"),
    ("still.png", "--evaluation-masks gt_masks"),
    ("images", "--bottom-rows 3"),
    ("images", "--depth brightness --baseline 5"),
]


@pytest.fixture
def given(clip_path: Path, tmp_path: Path) -> Path:
    shutil.copytree(clip_path, tmp_path / "clip")
    shutil.copytree(clip_path / "images", tmp_path / "images")
    cv2.imwrite(str(tmp_path / "still.png"), np.full((48, 64, 3), 90, np.uint8))
    return tmp_path


@pytest.mark.parametrize(("name", "said"), UNHEEDED)
def test_a_flag_without_effect_is_refused(given: Path, name: str, said: str, vesselsplat: Cli) -> None:
    call = vesselsplat("train", given / name, "--run", given / "run", *said.split())
    assert call.code == 2
    *_, flag, value = said.split()
    assert f"{flag} {value} has no effect" in call.error
    assert call.error.count("\n") == 1
    assert not (given / "run").exists()


def test_masks_refuse_them_too(given: Path, vesselsplat: Cli) -> None:
    call = vesselsplat("masks", given / "clip", "--out", given / "out", "--stereo", "off")
    assert (call.code, "--stereo off has no effect on EndoNeRF" in call.error) == (2, True)
    assert not (given / "out").exists()


def test_a_flag_that_counts_is_taken(given: Path, vesselsplat: Cli) -> None:
    steps = ("--iterations", "1")
    call = vesselsplat("train", given / "clip", "--run", given / "a", "--bottom-rows", "3", *steps)
    assert call.code == 0, call.error
    shown = ("--depth", "brightness", "--field-of-view", "100")
    call = vesselsplat("train", given / "images", "--run", given / "b", *shown, *steps)
    assert call.code == 0, call.error


def test_runs_that_differ_in_options_without_effect_are_compared(given: Path, vesselsplat: Cli) -> None:
    for name in ("a", "b"):
        call = vesselsplat("train", given / "clip", "--run", given / name, "--iterations", "1")
        assert call.code == 0, call.error
    record = given / "b" / "run.json"
    text = record.read_text()
    assert '"stereo": "auto"' in text
    record.write_text(text.replace('"stereo": "auto"', '"stereo": "side-by-side"'))
    call = vesselsplat("evaluate", given / "a", "--against", given / "b")
    assert call.code == 0, call.error
