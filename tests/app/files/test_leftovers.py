"""What killed processes leave: a set of files is wholly old or wholly new after the next start."""

from __future__ import annotations

import os
import platform
import subprocess
import sys
from collections.abc import Callable, Iterator
from itertools import product
from pathlib import Path
from typing import Any
from zlib import crc32

import psutil
import pytest

from app.files.atomic import filled, together, write_bytes
from renderer import leftovers
from renderer.leftovers import COMMIT, PARTIAL, clear, commit_name, machine, mark_of, temporary_name
from tests.app.apart import called

OLD, NEW = {"a.mp4": "old", "a.mp4.json": "old"}, {"a.mp4": "new", "a.mp4.json": "new"}


def write_until(folder: Path, calls: int) -> int:
    """A set of files; the process is gone with the call of the system that comes after so many."""
    left = calls

    def counted(call: Callable[..., Any]) -> Callable[..., Any]:
        def wrapped(*arguments: Any, **named: Any) -> Any:
            nonlocal left
            if left == 0:
                os._exit(9)
            left -= 1
            return call(*arguments, **named)

        return wrapped

    for name in ("mkdir", "replace", "rename", "fsync", "unlink", "rmdir", "open", "remove"):
        setattr(os, name, counted(getattr(os, name)))
    with together(folder / "a.mp4") as place:
        place.write_text("new")
        (place.parent / "a.mp4.json").write_text("new")
    os._exit(0)


def contents(folder: Path) -> dict[str, str]:
    return {path.name: path.read_text() for path in folder.iterdir() if not path.name.startswith(".")}


def write_and_die(folder: Path, calls: int) -> int:
    """In a process that is gone at that call of the system."""
    return called(write_until, folder, calls, folder=folder).code


