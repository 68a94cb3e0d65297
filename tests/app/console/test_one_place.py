"""A module of somebody else under one of the program's names is one line, before anything of it is run."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from app.__main__ import main
from app.console import startup
from app.errors import UserError
from tests.app.conftest import ROOT

FOREIGN = "raise SystemExit('somebody else was run')\n"


def start(folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    """As `python -m app` in that folder, which comes first on the path."""
    command = [sys.executable, "-m", "app", *arguments]
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    return subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, timeout=60)


@pytest.mark.parametrize("name", ["renderer", "enhance", "assets"])
@pytest.mark.parametrize("form", ["{}.py", "{}/__init__.py"])
def test_another_s_package_is_refused_in_one_line(tmp_path: Path, name: str, form: str) -> None:
    path = tmp_path / form.format(name)
    path.parent.mkdir(exist_ok=True)
    path.write_text(FOREIGN)
    for command in ("--version", "info"):
        done = start(tmp_path, command)
        assert (done.returncode, done.stdout, done.stderr.count("\n")) == (2, "", 1)
        assert f"got another {name}: {tmp_path / name}" in done.stderr


def test_another_s_app_is_refused_by_what_belongs_to_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Such as one that came first on the path of the installed program when it looked for the others."""
    (tmp_path / "app.py").write_text(FOREIGN)
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.delitem(sys.modules, "app")
    assert main(["--version"]) == 2
    assert f"got another app: {tmp_path / 'app.py'}" in capsys.readouterr().err


def test_folders_that_are_no_packages_are_no_matter(tmp_path: Path) -> None:
    for name in startup.PACKAGES:
        (tmp_path / name).mkdir()
        (tmp_path / name / "notes.txt").write_text("mine")
    assert start(tmp_path, "--version").returncode == 0


def test_a_package_that_is_missing_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(startup, "find_spec", lambda name: None)
    with pytest.raises(UserError, match="got no app in"):
        startup.require_one_place()
