"""A clip that nothing can be reconstructed from: all else is measured, and what is not says why."""

from __future__ import annotations

import json
from pathlib import Path

import cv2
import pytest

from app.errors import UserError
from app.report.bench import Bench, Clock
from app.report.section import Section
from renderer.clip import ClipError
from tests.app.conftest import Cli
from tests.enhance.pictures import vessels

REASON = "reconstruction expects depth, and this clip has none"


@pytest.fixture
def images(tmp_path: Path) -> Path:
    folder = tmp_path / "case"
    folder.mkdir()
    for index in range(3):
        cv2.imwrite(str(folder / f"{index}.png"), vessels(72, 96, index))
    return folder


def test_the_parts_that_need_no_depth_are_written(images: Path, tmp_path: Path, vesselsplat: Cli) -> None:
    out = tmp_path / "report"
    names = "enhancement,training,drawing,paper"
    call = vesselsplat("report", "--clip", images, "--out", out, "--parts", names)
    assert call.code == 0, call.error
    text = (out / "report.json").read_text()
    parts = json.loads(text)["parts"]
    assert list(parts) == names.split(",")
    assert parts["training"]["not_measured"] == [REASON]
    assert parts["drawing"]["not_measured"] == [f"no trained model: {REASON}"]
    assert {f"renders of Tables 1 and 2: {REASON}", f"DV/BV of renders: {REASON}"} <= {
        *parts["paper"]["not_measured"]
    }
    assert any(table["title"].startswith("Table 3: methods") for table in parts["paper"]["tables"])
    assert parts["enhancement"]["plates"]
    assert f"not measured: {REASON}" in call.error
    assert str(tmp_path) not in text
    assert REASON in (out / "report.html").read_text()


@pytest.mark.parametrize("kind", [ClipError, UserError])
def test_a_part_that_fails_takes_no_other_with_it(
    kind: type[Exception], images: Path, tmp_path: Path, vesselsplat: Cli, monkeypatch: pytest.MonkeyPatch
) -> None:
    def failing(bench: Bench, clock: Clock) -> Section:
        raise kind(f"expected an image, got a damaged one: {images / '2.png'}")

    quick = Section(title="Enhancement")
    monkeypatch.setattr("app.report.measures.enhancement.measure", lambda *_: quick)
    monkeypatch.setattr("app.report.measures.stability.measure", failing)
    out = tmp_path / "report"
    call = vesselsplat("report", "--clip", images, "--out", out, "--parts", "enhancement,stability")
    assert call.code == 0, call.error
    parts = json.loads((out / "report.json").read_text())["parts"]
    assert parts["enhancement"]["title"] == quick.title
    (reason,) = parts["stability"]["not_measured"]
    assert reason == "expected an image, got a damaged one: case/2.png"
