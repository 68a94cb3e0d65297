"""Runs: what the folder holds, when they go on, and what is measured of them."""

from __future__ import annotations

import errno
import json
import os
import shutil
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from app.errors import UserError
from app.files.provenance import read_provenance
from app.runs.run_folder import RunFolder
from app.runs.train_run import run_training
from app.runs.trained_clip import input_clip
from app.scenes.cpu_rendering import DrawOptions, draw_on_cpu
from enhance import EnhanceParams, enhance, measure
from enhance.metrics import dvbv_otsu
from renderer.metrics import psnr
from renderer.near_plane import near_plane
from renderer.phantom import PhantomParams, write_phantom
from renderer.sources import open_clip
from renderer.train.config import TrainConfig
from renderer.train.events import Finished, Warned
from tests.app.conftest import CONFIG, Cli, request_of

ROOT = Path(__file__).resolve().parents[3]
PULLING = ROOT / "../shared/data/endonerf/pulling_soft_tissues"


def test_a_run_folder_holds_what_was_asked_and_what_happened(runs: dict[str, Path], clip_path: Path) -> None:
    run = RunFolder(runs["original"])
    record = run.record()
    clip = open_clip(clip_path)
    assert (record.config, record.input, record.enhancement) == (CONFIG, "original", None)
    assert (record.clip.path, record.clip.frames) == (str(clip_path), len(clip))
    assert record.cameras == clip.cameras
    assert [record.time(index) for index in range(len(clip))] == list(clip.times)
    names = [event["event"] for event in run.events()]
    assert (names[0], names[-1]) == ("Started", "Finished")
    assert run.train_seconds() == run.events()[-1]["seconds"]
    checkpoints = sorted(path.name for path in run.path.glob("checkpoint-*"))
    assert checkpoints == ["checkpoint-0000030.safetensors", "checkpoint-0000040.safetensors"]
    assert len(run.model()) > 0
    assert not list(run.path.glob("*partial*"))


def test_what_is_odd_about_a_clip_is_told_and_logged(clip_path: Path, tmp_path: Path) -> None:
    clip = tmp_path / "clip"
    shutil.copytree(clip_path, clip)
    (clip / "masks" / "left_video.mp4").touch()
    config = replace(CONFIG, iterations=2)
    events = list(run_training(request_of(clip, tmp_path / "run", config=config)))
    warnings = [event.message for event in events if isinstance(event, Warned)]
    assert any("left_video.mp4" in warning for warning in warnings)
    logged = [e["message"] for e in RunFolder(tmp_path / "run").events() if e["event"] == "Warned"]
    assert logged == warnings


@pytest.mark.data
@pytest.mark.skipif(not PULLING.is_dir(), reason="the pulling clip is not here")
def test_a_real_clip_is_trained_and_measured(tmp_path: Path, vesselsplat: Cli) -> None:
    run = tmp_path / "run"
    part = ("--frames", "0:9")
    assert vesselsplat("train", PULLING, "--run", run, "--iterations", 20, *part).code == 0
    report = json.loads(vesselsplat("evaluate", run, "--json").out)
    assert [frame["index"] for frame in report["frames"]] == [1, 9]
    assert report["mean"]["psnr"] > 20
    assert 0 < report["mean"]["depth_rmse_mm"] < 30


def test_the_enhanced_run_remembers_frames_pooled_over_its_training_frames(
    runs: dict[str, Path], clip_path: Path
) -> None:
    record = RunFolder(runs["enhanced"]).record()
    clip = open_clip(clip_path)
    params = EnhanceParams(d_factor=0.5)
    frames = [clip.read_frame(index) for index in clip.train_indices]
    pooled = measure([f.image for f in frames], params, [f.tissue_mask for f in frames])
    assert record.enhancement is not None
    assert record.enhancement.params == params
    assert record.enhancement.statistics == pooled
    image = input_clip(clip, record).read_image(1)
    assert np.array_equal(image, enhance(clip.read_image(1), params, statistics=pooled).image)


def test_resuming_what_is_finished_gives_it_back_unchanged(runs: dict[str, Path], clip_path: Path) -> None:
    run = RunFolder(runs["original"])
    before = {path.name: path.read_bytes() for path in run.path.iterdir()}
    (finished,) = run_training(request_of(clip_path, run.path, resume=True))
    assert isinstance(finished, Finished)
    assert (finished.iteration, finished.seconds) == (40, run.train_seconds())
    assert {path.name: path.read_bytes() for path in run.path.iterdir()} == before


