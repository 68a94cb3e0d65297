from __future__ import annotations

from pathlib import Path
from typing import Any

import cv2
import pytest

from app.report.bench import Bench, Clock
from app.report.measures import left_out
from app.report.section import Section
from renderer.phantom import Phantom, PhantomParams, write_phantom

FRAMES = PhantomParams(n_frames=9, width=64, height=48)


@pytest.fixture(scope="module")
def frames(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Without depth, without poses."""
    folder = tmp_path_factory.mktemp("case") / "images"
    folder.mkdir()
    phantom = Phantom(FRAMES)
    for index in range(FRAMES.n_frames):
        cv2.imwrite(str(folder / f"{index:02d}.png"), phantom.view(index).frame.image[..., ::-1])
    return folder


def measured(
    frames: Path, work: Path, monkeypatch: pytest.MonkeyPatch, seconds: float, **other: Any
) -> Section:
    quick = {"KINDS": (), "STEPS": 6, "TIMED": 4, "LAPS": 1} | other
    for name, value in quick.items():
        monkeypatch.setattr(left_out, name, value)
    return left_out.measure(Bench(None, (frames,), work, print), Clock.of(seconds))


def rows(section: Section, title: str) -> list[dict[str, Any]]:
    table = next(table for table in section.tables if table.title == title)
    names = [column.name for column in table.columns]
    return [dict(zip(names, row, strict=True)) for row in table.rows]


def test_a_scene_without_depth_is_measured_with_a_guess_and_says_so(
    frames: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    section = measured(frames, tmp_path, monkeypatch, 600)
    pairs = rows(section, "Reconstruction")
    assert {row["scene"] for row in pairs} == {f"{frames.parent.name}/images, depth estimated"}
    assert "harmonics" in {row["left out"] for row in pairs}
    for row in pairs:
        assert row["error added, dB"] == row["kept, dB"] - row["PSNR, dB"]
        assert row["time saved"] == 1 - row["ms per step"] / row["kept, ms"]
    assert len({(row["PSNR, dB"], row["ms per step"], row["MB"]) for row in pairs}) == 1, "one run without"
    assert any(row["memory saved"] > 0 for row in pairs)


def test_what_the_enhancement_leaves_out_is_named_and_stays_below_its_bound(
    frames: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    by_setting = {
        row["setting"]: row for row in rows(measured(frames, tmp_path, monkeypatch, 600), "Enhancement")
    }
    assert (by_setting["P = 0"]["left out"], by_setting["P = 1/2"]["left out"]) == ("local detail", "nothing")
    assert {row["memory saved"] for row in by_setting.values()} == {0}
    assert by_setting["z = 1"]["why"] == "z is 1"
    for row in by_setting.values():
        assert row["error, largest"] <= row["bound"] + 1e-3


def test_long_scenes_are_thinned_and_none_is_begun_when_the_time_is_used_up(
    frames: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    section = measured(frames, tmp_path, monkeypatch, -1, MOST_FRAMES=4)
    name = f"{frames.parent.name}/images, one frame in 3, depth estimated"
    assert section.not_measured == (f"{name}: no time left",)
    assert not rows(section, "Reconstruction")


def test_a_scene_of_which_the_field_keeps_few_frames_is_thinned_further(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of 20 frames of such a clip 5 count: one in 3 of these."""
    scene = tmp_path / "dataset_3" / "keyframe_1"
    write_phantom(scene, PhantomParams(n_frames=20, width=64, height=48, camera="moving"), "scared")
    monkeypatch.setattr(left_out, "MOST_FRAMES", 2)
    thinned = left_out._opened(scene, "scene", [])
    assert thinned is not None
    assert (thinned.name, len(thinned)) == ("scene, one frame in 12", 2)
