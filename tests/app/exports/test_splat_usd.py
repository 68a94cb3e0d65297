"""Splats through the clip as USD, read back by usd-core's own interface."""

from __future__ import annotations

import random
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from pxr import Usd, UsdGeom, UsdVol

from app.errors import UserError
from app.exports.records import MovingSplats
from app.exports.splats.usd import write_usd
from app.exports.usd_file import read_usd
from app.files.records import extended
from app.files.stepping import run_to_end
from app.scenes.scene import Scene, open_scene
from renderer.deformation.motion import Still
from renderer.gaussians import DynamicGaussians
from renderer.harmonics import seen_colors
from renderer.splats import Splats
from tests.app.conftest import ROOT, Cli
from tests.app.exports.test_splat_glb import TURN, covariances
from tests.renderer.splat_files.files import gaussians


def at(stage: Usd.Stage, code: float, prim: Usd.Prim | None = None) -> Splats:
    """As the schema says: coefficients one Gaussian after the other, the real part of rotations by name."""
    field = UsdVol.ParticleField3DGaussianSplat(prim or stage.GetDefaultPrim())
    positions = np.array(field.GetPositionsAttr().Get(code))
    turns = field.GetOrientationsAttr().Get(code)
    degree = field.GetRadianceSphericalHarmonicsDegreeAttr().Get()
    coefficients = np.array(field.GetRadianceSphericalHarmonicsCoefficientsAttr().Get(code))
    coefficients = coefficients.reshape(len(positions), (degree + 1) ** 2, 3)
    low, high = np.array(field.GetExtentAttr().Get(code))
    assert (positions >= low).all()
    assert (positions <= high).all()
    return Splats(
        means=positions,
        quats=np.array([[turn.GetReal(), *turn.GetImaginary()] for turn in turns], np.float32),
        scales=np.array(field.GetScalesAttr().Get(code)),
        opacities=np.array(field.GetOpacitiesAttr().Get(code)),
        colors=0.5 + np.float32(0.28209479177387814) * coefficients[:, 0],
        harmonics=coefficients[:, 1:],
    )


def same(theirs: Splats, own: Splats) -> None:
    assert np.allclose(theirs.means, own.means @ TURN, atol=1e-5)
    assert np.allclose(theirs.opacities, own.opacities)
    ours = TURN @ covariances(own.quats, own.scales) @ TURN
    assert np.allclose(covariances(theirs.quats, theirs.scales), ours, rtol=1e-4, atol=1e-6)
    place = np.array([3.0, -40.0, 7.0])
    seen = seen_colors(theirs.means, theirs.harmonics, theirs.colors, TURN @ place)
    assert np.allclose(seen, own.seen_from(place).colors, atol=1e-5)


def test_usd_core_reads_the_splats_of_every_frame(
    runs: dict[str, Path], vesselsplat: Cli, tmp_path: Path
) -> None:
    scene, path = open_scene(runs["original"]), tmp_path / "a.usdc"
    done = vesselsplat("export", runs["original"], "--usd", path, "--frames-per-second", 15)
    assert (done.code, done.error) == (0, "")
    stage = Usd.Stage.Open(str(path))
    assert (UsdGeom.GetStageMetersPerUnit(stage), UsdGeom.GetStageUpAxis(stage)) == (0.001, "Y")
    assert stage.GetFramesPerSecond() == 15
    assert (stage.GetTimeCodesPerSecond(), stage.GetStartTimeCode(), stage.GetEndTimeCode()) == (15, 0, 9)
    for frame in range(10):
        same(at(stage, frame), scene.model.at(scene.time(frame)))
    # Between frames, programs interpolate.
    halves = [at(stage, code).means for code in (4, 4.5, 5)]
    assert np.allclose(halves[1], (halves[0] + halves[2]) / 2, atol=1e-5)
    field = UsdVol.ParticleField3DGaussianSplat(stage.GetDefaultPrim())
    assert len(field.GetPositionsAttr().GetTimeSamples()) == 10
    assert field.GetScalesAttr().GetTimeSamples() == []  # Nothing moves there.
    del stage, field
    again = vesselsplat("replay", path, "--source", runs["original"])
    assert again.out.rstrip().endswith("identical"), again.error + again.out
    assert "moving splats" in vesselsplat("info", path).out
    content, drawn, refused = path.read_bytes(), random.Random(0), 0
    for _ in range(50):
        path.write_bytes(content[: drawn.randrange(len(content))])
        try:
            read_usd(path)
        except UserError as error:
            refused += str(path) in str(error)
    assert refused == 50


