"""`vesselsplat replay`: the same pixels again from what a file says of itself, and what is said when not."""

from __future__ import annotations

import csv
import json
import shutil
from pathlib import Path

import cv2
import numpy as np
import pytest

from app.enhancement.frame_enhancer import PictureRequest
from app.enhancement.image_mask import PictureMask
from app.enhancement.settable import Scope
from app.exports.replay.again import replay
from app.exports.replay.difference import difference
from app.files.image_files import read_image
from app.files.provenance import read_provenance, write_png, write_sidecar
from app.gui.work.opening import OpenRequest, open_path
from app.runs.run_changes import rename_run
from app.scenes.free_camera import FreeView
from app.scenes.view_request import ViewRequest
from assets import phantom_path
from enhance import EnhanceParams
from enhance.vessel import VesselParams
from renderer.sources import open_clip
from renderer.splat_files.inria_ply import ply_bytes
from tests.app.conftest import Cli
from tests.app.gui.saving import saved
from tests.renderer.splat_files.files import gaussians


def changed(path: Path, **facts: object) -> None:
    """Write other facts into a picture, whose pixels stay."""
    write_png(path, read_image(path), read_provenance(path) | facts)


@pytest.mark.parametrize(
    "flags",
    [
        (),
        ("--z", "0.3", "--p", "0.4", "0.5", "0.6", "--d-factor", "2"),
        ("--statistics", "clip", "--pixels", "tissue"),
        ("--pixels", "tissue"),
        ("--method", "vessel", "--strength", "1.5"),
        ("--method", "clahe"),
    ],
)
def test_enhanced_pictures_come_again(
    folder: Path, tmp_path: Path, vesselsplat: Cli, flags: tuple[str, ...]
) -> None:
    assert vesselsplat("enhance", folder, tmp_path / "out", *flags).code == 0
    for name in ("0.png", "2.png"):
        call = vesselsplat("replay", tmp_path / "out" / name, "--source", folder)
        assert (call.code, call.error) == (0, "")
        assert call.out.endswith(": identical\n")


@pytest.mark.parametrize("suffix", [".tiff", ".jpg", ".npy"])
def test_other_formats_come_again(folder: Path, tmp_path: Path, vesselsplat: Cli, suffix: str) -> None:
    out, again = folder / f"out{suffix}", tmp_path / f"again{suffix}"
    assert vesselsplat("enhance", folder / "1.png", out).code == 0
    assert vesselsplat("replay", out, "--out", again).code == 0
    assert np.array_equal(read_image(again), read_image(out))
    assert vesselsplat("replay", again, "--source", folder).code == 0


@pytest.mark.parametrize("suffix", [".tiff", ".jpg"])
def test_files_of_before_come_again_by_the_file_beside_them(
    folder: Path, vesselsplat: Cli, suffix: str
) -> None:
    """JPEG and TIFF did not carry their provenance themselves."""
    out = folder / f"out{suffix}"
    assert vesselsplat("enhance", folder / "1.png", out).code == 0
    write_sidecar(out, read_provenance(out))
    out.write_bytes(cv2.imencode(suffix, cv2.imread(str(out)), [cv2.IMWRITE_JPEG_QUALITY, 100])[1].tobytes())
    call = vesselsplat("replay", out, "--json")
    assert json.loads(call.out)["replayed"]["kind"] == "enhanced picture"
    assert call.code == (0 if suffix == ".tiff" else 2)  # A JPEG that was encoded twice has changed.
    out.with_name(f"{out.name}.json").unlink()
    call = vesselsplat("replay", out)
    assert f"{out.name}.json" in call.error


def test_json_that_holds_no_provenance_is_told_as_such(tmp_path: Path, vesselsplat: Cli) -> None:
    path = tmp_path / "cameras.json"
    path.write_text("[]")
    call = vesselsplat("replay", path)
    assert call.code == 2
    assert call.error == (
        f"vesselsplat: expected an export that tells how it was made, got JSON, as of cameras: {path}\n"
    )


def test_an_enhanced_video_comes_again(folder: Path, vesselsplat: Cli) -> None:
    out = folder.parent / "out.mp4"
    assert vesselsplat("enhance", folder, out, "--statistics", "clip").code == 0
    call = vesselsplat("replay", out, "--source", folder)
    assert (call.code, call.error) == (0, "")
    second = folder.parent / "twice.mp4"
    assert vesselsplat("enhance", out, second).code == 0
    assert vesselsplat("replay", second, "--json").code == 0