@pytest.mark.parametrize(
    ("changes", "word"),
    [
        ({"resume": False}, "already holds a finished run"),
        ({"config": replace(CONFIG, seed=5)}, "seed 0, got 5"),
        ({"input": "enhanced"}, "input original, got enhanced"),
    ],
)
def test_a_run_goes_on_only_as_it_began(
    runs: dict[str, Path], clip_path: Path, changes: dict[str, object], word: str
) -> None:
    request = request_of(clip_path, runs["original"], **({"resume": True} | changes))
    with pytest.raises(UserError, match=word):
        list(run_training(request))


def test_a_run_goes_on_beside_what_is_not_of_the_clip(clip_path: Path, tmp_path: Path) -> None:
    clip = tmp_path / "clip"
    shutil.copytree(clip_path, clip)
    run = RunFolder(clip / "run")
    short = replace(CONFIG, iterations=2)
    list(run_training(request_of(clip, run.path, config=short)))
    (clip / "Thumbs.db").touch()
    resumed = request_of(clip, run.path, config=short, resume=True)
    assert isinstance(next(run_training(resumed)), Finished)
    frame = sorted((clip / "images").iterdir())[2]
    cv2.imwrite(str(frame), np.zeros((48, 64, 3), np.uint8))
    with pytest.raises(UserError, match=r"a changed one: .*clip$"):
        list(run_training(resumed))


@pytest.mark.parametrize("name", ["original", "enhanced"])
def test_evaluation_compares_with_the_frames_the_run_was_trained_on(
    runs: dict[str, Path], clip_path: Path, vesselsplat: Cli, name: str
) -> None:
    call = vesselsplat("evaluate", runs[name], "--json")
    report = json.loads(call.out)
    clip, run = open_clip(clip_path), RunFolder(runs[name])
    frames, model = input_clip(clip, run.record()), run.model()
    assert [frame["index"] for frame in report["frames"]] == [1, 9]
    frame = frames.read_frame(9)
    drawn = draw_on_cpu(model.at(frame.time), frame.camera, DrawOptions(near_plane(model, frame.camera)))
    row = report["frames"][1]
    assert row["psnr"] == pytest.approx(psnr(drawn.bytes / 255, frame.image / 255, frame.evaluation_mask))
    assert row["whole_picture"]["dv_bv"] == pytest.approx(dvbv_otsu(drawn.bytes).ratio)
    # A split by grey value does not care where pixels lie: the evaluated ones make a picture of one column.
    evaluated = [picture[frame.evaluation_mask][:, None] for picture in (drawn.bytes, frame.image)]
    assert row["dv_bv"] == pytest.approx(dvbv_otsu(evaluated[0]).ratio)
    assert row["input_photo"]["dv"] == pytest.approx(dvbv_otsu(evaluated[1]).dv)
    original = clip.read_image(9)[frame.evaluation_mask][:, None]
    assert row["original_photo"]["dv"] == pytest.approx(dvbv_otsu(original).dv)
    mean = report["mean"]
    assert report["frames_are"] == "test"
    names = "psnr psnr_masked ssim lpips depth_rmse_mm dv bv dv_bv n_gaussians train_seconds ms_per_frame"
    assert set(mean) == {*names.split(), "wall_seconds", "psnr_tissue", "psnr_seldom", "coverage"}
    assert mean["lpips"] is None
    assert mean["psnr"] == pytest.approx(np.mean([frame["psnr"] for frame in report["frames"]]))
    assert (mean["n_gaussians"], mean["train_seconds"]) == (len(model), run.train_seconds())
    assert str(runs[name].parent) not in call.out


