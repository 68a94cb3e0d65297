"""An export is shown in its folder by the file manager of the system."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

from app.errors import UserError
from app.gui.actions import actions, export_actions
from app.gui.work.revealing import RevealRequest, plain_environment, reveal, shown_by
from tests.app.gui.exporting import Exporter, exported


def test_the_command_of_each_system(tmp_path: Path) -> None:
    path = tmp_path / "a.png"
    assert shown_by(path, "darwin") == ("open", "-R", str(path))
    assert shown_by(path, "win32") == ("explorer", f'/select,"{path}"')
    assert shown_by(path, "linux") == ("xdg-open", str(tmp_path))
    assert shown_by(tmp_path, "linux") == ("xdg-open", str(tmp_path))


def test_explorer_gets_a_path_with_spaces_and_commas_as_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "Doe, Jane.png"
    path.touch()
    started: list[object] = []

    def start(command: object, **rest: object) -> subprocess.CompletedProcess[bytes]:
        started.append((command, rest["executable"]))
        raise OSError(2, "none here")

    monkeypatch.setattr("app.gui.work.revealing.which", lambda name: rf"C:\Windows\{name}.exe")
    monkeypatch.setattr(subprocess, "Popen", start)
    monkeypatch.setattr(sys, "platform", "win32")
    with pytest.raises(UserError, match="none here"):
        list(reveal(RevealRequest(path)))
    assert started == [(f'explorer /select,"{path}"', r"C:\Windows\explorer.exe")]


@pytest.mark.skipif(sys.platform != "linux", reason="starts a program of a Linux desktop")
def test_the_file_manager_is_started_and_trouble_is_one_line(
    run: Exporter, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    program = tmp_path / "bin" / "xdg-open"
    program.parent.mkdir()
    monkeypatch.setenv("PATH", f"{program.parent}{os.pathsep}/usr/bin{os.pathsep}/bin")
    path = exported(run, "both panes")
    monkeypatch.setattr("app.gui.work.revealing.which", lambda name: None)
    export_actions.reveal(run.state)
    run.turn()
    assert run.state.window.banner is not None
    assert run.state.window.banner.message.startswith("no file manager was found")
    actions.dismiss(run.state)
    monkeypatch.setattr("app.gui.work.revealing.which", lambda name: str(program))
    program.write_text(f'#!/bin/sh\nprintf %s "$1" > {tmp_path}/seen\n')
    program.chmod(0o755)
    export_actions.reveal(run.state)
    run.turn()
    assert (tmp_path / "seen").read_text() == str(path.parent)
    assert run.state.window.banner is None
    program.write_text("#!/bin/sh\nexit 3\n")
    with pytest.raises(UserError, match="no file manager"):
        list(reveal(RevealRequest(path)))
    # One that stays open is waited for by nobody.
    program.write_text("#!/bin/sh\nsleep 1\n")
    monkeypatch.setattr("app.gui.work.revealing.PATIENCE", 0.1)
    began = time.monotonic()
    steps = reveal(RevealRequest(path))
    assert next(steps) == path
    assert time.monotonic() - began < 0.9
    assert list(steps) == []
    path.unlink()
    with pytest.raises(UserError, match="no longer"):
        list(reveal(RevealRequest(path)))


def test_programs_of_the_system_get_the_system_s_libraries(monkeypatch: pytest.MonkeyPatch) -> None:
    bundle = {"LD_LIBRARY_PATH": "/bundle", "LD_LIBRARY_PATH_ORIG": "/mine", "HOME": "/h"}
    assert plain_environment(bundle)["LD_LIBRARY_PATH"] == "/mine"
    assert plain_environment({"LD_LIBRARY_PATH": "/x"}) == {"LD_LIBRARY_PATH": "/x"}
    monkeypatch.setattr(sys, "frozen", True, raising=False)
    assert plain_environment({"LD_LIBRARY_PATH": "/bundle"}) == {}