@pytest.mark.gl
@pytest.mark.parametrize("renderer", ["cpu", "gl"])
def test_renders_and_depth_come_again(
    runs: dict[str, Path], tmp_path: Path, vesselsplat: Cli, renderer: str
) -> None:
    flags = ("--frames", 3, "--depth", "--with", renderer, *(["--transparent"] if renderer == "gl" else []))
    assert vesselsplat("render", runs["enhanced"], "--out", tmp_path, *flags).code == 0
    for name in ("frame-000003.png", "frame-000003-depth.png", "frame-000003-depth.npy"):
        call = vesselsplat("replay", tmp_path / name, "--source", runs["enhanced"], "--json")
        assert (call.code, call.error) == (0, "")
        assert json.loads(call.out)["identical"]


def test_exports_come_again(runs: dict[str, Path], tmp_path: Path, vesselsplat: Cli) -> None:
    video, ply = tmp_path / "a.mp4", tmp_path / "frame-000004.ply"
    flags = ("--ply", tmp_path, "--video", video, "--frames", 2, 4)
    assert vesselsplat("export", runs["original"], *flags).code == 0
    for path in (video, ply):
        call = vesselsplat("replay", path, "--source", runs["original"].parent)
        assert (call.code, call.error) == (0, "")
    assert vesselsplat("render", ply, "--out", tmp_path, "--size", 64, 48).code == 0
    call = vesselsplat("replay", tmp_path / "frame-000000.png")  # The splat file lies beside it.
    assert (call.code, call.error) == (0, "")


def test_an_export_comes_again_from_the_runs_that_the_window_keeps(
    runs: dict[str, Path], tmp_path: Path, vesselsplat: Cli, monkeypatch: pytest.MonkeyPatch
) -> None:
    kept = tmp_path / "kept"
    monkeypatch.setenv("VESSELSPLAT_RUNS_DIR", str(kept))
    monkeypatch.chdir(tmp_path)
    out = tmp_path / "render" / "out"
    assert vesselsplat("render", runs["original"], "--out", out, "--frames", 1).code == 0
    (picture,) = out.glob("*.png")
    found = vesselsplat("replay", picture)
    assert (found.code, "found none" in found.error) == (2, True)
    shutil.copytree(runs["enhanced"], kept / runs["original"].name)
    shutil.copytree(runs["original"], kept / "first")
    rename_run(kept / "first", "another name")
    assert vesselsplat("replay", picture).code == 0


def test_a_splat_file_of_before_comes_again(runs: dict[str, Path], tmp_path: Path, vesselsplat: Cli) -> None:
    """With its provenance in one long line."""
    assert vesselsplat("export", runs["original"], "--ply", tmp_path, "--frames", 4).code == 0
    path = tmp_path / "frame-000004.ply"
    content = path.read_bytes()
    assert content.count(b"\ncomment vesselsplat+ ") > 2
    path.write_bytes(content.replace(b"\ncomment vesselsplat+ ", b""))
    call = vesselsplat("replay", path, "--source", runs["original"].parent)
    assert (call.code, call.error) == (0, "")


def test_a_source_may_have_several_spaces_in_its_name(tmp_path: Path, vesselsplat: Cli) -> None:
    file = tmp_path / "two  and   three spaces.ply"
    file.write_bytes(ply_bytes(gaussians(5)))
    assert vesselsplat("export", file, "--ply", tmp_path / "out").code == 0
    call = vesselsplat("replay", tmp_path / "out" / "frame-000000.ply", "--source", tmp_path)
    assert (call.code, call.error) == (0, "")


@pytest.mark.parametrize("view", ["motion", "difference"])
def test_videos_of_kinds_of_view_come_again(
    runs: dict[str, Path], tmp_path: Path, vesselsplat: Cli, view: str
) -> None:
    video = tmp_path / "a.mp4"
    assert vesselsplat("export", runs["enhanced"], "--video", video, "--view", view).code == 0
    facts = json.loads(video.with_name("a.mp4.json").read_text())
    assert facts["view"] == view
    assert facts["scale"]["high"] > 0
    call = vesselsplat("replay", video, "--source", runs["enhanced"].parent)
    assert (call.code, call.error) == (0, "")
    facts["scale"]["high"] *= 2
    video.with_name("a.mp4.json").write_text(json.dumps(facts))
    assert vesselsplat("replay", video, "--source", runs["enhanced"].parent).code == 2


@pytest.mark.parametrize("params", [None, EnhanceParams(d_factor=0.5), VesselParams(lift=0.4)])
@pytest.mark.parametrize("scope", ["image", "clip"])
def test_a_screenshot_comes_again(
    runs: dict[str, Path], tmp_path: Path, params: EnhanceParams | VesselParams | None, scope: Scope
) -> None:
    clip = open_clip(phantom_path())
    box = PictureMask(text=(10, 10, 90, 60))
    wanted = PictureRequest(clip, 3, params, scope, pixels="tissue", mask=box, span=(2, 6))
    (opened,) = open_path(OpenRequest(runs["original"]))
    assert opened.run is not None
    assert opened.run.model is not None
    model = opened.run.model
    free = FreeView.of(model.camera_at(0.3)).looked(0.1, 0.02)
    view = ViewRequest.fitted(model, 0.3, free, (70, 50))
    path, again = saved(tmp_path / "pictures", wanted, view), tmp_path / "again.png"
    assert replay(path, (runs["original"],), again).difference.is_none
    assert np.array_equal(read_image(again), read_image(path))


