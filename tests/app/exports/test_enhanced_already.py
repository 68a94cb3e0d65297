"""What is enhanced already is opened and enhanced all the same, with a line of warning."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from app.exports.replay.enhanced_already import enhanced_already
from app.gui.work.opening import OpenRequest, open_path
from tests.app.conftest import Cli


@pytest.mark.parametrize("name", ["made.png", "made.jpg", "made.mp4", "made.dcm"])
def test_of_an_image_a_video_or_dicom(folder: Path, tmp_path: Path, vesselsplat: Cli, name: str) -> None:
    given = folder if name.endswith(".mp4") else folder / "1.png"
    made = tmp_path / name
    assert "enhanced already" not in vesselsplat("enhance", given, made, "--d-factor", "0.5").error
    said = f"{name} is enhanced already by VesselSplat, method paper: it is no original"
    (opened,) = open_path(OpenRequest(made))
    assert opened.to_be_read[0] == said
    assert opened.is_enhanced
    (again,) = open_path(OpenRequest(given if given.is_file() else folder / "1.png"))
    assert again.to_be_read == ()
    assert not again.is_enhanced
    output = "again.mp4" if name.endswith(".mp4") else "again.png"
    call = vesselsplat("enhance", made, tmp_path / output, "--d-factor", "0.5")
    assert (call.code, call.error.count(said)) == (0, 1)
    call = vesselsplat("enhance", made, folder / "1.png", tmp_path / "both", "--d-factor", "0.5")
    assert (call.code, call.error.count(said)) == (0, 1)


def test_of_a_folder_in_a_batch_its_first_image_tells(folder: Path, tmp_path: Path, vesselsplat: Cli) -> None:
    out, again = tmp_path / "out", tmp_path / "again"
    assert "enhanced already" not in vesselsplat("enhance", folder, out, "--method", "clahe").error
    call = vesselsplat("enhance", out, again, "--recursive", "--method", "clahe")
    assert (call.code, call.error.count(".png is enhanced already by VesselSplat, method clahe")) == (0, 1)


def test_of_panes_and_of_records_of_any_form(tmp_path: Path) -> None:
    video = tmp_path / "a.mp4"
    video.touch()

    def said(facts: object) -> str:
        Path(f"{video}.json").write_text(json.dumps(facts))
        return enhanced_already(video)

    assert said({"kind": "panes video", "panes": [{"shows": "original"}]}) == ""
    assert said({"kind": "panes video", "panes": [{"shows": "setting"}]})
    assert said({"kind": "enhanced video", "pictures": [3]})
    for other in ({"kind": "live recording"}, {"kind": []}, {"panes": [3, {"shows": []}]}, [1], {}):
        assert said(other) == ""
    Path(f"{video}.json").unlink()
    assert enhanced_already(video) == enhanced_already(tmp_path) == ""
