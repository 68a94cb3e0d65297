"""Splat files of other programs, from the command line: rendered, described, reproduced."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import cv2
import pytest

from app.files.provenance import read_provenance
from renderer.splat_files.inria_ply import ply_bytes
from tests.app.conftest import Cli
from tests.renderer.splat_files.files import gaussians
from tests.renderer.splat_files.ksplat_files import ksplat
from tests.renderer.splat_files.sog_files import bundled, sog


def rendered(vesselsplat: Cli, path: Path, out: Path) -> Path:
    assert vesselsplat("render", path, "--out", out, "--size", 48, 64).code == 0
    return out / "frame-000000.png"


def test_an_unpacked_sog_is_a_source_with_all_of_its_files(tmp_path: Path, vesselsplat: Cli) -> None:
    """Its list counts as its images do, be the folder or the list named."""
    folder = tmp_path / "scene"
    folder.mkdir()
    for name, content in sog(gaussians(40, 3)).items():
        (folder / name).write_bytes(content)
    picture = rendered(vesselsplat, folder, tmp_path / "out")
    by_list = rendered(vesselsplat, folder / "meta.json", tmp_path / "list")
    facts = [read_provenance(path)["splats"] for path in (picture, by_list)]
    assert facts[0] == facts[1]
    assert facts[0]["name"] == "scene"
    assert vesselsplat("replay", picture, "--source", folder).code == 0
    listed = json.loads((folder / "meta.json").read_text())
    listed["scales"]["codebook"][7] += 0.1
    (folder / "meta.json").write_text(json.dumps(listed))
    call = vesselsplat("replay", picture, "--source", folder)
    assert call.code == 2
    assert "has changed" in call.error


@pytest.mark.parametrize("name", ["a.sog", "a.ksplat"])
def test_other_formats_are_drawn_and_described(tmp_path: Path, vesselsplat: Cli, name: str) -> None:
    raw = gaussians(40, 3)
    raw = replace(raw, log_scales=raw.log_scales + 2)
    path = tmp_path / name
    path.write_bytes(bundled(sog(raw)) if name == "a.sog" else ksplat(raw, level=0))
    call = vesselsplat("info", path, "--json")
    assert call.code == 0
    facts = json.loads(call.out)
    assert facts["what"] == {"kind": "splats", "format": path.suffix}
    assert facts["model"]["gaussians"] == 40
    image = cv2.imread(str(rendered(vesselsplat, path, tmp_path / "out")))
    (tmp_path / "a.ply").write_bytes(ply_bytes(raw))
    plain = cv2.imread(str(rendered(vesselsplat, tmp_path / "a.ply", tmp_path / "plain")))
    assert image.std() > 10
    # Of 16-bit positions and 8-bit colours of 0 to 1.
    assert cv2.PSNR(image, plain) > 25


def test_a_run_as_compressed_ply_comes_again_by_any_name(
    runs: dict[str, Path], tmp_path: Path, vesselsplat: Cli
) -> None:
    flags = ("--compressed-ply", tmp_path / "small", "--ply", tmp_path / "plain", "--frames", 4)
    call = vesselsplat("export", runs["original"], *flags)
    assert (call.code, call.error) == (0, "")
    (path,) = (tmp_path / "small").iterdir()
    assert path.name == "frame-000004.compressed.ply"
    plain = tmp_path / "plain" / "frame-000004.ply"
    assert path.stat().st_size < plain.stat().st_size / 3
    renamed = path.with_name("renamed.ply")
    path.rename(renamed)
    call = vesselsplat("replay", renamed, "--source", runs["original"].parent)
    assert (call.code, call.error) == (0, "")
    first, second = (rendered(vesselsplat, one, tmp_path / one.stem) for one in (renamed, plain))
    assert cv2.PSNR(cv2.imread(str(first)), cv2.imread(str(second))) > 45


@pytest.mark.parametrize("suffix", [".spz", ".sog"])
def test_a_run_is_exported_small_and_comes_again(
    runs: dict[str, Path], tmp_path: Path, vesselsplat: Cli, suffix: str
) -> None:
    """With its provenance beside it, which `info` tells and `replay` makes the file of."""
    flags = (f"--{suffix[1:]}", tmp_path / "small", "--ply", tmp_path / "plain", "--frames", 2, 4)
    call = vesselsplat("export", runs["original"], *flags, "--sh-degree", 1)
    assert (call.code, call.error) == (0, "")
    names = sorted(path.name for path in (tmp_path / "small").iterdir())
    stems = ("frame-000002", "frame-000004")
    assert names == sorted(f"{stem}{suffix}{more}" for stem in stems for more in ("", ".json"))
    path = tmp_path / "small" / f"frame-000004{suffix}"
    plain = tmp_path / "plain" / "frame-000004.ply"
    assert path.stat().st_size < plain.stat().st_size / 3
    facts = json.loads(vesselsplat("info", path, "--json").out)
    assert facts["what"]["format"] == suffix
    assert facts["run"]["name"] == "original"
    call = vesselsplat("replay", path, "--source", runs["original"].parent)
    assert (call.code, call.error) == (0, "")
    told = json.loads(path.with_name(f"{path.name}.json").read_text())
    assert (told["kind"], told["frame"], told["sh_degree"]) == ("splats", 4, 1)
    first, second = (rendered(vesselsplat, one, tmp_path / one.suffix[1:]) for one in (path, plain))
    assert cv2.PSNR(cv2.imread(str(first)), cv2.imread(str(second))) > 35


def test_a_changed_splat_file_is_found_out(runs: dict[str, Path], tmp_path: Path, vesselsplat: Cli) -> None:
    assert vesselsplat("export", runs["original"], "--spz", tmp_path, "--frames", 2, 4).code == 0
    path = tmp_path / "frame-000002.spz"
    path.write_bytes((tmp_path / "frame-000004.spz").read_bytes())
    call = vesselsplat("replay", path, "--source", runs["original"].parent)
    assert call.code == 2
    assert "differs in" in call.error
    path.with_name(f"{path.name}.json").unlink()
    call = vesselsplat("replay", path)
    assert "expected frame-000002.spz.json beside" in call.error


def test_what_to_export_is_asked_for(runs: dict[str, Path], vesselsplat: Cli) -> None:
    call = vesselsplat("export", runs["original"])
    assert call.code == 2
    assert "--spz DIR, --spz4 DIR, --sog DIR, --glb DIR" in call.error