def test_a_changed_parameter_is_found_out(folder: Path, vesselsplat: Cli) -> None:
    out = folder / "out.png"
    assert vesselsplat("enhance", folder / "1.png", out, "--z", "0.3").code == 0
    facts = read_provenance(out)
    changed(out, params=facts["params"] | {"z": 0.35})
    call = vesselsplat("replay", out, "--json")
    assert call.code == 2
    assert call.error.count("\n") == 1
    assert "has been changed since" in call.error
    found = json.loads(call.out)
    assert not found["identical"]
    assert found["replayed"]["difference"]["largest"] >= 1


def test_another_version_and_driver_are_named(
    runs: dict[str, Path], tmp_path: Path, vesselsplat: Cli
) -> None:
    assert vesselsplat("render", runs["original"], "--out", tmp_path, "--frames", 3).code == 0
    path = tmp_path / "frame-000003.png"
    image = read_image(path)
    image[0, 0] ^= 1
    facts = read_provenance(path)
    libraries = facts["libraries"] | {"numba": "0.1"}
    write_png(path, image, facts | {"version": "0.0.1", "renderer": "numba", "libraries": libraries})
    call = vesselsplat("replay", path, "--source", runs["original"])
    assert call.code == 2
    for words in ("VesselSplat 0.0.1, here ", "numba 0.1, here ", "renderer numba, here numba on the CPU"):
        assert words in call.error
    assert "by at most 1 of 255" in call.error


@pytest.mark.parametrize(
    "facts",
    [
        {"libraries": None},
        {"libraries": ["numpy"]},
        {"libraries": {"processor": 3}},
        {"views": 3},
        {"views": [3]},
        {"views": []},
    ],
)
def test_what_is_told_beside_in_another_form_keeps_no_file_from_being_made_again(
    facts: dict[str, object], folder: Path, vesselsplat: Cli
) -> None:
    """As by another version, or by hand."""
    out = folder / "out.png"
    assert vesselsplat("enhance", folder / "1.png", out).code == 0
    changed(out, **facts)
    call = vesselsplat("replay", out)
    assert call.out.rstrip().endswith("identical"), call.error


def test_a_missing_or_changed_source_is_one_line(folder: Path, tmp_path: Path, vesselsplat: Cli) -> None:
    out = tmp_path / "out" / "1.png"
    assert vesselsplat("enhance", folder / "1.png", out).code == 0
    call = vesselsplat("replay", out)
    assert (call.code, call.error.count("\n")) == (2, 1)
    assert "expected the source 1.png beside" in call.error
    cv2.imwrite(str(folder / "1.png"), np.zeros((4, 4, 3), np.uint8))
    call = vesselsplat("replay", out, "--source", folder)
    assert (call.code, call.error.count("\n")) == (2, 1)
    assert "has changed since 1.png was made" in call.error


def test_a_source_that_is_not_there_is_one_line(folder: Path, tmp_path: Path, vesselsplat: Cli) -> None:
    vesselsplat("enhance", folder / "1.png", tmp_path / "made.png")
    called = vesselsplat("replay", tmp_path / "made.png", "--source", tmp_path / "none")
    wanted = "--source: expected a file or folder, got no such path"
    assert (called.code, called.error) == (2, f"vesselsplat: {wanted}: {tmp_path / 'none'}\n")


def test_a_source_is_known_by_its_bytes(folder: Path, tmp_path: Path, vesselsplat: Cli) -> None:
    out = tmp_path / "out.png"
    assert vesselsplat("enhance", folder / "1.png", out).code == 0
    moved = Path(shutil.move(folder / "1.png", tmp_path / "another name.png"))
    assert vesselsplat("replay", out, "--source", moved).code == 0


def test_what_cannot_be_made_again_is_one_line(
    folder: Path, runs: dict[str, Path], tmp_path: Path, vesselsplat: Cli
) -> None:
    out = folder / "out.png"
    assert vesselsplat("enhance", folder / "1.png", out).code == 0
    facts = read_provenance(out)
    cases: list[tuple[dict[str, object], str]] = [
        ({"kind": "poster"}, "got kind poster"),
        ({"params": facts["params"] | {"z": 7}}, "has invalid provenance"),
        ({"source": {"name": "1.png"}}, "sha256"),
        ({"method": "magic"}, "magic"),
        ({"bits": 99}, "out.png has invalid provenance"),
    ]
    for wrong, said in cases:
        changed(out, **facts | wrong)
        call = vesselsplat("replay", out)
        assert (call.code, call.error.count("\n")) == (2, 1)
        assert said in call.error
    for path in (folder / "0.png", folder / "none.png", runs["original"] / "run.json"):
        call = vesselsplat("replay", path)
        assert (call.code, call.error.count("\n")) == (2, 1)
    changed(out, **facts)
    for target in (out, tmp_path / "again.jpg"):
        call = vesselsplat("replay", out, "--out", target)
        assert (call.code, "--out" in call.error) == (2, True)


