from __future__ import annotations

import tempfile
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.enhancement.settable import MODES, PIXELS
from app.files.atomic import write_bytes
from app.gui.work.settings import (
    RECENT_LIMIT,
    TEXT_PERCENTS,
    Places,
    Settings,
    load_settings,
    settings_content,
)
from app.scenes.backgrounds import BACKGROUNDS

texts = st.lists(st.text(max_size=20), max_size=RECENT_LIMIT).map(tuple)


@given(
    st.builds(
        Settings,
        st.booleans(),
        st.booleans(),
        texts,
        st.sampled_from(["dark", "light"]),
        st.sampled_from(TEXT_PERCENTS),
        st.sampled_from(["paper", "vessel"]),
        st.sampled_from(["automatic", "image", "clip"]),
        st.sampled_from(PIXELS),
        st.sampled_from(MODES),
        background=st.sampled_from(list(BACKGROUNDS)),
        folders=st.dictionaries(st.sampled_from(["file", "export"]), st.text(max_size=20)),
    )
)
def test_what_is_saved_is_loaded(settings: Settings) -> None:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "deep" / "settings.json"
        write_bytes(path, settings_content(settings))
        assert load_settings(path) == settings


@pytest.mark.parametrize(
    "content", [None, "", "[]", "{}", '{"recent": 3}', "\x00\x01", '{"acknowledged": 1}']
)
def test_a_damaged_file_gives_the_defaults(tmp_path: Path, content: str | None) -> None:
    path = tmp_path / "settings.json"
    if content is not None:
        path.write_text(content)
    assert load_settings(path) == Settings()


def test_recent_is_newest_first_without_doubles_and_bounded() -> None:
    settings = Settings()
    for number in [*range(RECENT_LIMIT + 3), 5]:
        settings = settings.opened(Path(f"/clips/{number}"))
    assert len(settings.recent) == RECENT_LIMIT
    assert len(set(settings.recent)) == RECENT_LIMIT
    assert Path(settings.recent[0]).name == "5"


def test_what_has_moved_or_gone_is_so_in_the_recent_list() -> None:
    settings = Settings().opened(Path("/clips/a")).opened(Path("/runs/one")).opened(Path("/runs/two"))
    moved = settings.moved(Path("/runs/one"), Path("/runs/best"))
    assert moved.recent == ("/runs/two", "/runs/best", "/clips/a")
    assert moved.moved(Path("/runs/two"), None).recent == ("/runs/best", "/clips/a")
    assert moved.moved(Path("/runs/other"), None) == moved


def test_folders_of_dialogs_are_forgotten_with_recent_files() -> None:
    settings = Settings().visited("export", Path("/out")).visited("file", Path("/in"))
    assert settings.folders == {"export": "/out", "file": "/in"}
    off = settings.remembering(False)
    assert off.folders == {}
    assert off.visited("export", Path("/out")).folders == {}
    assert off.remembering(True).visited("file", Path("/in")).folders == {"file": "/in"}


def test_switching_recent_off_forgets_and_stays_empty() -> None:
    settings = Settings().opened(Path("/clips/a")).remembering(False).opened(Path("/clips/b"))
    assert settings.recent == ()


def test_places_follow_the_environment(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("VESSELSPLAT_CONFIG_DIR", str(tmp_path / "config"))
    places = Places.of_user()
    assert places.settings_file == tmp_path / "config" / "settings.json"
    assert not places.settings_file.parent.exists()


def test_settings_of_an_earlier_start_without_a_theme_are_kept(tmp_path: Path) -> None:
    path = tmp_path / "settings.json"
    path.write_text('{"acknowledged": true, "remember_recent": true, "recent": ["/a"], "text_percent": 1000}')
    assert load_settings(path) == Settings(acknowledged=True, recent=("/a",))


def test_text_grows_and_shrinks_by_steps_within_its_bounds() -> None:
    settings = Settings()
    assert settings.resized(1).resized(-1) == settings
    assert settings.resized(99).text_percent == 200
    assert settings.resized(-99).text_percent == 80
