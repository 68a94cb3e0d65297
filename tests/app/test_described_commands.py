"""Commands that are named to be run are as the shell of the system takes them, and follow what a file is."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from app.commands.described.files import READ_WHOLE
from app.commands.described.paths import described
from app.console.shell import command
from app.files.provenance import provenance, write_sidecar


def test_commands_are_written_as_the_systems_shell_takes_them(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "platform", "win32")
    assert command("replay", r"C:\a b\film.mp4") == r'vesselsplat replay "C:\a b\film.mp4"'
    assert command("replay", r"C:\a\film.mp4") == r"vesselsplat replay C:\a\film.mp4"
    assert command("replay", r"C:\R&D\film.mp4") == r'vesselsplat replay "C:\R&D\film.mp4"'


@pytest.mark.parametrize("name", ["clip.4dgs", "tracks.csv"])
def test_a_large_export_with_its_provenance_beside_it_is_told(tmp_path: Path, name: str) -> None:
    path = tmp_path / name
    with path.open("wb") as file:
        file.truncate(READ_WHOLE + 1)
    write_sidecar(path, provenance(kind="made"))
    assert {fact.name: fact.text for fact in described(path)}["what"] == "exported by VesselSplat"