def test_a_folder_of_many_files_is_not_looked_through_for_each(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    listed, list_folder = list[Path](), os.listdir

    def noted(folder: Path) -> list[str]:
        listed.append(folder)
        return list_folder(folder)

    monkeypatch.setattr(os, "listdir", noted)
    with filled(tmp_path) as staging:
        for number in range(5):
            write_bytes(staging / f"{number}.png", b"new")
        assert listed == [tmp_path]
    assert len(list(tmp_path.iterdir())) == 5


def test_a_kill_at_any_call_leaves_all_old_or_all_new(tmp_path: Path) -> None:
    before, after, ended = 0, 0, False
    for calls in range(100):
        folder = tmp_path / str(calls)
        folder.mkdir()
        for name, text in OLD.items():
            (folder / name).write_text(text)
        ended = write_and_die(folder, calls) == 0
        clear(folder)
        assert contents(folder) in (OLD, NEW), f"after {calls} calls"
        assert sorted(path.name for path in folder.iterdir()) == sorted(OLD), f"after {calls} calls"
        before += contents(folder) == OLD
        after += contents(folder) == NEW
        if ended:
            break
    assert ended
    # Some kills fell before the commit, some within it and after.
    assert before > 2
    assert after > 2


def test_the_next_writer_into_the_folder_completes_what_was_cut_off(tmp_path: Path) -> None:
    for calls in range(100):
        for name, text in OLD.items():
            (tmp_path / name).write_text(text)
        ended = write_and_die(tmp_path, calls) == 0
        write_bytes(tmp_path / "other", b"")
        assert contents(tmp_path) in (OLD | {"other": ""}, NEW | {"other": ""})
        assert not [path for path in tmp_path.iterdir() if path.name.startswith(".")]
        if ended:
            return
    pytest.fail("the set was never written")


def name_of(process: int, name: str = "run") -> str:
    """What the process writes the file of that name as."""
    return temporary_name(name).replace(f"-{os.getpid()}.", f"-{process}.")


def gone() -> int:
    """Of a process that has ended."""
    child = subprocess.Popen([sys.executable, "-c", ""])
    child.wait()
    return child.pid


def test_only_what_processes_that_are_gone_left_is_cleared(tmp_path: Path) -> None:
    dead = gone()
    elsewhere = f".run-{dead}-00000000{PARTIAL}"
    kept = [
        temporary_name("mine"),
        temporary_name("run").replace(mark_of(os.getpid()), mark_of(os.getppid())),
        elsewhere,
        "own.partial",
        ".note",
        f".run{PARTIAL}",
    ]
    former = f".run-{dead}-{machine()}{PARTIAL}"
    # The number of a process that lives, which another one had before it.
    again = name_of(os.getppid())
    for name in (*kept, name_of(dead), f"{name_of(dead)}.json", former, again):
        (tmp_path / name).write_text("half")
    clear(tmp_path)
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted(kept)


@pytest.mark.parametrize("seconds", [-1e6, 1e6])
def test_what_a_living_process_writes_stays_whatever_the_clocks_say(tmp_path: Path, seconds: float) -> None:
    """Of this machine, which may be set, and of the one that the disk belongs to."""
    with subprocess.Popen([sys.executable, "-c", "input()"], stdin=subprocess.PIPE) as other:
        name = temporary_name("run").replace(mark_of(os.getpid()), mark_of(other.pid))
        (tmp_path / name).write_text("half")
        moment = (tmp_path / name).stat().st_mtime + seconds
        os.utime(tmp_path / name, (moment, moment))
        clear(tmp_path)
        assert (tmp_path / name).exists()
        other.communicate(b"\n")
    clear(tmp_path)
    assert not (tmp_path / name).exists()


@pytest.mark.parametrize("system", ["linux", "darwin", "win32"])
def test_a_process_keeps_its_mark_when_the_clock_is_set(system: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """psutil's moments of processes move along, but not those by which it knows them again."""
    real = psutil.Process.create_time
    monkeypatch.setattr(sys, "platform", system)
    mark = mark_of(os.getpid())
    monkeypatch.setattr(psutil.Process, "create_time", lambda self: real(self) + 5)
    assert mark_of(os.getpid()) == mark
    assert leftovers.lives(mark)
    assert not leftovers.lives(f"{mark}0")


@pytest.fixture
def named_anew() -> Iterator[Callable[[], str]]:
    """What this machine is called now, by what the test has changed."""
    known = (leftovers.machine, leftovers.machines)

    def name() -> str:
        for function in known:
            function.cache_clear()
        return leftovers.machine()

    yield name
    for function in known:
        function.cache_clear()


def test_a_mac_stays_the_same_in_another_network(
    named_anew: Callable[[], str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys, "platform", "darwin")
    monkeypatch.setattr("uuid.getnode", lambda: 0x02_42_AC_11_00_02)
    found = set()
    for name in ("laptop.here", "laptop.elsewhere"):
        monkeypatch.setattr("platform.node", lambda name=name: name)
        found.add(named_anew())
    assert len(found) == 1


def test_copies_of_one_installation_are_machines_of_their_own_and_stay_so(
    named_anew: Callable[[], str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    found = []
    for node, installation in product(("one", "other"), ("0123", "4567")):
        (tmp_path / "id").write_text(installation)
        monkeypatch.setattr(leftovers, "INSTALLATION", tmp_path / "id")
        monkeypatch.setattr("platform.node", lambda node=node: node)
        found.append(named_anew())
        assert named_anew() == found[-1]
    assert len(set(found)) == 4


def test_what_former_versions_left_under_the_name_of_the_machine_goes(tmp_path: Path) -> None:
    former = f"{crc32(platform.node().encode()):08x}"
    (tmp_path / f".run-{gone()}.1-{former}{PARTIAL}").write_text("half")
    clear(tmp_path)
    assert not list(tmp_path.iterdir())


def test_a_folder_that_was_being_filled_goes_and_a_link_of_that_name_is_not_followed(tmp_path: Path) -> None:
    dead, outside = gone(), tmp_path / "outside"
    work = tmp_path / "work"
    work.mkdir()
    for folder in (outside, work / name_of(dead)):
        folder.mkdir()
        (folder / "0.png").write_text("picture")
    commit = work / commit_name(name_of(dead).replace("run", "linked"))
    commit.symlink_to(outside)
    clear(work)
    assert (outside / "0.png").read_text() == "picture"
    assert not (work / name_of(dead)).exists()
    assert not (work / "0.png").exists()


def write_new(folder: Path) -> None:
    with together(folder / "a.mp4") as place:
        for name, text in NEW.items():
            (place.parent / name).write_text(text)


def test_a_set_whose_files_cannot_be_moved_now_is_completed_later(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As on Windows, while another program has one of them open."""
    real = os.replace

    def busy(source: Path, target: Path) -> None:
        if Path(target).name == "a.mp4.json":
            raise PermissionError(13, "in use", str(target))
        real(source, target)

    for name, text in OLD.items():
        (tmp_path / name).write_text(text)
    with monkeypatch.context() as patch:
        patch.setattr(os, "replace", busy)
        with pytest.raises(PermissionError):
            write_new(tmp_path)
    (commit,) = (path for path in tmp_path.iterdir() if path.name.endswith(COMMIT))
    monkeypatch.setattr(leftovers, "lives", lambda mark: False)
    clear(tmp_path)
    assert contents(tmp_path) == NEW
    assert not commit.exists()


def test_a_set_is_completed_when_the_other_program_lets_go(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    real, refused = os.replace, []

    def busy(source: Path, target: Path) -> None:
        if Path(source).name not in refused:
            refused.append(Path(source).name)
            raise PermissionError(13, "in use", str(source))
        real(source, target)

    monkeypatch.setattr(sys, "platform", "win32")
    monkeypatch.setattr(os, "replace", busy)
    write_new(tmp_path)
    assert contents(tmp_path) == NEW
    assert len(refused) == 3  # The folder, and each of its files.
    assert not [path for path in tmp_path.iterdir() if path.name.startswith(".")]


def test_names_of_any_length_and_kind_are_written(tmp_path: Path) -> None:
    """The name beside which the temporary one lies may be as long as the system allows."""
    for name in ("x" * 250 + ".png", "a b.png", "-.png", "é" * 120 + ".png"):
        write_bytes(tmp_path / name, b"new")
        assert (tmp_path / name).read_bytes() == b"new"
    long = tmp_path / ("y" * 250)
    with filled(long) as staging:
        (staging / "0.png").write_bytes(b"new")
    assert (long / "0.png").read_bytes() == b"new"
