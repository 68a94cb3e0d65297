"""The preparation in a process of its own: what it says, that it ends with its window, what is noted."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from collections.abc import Callable
from multiprocessing.connection import Connection
from pathlib import Path

import psutil
import pytest

from app.enhancement.methods import PAPER, VESSEL, Preset
from app.gui.state.app_state import AppState
from app.gui.update.preparing import COMPLETE, ENDED, follow_preparation
from app.gui.work.settings import Places
from app.kernels import preparer, stamp
from app.kernels.preparer import Preparer
from app.kernels.progress import OVER, Kind, Preparation, Task, paced, tasks, worded
from tests.benchmarks.soak_health import children

SECONDS = 60.0


def quick(pipe: Connection, *first: Kind) -> None:
    pipe.send(Preparation(tasks(*first), 1, 0.5))
    pipe.send(Preparation(tasks(*first), len(tasks(*first))))


def killed(pipe: Connection, *first: Kind) -> None:
    pipe.send(Preparation(tasks(*first), 1, 0.5))
    os._exit(1)


def wait(until: Callable[[], bool], what: str) -> None:
    end = time.monotonic() + SECONDS
    while not until():
        assert time.monotonic() < end, f"waited for {what}"
        time.sleep(0.02)


@pytest.mark.parametrize(("work", "said"), [(quick, COMPLETE), (killed, ENDED)])
def test_it_is_followed_to_its_end(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, work: Callable[..., None], said: str
) -> None:
    monkeypatch.setattr(preparer, "work", work)
    state = AppState(Places(tmp_path, tmp_path, tmp_path))
    made = Preparer()
    made.start()
    follow_preparation(state, made)
    assert state.window.preparation is not None  # From the beginning, before the process has said anything.

    def ended() -> bool:
        follow_preparation(state, made)
        return state.window.preparation is None

    wait(ended, "its end")
    assert list(state.window.log) == [said]


def test_closing_the_window_ends_it() -> None:
    made = Preparer()
    made.start()
    process = psutil.Process(made._process.pid)
    began = time.monotonic()
    made.close()
    assert time.monotonic() - began < 10
    assert not process.is_running()


@pytest.mark.skipif(sys.platform == "win32", reason="another scale of priorities")
def test_it_steps_back_once_the_first_method_is_ready() -> None:
    made, before = Preparer(), psutil.Process().nice()
    made.start()
    process, seen = psutil.Process(made._process.pid), set()

    def is_second() -> bool:
        lowered, now = process.nice() == preparer.NICE, made.poll()
        assert now is not None
        seen.add((lowered, now.done > 0))
        return now.done > 0

    assert before < preparer.NICE
    wait(is_second, "the first step")
    assert process.nice() == preparer.NICE
    made.close()
    assert (False, False) in seen


@pytest.mark.skipif(sys.platform == "win32", reason="no such signal")
def test_it_ends_with_a_window_that_is_killed(tmp_path: Path) -> None:
    code = (
        "import time\nfrom app.kernels.preparer import Preparer\n"
        "if __name__ == '__main__':\n    made = Preparer(); made.start()\n"
        "    print(made._process.pid, flush=True); time.sleep(60)\n"
    )
    script = tmp_path / "window.py"
    script.write_text(code)
    root = str(Path(preparer.__file__).parents[2])
    own = os.environ | {"PYTHONPATH": root, "NUMBA_CACHE_DIR": str(tmp_path / "cold")}
    with subprocess.Popen(
        [sys.executable, str(script)], stdout=subprocess.PIPE, text=True, env=own
    ) as window:
        assert window.stdout is not None
        process = psutil.Process(int(window.stdout.readline()))
        wait(lambda: any((tmp_path / "cold").rglob("*.nbi")) or not process.is_running(), "the first kernel")
        window.kill()
    wait(lambda: not process.is_running() or process.status() == psutil.STATUS_ZOMBIE, "its end")


def test_the_chosen_method_comes_first() -> None:
    assert [task.kind for task in tasks(PAPER)][:2] == [PAPER, VESSEL]
    assert [task.kind for task in tasks(VESSEL)][:2] == [VESSEL, PAPER]


def test_a_splat_file_is_seen_before_anything_else_is_prepared() -> None:
    todo = tasks("3D view", PAPER)
    assert [task.kind for task in todo][:3] == ["3D view", PAPER, VESSEL]
    usual = tasks(PAPER)
    assert {task.name for task in todo} == {task.name for task in usual}
    assert sum(task.seconds for task in todo) == sum(task.seconds for task in usual)
    assert Preparation(todo, 1).has("3D view")


def test_what_is_ready_and_how_long_it_takes() -> None:
    todo = tasks(VESSEL)
    now = Preparation(todo, 1, pace=2.0, seconds=1.0)
    assert now.has(VESSEL)
    assert not now.has("training")
    assert now.seconds_left == 2 * sum(task.seconds for task in todo[1:]) - 1
    assert f"One-time preparation, step 2 of {len(todo)} · about " in worded(now)
    whole = Preparation(todo, len(todo))
    assert (whole.is_ready, whole.seconds_left, whole.step) == (True, 0.0, len(todo))


def test_steps_that_were_prepared_before_tell_nothing_of_the_pace() -> None:
    todo = tasks(VESSEL)
    usual = [task.seconds for task in todo]
    assert paced(todo, []) == 1
    assert paced(todo, [0.1, 3 * usual[1]]) == pytest.approx(3)


@pytest.fixture
def noted(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The folder of kernels, with one, and a note that it is all."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.setattr(stamp, "_stamp", lambda: tmp_path / "notes" / "kernels.json")
    folder = tmp_path / "kernels"
    folder.mkdir()
    (folder / "one.nbi").touch()
    monkeypatch.setattr(stamp, "_cache_folders", lambda: iter([folder]))
    assert not stamp.is_prepared()
    stamp.note_prepared()
    return folder


def test_it_is_done_once(noted: Path) -> None:
    assert stamp.is_prepared()


def test_and_again_where_a_kernel_is_gone(noted: Path) -> None:
    (noted / "one.nbi").unlink()
    assert not stamp.is_prepared()


def test_and_again_with_other_sources(noted: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(stamp, "PACKAGES", ("enhance",))
    assert not stamp.is_prepared()


def test_a_damaged_note_is_none(noted: Path) -> None:
    for content in (b"", b"[]", b"{}", b'{"key": 1, "files": [1]}'):
        stamp._stamp().write_bytes(content)
        assert not stamp.is_prepared()


def test_where_nothing_can_be_written_nothing_is_noted(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "file").touch()
    monkeypatch.setattr(stamp, "_stamp", lambda: tmp_path / "file" / "kernels.json")
    stamp.note_prepared()
    assert not stamp.is_prepared()


def test_what_both_methods_share_is_counted_once() -> None:
    def seconds(first: Preset) -> float:
        return sum(task.seconds for task in tasks(first))

    assert seconds(PAPER) == seconds(VESSEL)
    assert all(task.seconds > 0 for task in tasks())


def test_a_step_that_takes_longer_than_it_should_tells_of_all_that_follow() -> None:
    todo = tasks()
    slow = Preparation(todo, 0, seconds=3 * todo[0].seconds)
    assert slow.seconds_until(todo[0].kind) == OVER * slow.seconds
    rest = sum(task.seconds for task in todo[1:])
    assert slow.seconds_left == pytest.approx(OVER * slow.seconds + 3 * rest)


def test_an_end_that_moves_away_is_called_longer_than_expected() -> None:
    made = Preparer()
    first = made.poll()
    assert first is not None
    assert "longer" not in worded(first)
    made._since -= 3 * first.tasks[0].seconds
    late = made.poll()
    assert late is not None
    assert late.seconds_left > first.seconds_left
    assert "· longer than expected, about " in worded(late)
    made.close()


def test_a_second_process_takes_the_steps_of_its_kinds(monkeypatch: pytest.MonkeyPatch) -> None:
    taken: list[Task] = []
    monkeypatch.setattr(preparer, "_begin", lambda pipe: None)
    monkeypatch.setattr("app.kernels.steps.use", taken.append)
    preparer.take(None, ("training", "3D view"))  # type: ignore[arg-type]
    assert taken == [task for task in tasks() if task.kind in ("training", "3D view")]


def test_a_second_process_is_waited_for_and_leaves_nothing() -> None:
    before = set(children())
    with preparer.taken_beside(()) as wait:
        (process,) = set(children()) - before
        wait()
        assert not process.is_running()
    with preparer.taken_beside(("training",)):
        (process,) = set(children()) - before
    assert not process.is_running()
