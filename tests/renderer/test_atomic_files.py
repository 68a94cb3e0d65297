"""Files that appear whole or not at all."""

from __future__ import annotations

import os
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from renderer import atomic_files
from renderer.atomic_files import patiently, written_atomically
from renderer.leftovers import temporary_name


def write(path: Path, content: bytes) -> None:
    with written_atomically(path) as partial:
        partial.write_bytes(content)


def test_a_file_is_whole_and_nothing_else_is_left(tmp_path: Path) -> None:
    ended = subprocess.Popen([sys.executable, "-c", ""])
    ended.wait()
    left = temporary_name("b").replace(f"-{os.getpid()}.", f"-{ended.pid}.")
    (tmp_path / left).write_bytes(b"of a killed process")
    write(tmp_path / "a", b"new")
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == {"a": b"new"}


SECOND_WRITER = """
import sys
from pathlib import Path
from renderer.atomic_files import written_atomically
with written_atomically(Path(sys.argv[1])) as partial:
    partial.write_bytes(b"second")
"""


def test_two_processes_that_write_one_file_leave_each_others_alone(tmp_path: Path) -> None:
    with written_atomically(tmp_path / "a") as partial:
        partial.write_bytes(b"fir")
        subprocess.run([sys.executable, "-c", SECOND_WRITER, str(tmp_path / "a")], check=True)
        assert (tmp_path / "a").read_bytes() == b"second"
        with partial.open("ab") as file:
            file.write(b"st")
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == {"a": b"first"}


def test_two_threads_that_write_one_file_leave_each_others_alone(tmp_path: Path) -> None:
    with written_atomically(tmp_path / "a") as partial:
        partial.write_bytes(b"fir")
        with ThreadPoolExecutor(1) as pool:
            pool.submit(write, tmp_path / "a", b"second").result()
        assert (tmp_path / "a").read_bytes() == b"second"
        with partial.open("ab") as file:
            file.write(b"st")
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == {"a": b"first"}


def test_a_link_that_somebody_laid_is_not_followed(tmp_path: Path) -> None:
    outside, run = tmp_path / "outside", tmp_path / "run"
    run.mkdir()
    outside.write_bytes(b"precious")
    (run / temporary_name("a")).symlink_to(outside)
    write(run / "a", b"new")
    assert outside.read_bytes() == b"precious"
    assert not (run / "a").is_symlink()


def test_a_link_at_the_target_is_followed(tmp_path: Path) -> None:
    disk, folder = tmp_path / "disk", tmp_path / "folder"
    for made in (disk, folder):
        made.mkdir()
    (disk / "b").write_bytes(b"old")
    (folder / "a").symlink_to(disk / "b")
    write(folder / "a", b"new")
    assert (folder / "a").is_symlink()
    assert {path.name: path.read_bytes() for path in disk.iterdir()} == {"b": b"new"}


def test_what_fails_leaves_the_old_and_no_partial(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(handle: int) -> None:
        raise OSError(28, "No space left on device")

    write(tmp_path / "a", b"old")
    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(OSError, match="No space") as told:
        write(tmp_path / "a", b"new")
    assert told.value.filename == str(tmp_path / "a")
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == {"a": b"old"}


def test_renames_are_synced_with_their_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    synced: list[str] = []
    real = os.fsync

    def fsync(handle: int) -> None:
        synced.append(os.path.basename(os.readlink(f"/proc/self/fd/{handle}")))
        real(handle)

    if not Path("/proc/self/fd").is_dir():
        pytest.skip("tells files by /proc")
    monkeypatch.setattr(os, "fsync", fsync)
    write(tmp_path / "a", b"new")
    assert synced == [temporary_name("a"), tmp_path.name]


@pytest.mark.parametrize(("system", "tries"), [("win32", 3), ("linux", 1)])
def test_what_windows_refuses_for_a_moment_is_tried_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, system: str, tries: int
) -> None:
    """While a virus scanner looks at the file."""
    asked = []
    real = Path.replace

    def busy(path: Path, target: Path) -> Path:
        asked.append(path)
        if len(asked) < 3:
            raise PermissionError(13, "in use", str(path))
        return real(path, target)

    monkeypatch.setattr(sys, "platform", system)
    monkeypatch.setattr(Path, "replace", busy)
    if tries == 1:
        with pytest.raises(PermissionError):
            write(tmp_path / "a", b"new")
    else:
        write(tmp_path / "a", b"new")
        assert (tmp_path / "a").read_bytes() == b"new"
    assert len(asked) == tries


def test_it_is_not_tried_for_ever(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def busy() -> None:
        raise PermissionError(13, "in use")

    monkeypatch.setattr(sys, "platform", "win32")
    monkeypatch.setattr(atomic_files, "PATIENCE", 0.1)
    with pytest.raises(PermissionError):
        patiently(busy)
