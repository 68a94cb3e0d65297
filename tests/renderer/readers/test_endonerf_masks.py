"""Masks of EndoNeRF folders: which value is tissue, and what counts where."""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from renderer.readers.clip_options import ClipOptions
from renderer.readers.data_sets.endonerf import open_endonerf, write_endonerf
from tests.renderer.readers.endonerf_folders import HEIGHT, WIDTH, make_frames
from tests.renderer.small_clip import refusal


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    path = tmp_path / "clip"
    write_endonerf(path, make_frames())
    return path


def rewrite_masks(folder: Path, change) -> None:
    for path in (folder / "masks").iterdir():
        Image.fromarray(change(np.asarray(Image.open(path)))).save(path)


def test_inverted_masks_are_refused_unless_meant(folder):
    rewrite_masks(folder, lambda mask: 255 - mask)
    assert "expected masks that mark tool" in refusal(folder)
    meant = open_endonerf(folder, ClipOptions(mask_polarity="tissue"))
    np.testing.assert_array_equal(meant.read_frame(2).tissue_mask, make_frames()[2].tissue_mask)
    forced = open_endonerf(folder, ClipOptions(mask_polarity="tool"))
    np.testing.assert_array_equal(forced.read_frame(2).tissue_mask, ~make_frames()[2].tissue_mask)


def test_inverted_masks_are_seen_without_depth(folder):
    shutil.rmtree(folder / "depth")
    shutil.rmtree(folder / "depth_fine")
    assert not open_endonerf(folder).has_depth
    rewrite_masks(folder, lambda mask: 255 - mask)
    assert "mask_polarity" in refusal(folder)


def test_masks_of_one_value_are_judged(folder):
    rewrite_masks(folder, lambda mask: np.full_like(mask, 255))
    assert "100 %" in refusal(folder)
    rewrite_masks(folder, lambda mask: np.zeros_like(mask))
    assert open_endonerf(folder).read_frame(0).tissue_mask.all()


def test_a_tool_that_fills_most_of_the_view_is_no_inversion(folder):
    """Depth and colour speak against the area."""
    frames = []
    for frame in make_frames():
        tool = np.zeros((HEIGHT, WIDTH), dtype=bool)
        tool[:22] = True
        image = np.where(tool[:, :, None], 100, [200, 100, 90]).astype(np.uint8)
        depth = np.where(tool, 0, 50).astype(np.float32)
        frames.append(replace(frame, image=image, tissue_mask=~tool, evaluation_mask=~tool, depth=depth))
    path = folder.with_name("filled")
    write_endonerf(path, frames)
    clip = open_endonerf(path)
    assert clip.read_frame(0).tissue_mask.sum() == 10 * WIDTH
    assert any("as tool" in notice for notice in clip.notices)


@pytest.mark.parametrize("top", [1, 255])
def test_masks_of_0_and_1_mean_the_same(folder, top):
    rewrite_masks(folder, lambda mask: (mask > 0).astype(np.uint8) * np.uint8(top))
    np.testing.assert_array_equal(
        open_endonerf(folder).read_frame(2).tissue_mask, make_frames()[2].tissue_mask
    )


@pytest.mark.parametrize("empty", [False, True])
def test_labels_mark_in_every_frame_whichever_it_shows(folder, empty):
    """A second tool with a label of its own in every other frame; none at all in those that are looked at."""
    for name in ("masks", "gt_masks"):
        for number, path in enumerate(sorted((folder / name).iterdir())):
            mask = (np.asarray(Image.open(path)) > 0).astype(np.uint8)
            mask[:16] *= 1 + number % 2
            Image.fromarray(mask * np.uint8(not empty or number == 4)).save(path)
    clip = open_endonerf(folder)
    for index in (4,) if empty else range(len(clip)):
        np.testing.assert_array_equal(clip.read_frame(index).tissue_mask, make_frames()[index].tissue_mask)
    assert not any("marks nothing" in notice for notice in clip.notices)


