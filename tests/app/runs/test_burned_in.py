"""A panel burned in beside masks of tools is found, said to be left out, and not trained on; tissue at rest
stays."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
from pydantic import TypeAdapter
from pydantic_core import to_json

from app.enhancement.image_mask import NO_MASK
from app.gui.work.masking import LeftOutRequest, MaskRequest, left_out, read_frame_mask
from app.gui.work.omissions import OmissionsRequest
from app.runs.burned_in import burned_in_of
from app.runs.clip_selection import WHOLE, ClipPart
from app.runs.left_out import left_out_of, with_found
from app.runs.run_folder import RunFolder
from app.runs.train_run import run_training
from app.runs.trained_clip import run_clip
from app.runs.unmasked_tools import tools_in
from renderer.camera import Camera
from renderer.clip import BoolImage, Frame
from renderer.phantom import PhantomParams, write_phantom
from renderer.sources import open_clip
from renderer.train.config import TrainConfig
from renderer.train.events import Started
from tests.app.conftest import Cli, request_of
from tests.app.looking import found_omissions

PANEL = np.s_[215:240, 0:90]
SMALL_PANEL = np.s_[38:48, 0:24]
CONFIG = TrainConfig(iterations=2, n_gaussians=500)


@pytest.fixture(scope="session")
def with_text(clip_path: Path, made_once: Callable[..., Path]) -> Path:
    """The small clip, its own masks, and a panel in the corner of its images. Read only."""

    def make(folder: Path) -> None:
        shutil.copytree(clip_path, folder / "clip")
        for path in sorted((folder / "clip" / "images").iterdir()):
            image = cv2.imread(str(path))
            assert image is not None
            image[SMALL_PANEL] = 50
            cv2.imwrite(str(path), image)

    return made_once("with_text", make) / "clip"


def test_a_panel_is_left_out_beside_masks_and_no_pixel_more() -> None:
    frames = [masked(index) for index in range(8)]
    assert tools_in(frames) is None
    part = found_in(frames)
    assert part.burned_in is not None
    assert (part.burned_in.frames, part.burned_in.looked_at) == (8, 8)
    around = np.zeros((240, 320), bool)
    around[205:, :100] = True
    for frame in frames:
        seen = part.cleared(frame)
        assert not seen.tissue_mask[PANEL].any()
        np.testing.assert_array_equal(seen.tissue_mask | around, frame.tissue_mask | around)
        np.testing.assert_array_equal(seen.evaluation_mask, seen.tissue_mask)
    assert 25 * 90 < part.burned_in.share * 240 * 320 < 35 * 100
    assert "without text or tools at rest" in part.told()
    (omission,), (line,) = left_out_of(part)
    assert (omission.what, omission.part) == ("text or tools at rest", "tools")
    assert "text or tools at rest, unchanged beside the masks in 8 of 8 frames" in line


def test_masks_that_are_said_to_be_of_tools_may_rest() -> None:
    frames = [replace(masked(0), index=index) for index in range(8)]
    assert burned_in_of(frames) is None
    assert burned_in_of(replace(frame, tools_are_known=True) for frame in frames) is not None


def test_tissue_at_rest_stays_beside_masks_and_what_moves_too() -> None:
    assert burned_in_of(without_panel(masked(index)) for index in range(8)) is None
    moving = (masked(index, np.s_[215 - 20 * index : 240 - 20 * index, 0:90]) for index in range(8))
    assert burned_in_of(moving) is None


def test_the_phantom_at_rest_stays_whole_with_its_masks(tmp_path: Path) -> None:
    write_phantom(tmp_path / "clip", PhantomParams(n_frames=8, width=160, height=128, tissue="static"))
    clip = open_clip(tmp_path / "clip")
    frames = [clip.read_frame(index) for index in range(8)]
    assert any((frame.tissue_mask != frames[0].tissue_mask).any() for frame in frames)
    assert burned_in_of(frames) is None
    assert burned_in_of(replace(frame, tools_are_known=True) for frame in frames) is None


def test_frames_of_several_sizes_and_no_frames_say_nothing() -> None:
    every = np.ones((24, 32), bool)
    small = Frame(1, 0.1, np.zeros((24, 32, 3), np.uint8), Camera.from_fov(60, 32, 24), every, every)
    assert burned_in_of([masked(0), masked(1), small]) is None
    assert burned_in_of([]) is None


def test_a_surround_that_is_kept_is_no_panel() -> None:
    frames = [surrounded(masked(index)) for index in range(8)]
    part = with_found(WHOLE, frames.__getitem__, range(8), ("surround",))
    assert (part.field_of_view, part.burned_in) == (None, None)
    assert burned_in_of(frames) is not None, "it stands still"


def test_runs_of_versions_before_keep_it() -> None:
    part = found_in([masked(index) for index in range(8)])
    told = to_json(part)
    assert TypeAdapter(ClipPart).validate_json(told) == part
    facts = json.loads(told)
    del facts["burned_in"]
    before = TypeAdapter(ClipPart).validate_python(facts)
    np.testing.assert_array_equal(before.cleared(masked(3)).tissue_mask, masked(3).tissue_mask)


def test_a_run_leaves_it_out_as_the_window_says(with_text: Path, tmp_path: Path) -> None:
    (started,) = (
        event
        for event in run_training(request_of(with_text, tmp_path / "run", config=CONFIG))
        if isinstance(event, Started)
    )
    record = RunFolder(tmp_path / "run").record()
    assert record.clip.part.burned_in is not None
    assert record.clip.part.tools is None
    assert started.omitted[0].what == "text or tools at rest"
    assert found_omissions(OmissionsRequest(open_clip(with_text), CONFIG)).omitted == started.omitted
    seen, own = run_clip(record), open_clip(with_text)
    for index in range(10):
        frame = seen.read_frame(index)
        assert not frame.tissue_mask[SMALL_PANEL].any()
        assert np.count_nonzero(frame.tissue_mask != own.read_frame(index).tissue_mask) < 2 * 240


def test_it_is_kept_where_asked_and_a_run_goes_on_as_it_began(
    with_text: Path, tmp_path: Path, vesselsplat: Cli
) -> None:
    flags = (with_text, "--iterations", 2)
    first = vesselsplat("train", *flags, "--run", tmp_path / "run")
    (tmp_path / "run" / "model.safetensors").unlink()
    again = vesselsplat("train", *flags, "--run", tmp_path / "run", "--resume")
    kept = vesselsplat("train", *flags, "--run", tmp_path / "kept", "--keep", "tools")
    assert (first.code, again.code, kept.code) == (0, 0, 0), first.error + again.error + kept.error
    assert "left out: text or tools at rest" in first.error
    assert "left out: text or tools at rest" not in kept.error
    assert RunFolder(tmp_path / "kept").record().clip.part.burned_in is None


def test_the_tint_and_the_mask_to_mend_show_it(with_text: Path, tmp_path: Path) -> None:
    clip = open_clip(with_text)
    (answer,) = left_out(LeftOutRequest(clip, 5, NO_MASK))
    assert answer.pixels[SMALL_PANEL].all()
    (mask,) = read_frame_mask(MaskRequest(clip, tmp_path, 5))
    np.testing.assert_array_equal(mask.left_out, answer.pixels)


def found_in(frames: list[Frame]) -> ClipPart:
    return with_found(WHOLE, frames.__getitem__, range(len(frames)), ("surround",))


def tool(index: int) -> BoolImage:
    """A mask that moves."""
    mask = np.zeros((240, 320), bool)
    mask[:120, 100 + 10 * index : 130 + 10 * index] = True
    return mask


def masked(index: int, panel: tuple[slice, slice] = PANEL) -> Frame:
    """Red tissue at rest, grey tools that are masked, and a grey panel."""
    image = np.full((240, 320, 3), (150, 70, 60), np.uint8)
    image[tool(index)] = 120
    image[panel] = 60
    tissue = ~cv2.dilate(tool(index).astype(np.uint8), np.ones((9, 9), np.uint8)).astype(bool)
    return Frame(index, index / 8, image, Camera.from_fov(60, 320, 240), tissue, tissue)


def surrounded(frame: Frame) -> Frame:
    """Seen through a round view, without a panel."""
    y, x = np.mgrid[:240, :320] + 0.5
    away = np.hypot(x - 160, y - 120)
    image = without_panel(frame).image
    image[away > 110] = 3
    image[np.abs(away - 110) < 2] = 30
    return replace(frame, image=image)


def without_panel(frame: Frame) -> Frame:
    image = frame.image.copy()
    image[PANEL] = (150, 70, 60)
    return replace(frame, image=image)
