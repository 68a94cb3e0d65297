"""A run's own copies of tool masks, when they are no longer what they were."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from app.runs.clip_selection import ClipPart
from app.runs.run_folder import RunFolder
from app.runs.tool_masks import FOLDER, ToolMasks
from app.runs.train_run import run_training
from app.runs.trained_clip import run_clip
from renderer.clip import ClipError
from renderer.sources import open_clip
from renderer.tools.mask_files import save_mask
from renderer.train.events import Progress
from tests.app.conftest import Cli, request_of

SAID = "expected the tool masks that the run began with, got lost or changed ones"


def lost(masks: Path) -> None:
    (masks / "000004.png").unlink()


def blanked(masks: Path) -> None:
    save_mask(masks / "000004.png", np.zeros((48, 64), bool))


def beyond(masks: Path) -> None:
    save_mask(masks / "000010.png", np.zeros((48, 64), bool))


def gone(masks: Path) -> None:
    for path in masks.iterdir():
        path.unlink()


def masks_of(clip: Path, folder: Path) -> ClipPart:
    mask = np.zeros((48, 64), bool)
    mask[:16, :20] = True
    folder.mkdir()
    for label in open_clip(clip).labels:
        save_mask(folder / f"{Path(label).stem}.png", mask)
    return ClipPart(tool_masks=ToolMasks(folder=str(folder)))


@pytest.mark.parametrize("change", [lost, blanked, beyond, gone])
def test_a_run_goes_on_with_the_masks_it_began_with_or_not_at_all(
    change: Callable[[Path], None], clip_path: Path, tmp_path: Path
) -> None:
    request = request_of(clip_path, tmp_path / "run", part=masks_of(clip_path, tmp_path / "masks"))
    events = run_training(request)
    next(event for event in events if isinstance(event, Progress))
    events.close()
    change(tmp_path / "run" / FOLDER)
    with pytest.raises(ClipError, match=SAID):
        list(run_training(request_of(clip_path, tmp_path / "run", resume=True)))


def test_a_run_is_not_measured_on_other_masks(clip_path: Path, tmp_path: Path, vesselsplat: Cli) -> None:
    list(run_training(request_of(clip_path, tmp_path / "run", part=masks_of(clip_path, tmp_path / "masks"))))
    record = RunFolder(tmp_path / "run").record()
    assert len(run_clip(record)) == 10
    assert json.loads(vesselsplat("evaluate", tmp_path / "run", "--json").out)["mean"]["psnr"] > 0
    blanked(tmp_path / "run" / FOLDER)
    call = vesselsplat("evaluate", tmp_path / "run")
    assert call.code == 2
    assert call.error.strip().splitlines()[-1] == f"vesselsplat: {SAID}: {tmp_path / 'run' / FOLDER}"
