"""`vesselsplat metrics`: which original belongs to which image."""

from __future__ import annotations

import json
from pathlib import Path

import cv2
import pytest

from tests.app.conftest import Cli, tissue


@pytest.fixture
def originals(tmp_path: Path) -> Path:
    return written(tmp_path / "originals", range(4))


def written(folder: Path, numbers: range, name: str = "{:03d}.png") -> Path:
    """Images whose content follows from their number."""
    folder.mkdir()
    for number in numbers:
        cv2.imwrite(str(folder / name.format(number)), tissue(number, 100 + 20 * number))
    return folder


def pairs(vesselsplat: Cli, *arguments: object) -> list[tuple[str, str, float | None]]:
    call = vesselsplat("metrics", *arguments, "--json")
    assert call.code == 0, call.error
    images = json.loads(call.out)["images"]
    return [(one["image"]["name"], one["original"]["name"], one["psnr"]) for one in images]


def test_folders_are_paired_by_name_however_many_originals_there_are(
    originals: Path, tmp_path: Path, vesselsplat: Cli
) -> None:
    results = written(tmp_path / "results", range(1, 3))
    found = pairs(vesselsplat, results, "--against", originals)
    assert found == [("001.png", "001.png", None), ("002.png", "002.png", None)]
    single = pairs(vesselsplat, results / "002.png", "--against", originals)
    assert single == [("002.png", "002.png", None)]


def test_several_folders_are_paired_folder_by_folder(
    originals: Path, tmp_path: Path, vesselsplat: Cli
) -> None:
    others = written(tmp_path / "others", range(2, 6))
    found = pairs(vesselsplat, others, originals, "--against", others, originals)
    assert [(one, other) for one, other, _ in found] == [(one, one) for one, *_ in found]
    assert {ratio for *_, ratio in found} == {None}


def test_an_image_without_an_original_of_its_name_is_refused_where_others_have_one(
    originals: Path, tmp_path: Path, vesselsplat: Cli
) -> None:
    results = written(tmp_path / "results", range(1, 5))
    call = vesselsplat("metrics", results, "--against", originals)
    assert (call.code, call.out, call.error.count("\n")) == (2, "", 1)
    assert "got none for 004.png" in call.error
    assert "3 of 4" in call.error
    call = vesselsplat("metrics", results, "--vessels", originals)
    assert (call.code, "one vessel mask for each image by its name" in call.error) == (2, True)


def test_other_names_are_paired_in_order_where_there_are_as_many(
    originals: Path, tmp_path: Path, vesselsplat: Cli
) -> None:
    results = written(tmp_path / "results", range(4), "enhanced-{}.png")
    assert {ratio for *_, ratio in pairs(vesselsplat, results, "--against", originals)} == {None}
    (originals / "000.png").unlink()
    call = vesselsplat("metrics", results, "--against", originals)
    assert (call.code, "one original for each of 4 images, got 3" in call.error) == (2, True)


def test_videos_are_paired_frame_by_frame_where_they_have_as_many(tmp_path: Path, vesselsplat: Cli) -> None:
    paths = {name: tmp_path / f"{name}.avi" for name in ("whole", "end", "again")}
    for name, numbers in (("whole", range(4)), ("end", range(2, 4)), ("again", range(4))):
        writer = cv2.VideoWriter(str(paths[name]), cv2.VideoWriter.fourcc(*"MJPG"), 10.0, (60, 40))
        for number in numbers:
            writer.write(tissue(number, 100 + 20 * number))
        writer.release()
    for flag in ("--against", "--vessels"):
        call = vesselsplat("metrics", paths["end"], flag, paths["whole"])
        assert (call.code, call.out, call.error.count("\n")) == (2, "", 1)
        assert "for each frame of a video, got 2 frames and 4" in call.error
    both = pairs(vesselsplat, paths["whole"], paths["again"], "--against", paths["whole"])
    assert [one[0] for one in both] == ["whole.avi"] * 4 + ["again.avi"] * 4
    assert {ratio for *_, ratio in both} == {None}
    frames = tmp_path / "frames"
    frames.mkdir()
    cv2.imwrite(str(frames / "frame-000003.png"), tissue(3, 160))
    ((_, _, ratio),) = pairs(vesselsplat, frames, "--against", paths["whole"])
    assert ratio is not None
    assert ratio > 25, "by its number"


def test_files_named_one_by_one_keep_their_order(originals: Path, vesselsplat: Cli) -> None:
    first, second = originals / "001.png", originals / "002.png"
    found = pairs(vesselsplat, first, second, "--against", second, first)
    assert [(one, other) for one, other, _ in found] == [("001.png", "002.png"), ("002.png", "001.png")]


def test_images_of_one_name_are_told_apart_by_their_folders(
    originals: Path, tmp_path: Path, vesselsplat: Cli
) -> None:
    others = written(tmp_path / "others", range(3, 5))
    call = vesselsplat("metrics", originals, others, "--json")
    told = [(one["image"]["name"], one["image"].get("path")) for one in json.loads(call.out)["images"]]
    assert told[2:] == [
        ("002.png", None),
        ("003.png", "originals/003.png"),
        ("003.png", "others/003.png"),
        ("004.png", None),
    ]
    table = vesselsplat("metrics", originals, others).out
    assert all(table.count(name) >= 1 for name in ("originals/003.png", "others/003.png"))
    deep = tmp_path / "deep"
    deep.mkdir()
    again = written(deep / "others", range(3, 4))
    told = json.loads(vesselsplat("metrics", others, again, others, "--json").out)["images"]
    ends = [one["image"].get("path") for one in told]
    assert ends == [f"{tmp_path.name}/others/003.png", None, "deep/others/003.png", ends[0], None]