def test_frames_whose_masks_are_too_dark_beside_others_are_named(folder):
    for path in sorted((folder / "masks").iterdir())[:1]:
        Image.fromarray(np.asarray(Image.open(path)) // 4).save(path)
    said = "masks/ holds values up to 63 of 255 alone in 1 of 4 frames looked at and marks nothing there"
    assert any(said in notice for notice in open_endonerf(folder).notices)


def test_masks_that_mark_nothing_for_being_dark_are_named(folder):
    assert not any("marks nothing" in notice for notice in open_endonerf(folder).notices)
    rewrite_masks(folder, lambda mask: np.where(mask > 0, 2, 0).astype(np.uint8))
    assert any(
        "values up to 2 of 255 and marks nothing" in notice for notice in open_endonerf(folder).notices
    )


def test_masks_in_the_alpha_alone_are_refused(folder):
    rewrite_masks(folder, lambda mask: np.dstack([0 * mask] * 3 + [mask]))
    assert "in the alpha alone" in refusal(folder)


def test_without_masks_everything_is_tissue(folder):
    shutil.rmtree(folder / "masks")
    shutil.rmtree(folder / "gt_masks")
    clip = open_endonerf(folder)
    assert clip.read_frame(0).tissue_mask.all()
    assert any("masks" in notice for notice in clip.notices)


def test_evaluation_follows_the_masks_asked_for(folder):
    for path in (folder / "gt_masks").iterdir():
        Image.new("L", (WIDTH, HEIGHT)).save(path)
    assert not open_endonerf(folder).read_frame(0).evaluation_mask.all()
    options = ClipOptions(evaluation_masks="gt_masks")
    frame = open_endonerf(folder, options).read_frame(0)
    assert frame.evaluation_mask.all()
    shutil.rmtree(folder / "gt_masks")
    assert "gt_masks" in refusal(folder, options)


def test_colour_counts_wherever_no_tool_is_and_depth_within_masks(folder):
    before = open_endonerf(folder).read_frame(0)
    for path in (folder / "gt_masks").iterdir():
        Image.new("L", (WIDTH, HEIGHT)).save(path)
    frame = open_endonerf(folder).read_frame(0)
    assert frame.tissue_mask.all()
    np.testing.assert_array_equal(frame.evaluation_mask, before.evaluation_mask)
    assert not before.depth_mask.all()
    np.testing.assert_array_equal(frame.depth_mask, before.depth_mask)


def test_tools_that_cover_what_masks_call_tissue_are_not_trained_on(folder):
    before = open_endonerf(folder).read_frame(0)
    for path in (folder / "gt_masks").iterdir():
        Image.fromarray(255 - np.array(Image.open(path))).save(path)
    clip = open_endonerf(folder)
    assert "gt_masks/ marks tissue of masks/ as tool, and is not trained on" in clip.notices
    np.testing.assert_array_equal(clip.read_frame(0).tissue_mask, before.tissue_mask)


def test_burned_in_rows_leave_the_supervision_only(tmp_path):
    frames = []
    for frame in make_frames():
        assert frame.depth is not None
        frame.image[-3:] = np.arange(WIDTH)[None, :, None] * 6
        frame.depth[-3:] = 0
        frames.append(frame)
    write_endonerf(tmp_path / "clip", frames)
    clip = open_endonerf(tmp_path / "clip")
    frame = clip.read_frame(0)
    assert not frame.tissue_mask[-3:].any()
    assert frame.tissue_mask[-4].all()
    assert frame.evaluation_mask[-3:].all()
    assert any("last 3 rows" in notice for notice in clip.notices)
    kept = open_endonerf(tmp_path / "clip", ClipOptions(bottom_rows=0)).read_frame(0)
    assert kept.tissue_mask[-3:].all()
    assert "below 32, the rows" in refusal(tmp_path / "clip", ClipOptions(bottom_rows=32))


def test_a_black_border_is_burned_in_also_without_depth(tmp_path):
    frames = make_frames()
    for frame in frames:
        frame.image[-2:] = 0
    write_endonerf(tmp_path / "clip", frames)
    shutil.rmtree(tmp_path / "clip/depth")
    shutil.rmtree(tmp_path / "clip/depth_fine")
    assert not open_endonerf(tmp_path / "clip").read_frame(0).tissue_mask[-2:].any()
