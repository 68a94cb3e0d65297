"""Edits beside a run: kept, used by render and export, told by evaluate, refused for another model."""

from __future__ import annotations

import base64
import json
import shutil
import zlib
from pathlib import Path

import cv2
import numpy as np
import pytest

from app.errors import UserError
from app.files.provenance import digest, read_provenance
from app.runs.run_edits import read_edits, save_edits
from app.runs.run_folder import RunFolder
from app.scenes.cpu_rendering import DrawOptions, draw_on_cpu, over
from renderer.editing.edits import Edits
from renderer.editing.mask import Mask
from renderer.near_plane import near_plane
from renderer.splat_files import read_splats
from renderer.unobserved import GREY
from tests.app.conftest import Cli


@pytest.fixture
def run(runs: dict[str, Path], tmp_path: Path) -> RunFolder:
    """A copy that may be edited."""
    return RunFolder(Path(shutil.copytree(runs["original"], tmp_path / "edited")))


def half_gone(folder: RunFolder) -> Edits:
    """Every third deleted, every fifth of the others hidden."""
    count = len(folder.model())
    numbers = np.arange(count)
    deleted = Mask.of(numbers % 3 == 0)
    return Edits(deleted, Mask.of(numbers % 5 == 0) - deleted, Mask.of(numbers % 7 == 1))


def test_edits_come_back_and_the_model_stays_as_trained(run: RunFolder) -> None:
    count = len(run.model())
    assert read_edits(run, count) is None
    before, edits = digest(run.model_path), half_gone(run)
    save_edits(run, edits)
    again = read_edits(run, count)
    assert again is not None
    assert (again.deleted, again.hidden, len(again.selected)) == (edits.deleted, edits.hidden, 0)
    assert digest(run.model_path) == before
    save_edits(run, Edits.none(edits.count))
    assert not run.edits_path.exists()


def test_edits_are_not_written_through_a_link_in_a_run(run: RunFolder, tmp_path: Path) -> None:
    outside = tmp_path / "outside"
    outside.write_bytes(b"precious")
    run.edits_path.symlink_to(outside)
    save_edits(run, half_gone(run))
    assert outside.read_bytes() == b"precious"
    assert not run.edits_path.is_symlink()


def test_edits_of_another_model_are_refused_in_a_line(
    run: RunFolder, tmp_path: Path, vesselsplat: Cli
) -> None:
    save_edits(run, half_gone(run))
    model = run.model()
    run.save_model(model.rows(np.arange(len(model) - 1)))
    for command in ("render", "export"):
        flag = "--out" if command == "render" else "--ply"
        call = vesselsplat(command, run.path, flag, tmp_path / "out")
        assert (call.code, call.error.count("\n")) == (2, 1)
        assert "edits of another model" in call.error
    assert not (tmp_path / "out").exists()
    assert vesselsplat("evaluate", run.path, "--edited").code == 2
    assert vesselsplat("render", run.path, "--out", tmp_path / "out", "--frames", 0, "--as-trained").code == 0


def test_render_draws_what_is_left_and_says_so(run: RunFolder, tmp_path: Path, vesselsplat: Cli) -> None:
    edits, record = half_gone(run), run.record()
    save_edits(run, edits)
    call = vesselsplat("render", run.path, "--out", tmp_path, "--frames", 4)
    assert call.code == 0
    assert f"{edits.count - len(edits.visible)} of {edits.count} Gaussians are removed" in call.error
    model = edits.applied(run.model())
    drawn = draw_on_cpu(
        model.at(record.time(4)), record.cameras[4], DrawOptions(near_plane(model, record.cameras[4]))
    )
    path = tmp_path / "frame-000004.png"
    assert np.array_equal(cv2.imread(str(path))[..., ::-1], over(drawn, GREY))
    facts = read_provenance(path)["edits"]
    assert (facts["n_deleted"], facts["n_hidden"]) == (len(edits.deleted), len(edits.hidden))


def test_pictures_come_again_with_the_edits_that_they_were_drawn_with(
    run: RunFolder, tmp_path: Path, vesselsplat: Cli
) -> None:
    save_edits(run, half_gone(run))
    assert vesselsplat("render", run.path, "--out", tmp_path, "--frames", 4).code == 0
    save_edits(run, Edits.none(len(run.model())))
    call = vesselsplat("replay", tmp_path / "frame-000004.png", "--source", run.path)
    assert (call.code, call.error) == (0, "")


def test_export_writes_the_edited_splats(run: RunFolder, tmp_path: Path, vesselsplat: Cli) -> None:
    edits = half_gone(run)
    save_edits(run, edits)
    assert vesselsplat("export", run.path, "--ply", tmp_path, "--frames", 3).code == 0
    written = read_splats(tmp_path / "frame-000003.ply").raw
    model = run.model()
    whole = model.motion.moved(model.raw, run.record().time(3))
    np.testing.assert_array_equal(written.means, whole.means[edits.visible.indices()])


def test_evaluate_measures_the_trained_model_unless_asked(run: RunFolder, vesselsplat: Cli) -> None:
    trained = json.loads(vesselsplat("evaluate", run.path, "--json").out)
    edits = half_gone(run)
    save_edits(run, edits)
    still = json.loads(vesselsplat("evaluate", run.path, "--json").out)
    edited = json.loads(vesselsplat("evaluate", run.path, "--json", "--edited").out)
    assert trained["edits"] is None
    assert still["edits"] == {"measured": False}
    assert still["mean"]["psnr"] == trained["mean"]["psnr"]
    assert edited["edits"]["n_deleted"] == len(edits.deleted)
    assert edited["mean"]["n_gaussians"] == len(edits.visible)
    assert edited["mean"]["psnr"] < still["mean"]["psnr"]
    assert "without its edits" in vesselsplat("evaluate", run.path).out.replace("\n", " ")


def test_damaged_files_are_refused_in_a_line_and_never_crash(run: RunFolder) -> None:
    save_edits(run, half_gone(run))
    good, count = run.edits_path.read_bytes(), len(run.model())
    lines: list[str] = []
    rng = np.random.default_rng(0)
    for _ in range(300):
        broken = bytearray(good)
        for place in rng.integers(0, len(good), 3):
            broken[place] = rng.integers(0, 256)
        run.edits_path.write_bytes(bytes(broken[: rng.integers(1, 2 * len(good))]))
        try:
            edits = read_edits(run, count)
        except UserError as error:
            lines.append(str(error))
        else:
            assert edits is not None
            assert edits.count == count
    assert not any("\n" in line for line in lines)
    assert len(lines) > 250


def test_masks_that_unpack_to_more_than_they_say_are_refused(run: RunFolder) -> None:
    save_edits(run, half_gone(run))
    said = json.loads(run.edits_path.read_bytes())
    bomb = base64.b64encode(zlib.compress(bytes(50_000_000))).decode()
    run.edits_path.write_text(json.dumps(said | {"deleted": bomb}))
    with pytest.raises(UserError, match="expected masks of"):
        read_edits(run, said["gaussians"])
    run.edits_path.write_text(json.dumps(said | {"gaussians": said["gaussians"] - 1}))
    with pytest.raises(UserError, match="got edits of"):
        read_edits(run, said["gaussians"])
