"""The script that tells what a machine lacks: on machines made of a few programs."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from tests.app.conftest import ROOT

SCRIPT = ROOT / "install" / "system-packages"
NOTHING = "#!/bin/sh\nexit 0\n"
BARE_PYTHON = """#!/bin/sh
case "$2" in
  *version_info\\ \\<*) exit 0 ;;
  *print*) echo python3.11-venv ;;
  *) exit 1 ;;
esac
"""
"""Without venv, and where no library loads."""
OLD_PYTHON = """#!/bin/sh
case "$2" in
  *python_version*) echo 3.9.2 ;;
  *) exit 1 ;;
esac
"""
pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="elsewhere nothing is needed")


class Machine:
    """One whose PATH holds these programs alone; nobody is root there, and sudo asks for a password."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self.add("id", "#!/bin/sh\necho 1000\n")
        self.add("uname", "#!/bin/sh\necho Linux\n")
        self.add("python3", BARE_PYTHON)

    def add(self, name: str, text: str) -> None:
        (self._folder / name).write_text(text)
        (self._folder / name).chmod(0o755)

    def ask(self, *targets: str, **variables: str) -> subprocess.CompletedProcess[str]:
        environment = {"PATH": str(self._folder), "VENV": str(self._folder / "none")} | variables
        return subprocess.run(
            ["/bin/sh", SCRIPT, *targets], env=environment, capture_output=True, text=True, timeout=60
        )


@pytest.fixture
def machine(tmp_path: Path) -> Machine:
    return Machine(tmp_path)


def test_debian_without_rights_is_told_the_exact_command(machine: Machine) -> None:
    machine.add("apt-get", NOTHING)
    machine.add("sudo", "#!/bin/sh\nexit 1\n")
    told = machine.ask("test")
    assert told.returncode == 2
    [line] = told.stderr.splitlines()
    for word in (
        "Xvfb",
        "EGL",
        "venv",
        "sudo apt-get install",
        "xvfb",
        "libegl1",
        "libgomp1",
        "python3.11-venv",
    ):
        assert word in line


def test_only_what_the_target_needs_is_missed(machine: Machine) -> None:
    machine.add("apt-get", NOTHING)
    demo, lint = machine.ask("demo"), machine.ask("lint")
    shown = machine.ask("test", DISPLAY=":0")
    assert "xvfb" not in demo.stderr
    assert "libegl1" in demo.stderr
    assert "libegl1" not in lint.stderr
    assert "xvfb" not in shown.stderr
    machine.add("Xvfb", NOTHING)
    assert "xvfb" not in machine.ask("test").stderr


@pytest.mark.parametrize(
    ("manager", "words"),
    [
        ("dnf", "dnf install python3 libglvnd-egl"),
        ("pacman", "pacman -S python libglvnd"),
        ("none", "libegl1"),
    ],
)
def test_other_systems_are_told_what_is_missing(machine: Machine, manager: str, words: str) -> None:
    machine.add(manager, NOTHING)
    told = machine.ask("demo")
    assert told.returncode == 2
    [line] = told.stderr.splitlines()
    assert words in line


def test_an_old_python_is_one_line(machine: Machine) -> None:
    machine.add("python3", OLD_PYTHON)
    told = machine.ask("demo")
    assert told.returncode == 2
    [line] = told.stderr.splitlines()
    assert "expected Python 3.11 or newer, python3 is 3.9.2" in line


def test_macos_needs_python_alone(machine: Machine) -> None:
    machine.add("uname", "#!/bin/sh\necho Darwin\n")
    machine.add("python3", NOTHING)
    assert machine.ask("demo", "test").returncode == 0


def test_what_is_missing_is_installed_by_sudo_and_looked_for_again(machine: Machine, tmp_path: Path) -> None:
    machine.add("sudo", '#!/bin/sh\n[ "$1" != -n ] || shift\nexec "$@"\n')
    machine.add("true", NOTHING)
    machine.add("env", '#!/bin/sh\nshift\nexec "$@"\n')
    machine.add("apt-get", f'#!/bin/sh\necho "$*" >> {tmp_path}/asked\n')
    told = machine.ask("demo")
    asked = (tmp_path / "asked").read_text().splitlines()
    assert asked[0].startswith("update")
    assert "install" in asked[1]
    assert "libegl1" in asked[1]
    # This apt-get has installed nothing.
    assert told.returncode == 2
    assert "still missing" in told.stderr.splitlines()[-1]
