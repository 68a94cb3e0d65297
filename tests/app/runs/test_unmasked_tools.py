"""Tools that nobody has masked are found, said to be left out, and neither trained nor measured."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from app.enhancement.image_mask import NO_MASK
from app.gui.work.masking import LeftOutRequest, left_out
from app.gui.work.omissions import OmissionsRequest, look
from app.runs.run_folder import RunFolder
from app.runs.train_run import run_training
from app.runs.trained_clip import run_clip
from app.runs.unmasked_tools import tools_in
from renderer.sources import open_clip
from renderer.train.config import TrainConfig
from renderer.train.events import Started
from tests.app.conftest import Cli, request_of


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
    (before,) = look(OmissionsRequest(open_clip(unmasked), config))
    assert before.omitted == started.omitted
    truth, seen = open_clip(clip_path), run_clip(run.record())
    for index in (0, 5, 9):
        tool = ~truth.read_frame(index).tissue_mask
        frame = seen.read_frame(index)
        assert not frame.tissue_mask[tool].any()
        assert not frame.evaluation_mask[tool].any()
        assert frame.tissue_mask[~tool].mean() > 0.85


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
