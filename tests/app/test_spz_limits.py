"""What SPZ and compressed PLY do not hold is clipped, and that is told: by the command, and by the file."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from app.exports.replay.recorded import recorded
from renderer import read_splats, write_splats
from renderer.splat_files import packed_writing
from renderer.splat_files.spz_writing import clipped
from tests.app.conftest import Cli
from tests.renderer.splat_files.files import gaussians

SMALL = "30 of 120 sizes are beyond 4.54e-05 to 379, which SPZ does not hold: they are clipped"


def tiny(tmp_path: Path) -> Path:
    """A quarter of its splats is 0.02 mm large in a scene in metres."""
    raw = replace(gaussians(40), colors=np.full((40, 3), 0.5, np.float32))
    raw.log_scales[:10] = np.log(2e-5)
    path = tmp_path / "tiny.ply"
    write_splats(path, raw)
    return path


def test_what_is_within_the_format_is_not_told() -> None:
    raw = gaussians(100)
    assert clipped(replace(raw, log_scales=raw.log_scales.clip(-10.03, 5.96))) == ()


def test_what_is_beyond_is_counted_kind_by_kind() -> None:
    raw = gaussians(40, 3)
    raw.log_scales[:2] = 7
    raw.colors[0, 0] = -2
    raw.harmonics[:] = 0.5
    raw.harmonics[:5, 1, 2] = -1.5
    told = clipped(raw)
    assert [notice.split(" are beyond ")[0] for notice in told] == [
        "6 of 120 sizes",
        "1 of 120 values of colours",
        "5 of 360 values of colours by direction",
    ]


@pytest.mark.parametrize(("flag", "suffix"), [("--spz", ".spz"), ("--spz4", ".v4.spz")])
def test_the_command_tells_and_so_does_the_file_beside(
    flag: str, suffix: str, tmp_path: Path, vesselsplat: Cli
) -> None:
    call = vesselsplat("export", tiny(tmp_path), flag, tmp_path / "out")
    file = tmp_path / "out" / f"frame-000000{suffix}"
    assert (call.code, call.error) == (0, f"{SMALL}: {file}\n")
    assert json.loads((tmp_path / "out" / f"{file.name}.json").read_text())["clipped"] == [SMALL]
    assert np.exp(read_splats(file).raw.log_scales.min()) == pytest.approx(4.54e-5, rel=0.01)
    assert vesselsplat("replay", file, "--source", tiny(tmp_path)).out.rstrip().endswith("identical")


def test_another_format_holds_it(tmp_path: Path, vesselsplat: Cli) -> None:
    call = vesselsplat("export", tiny(tmp_path), "--sog", tmp_path / "out")
    assert (call.code, call.error) == (0, "")
    raw = read_splats(tmp_path / "out" / "frame-000000.sog").raw
    assert np.exp(raw.log_scales.min()) == pytest.approx(2e-5, rel=0.05)


def test_compressed_ply_tells_in_the_file_itself(tmp_path: Path, vesselsplat: Cli) -> None:
    raw = gaussians(600)
    raw.means[3] = 1e5
    write_splats(tmp_path / "a.ply", raw)
    call = vesselsplat("export", tmp_path / "a.ply", "--compressed-ply", tmp_path / "out")
    file = tmp_path / "out" / "frame-000000.compressed.ply"
    (said,) = packed_writing.clipped(raw)
    assert said.startswith("88 of 600 splats are rounded by more than 2 %")
    assert (call.code, call.error) == (0, f"{said}: {file}\n")
    assert recorded(file)["clipped"] == [said]
    assert vesselsplat("replay", file, "--source", tmp_path / "a.ply").out.rstrip().endswith("identical")