def test_each_window_of_a_long_clip_is_seen_while_it_is_there(
    windowed_run: Path, vesselsplat: Cli, tmp_path: Path
) -> None:
    scene, path = open_scene(windowed_run), tmp_path / "a.usdc"
    done = vesselsplat("export", windowed_run, "--usd", path, "--frames-per-second", 15)
    assert (done.code, done.error) == (0, "")
    stage = Usd.Stage.Open(str(path))
    fields = list(stage.GetDefaultPrim().GetChildren())
    assert len(fields) == 3
    for frame in (0, 20, 35, 36, 44, 47, 48, 60, 64, 70, 90, 111):
        there = [
            prim
            for prim in fields
            if UsdGeom.Imageable(prim).ComputeVisibility(frame) != UsdGeom.Tokens.invisible
        ]
        parts, own = [at(stage, frame, prim) for prim in there], scene.model.at(scene.time(frame))
        names = ("means", "quats", "scales", "opacities", "colors", "harmonics")
        joined = {name: np.concatenate([getattr(part, name) for part in parts]) for name in names}
        same(Splats(**joined), own)
    samples = [
        len(UsdVol.ParticleField3DGaussianSplat(prim).GetScalesAttr().GetTimeSamples()) for prim in fields
    ]
    assert samples == [0, 0, 0]  # Nothing moves there.
    again = vesselsplat("replay", path, "--source", windowed_run)
    assert again.out.rstrip().endswith("identical"), again.error + again.out


@pytest.mark.parametrize("bands", [3, 15])
def test_colours_by_direction_are_turned_with_the_axes(
    runs: dict[str, Path], tmp_path: Path, bands: int
) -> None:
    raw = gaussians(50, bands)
    scene: Scene = replace(open_scene(runs["original"]), model=DynamicGaussians(raw, Still()))
    path = tmp_path / "a.usdc"
    run_to_end(write_usd(extended(MovingSplats, scene.record, seconds=2.0), scene, path))
    stage = Usd.Stage.Open(str(path))
    same(at(stage, 3), raw.splats())


def test_another_suffix_or_no_usd_core_is_one_line(
    runs: dict[str, Path],
    vesselsplat: Cli,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    done = vesselsplat("export", runs["original"], "--usd", tmp_path / "a.usd")
    assert (done.code, "--usd: expected the name of a .usdc file, got a.usd" in done.error) == (2, True)
    monkeypatch.delattr(UsdVol, "ParticleField3DGaussianSplat")
    done = vesselsplat("export", runs["original"], "--usd", tmp_path / "a.usdc")
    assert (done.code, "need usd-core 26.3 or newer" in done.error) == (2, True)
    monkeypatch.setitem(__import__("sys").modules, "pxr", None)
    done = vesselsplat("export", runs["original"], "--usd", tmp_path / "a.usdc")
    assert (done.code, "pip install usd-core" in done.error) == (2, True)
    assert list(tmp_path.iterdir()) == []


LIMITED = """
import resource, signal, sys
from app.__main__ import main

signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
most = int(sys.argv.pop(1))
resource.setrlimit(resource.RLIMIT_FSIZE, (most, most))
sys.exit(main(sys.argv[1:]))
"""


@pytest.mark.skipif(sys.platform != "linux", reason="limits files as Linux does")
@pytest.mark.parametrize(("flag", "most"), [("--usd", 4000), ("--usd", 0), ("--mesh", 4000)])
def test_a_full_disk_is_told_in_a_line(runs: dict[str, Path], tmp_path: Path, flag: str, most: int) -> None:
    path = tmp_path / "a.usdc"
    asked = (sys.executable, "-B", "-c", LIMITED, str(most), "export", str(runs["original"]))
    asked += flag, str(path)
    done = subprocess.run(asked, cwd=ROOT, capture_output=True, text=True, timeout=120, check=False)
    last = done.stderr.splitlines()[-1]
    assert done.returncode == 2, done.stderr
    assert last.endswith(f"the file cannot be written, the disk may be full: {path}")
    assert "Traceback" not in done.stderr
    assert not list(tmp_path.iterdir())
