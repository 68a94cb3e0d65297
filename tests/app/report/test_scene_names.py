from __future__ import annotations

from pathlib import Path

import cv2
import pytest

from app.report.bench import Bench, scene_names
from app.report.measures import left_out, paper
from renderer.phantom import PhantomParams
from tests.enhance.pictures import vessels


def test_scenes_are_told_apart_by_as_much_of_their_path_as_that_needs() -> None:
    paths = [Path("/data/a/rec/images"), Path("/data/b/rec/images"), Path("/data/a/other/images")]
    assert [*scene_names(paths).values()] == ["a/rec/images", "b/rec/images", "other/images"]
    assert scene_names([Path("/rec/images"), Path("/data/rec/images")]) == {
        Path("/rec/images"): "/rec/images",
        Path("/data/rec/images"): "data/rec/images",
    }
    assert scene_names([paths[0], paths[0]]) == {paths[0]: "rec/images"}


def test_two_scenes_of_one_name_are_two_tables_and_two_kinds_of_rows(
    clip_path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(left_out, "SMALL", PhantomParams(n_frames=2, width=48, height=40))
    scenes = tuple(tmp_path / patient / "rec" / "images" for patient in ("first", "second", "broken"))
    for seed, folder in enumerate(scenes[:2]):
        folder.mkdir(parents=True)
        cv2.imwrite(str(folder / "0.png"), vessels(72, 96, seed))
    scenes[2].mkdir(parents=True)
    missing: list[str] = []
    bench = Bench(clip_path, scenes, tmp_path / "work", print)
    sets = paper._sets(bench, missing)
    assert list(sets)[1:] == ["first/rec/images", "second/rec/images"]
    assert (sets["first/rec/images"][0].image != sets["second/rec/images"][0].image).any()
    assert [line.split(":")[0] for line in missing] == ["Table 3, broken/rec/images"]
    names = [scene.name for scene in left_out._scenes(bench, missing)]
    assert names[-2:] == ["first/rec/images, depth estimated", "second/rec/images, depth estimated"]