def test_a_clip_with_tissue_masks_trains_and_is_measured_when_its_polarity_is_said(
    clip_path: Path, tmp_path: Path, vesselsplat: Cli
) -> None:
    inverted = tmp_path / "inverted"
    shutil.copytree(clip_path, inverted)
    for path in (inverted / "masks").iterdir():
        cv2.imwrite(str(path), 255 - cv2.imread(str(path), cv2.IMREAD_GRAYSCALE))
    steps = ("--iterations", "10")
    refused = vesselsplat("train", inverted, "--run", tmp_path / "refused", *steps)
    assert refused.code == 2
    assert "mask_polarity" in refused.error
    assert vesselsplat("train", clip_path, "--run", tmp_path / "plain", *steps).code == 0
    said = vesselsplat("train", inverted, "--run", tmp_path / "said", *steps, "--mask-polarity", "tissue")
    assert said.code == 0
    same = [(tmp_path / name / "model.safetensors").read_bytes() for name in ("plain", "said")]
    assert same[0] == same[1]
    assert vesselsplat("evaluate", tmp_path / "said").code == 0


def test_a_frame_without_evaluated_pixels_does_not_count(
    clip_path: Path, tmp_path: Path, vesselsplat: Cli
) -> None:
    hidden = tmp_path / "hidden"
    shutil.copytree(clip_path, hidden)
    cv2.imwrite(str(hidden / "masks" / "frame-000001.mask.png"), np.full((48, 64), 255, np.uint8))
    assert vesselsplat("train", hidden, "--run", tmp_path / "run", "--iterations", "10").code == 0
    report = json.loads(vesselsplat("evaluate", tmp_path / "run", "--json").out)
    nothing, measured = report["frames"]
    for name in ("psnr", "psnr_masked", "ssim", "dv", "dv_bv"):
        assert nothing[name] is None
        assert report["mean"][name] == measured[name]


def test_frames_without_depth_are_refused_until_it_may_be_guessed(
    clip_path: Path, tmp_path: Path, vesselsplat: Cli
) -> None:
    frames = tmp_path / "photos"
    frames.mkdir()
    for path in sorted((clip_path / "images").iterdir())[:3]:
        shutil.copy(path, frames)
    call = vesselsplat("train", frames, "--run", tmp_path / "run", "--input", "enhanced")
    assert call.code == 2
    assert "--depth brightness" in call.error
    guess = ("--depth", "brightness", "--iterations", "10")
    assert vesselsplat("train", frames, "--run", tmp_path / "guessed", *guess).code == 0
    report = json.loads(vesselsplat("evaluate", tmp_path / "guessed", "--json").out)
    assert report["mean"]["psnr"] > 10
    assert report["mean"]["depth_rmse_mm"] is None


def test_a_clip_that_changed_is_not_evaluated(
    runs: dict[str, Path], tmp_path: Path, vesselsplat: Cli
) -> None:
    text = RunFolder(runs["original"]).record_path.read_text()
    copy = RunFolder(tmp_path / "copy")
    copy.path.mkdir()
    copy.model_path.write_bytes(RunFolder(runs["original"]).model_path.read_bytes())
    digest = RunFolder(runs["original"]).record().clip.sha256
    copy.record_path.write_text(text.replace(digest, "0" * 64))
    call = vesselsplat("evaluate", copy.path)
    assert (call.code, call.error.count("\n")) == (2, 1)
    assert "changed" in call.error


def test_train_prints_one_json_object(clip_path: Path, tmp_path: Path, vesselsplat: Cli) -> None:
    call = vesselsplat(
        "train", clip_path, "--run", tmp_path / "run", "--iterations", 3, "--seed", 2, "--json"
    )
    summary = json.loads(call.out)
    assert (call.code, summary["iterations"], summary["config"]["seed"]) == (0, 3, 2)
    assert summary["omitted"][0]["what"]
    assert str(tmp_path) not in call.out
    again = vesselsplat(
        "train", clip_path, "--run", tmp_path / "run", "--iterations", 3, "--seed", 2, "--json", "--resume"
    )
    assert json.loads(again.out)["omitted"] == summary["omitted"]
    again = vesselsplat(
        "train", clip_path, "--run", tmp_path / "run", "--iterations", 3, "--seed", 2, "--resume"
    )
    _, *table = again.out.splitlines()
    told = ("what", "why", "saves")
    columns = [("left out", *told[1:]), *(tuple(each[one] for one in told) for each in summary["omitted"])]
    places = {tuple(line.index(cell) for cell in cells) for line, cells in zip(table, columns, strict=True)}
    assert len(places) == 1


