"""Names in other scripts than the window's own font has are shown by the system's fonts."""

from __future__ import annotations

from pathlib import Path

import pytest

from app.gui.style import fonts


def test_of_each_choice_the_first_font_that_is_there_is_taken(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    there = tuple(tmp_path / name for name in ("b.ttc", "c.ttc"))
    for path in there:
        path.write_bytes(b"font")
    wanted = tuple(map(str, (tmp_path / "a.ttc", *there)))
    choices = {"linux": ((1.2, wanted), (1.0, wanted[2:])), "win32": ((1.2, wanted[:1]), (1.0, wanted[1:]))}
    monkeypatch.setattr(fonts, "OF_SYSTEM", choices)
    assert fonts.of_system("linux") == ((1.2, there[0]), (1.0, there[1]))
    assert fonts.of_system("win32") == ((1.0, there[0]),)
    assert fonts.of_system("plan9") == ()


def test_where_no_such_font_is_the_window_has_its_own(monkeypatch: pytest.MonkeyPatch) -> None:
    loaded: list[str] = []
    monkeypatch.setattr(fonts, "OF_SYSTEM", {})
    monkeypatch.setattr(
        "imgui_bundle.hello_imgui.load_font_ttf_with_font_awesome_icons",
        lambda name, size: loaded.append(name),
    )
    fonts.load_fonts()
    assert loaded == [fonts.OWN]
