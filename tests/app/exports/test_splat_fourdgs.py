"""Splats through the clip as 4DGS, read back by the package's own two ways of reading."""

from __future__ import annotations

import random
import sys
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from fourdgs import validate
from fourdgs.keyframe_delta_file import decode_indexed, decode_streamed, render_at

from app.errors import UserError
from app.exports.records import MovingSplats
from app.exports.replay.difference import difference
from app.exports.splats import fourdgs
from app.files.records import extended
from app.files.stepping import run_to_end
from app.scenes.scene import Scene, open_scene
from renderer.deformation.motion import Motion, Still
from renderer.editing.edits import Edits
from renderer.editing.mask import Mask
from renderer.gaussians import DynamicGaussians
from renderer.model_windows import windows_of
from renderer.raw_gaussians import RawGaussians
from renderer.splats import Splats
from tests.app.conftest import Cli
from tests.app.exports.test_splat_glb import TURN, covariances
from tests.renderer.splat_files.files import gaussians

STILL = Still()
SEC = 1 / 15
"""A frame of the clip."""


class Swinging(Still):
    """Once to and fro."""

    def moved(self, raw: RawGaussians, time: float) -> RawGaussians:
        return replace(raw, means=raw.means + np.float32(20 * np.sin(2 * np.pi * time)))


def written(scene: Scene, path: Path) -> Path:
    record = extended(MovingSplats, scene.record, seconds=len(scene.cameras) * SEC)
    run_to_end(fourdgs.write_fourdgs(record, scene, path))
    return path


def still(count: int, runs: dict[str, Path], motion: Motion = STILL) -> Scene:
    """A scene of `count` Gaussians that do not move."""
    scene = open_scene(runs["original"])
    return replace(scene, model=DynamicGaussians(gaussians(count, 0), motion))


def apart(decoded: object, scene: Scene, time: float, at: Splats) -> dict[str, float]:
    """Of each value the largest error, sizes and places in shares of the median size."""
    found = render_at(decoded, time)
    size = float(np.median(at.scales))
    ours = TURN @ covariances(at.quats, at.scales) @ TURN
    theirs = covariances(found["rotations"][:, [3, 0, 1, 2]], found["scales"])
    spread = np.abs(theirs - ours).max(axis=(1, 2)) / at.scales.max(axis=1) ** 2
    return {
        "places": float(np.abs(found["centers"] - at.means @ TURN).max()) / size,
        "shapes": float(spread.max()),
        "colors": float(np.abs(found["rgb"] - at.colors.clip(0, 1)).max()),
        "opacities": float(np.abs(found["opacity"] - at.opacities).max()),
    }


def test_each_frame_is_read_back_within_the_bounds_of_the_format(
    runs: dict[str, Path], vesselsplat: Cli, tmp_path: Path
) -> None:
    scene, path = open_scene(runs["original"]), tmp_path / "a.4dgs"
    done = vesselsplat("export", runs["original"], "--4dgs", path, "--frames-per-second", 15)
    assert (done.code, done.error) == (0, "")
    content = path.read_bytes()
    assert validate.validate(content).ok
    walked, (sought, _) = decode_streamed(content), decode_indexed(content)
    for decoded in (walked, sought):
        assert decoded.header.duration_sec == pytest.approx(10 * SEC)
        for frame in range(10):
            found = apart(decoded, scene, frame * SEC, scene.model.at(scene.time(frame)))
            assert found["places"] < 0.05  # Of which 0.02 is the position's bound, the rest the motion's.
            assert found["shapes"] < 0.02
            assert found["colors"] <= 0.51 / 255
            assert found["opacities"] <= 0.51 / 255
    again = vesselsplat("replay", path, "--source", runs["original"])
    assert again.out.rstrip().endswith("identical"), again.error + again.out
    assert "moving splats" in vesselsplat("info", path).out


def test_of_a_long_clip_gaussians_come_and_go_with_their_windows(
    windowed_run: Path, vesselsplat: Cli, tmp_path: Path
) -> None:
    scene, path = open_scene(windowed_run), tmp_path / "a.4dgs"
    done = vesselsplat("export", windowed_run, "--4dgs", path, "--frames-per-second", 15)
    assert (done.code, done.error) == (0, "")
    content = path.read_bytes()
    assert validate.validate(content).ok
    decoded, speed = decode_streamed(content), len(scene.cameras) / 15
    assert decoded.header.duration_sec == pytest.approx(speed)
    for frame in (0, 20, 36, 44, 60, 90, 111):
        found = apart(decoded, scene, frame * SEC, scene.model.at(scene.time(frame)))
        assert found["places"] < 0.1
        assert found["opacities"] <= 0.51 / 255
    again = vesselsplat("replay", path, "--source", windowed_run)
    assert again.out.rstrip().endswith("identical"), again.error + again.out