def test_what_is_forced_back_is_not_left_out_and_can_be_resumed(
    clip_path: Path, tmp_path: Path, vesselsplat: Cli
) -> None:
    flags = ("--run", tmp_path / "run", "--iterations", 3, "--sh-degree", 3, "--keep", "harmonics", "tiles")
    call = vesselsplat("train", clip_path, *flags, "--json")
    assert json.loads(call.out)["config"]["keep"] == ["harmonics", "tiles"]
    left_out = {each["what"] for each in json.loads(call.out)["omitted"]}
    assert not {"harmonics", "tiles without tissue"} & left_out
    assert RunFolder(tmp_path / "run").model().raw.harmonics.shape[1] == 15
    # Records of before hold the parts as they were named.
    record = tmp_path / "run" / "run.json"
    told = json.loads(record.read_text())
    told["config"]["keep"] = ["tiles", "harmonics", "tiles"]
    record.write_text(json.dumps(told))
    for kept in (("harmonics", "tiles"), ("tiles", "harmonics", "tiles")):
        again = vesselsplat("train", clip_path, *flags, "--keep", *kept, "--json", "--resume")
        assert again.code == 0, again.error
        assert json.loads(again.out)["omitted"] == json.loads(call.out)["omitted"]
    other = vesselsplat("train", clip_path, *flags, "--keep", "tiles", "--resume")
    assert "expected the run's keep ('harmonics', 'tiles'), got ('tiles',)" in other.error


def test_the_only_frame_of_a_clip_is_said_to_be_its_training_frame(tmp_path: Path, vesselsplat: Cli) -> None:
    clip, run = tmp_path / "clip", tmp_path / "run"
    write_phantom(clip, PhantomParams(n_frames=1, width=64, height=48), "endonerf")
    assert vesselsplat("train", clip, "--run", run, "--iterations", 3).code == 0
    report = json.loads(vesselsplat("evaluate", run, "--json").out)
    assert (report["frames_are"], [frame["index"] for frame in report["frames"]]) == ("training", [0])
    assert "training frames" in vesselsplat("evaluate", run).out
    call = vesselsplat("render", run, "--out", tmp_path / "out", "--frames", "test")
    assert (call.code, call.error.count("\n"), "--frames all" in call.error) == (2, 1, True)
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("count", [1, 2, 9, 10, 63])
def test_a_record_holds_out_the_frames_of_its_clip(
    runs: dict[str, Path], clip_path: Path, count: int
) -> None:
    record, clip = RunFolder(runs["original"]).record(), open_clip(clip_path)
    short = replace(record, clip=replace(record.clip, frames=count))
    assert short.test_indices == replace(clip, cameras=clip.cameras[:1] * count).test_indices


def test_a_demo_on_a_full_disk_leaves_no_folder(
    vesselsplat: Cli, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, clip_path: Path
) -> None:
    def full(path: Path, *rest: object) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(path))

    monkeypatch.setattr("app.commands.demo.phantom_path", lambda: clip_path)
    monkeypatch.setattr("app.commands.demo.write_png", full)
    called = vesselsplat("demo", "--headless", "--out", tmp_path / "demo")
    assert called.code == 2
    assert "No space left on device" in called.error
    assert list(tmp_path.iterdir()) == []


def test_the_demo_leaves_sheets_and_a_report_and_can_be_repeated(
    clip_path: Path, tmp_path: Path, vesselsplat: Cli, monkeypatch: pytest.MonkeyPatch
) -> None:
    """An earlier one of a small clip, and that of the embedded phantom in its place."""
    monkeypatch.setattr("app.commands.demo.CONFIG", TrainConfig(iterations=6, n_gaussians=1000))
    with monkeypatch.context() as patch:
        patch.setattr("app.commands.demo.phantom_path", lambda: clip_path)
        assert vesselsplat("demo", "--headless", "--out", tmp_path / "demo").code == 0
    assert vesselsplat("demo", "--headless", "--out", tmp_path / "demo").code == 0
    out = tmp_path / "demo"
    names = {"compare.png", "strip.png", "report.json", "enhanced", "original-run", "enhanced-run"}
    assert {path.name for path in out.iterdir()} == names
    report = json.loads((out / "report.json").read_text())
    assert {"train original", "train enhanced", "evaluate"} <= set(report["seconds"])
    assert report["runs"]["enhanced"]["mean"]["psnr"] > 10
    for sheet in ("compare.png", "strip.png"):
        assert read_provenance(out / sheet)["source"]["name"] == "phantom"
    assert str(tmp_path) not in (out / "report.json").read_text()