def test_no_file_is_overwritten_by_what_is_made_again(folder: Path, vesselsplat: Cli) -> None:
    source, out = folder / "1.png", folder / "out.png"
    assert vesselsplat("enhance", source, out).code == 0
    before = source.read_bytes()
    call = vesselsplat("replay", out, "--out", source)
    assert (call.code, "expected a new file, got one that exists" in call.error) == (2, True)
    assert source.read_bytes() == before


def test_no_file_beside_what_is_made_again_is_overwritten(folder: Path, vesselsplat: Cli) -> None:
    out, again = folder / "out.npy", folder / "again.npy"
    assert vesselsplat("enhance", folder / "1.png", out).code == 0
    theirs = folder / "again.npy.json"
    theirs.write_text("another's")
    call = vesselsplat("replay", out, "--out", again)
    assert (call.code, call.error.count("\n")) == (2, 1)
    assert f"expected a new file, got one that exists: {theirs}" in call.error
    assert theirs.read_text() == "another's"
    assert not again.exists()


def test_difference_counts_values_and_frames(tmp_path: Path) -> None:
    one, other = np.zeros((4, 5, 3)), np.zeros((4, 5, 3))
    one[0, 0, 0] = other[0, 0, 0] = np.nan
    other[1, 1, 1] = 0.5
    for name, array in (("a", one), ("b", other), ("c", np.zeros((5, 4, 3)))):
        np.save(tmp_path / f"{name}.npy", array)
    a, b, c = (tmp_path / f"{name}.npy" for name in "abc")
    assert difference(a, a).is_none
    assert (difference(a, b).largest, difference(a, b).share) == (0.5, 1 / 60)
    assert "shape" in difference(a, c).text


@pytest.mark.parametrize("label", ["a\u2028b", "a\x85b", "a\x0bb", "a\nb"])
def test_a_table_is_read_row_by_row_whatever_signs_a_label_has(tmp_path: Path, label: str) -> None:
    for name, value in (("a", 1), ("b", 2)):
        path = tmp_path / f"{name}.csv"
        with path.open("w", encoding="utf-8", newline="") as file:
            csv.writer(file).writerows([("frame", "label", "dv"), (0, label, value)])
        (tmp_path / f"{name}.csv.json").write_text("{}")
    a, b = tmp_path / "a.csv", tmp_path / "b.csv"
    assert difference(a, a).is_none
    assert difference(a, b).largest == 1


@pytest.mark.parametrize("name", ["/etc/hostname", "../1.png", "..\\1.png", "a/1.png", "..", "", "1.png\0"])
def test_sources_are_looked_up_by_bare_names_alone(
    folder: Path, tmp_path: Path, vesselsplat: Cli, name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A file of anyone's says where its source is: nothing is opened, hashed or told of places elsewhere."""
    assert vesselsplat("enhance", folder / "1.png", tmp_path / "deep" / "out.png").code == 0
    out = tmp_path / "deep" / "out.png"
    shutil.copyfile(folder / "1.png", tmp_path / "1.png")
    changed(out, source=read_provenance(out)["source"] | {"name": name})
    looked_at: list[Path] = []
    monkeypatch.setattr("app.exports.replay.sources.digest", looked_at.append)
    call = vesselsplat("replay", out)
    assert call.code == 2
    assert call.error.count("\n") == 1
    assert looked_at == []
    monkeypatch.undo()
    assert vesselsplat("replay", out, "--source", folder / "1.png").code == 0


def test_a_link_that_leads_out_of_the_folder_is_no_source(
    folder: Path, tmp_path: Path, vesselsplat: Cli
) -> None:
    place = tmp_path / "place"
    assert vesselsplat("enhance", folder / "1.png", place / "out.png").code == 0
    (place / "1.png").symlink_to(folder / "1.png")
    assert vesselsplat("replay", place / "out.png").code == 2
    assert vesselsplat("replay", place / "out.png", "--source", place / "1.png").code == 0
    # Within the folder a link is a name like another.
    shutil.copyfile(folder / "1.png", place / "kept.png")
    (place / "1.png").unlink()
    (place / "1.png").symlink_to(place / "kept.png")
    assert vesselsplat("replay", place / "out.png").code == 0
