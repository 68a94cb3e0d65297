"""What a folder of results holds from before is told, and nothing else."""

from __future__ import annotations

from pathlib import Path

import pytest

from app.console.older_files import say_older
from tests.app.conftest import Cli


@pytest.mark.parametrize(
    ("written", "said"),
    [
        (["a.ply", "b.ply"], ""),
        (["a.ply"], "1 file of this kind from before"),
        (["c.ply"], "2 files of this kind from before"),
        (["a.png"], ""),
        (["a.ply", "x.txt"], "2 files of these kinds from before"),
    ],
)
def test_files_of_the_same_endings_are_counted(
    written: list[str], said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for name in {"a.ply", "b.ply", "notes.txt", *written}:
        (tmp_path / name).touch()
    (tmp_path / "folder.ply").mkdir()
    say_older(tmp_path, written)
    assert capsys.readouterr().err == (f"{tmp_path} also holds {said}\n" if said else "")


def test_fewer_frames_into_the_same_folder_say_so(
    runs: dict[str, Path], vesselsplat: Cli, tmp_path: Path
) -> None:
    first = vesselsplat("export", runs["original"], "--ply", tmp_path / "splats", "--frames", 0, 1, 2)
    assert (first.code, first.error) == (0, "")
    again = vesselsplat("export", runs["original"], "--ply", tmp_path / "splats", "--frames", 1)
    assert again.error == f"{tmp_path / 'splats'} also holds 2 files of this kind from before\n"