def test_a_window_whose_gaussians_are_removed_shows_nothing(windowed_run: Path, tmp_path: Path) -> None:
    scene = open_scene(windowed_run)
    middle = np.zeros(len(scene.model), bool)
    middle[windows_of(scene.model)[1].rows] = True
    edits = Edits.none(len(scene.model)).selecting(Mask.of(middle), "replace").deleting()
    path = written(scene.edited(edits), tmp_path / "a.4dgs")
    decoded = decode_streamed(path.read_bytes())
    assert len(render_at(decoded, 60 * SEC)["centers"]) == 0
    assert len(render_at(decoded, 10 * SEC)["centers"]) == len(windows_of(scene.model)[0])


def test_between_frames_gaussians_go_straight_on(runs: dict[str, Path], tmp_path: Path) -> None:
    scene = still(40, runs, Swinging())
    decoded = decode_streamed(written(scene, tmp_path / "a.4dgs").read_bytes())
    before, after = (scene.model.at(scene.time(frame)).means @ TURN for frame in (4, 5))
    size = float(np.median(scene.model.at(0).scales))
    assert np.abs(after - before).min(axis=0).max() > size
    middle = render_at(decoded, 4.5 * SEC)["centers"]
    assert np.abs(middle - (before + after) / 2).max() < 0.05 * size


def test_what_does_not_move_is_written_once(runs: dict[str, Path], tmp_path: Path) -> None:
    path = written(still(500, runs), tmp_path / "a.4dgs")
    chunks = decode_streamed(path.read_bytes()).chunks
    assert len(chunks) == 10
    assert all(chunk.update_count == 0 for chunk in chunks if chunk.kind == 1)


def test_another_model_is_told_from_it(runs: dict[str, Path], tmp_path: Path) -> None:
    one, other = (written(still(count, runs), tmp_path / f"{count}.4dgs") for count in (20, 21))
    assert difference(one, one).is_none
    assert not difference(one, other).is_none


@pytest.mark.parametrize("kind", ["empty", "large", "package"])
def test_what_cannot_be_written_is_told_and_leaves_nothing(
    kind: str, runs: dict[str, Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    scene, said = still(20 if kind != "empty" else 0, runs), "got none"
    if kind == "large":
        monkeypatch.setattr(fourdgs, "free_memory", lambda: 10_000)
        said = r"20 Gaussians at 10 frames need .* a \.usdc file is not"
    if kind == "package":
        monkeypatch.setattr(fourdgs, "has_fourdgs", lambda: False)
        said = "needs fourdgs: pip install fourdgs"
    with pytest.raises(UserError, match=said):
        written(scene, tmp_path / "a.4dgs")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("name", ["a.ply", "folder"])
def test_another_name_is_one_line(name: str, runs: dict[str, Path], vesselsplat: Cli, tmp_path: Path) -> None:
    done = vesselsplat("export", runs["original"], "--4dgs", tmp_path / name)
    assert (done.code, done.error.count("\n")) == (2, 1)
    assert f"--4dgs: expected the name of a .4dgs file, got {name}" in done.error
    assert list(tmp_path.iterdir()) == []


def test_damaged_files_are_refused_or_read_in_bounds(runs: dict[str, Path], tmp_path: Path) -> None:
    path = written(still(50, runs), tmp_path / "a.4dgs")
    content, drawn, refused = path.read_bytes(), random.Random(0), 0
    for at in range(100):
        damaged = bytearray(content[: drawn.randrange(len(content))] if at % 2 else content)
        if damaged:
            damaged[drawn.randrange(len(damaged))] ^= 1 << drawn.randrange(8)
        path.write_bytes(damaged)
        with suppress(UserError):
            list(fourdgs.read_fourdgs(path))
            continue
        refused += 1
    assert refused >= 50


def test_the_package_is_not_loaded_to_look_for_it() -> None:
    fourdgs.has_fourdgs.cache_clear()
    sys.modules.pop("fourdgs", None)
    assert fourdgs.has_fourdgs()
    assert "fourdgs" not in sys.modules
