"""The comparison that ships: complete, by the published rules, beside published figures."""

from __future__ import annotations

import tomllib
from importlib.resources import files
from pathlib import Path

import numpy as np
from PIL import Image

from app.commands.protocol import compared
from app.sweeps.jobs import JobFolder
from app.sweeps.plan import planned, write_sweep
from app.sweeps.settings import Training
from app.sweeps.spec import spec_of
from tests.app.conftest import Cli
from tests.renderer.readers.numbered import encoded


def test_it_prints_a_sweep_that_runs_every_method_at_its_published_length(
    vesselsplat: Cli, clip_path: Path, tmp_path: Path
) -> None:
    printed = vesselsplat("protocol", "--print")
    assert printed.out == files("app.sweeps").joinpath("protocol.toml").read_text()
    whole = vesselsplat("protocol", clip_path, "--print")
    assert tomllib.loads(whole.out) == tomllib.loads(printed.out) | {"clips": [str(clip_path)]}
    for flag in ("--json", "--retry"):
        refused = vesselsplat("protocol", clip_path, "--print", flag)
        assert (refused.code, refused.out) == (2, "")
        assert f"{flag} has no effect with --print" in refused.error
    spec = spec_of(tomllib.loads(whole.out), tmp_path / "protocol.toml")
    plan = planned(spec, tmp_path / "protocol.toml")
    settings = [job.settings for job in plan.jobs]
    assert len(settings) == 4 * 3
    assert all(isinstance(one, Training) and one.config.iterations == 3000 for one in settings)
    assert all(isinstance(one, Training) and one.options.split == "field" for one in settings)
    methods = {one.config.method for one in settings if isinstance(one, Training)}
    assert methods == {"vesselsplat", "deform3dgs", "endogaussian", "static"}


def test_any_name_of_a_clip_is_printed_as_toml_reads_it(vesselsplat: Cli, tmp_path: Path) -> None:
    clips = [tmp_path / name for name in ("c\N{GRINNING FACE}", "a\x7fb", 'q"\\u0041', "é\n")]
    printed = vesselsplat("protocol", *clips, "--print")
    assert tomllib.loads(printed.out)["clips"] == [str(path) for path in clips]


def test_a_video_without_depth_is_refused_before_the_first_job(vesselsplat: Cli, tmp_path: Path) -> None:
    video = encoded(tmp_path / "a.mp4", [np.zeros((48, 64, 3), np.uint8)] * 3)
    called = vesselsplat("protocol", video, "--out", tmp_path / "out")
    assert (called.code, called.out, called.error.count("\n")) == (2, "", 1)
    assert "expected clips with depth, got a video, which has none" in called.error
    assert called.error.endswith(f": {video}\n")
    assert not (tmp_path / "out").exists()
    path = tmp_path / "sweep.toml"
    for found in ({"grid": {"depth": ["auto", "brightness"]}}, {"settings": {"stereo": "side-by-side"}}):
        assert planned(spec_of({"clips": [str(video)], "task": "train"} | found, path), path).jobs


def test_images_without_depth_are_refused_before_the_first_job(vesselsplat: Cli, tmp_path: Path) -> None:
    folder = tmp_path / "images"
    folder.mkdir()
    for name in "ab":
        Image.fromarray(np.full((48, 64, 3), 90, np.uint8)).save(folder / f"{name}.png")
    for clip, got in ((folder, "a folder of images without any"), (folder / "a.png", "one image")):
        called = vesselsplat("protocol", clip, "--out", tmp_path / "out")
        assert (called.code, called.out, called.error.count("\n")) == (2, "", 1)
        assert f"expected clips with depth, got {got}" in called.error
        assert not (tmp_path / "out").exists()
    path, given = tmp_path / "sweep.toml", {"clips": [str(folder)], "task": "train"}
    assert planned(spec_of(given | {"grid": {"depth": ["auto", "brightness"]}}, path), path).jobs
    (folder / "b.png").write_bytes(b"damaged")
    (tmp_path / "text.mp4").write_text("no video")
    for clip, said in (
        (folder, "expected an image, got"),
        (tmp_path / "text.mp4", "expected an image or a video, got"),
    ):
        called = vesselsplat("protocol", clip, "--out", tmp_path / "out")
        assert (called.code, called.out, called.error.count("\n")) == (2, "", 1)
        assert said in called.error
        assert not (tmp_path / "out").exists()


def test_rows_of_a_known_clip_stand_beside_the_published_ones(clip_path: Path, tmp_path: Path) -> None:
    pulling = tmp_path / "pulling_soft_tissues"
    pulling.symlink_to(clip_path)
    given = {"clips": [str(pulling)], "task": "train", "seeds": [0, 1], "variants": [{"method": "static"}]}
    plan = planned(spec_of(given, path := tmp_path / "sweep.toml"), path)
    write_sweep(plan, tmp_path / "out")
    for psnr, job in zip((30.0, 32.0), plan.jobs, strict=True):
        JobFolder.of(tmp_path / "out", job.key).finish(job, {"measures": {"psnr": psnr}, "seconds": 1.0})
    table = compared(tmp_path / "out")
    ours, *published = table.rows
    assert ours[:3] == ("pulling_soft_tissues", "static", 31.0)
    assert ours[-1] == "measured here, 2 seeds"
    assert ("pulling_soft_tissues", "EndoGaussian", 37.21) in [row[:3] for row in published]
    assert all(row[-1] for row in published)


def test_without_clips_it_says_what_it_expects(vesselsplat: Cli) -> None:
    called = vesselsplat("protocol")
    assert (called.code, called.error.count("\n")) == (2, 1)
    assert "expected CLIP... and --out DIR, or --print" in called.error


def test_a_number_of_workers_that_cannot_be_is_refused_before_anything_is_written(
    vesselsplat: Cli, clip_path: Path, tmp_path: Path
) -> None:
    for number in ("0", "-1", "two"):
        called = vesselsplat("protocol", clip_path, "--out", tmp_path / "out", "--workers", number)
        assert (called.code, called.error.count("\n")) == (2, 1)
        assert f"--workers: expected 1 or more, got '{number}'" in called.error
        assert not (tmp_path / "out").exists()
