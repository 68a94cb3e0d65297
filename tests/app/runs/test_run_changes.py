"""Run folders are renamed and deleted; whatever is no run, or is in training, stays."""

from __future__ import annotations

import shutil
import sys
from pathlib import Path

import pytest

from app.errors import UserError
from app.runs.run_changes import delete_run, folder_name, footprint, rename_run
from app.runs.run_folder import RunFolder
from app.runs.run_lock import locked


@pytest.fixture
def run(runs: dict[str, Path], tmp_path: Path) -> Path:
    return Path(shutil.copytree(runs["original"], tmp_path / "run"))


def test_a_renamed_run_is_the_same_run(run: Path, runs: dict[str, Path]) -> None:
    there = rename_run(run, "patient 7, second try")
    assert there == run.with_name("patient-7-second-try")
    assert not run.exists()
    assert RunFolder(there).model_path.read_bytes() == RunFolder(runs["original"]).model_path.read_bytes()
    assert rename_run(there, there.name) == there


@pytest.mark.parametrize("name", ["NUL", "con", "aux.v2", "lpt9"])
def test_no_folder_has_the_name_of_a_device_of_windows(name: str) -> None:
    assert folder_name(name) == f"run-{name}"
    assert folder_name(f"{name[:3]}-x") == f"{name[:3]}-x"


@pytest.mark.parametrize("letter", ["x", "é", "-x"])
def test_a_run_of_a_very_long_name_can_be_deleted(run: Path, letter: str) -> None:
    """Systems allow names of 255 bytes, with all that their bin adds."""
    assert len(folder_name(250 * letter).encode()) in range(118, 121)
    assert folder_name(250 * letter, "-20260101-120000").endswith(f"{letter[-1]}-20260101-120000")
    assert len(folder_name(250 * letter, "-20260101-120000").encode()) in range(118, 121)
    assert folder_name("..", "-original") == ""
    named_elsewhere = run.rename(run.with_name(250 * "x"))
    delete_run(named_elsewhere, for_good=True)
    assert not list(run.parent.iterdir())


@pytest.mark.parametrize("name", ["", " ./.. ", "other"])
def test_a_name_that_is_none_or_taken_is_refused(run: Path, name: str) -> None:
    (run.parent / "other").mkdir()
    with pytest.raises(UserError, match="expected a name"):
        rename_run(run, name)
    assert RunFolder(run).is_finished


@pytest.mark.skipif(sys.platform != "linux", reason="elsewhere the system keeps its bin to itself")
def test_a_deleted_run_is_in_the_bin_and_can_be_had_back(run: Path, bin_files: Path) -> None:
    beside = run.parent / "beside.txt"
    beside.write_text("mine")
    kept = {path.relative_to(run): path.read_bytes() for path in run.rglob("*") if path.is_file()}
    assert footprint(run).has_bin
    delete_run(run)
    assert list(run.parent.iterdir()) == [beside]
    thrown = bin_files / "run"
    assert {
        path.relative_to(thrown): path.read_bytes() for path in thrown.rglob("*") if path.is_file()
    } == kept
    (told,) = (bin_files.parent / "info").iterdir()
    assert str(run) in told.read_text()


@pytest.mark.skipif(sys.platform != "linux", reason="elsewhere the system keeps its bin to itself")
def test_without_a_bin_nothing_goes_unless_for_good(run: Path, bin_files: Path) -> None:
    bin_files.parent.write_text("in the place of a bin")
    assert not footprint(run).has_bin
    with pytest.raises((UserError, OSError)):
        delete_run(run)
    assert RunFolder(run).is_finished


def test_a_run_deleted_for_good_is_gone_and_nothing_else(run: Path) -> None:
    beside = run.parent / "beside.txt"
    beside.write_text("mine")
    kept = footprint(run)
    assert kept.files == sum(path.is_file() for path in run.rglob("*"))
    assert kept.size == sum(path.stat().st_size for path in run.rglob("*") if path.is_file())
    delete_run(run, for_good=True)
    assert list(run.parent.iterdir()) == [beside]


def test_deleting_that_is_cut_short_leaves_no_run_and_is_no_hindrance(
    run: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    again = Path(shutil.copytree(run, run.parent / "kept"))
    remove = shutil.rmtree
    monkeypatch.setattr("shutil.rmtree", lambda path, **how: None)
    delete_run(run, for_good=True)
    (left,) = (path for path in run.parent.iterdir() if path != again)
    assert not RunFolder(left).is_run
    monkeypatch.setattr("shutil.rmtree", remove)
    again.rename(run)
    delete_run(run, for_good=True)
    assert list(run.parent.iterdir()) == []


def test_what_is_in_training_or_no_run_stays(run: Path) -> None:
    with locked(run):
        for change in (delete_run, lambda path: rename_run(path, "new")):
            with pytest.raises(UserError, match="trained by another process"):
                change(run)
    other, link = run.parent / "photos", run.parent / "link"
    other.mkdir()
    link.symlink_to(run, target_is_directory=True)
    for path in (other, link, run.parent / "nothing"):
        with pytest.raises(UserError, match="expected a run folder"):
            delete_run(path)
    assert RunFolder(run).is_finished
    assert other.is_dir()
