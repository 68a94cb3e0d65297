"""What the file dialog makes of folders and files that cannot be looked at, and which files it shows."""

from __future__ import annotations

import os
import re
import sys
from pathlib import Path

import cv2
import numpy as np
import pytest
from imgui_bundle import imgui

from app.commands.described.paths import described
from app.errors import UserError
from app.gui.actions import browse_actions
from app.gui.state.choosing import OPENED
from app.gui.work.listing import SIDE, ListRequest, list_folder
from app.gui.work.opening import OpenRequest, open_path
from tests.app.gui.chooser import Chooser

K = imgui.Key


def test_entries_that_may_not_be_looked_at_cannot_be_chosen(
    case: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    look = Path.stat

    def stat(path: Path, **how: bool) -> os.stat_result:
        if path.name == "A clip":
            raise PermissionError(13, "Permission denied", str(path))
        return look(path, **how)

    monkeypatch.setattr(Path, "stat", stat)
    (listing,) = list_folder(ListRequest(case))
    kinds = {entry.name: entry.kind for entry in listing.entries}
    assert (kinds["A clip"], kinds["b clip"], kinds["2.png"]) == (None, "folder", "file")


def test_a_folder_that_cannot_be_read_says_so(
    chooser: Chooser, case: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refused(path: object) -> None:
        raise PermissionError(13, "Permission denied", str(path))

    monkeypatch.setattr("app.gui.work.listing.os.scandir", refused)
    chooser.ask("file", "file", case)
    assert chooser.browsing.listing is not None
    assert "Permission denied" in chooser.browsing.listing.trouble
    assert chooser.names() == []
    monkeypatch.setattr("app.gui.work.listing.is_folder", lambda path: False)
    with pytest.raises(UserError, match="nowhere"):
        list(list_folder(ListRequest(Path("nowhere"))))


def test_a_folder_whose_files_may_not_be_looked_at_is_named(
    case: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("renderer.regular_files.os.access", lambda path, how: path != case)
    with pytest.raises(UserError, match=re.escape(f"Permission denied: {case}") + "$"):
        list(open_path(OpenRequest(case)))
    with pytest.raises(PermissionError, match=re.escape(f"'{case}'") + "$"):
        described(case)


@pytest.mark.skipif(sys.platform != "linux", reason="elsewhere file names are Unicode")
def test_a_name_that_is_not_utf_8_is_shown_and_still_opens_its_file(chooser: Chooser, case: Path) -> None:
    path = Path(os.fsdecode(os.fsencode(case) + b"/caf\xe9.png"))
    path.write_text("")
    chooser.ask("file", "file", case)
    entry = next(one for one in chooser.browsing.entries if one.path == path)
    assert entry.name == "caf?.png"
    browse_actions.mark(chooser.browsing, entry)
    chooser.frames(2)
    assert chooser.browsing.text.endswith("caf?.png")
    chooser.press(K.enter)
    assert chooser.chosen == [path]


def test_images_videos_and_clips_have_thumbnails_and_damaged_files_an_icon(
    chooser: Chooser, case: Path
) -> None:
    red = np.full((60, 320, 3), (0, 0, 200), np.uint8)
    cv2.imwrite(str(case / "2.png"), red)
    cv2.imwrite(str(case / "A clip" / "mask.png"), np.zeros_like(red))
    (case / "A clip" / "img_left").mkdir()
    cv2.imwrite(str(case / "A clip" / "img_left" / "0.jpg"), red)
    cv2.imwrite(str(case / "deep.png"), np.full((40, 80), 60000, np.uint16))
    writer = cv2.VideoWriter(str(case / "scope.mp4"), cv2.VideoWriter.fourcc(*"mp4v"), 10.0, (64, 48))
    for frame in range(20):
        writer.write(np.full((48, 64, 3), (0, 0, 200 if frame else 0), np.uint8))
    writer.release()
    chooser.ask("file", "file", case)
    chooser.frames(10)
    found = {path.name: image for path, image in chooser.browsing.thumbnails.items()}
    assert found["10.png"] is None  # It is empty.
    assert found["b clip"] is None
    for name in ("2.png", "A clip", "scope.mp4"):
        image = found[name]
        assert image is not None
        assert max(image.shape) <= SIDE
        assert np.abs(image.reshape(-1, 3).mean(axis=0) - (200, 0, 0)).max() < 12, name
    assert found["deep.png"] is not None
    assert found["deep.png"].min() > 200
    assert "notes.txt" not in found
    assert any(image is found["2.png"] for image in chooser.shown.images.values())


def test_all_that_the_reader_takes_is_listed_as_what_opens() -> None:
    for name in ("a.gif", "a.HEIC", "a.avif", "a.jp2", "a.ts", "a.mp4", "a.dcm", "a.sog", "a.tif"):
        assert OPENED.passes(Path(name))
    assert not OPENED.passes(Path("a.docx"))
