"""A part of a clip: trimmed frames and masked pixels leave no trace in what is trained and measured."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from app.enhancement.image_mask import PictureMask
from app.errors import UserError
from app.evaluation.evaluate import open_evaluation
from app.runs.clip_selection import WHOLE, ClipPart
from app.runs.run_folder import RunFolder
from app.runs.train_run import run_training
from renderer.clip import Clip
from renderer.readers.clip_options import ClipOptions
from renderer.sources import open_clip
from renderer.train.config import Method, TrainConfig
from renderer.train.events import Evaluated, Finished
from renderer.train.training import train
from tests.app.conftest import Cli, request_of

PART = ClipPart(trim=(2, 8), mask=PictureMask(text=(40, 0, 64, 20)))


def test_the_whole_clip_is_itself(clip_path: Path) -> None:
    clip = open_clip(clip_path)
    for part in (WHOLE, ClipPart(trim=(0, 9)), ClipPart(mask=PictureMask(view=(32, 24, 99)))):
        assert part.of(clip) is clip
        assert part.told(len(clip)) in ("", "without masked pixels")


def test_frames_are_numbered_and_timed_anew_and_masked_pixels_are_nothing(clip_path: Path) -> None:
    clip = open_clip(clip_path)
    part = PART.of(clip)
    assert len(part) == 7
    assert part.labels == clip.labels[2:9]
    for index in range(7):
        own, whole = part.read_frame(index), clip.read_frame(index + 2)
        assert (own.index, own.time) == (index, index / 7)
        np.testing.assert_array_equal(own.image, whole.image)
        np.testing.assert_array_equal(part.read_image(index), whole.image)
        kept = PART.mask.kept(whole.tissue_mask.shape)
        np.testing.assert_array_equal(own.tissue_mask, whole.tissue_mask & kept)
        np.testing.assert_array_equal(own.evaluation_mask, whole.evaluation_mask & kept)
        assert not own.depth_mask[:20, 40:].any()
    assert PART.told(10) == "frames 3 to 9 of 10, without masked pixels"
    assert PART.told() == "frames 3 to 9, without masked pixels"


@pytest.mark.parametrize("trim", [(5, 10), (7, 2)])
def test_frames_that_are_not_there_are_refused(clip_path: Path, trim: tuple[int, int]) -> None:
    with pytest.raises(UserError, match="expected frames from 0 to 9"):
        ClipPart(trim=trim).of(open_clip(clip_path))


def test_a_mask_that_leaves_nothing_is_refused(clip_path: Path) -> None:
    with pytest.raises(UserError, match="64x48"):
        ClipPart(mask=PictureMask(text=(-1, -1, 65, 49))).of(open_clip(clip_path))


def spoilt(clip: Clip, part: ClipPart) -> Clip:
    """The same but for what the part leaves out, which is noise."""
    rng = np.random.default_rng(0)

    def read_frame(index: int):  # type: ignore[no-untyped-def]
        frame = clip.read_frame(index)
        kept = part.mask.kept(frame.tissue_mask.shape)
        if not 2 <= index <= 8:
            kept &= False
        noise = rng.integers(0, 256, frame.image.shape, dtype=np.uint8)
        depth = rng.uniform(5, 500, kept.shape).astype(np.float32)
        image = np.where(kept[..., None], frame.image, noise)
        return replace(frame, image=image, depth=np.where(kept, frame.depth, depth))

    return replace(clip, read_frame=read_frame, read_image=lambda index: read_frame(index).image)


@pytest.mark.parametrize("method", ["vesselsplat", "endogaussian", "static"])
def test_what_is_left_out_leaves_no_trace(clip_path: Path, method: Method) -> None:
    """Noise in its place gives the same model to the last byte, and the same measures."""
    clip = open_clip(clip_path)
    config = TrainConfig(method=method, iterations=12, n_gaussians=300)
    models, measures = [], []
    for each in (clip, spoilt(clip, PART)):
        events = list(train(PART.of(each), config))
        assert isinstance(events[-1], Finished)
        models.append(events[-1].model.arrays())
        measures.append([event for event in events if isinstance(event, Evaluated)][-1])
    for name, values in models[0].items():
        np.testing.assert_array_equal(values, models[1][name], err_msg=name)
    assert measures[0] == measures[1]
    different = list(train(spoilt(clip, PART), config))[-1]
    assert isinstance(different, Finished)
    assert different.model.means.shape != models[0]["means"].shape or not np.array_equal(
        different.model.means, models[0]["means"]
    )  # Without the part, the noise does count.


@pytest.fixture(scope="module")
def run(clip_path: Path, tmp_path_factory: pytest.TempPathFactory) -> RunFolder:
    """A finished run of PART."""
    path = tmp_path_factory.mktemp("part") / "run"
    list(run_training(request_of(clip_path, path, part=PART)))
    return RunFolder(path)


def test_the_run_says_so_and_is_measured_and_drawn_on_it_alone(
    run: RunFolder, vesselsplat: Cli, tmp_path: Path
) -> None:
    record = run.record()
    assert (record.clip.part, record.clip.frames) == (PART, 7)
    measured = vesselsplat("evaluate", run.path, "--json")
    assert measured.code == 0, measured.error
    report = json.loads(measured.out)
    assert report["clip"]["part"]["trim"] == [2, 8]
    assert {frame["index"] for frame in report["frames"]} == {1}
    evaluation = open_evaluation(run.path)
    assert [frame["label"] for frame in report["frames"]] == [open_clip(evaluation.clip.path).labels[3]]
    assert evaluation.clip.read_frame(1).evaluation_mask.mean() == pytest.approx(report["evaluated_share"])
    drawn = vesselsplat("render", run.path, "--out", tmp_path / "pictures", "--view", "difference")
    assert drawn.code == 0, drawn.error
    assert len(list((tmp_path / "pictures").glob("*.png"))) == 7


def test_a_run_goes_on_with_its_own_part_only(clip_path: Path, tmp_path: Path, vesselsplat: Cli) -> None:
    begin = ("train", clip_path, "--run", tmp_path / "run", "--iterations", 20)
    said = ("--frames", "2:8", "--text-box", 40, 0, 64, 20, "--view-circle", 32, 24, 39)
    first = vesselsplat(*begin, *said)
    assert first.code == 0, first.error
    folder = RunFolder(tmp_path / "run")
    assert folder.record().clip.part == ClipPart(
        trim=(2, 8), mask=PictureMask(text=(40, 0, 64, 20), view=(32, 24, 39))
    )
    again = vesselsplat(*begin, *said, "--resume")
    assert again.code == 0, again.error
    own = vesselsplat(*begin[:4], "--view-circle", 32, 24, 39, "--resume")
    assert own.code == 0, own.error
    other = vesselsplat(*begin, "--frames", "2:7", *said[2:], "--resume")
    assert other.code == 2
    assert "trim (2, 8)" in other.error


@pytest.mark.parametrize(
    ("flags", "said"),
    [
        (("--frames", "8:2"), "such as 7 10:59 or 7,10:59, got '8:2'"),
        (("--frames", "0:10"), "0 to 9"),
        (("--frames", "3-5"), "--frames"),
        (("--text-box", -1, -1, 99, 99), "64x48"),
        (("--text-box", 64, 0, 90, 9), "overlaps the 64x48 pixels of a frame, got 64 0 90 9"),
        (("--text-box", -9, -9, 0, 0), "overlaps the 64x48 pixels"),
        (("--text-box", 1, 1, "nan", 9), "LEFT below RIGHT"),
        (("--view-circle", "nan", 1, 1), "--view-circle"),
    ],
)
def test_flags_that_say_nothing_are_one_line(
    clip_path: Path, tmp_path: Path, vesselsplat: Cli, flags: tuple[object, ...], said: str
) -> None:
    call = vesselsplat("train", clip_path, "--run", tmp_path / "run", "--iterations", 5, *flags)
    assert call.code == 2
    assert said in call.error
    assert call.error.count("\n") == 1
    assert not (tmp_path / "run").exists()


@pytest.mark.parametrize("flags", [("--frames", "0:10"), ("--text-box", 64, 0, 90, 9)])
def test_a_part_that_is_not_there_is_refused_before_depth_is_matched(
    clip_path: Path,
    tmp_path: Path,
    vesselsplat: Cli,
    monkeypatch: pytest.MonkeyPatch,
    flags: tuple[object, ...],
) -> None:
    def matched(bare: Clip, options: ClipOptions) -> Clip:
        raise AssertionError("depth is not needed to know")

    monkeypatch.setattr("app.runs.train_run.with_chosen_depth", matched)
    assert vesselsplat("train", clip_path, "--run", tmp_path / "run", *flags).code == 2


def test_runs_of_two_parts_are_not_compared(run: RunFolder, runs: dict[str, Path], vesselsplat: Cli) -> None:
    call = vesselsplat("evaluate", run.path, "--against", runs["original"])
    assert call.code == 2
    assert "another part" in call.error


def test_records_of_before_there_were_parts_are_of_the_whole_clip(runs: dict[str, Path]) -> None:
    path = RunFolder(runs["original"]).record_path
    told = json.loads(path.read_text())
    del told["clip"]["part"]
    old = runs["original"].parent / "old"
    old.mkdir(exist_ok=True)
    (old / "run.json").write_text(json.dumps(told))
    assert RunFolder(old).record().clip.part == WHOLE
