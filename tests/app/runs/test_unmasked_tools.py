"""Tools that nobody has masked are found, said to be left out, and neither trained nor measured."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
from pydantic import TypeAdapter
from pydantic_core import to_json

from app.enhancement.image_mask import NO_MASK
from app.gui.work.masking import LeftOutRequest, left_out
from app.gui.work.omissions import OmissionsRequest
from app.runs.clip_selection import ClipPart
from app.runs.run_folder import RunFolder
from app.runs.train_run import run_training
from app.runs.trained_clip import run_clip
from app.runs.unmasked_tools import tools_in, untold_in
from renderer.camera import Camera
from renderer.clip import Clip, Frame
from renderer.readers.masks.nonzero_masks import read_nonzero
from renderer.sources import open_clip
from renderer.tools.search import find_tools
from renderer.train.config import TrainConfig
from renderer.train.events import Started
from tests.app.conftest import Cli, request_of
from tests.app.looking import found_omissions

PANEL = np.s_[215:240, 0:90]
JAWS = np.s_[100:140, 80:130]


def test_a_run_leaves_them_out_and_says_so(unmasked: Path, clip_path: Path, tmp_path: Path) -> None:
    config = TrainConfig(iterations=2, n_gaussians=500)
    events = list(run_training(request_of(unmasked, tmp_path / "run", config=config)))
    (started,) = (event for event in events if isinstance(event, Started))
    run = RunFolder(tmp_path / "run")
    tools = run.record().clip.part.tools
    assert tools is not None
    assert (tools.frames, tools.looked_at) == (8, 8)
    assert (started.omitted[0].what, started.omitted[0].part) == ("tools", "tools")
    assert run.omitted()[0] == started.omitted[0]
    assert "without tools" in run.record().clip.part.told()
    before = found_omissions(OmissionsRequest(open_clip(unmasked), config))
    assert before.omitted == started.omitted
    truth, seen = open_clip(clip_path), run_clip(run.record())
    for index in (0, 5, 9):
        tool = ~truth.read_frame(index).tissue_mask
        frame = seen.read_frame(index)
        assert not frame.tissue_mask[tool].any()
        assert not frame.evaluation_mask[tool].any()
        assert frame.tissue_mask[~tool].mean() > 0.85


def test_of_grey_frames_it_is_said_that_tools_are_not_told(unmasked: Path, clip_path: Path) -> None:
    """Not where masks tell them."""

    def grey(path: Path, spread: int) -> Clip:
        clip = open_clip(path)

        def read_frame(index: int) -> Frame:
            frame = clip.read_frame(index)
            levels = np.repeat(frame.image[..., 1:2], 3, axis=2) // 2
            levels[..., 0] += np.uint8(spread)
            return replace(frame, image=levels)

        return replace(clip, read_frame=read_frame)

    assert untold_in(open_clip(unmasked)) == ()
    assert [untold_in(grey(unmasked, spread)) != () for spread in (0, 3, 20)] == [True, True, False]
    assert "masks of them leave them out (--tool-masks DIR)" in untold_in(grey(unmasked, 0))[0]
    assert untold_in(grey(clip_path, 0)) == ()


def test_they_are_kept_where_asked_and_a_run_goes_on_as_it_began(
    unmasked: Path, tmp_path: Path, vesselsplat: Cli
) -> None:
    flags = (
        unmasked,
        "--iterations",
        2,
    )
    first = vesselsplat("train", *flags, "--run", tmp_path / "run")
    again = vesselsplat("train", *flags, "--run", tmp_path / "run", "--resume")
    kept = vesselsplat("train", *flags, "--run", tmp_path / "kept", "--keep", "tools")
    assert (first.code, again.code, kept.code) == (0, 0, 0), first.error + again.error + kept.error
    said = "left out: tools, found by their colour in 8 of 8 frames, as the clip has no masks"
    assert said in first.error
    assert "left out: tools" not in kept.error
    assert RunFolder(tmp_path / "kept").record().clip.part.tools is None


def test_masks_of_the_clip_are_left_as_they_are(clip_path: Path) -> None:
    clip = open_clip(clip_path)
    frames = [clip.read_frame(index) for index in range(3)]
    assert tools_in(frames) is None
    assert tools_in(replace(frame, tissue_mask=np.ones_like(frame.tissue_mask)) for frame in frames)


def test_the_tint_shows_them(unmasked: Path, clip_path: Path) -> None:
    truth = open_clip(clip_path)
    (answer,) = left_out(LeftOutRequest(open_clip(unmasked), 5, NO_MASK))
    assert answer.pixels[~truth.read_frame(5).tissue_mask].all()
    (own,) = left_out(LeftOutRequest(truth, 5, NO_MASK))
    assert np.array_equal(own.pixels, ~truth.read_frame(5).tissue_mask)


def test_a_panel_is_masked_in_every_frame_but_in_runs_of_versions_before() -> None:
    frames = [with_panel(index, is_pale=index == 5) for index in range(8)]
    found = tools_in(frames)
    assert found is not None
    assert (found.frames, found.looked_at) == (8, 8)
    told = to_json(ClipPart(tools=found))
    now = TypeAdapter(ClipPart).validate_json(told)
    assert now == ClipPart(tools=found)
    facts = json.loads(told)
    del facts["tools"]["still"]
    before = TypeAdapter(ClipPart).validate_python(facts)
    for index, frame in enumerate(frames):
        alone = ~find_tools(frame.image, frame.tissue_mask)
        assert np.array_equal(before.cleared(frame).tissue_mask, alone)
        assert alone[PANEL].any() == (index == 5)
        assert now.cleared(frame).tissue_mask[PANEL].mean() < 0.02
        assert now.cleared(frame).tissue_mask.mean() > 0.8


def test_jaws_apart_from_their_shaft_are_masked_but_in_runs_of_versions_before() -> None:
    frames = [in_pieces(index) for index in range(2)]
    found = tools_in(frames)
    assert found is not None
    assert not found.still  # Of two frames nobody knows.
    facts = json.loads(to_json(ClipPart(tools=found)))
    del facts["tools"]["reach"]
    before = TypeAdapter(ClipPart).validate_python(facts)
    for frame in frames:
        alone = ~find_tools(frame.image, frame.tissue_mask, reach=0.0)
        assert np.array_equal(before.cleared(frame).tissue_mask, alone)
        assert alone[JAWS].mean() > 0.5
        assert not ClipPart(tools=found).cleared(frame).tissue_mask[JAWS].any()


def test_masks_that_are_made_by_colour_hold_it_in_every_frame(tmp_path: Path, vesselsplat: Cli) -> None:
    (tmp_path / "clip").mkdir()
    for index in range(8):
        frame = with_panel(index, is_pale=index == 5)
        cv2.imwrite(str(tmp_path / "clip" / f"{index}.png"), frame.image[:, :, ::-1])
    call = vesselsplat("masks", tmp_path / "clip", "--out", tmp_path / "masks")
    assert call.code == 0, call.error
    masks = sorted((tmp_path / "masks").glob("*.png"))
    assert [read_nonzero(path, (320, 240))[PANEL].mean() > 0.98 for path in masks] == [True] * 8


def with_panel(index: int, is_pale: bool) -> Frame:
    """A grey panel at the bottom left of red tissue, or of tissue that is told from no tool."""
    image = np.full((240, 320, 3), (170, 160, 160) if is_pale else (150, 70, 60), np.uint8)
    image[PANEL] = 60
    every = np.ones((240, 320), bool)
    return Frame(index, index / 8, image, Camera.from_fov(60, 320, 240), every, every)


def in_pieces(index: int) -> Frame:
    """A grey shaft from the left, whose length changes, and its jaws, with red tissue between them."""
    image = np.full((240, 320, 3), (150, 70, 60), np.uint8)
    image[100:140, : 60 + 2 * index] = image[JAWS] = (120, 122, 126)
    every = np.ones((240, 320), bool)
    return Frame(index, index / 2, image, Camera.from_fov(60, 320, 240), every, every)
