"""Commands that are named to be run are as the shell of the system takes them."""

from __future__ import annotations

import sys

import pytest

from app.commands.described.fact import command


def test_commands_are_written_as_the_systems_shell_takes_them(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "platform", "win32")
    assert command("replay", r"C:\a b\film.mp4") == r'vesselsplat replay "C:\a b\film.mp4"'
    assert command("replay", r"C:\a\film.mp4") == r"vesselsplat replay C:\a\film.mp4"
