"""`vesselsplat export` refuses flags that none of its files heeds, and says what becomes of the others."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from app.exports.replay.recorded import recorded
from app.runs.run_folder import RunFolder
from tests.app.conftest import Cli


@pytest.mark.parametrize(
    ("flags", "said"),
    [
        (("--usd", "a.usdc", "--frames", "2"), "--frames: --usd holds all of the clip"),
        (("--4dgs", "a.4dgs", "--time", "0.5"), "--time: --4dgs holds all of the clip"),
        (("--html", "a.html", "--frames", "2"), "--frames: --html holds all of the clip"),
        (("--mesh", "a.glb", "--path", "p.json"), "--path: --mesh holds all of the clip"),
        (("--ply", "ply", "--mesh", "a.usdc", "--frames", "2"), "--frames: --mesh holds all of the clip"),
        (("--ply", "ply", "--camera", "a.json"), "--camera: expected an export that it applies to, such as "),
        (("--usd", "a.usdc", "--size", "64", "48"), "--size: expected an export that it applies to"),
        (
            ("--html", "a.html", "--view", "motion"),
            "--view: expected an export that it applies to, such as --v",
        ),
        (("--npz", "a.npz", "--background", "black"), "--background: expected an export that it applies"),
        (("--cameras", "a.json", "--supersampling", "2"), "--supersampling: expected an export that"),
        (("--cameras", "a.json", "--with", "reference"), "--with: expected an export that it applies"),
        (
            ("--html", "a.html", "--camera", "cameras.json"),
            "--html: expected one --camera, got 2: cameras.json",
        ),
        (
            ("--ply", "ply", "--faces", "500"),
            "--faces: expected an export that it applies to, such as --mesh",
        ),
        (("--ply", "ply", "--vertices", "2000"), "--vertices: expected an export that it applies to"),
        (("--ply", "ply", "--mesh-format", "obj"), "--mesh-format: expected an export that it applies to"),
        (("--ply", "ply", "--cameras-format", "colmap"), "--cameras-format: expected an export that"),
        (
            ("--ply", "ply", "--frames-per-second", "3"),
            "--frames-per-second: expected an export through time",
        ),
        (("--ply", "ply", "--html", "x.txt"), "--html: expected the name of an .html file, got x.txt"),
        (("--ply", "ply", "--html", "/"), "--html: expected the name of an .html file, got /"),
        (
            ("--ply", "ply", "--cameras", "c.txt", "--cameras-format", "colmap"),
            "--cameras: expected a folder for COLMAP, got c.txt",
        ),
        (("--ply", "ply", "--cameras", "0.png"), "--cameras: expected the name of a .json file, got 0.png"),
        (
            ("--ply", "ply", "--cameras", "folder", "--cameras-format", "transforms"),
            "--cameras: expected the name of a .json file, got folder",
        ),
        (("--ply", "ply", "--tracks", "x.csv", "--points", "500,5"), "got 500,5 at frame 0, counted from 0"),
        (
            ("--ply", "ply", "--video", "a.mp4", "--view", "difference", "--time", "0.5"),
            "--view difference: expected frames of a run",
        ),
        (("--ply", "{run}"), "--ply: expected a place outside the run {run}, got "),
        (("--video", "{run}/a.mp4"), "--video: expected a place outside the run {run}, got "),
    ],
)
def test_what_no_file_heeds_is_refused(
    runs: dict[str, Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, vesselsplat: Cli,
    flags: tuple[str, ...], said: str,
) -> None:  # fmt: skip
    run = runs["original"]
    monkeypatch.chdir(tmp_path)
    assert vesselsplat("export", run, "--cameras", "cameras.json", "--frames", 0, 0, 5).code == 0
    before = sorted(run.iterdir())
    call = vesselsplat("export", run, *(one.format(run=run) for one in flags))
    assert (call.code, call.error.count("\n")) == (2, 1)
    assert said.format(run=run) in call.error
    assert [path.name for path in tmp_path.iterdir()] == ["cameras.json"]
    assert sorted(run.iterdir()) == before


def test_a_page_opens_as_the_camera_that_is_given(
    runs: dict[str, Path], tmp_path: Path, vesselsplat: Cli
) -> None:
    camera = RunFolder(runs["original"]).record().cameras[5].shaped(80, 60)
    (tmp_path / "one.json").write_text(json.dumps(camera.to_json()))
    page = tmp_path / "a.html"
    call = vesselsplat("export", runs["original"], "--html", page, "--camera", tmp_path / "one.json")
    assert call.code == 0, call.error
    assert (recorded(page)["camera"]["width"], recorded(page)["camera"]["height"]) == (80, 60)


def test_an_odd_size_is_told_and_a_frame_is_written_once(
    runs: dict[str, Path], tmp_path: Path, vesselsplat: Cli
) -> None:
    video, splats = tmp_path / "a.mp4", tmp_path / "ply"
    flags = ("--video", video, "--size", 33, 21, "--frames", 0, "0:1", 0)
    call = vesselsplat("export", runs["original"], *flags, "--ply", splats)
    assert call.code == 0
    assert f"the codec needs even sizes: 33x21 was cut to 32x20: {video}\n" in call.error
    assert f"{splats}: 2 splat files" in call.out
    assert len(list(splats.iterdir())) == 2


@pytest.mark.parametrize("flags", [("--ply", "."), ("--mesh", "../series"), ("--mesh", "frame-000000.glb")])
def test_a_splat_file_and_its_series_are_never_overwritten(
    runs: dict[str, Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, vesselsplat: Cli,
    flags: tuple[str, str],
) -> None:  # fmt: skip
    series = tmp_path / "series"
    asked = ("--ply", series, "--glb", series, "--frames", 0, 1)
    assert vesselsplat("export", runs["original"], *asked).code == 0
    before = {path.name: path.read_bytes() for path in series.iterdir()}
    monkeypatch.chdir(series)
    given = "frame-000000.glb" if flags[1].endswith(".glb") else "frame-000001.ply"
    call = vesselsplat("export", given, *flags)
    assert (call.code, call.error.count("\n")) == (2, 1)
    assert f"{flags[0]}: expected a place apart from the splat file {given}, got " in call.error
    assert {path.name: path.read_bytes() for path in series.iterdir()} == before
    assert vesselsplat("export", given, "--ply", tmp_path / "other").code == 0


def test_nothing_is_written_among_the_files_of_a_run_or_its_clip(
    runs: dict[str, Path], clip_path: Path, vesselsplat: Cli
) -> None:
    run = runs["original"]
    for command, flag in (("render", "--out"), ("export", "--ply")):
        for out, what in ((run, f"run {run}"), (run / "views" / "a", f"run {run}"), (
            clip_path / "images", f"clip of the run {clip_path}",
        )):  # fmt: skip
            before = sorted(out.glob("*"))
            call = vesselsplat(command, run, flag, out)
            assert (call.code, call.error.count("\n")) == (2, 1)
            assert f"{flag}: expected a place outside the {what}, got {out}" in call.error
            assert sorted(out.glob("*")) == before
