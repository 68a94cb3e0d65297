"""What files say of themselves: nothing of it is lost, and what no pixel needs may be odd."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any, get_args

import numpy as np
import pytest

from app.enhancement.measures import Lengths
from app.enhancement.records import EnhancedVideo
from app.errors import UserError
from app.exports.measures import write_measures
from app.exports.records import EXPORT, KINDS, MeasuresTable
from app.exports.replay.again import replay
from app.exports.replay.recorded import recorded
from app.files.image_files import read_image
from app.files.provenance import SCHEMA, plain, strict_json, write_png
from enhance import enhance_vessels
from enhance.field import FieldOfView
from enhance.noise import NoiseCut
from enhance.vessel import VesselParams
from tests.app.exports.test_before import BEFORE, FILES, SOURCES

HEAD = {"app", "version", "schema", "utc", "notice", "libraries"}
TABLE = {"definitions", "frames"}
"""Of measures: what is worked out again."""


def said(name: str) -> dict[str, Any]:
    """All but the head."""
    return {key: value for key, value in recorded(BEFORE / name).items() if key not in HEAD}


@pytest.mark.parametrize("name", [*FILES, "window.png"])
def test_all_that_files_of_before_say_is_kept(name: str) -> None:
    facts = {key: value for key, value in said(name).items() if key not in TABLE}
    now = EXPORT.validate_python(facts)
    assert_kept(facts, plain(now) | ({"pictures": plain(list(now.pictures))} if "pictures" in facts else {}))


@pytest.mark.parametrize("cut", get_args(NoiseCut))
def test_a_table_defines_noise_as_it_was_cut(cut: NoiseCut, tmp_path: Path) -> None:
    path, names = tmp_path / "table.csv", ("noise_gain", "chroma_noise_gain")
    write_measures(path, [], MeasuresTable(first_frame=0, last_frame=0, measures=names, noise_cut=cut))
    defined = recorded(path)["definitions"]
    assert ("clipped" in defined["noise_gain"]) is (cut == "unclipped")
    assert ("blocks" in defined["chroma_noise_gain"]) is (cut == "unclipped")


@pytest.mark.parametrize("lengths", get_args(Lengths))
def test_a_table_defines_the_colour_difference_by_its_lengths(lengths: Lengths, tmp_path: Path) -> None:
    path, names = tmp_path / "table.csv", ("color_difference",)
    write_measures(path, [], MeasuresTable(first_frame=0, last_frame=0, measures=names, lengths=lengths))
    assert ("640" in recorded(path)["definitions"]["color_difference"]) is (lengths == "by size")


def test_a_video_says_of_each_frame_what_differs_from_the_first() -> None:
    """All of each, as it was said before, is read as well."""
    facts = said("enhanced.mp4")
    read = EXPORT.validate_python(facts)
    assert isinstance(read, EnhancedVideo)
    first, second, *_ = read.pictures
    odd = replace(first, frame=7, params=None, statistics=None, pixels="tissue")
    for pictures in ((first, second, odd, first), (odd, first), (first,), ()):
        video = replace(read, pictures=pictures)
        assert EXPORT.validate_python(json.loads(strict_json(video))) == video
        assert EXPORT.validate_python(facts | {"pictures": plain(list(pictures))}) == video
    (_, short, other) = plain(replace(read, pictures=(first, second, odd)))["pictures"]
    assert short == {"source": plain(second.source), "picture": second.picture}
    assert other.keys() == {"frame", "params", "statistics", "pixels"}


def assert_kept(before: Any, now: Any, place: str = "") -> None:
    """Everything that was said is said, but for None, which nothing says as well."""
    if isinstance(before, dict):
        for key, value in before.items():
            if key == "tissue_only":
                assert now["pixels"] == ("tissue" if value else "all"), place
            elif value is not None or key in now:
                assert key in now, f"{place}.{key}"
                assert_kept(value, now[key], f"{place}.{key}")
    elif isinstance(before, list):
        assert len(before) == len(now), place
        for one, other in zip(before, now, strict=True):
            assert_kept(one, other, place)
    else:
        assert before == now, place


def test_the_files_of_before_are_of_every_kind() -> None:
    assert {said(name)["kind"] for name in (*FILES, "window.png")} == set(KINDS)


@pytest.mark.parametrize("name", ["render-color.png", "panes-and-view.png", "depth.npy", "tuned.png"])
def test_a_file_that_was_made_again_is_made_again_of_its_own_record(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(BEFORE)
    first, second = tmp_path / "first" / name, tmp_path / "second" / name
    replay(BEFORE / name, SOURCES, first)
    assert replay(first, SOURCES, second).difference.is_none
    assert recorded(first) | {"utc": None} == recorded(second) | {"utc": None}


def test_what_is_drawn_of_a_model_is_the_same_file_every_time(tmp_path: Path) -> None:
    first, second = tmp_path / "first.png", tmp_path / "second.png"
    for path in (first, second):
        replay(BEFORE / "render-color.png", SOURCES, path)
    assert first.read_bytes() == second.read_bytes()
    before, again = (EXPORT.validate_python(recorded(path)) for path in (BEFORE / "render-color.png", first))
    assert before == again


def changed(name: str, tmp_path: Path, **facts: object) -> Path:
    """The same picture that says something else."""
    path = tmp_path / name
    write_png(path, read_image(BEFORE / name), recorded(BEFORE / name) | facts)
    return path


def test_what_no_pixel_needs_keeps_nobody_from_replaying(tmp_path: Path) -> None:
    """A later or an earlier version may say it in another way."""
    odd = {"config": {"no": "such setting"}, "enhancement": 3, "iteration": "many", "clip": [], "newly": 1}
    path = changed("render-color.png", tmp_path, **odd)
    assert replay(path, SOURCES, tmp_path / "again.png").difference.largest <= 2


def test_what_a_later_version_says_besides_of_a_field_of_view_is_passed_over() -> None:
    facts = said("enhanced.png")
    size = {"width": 64, "height": 48}
    field = size | {"circle": [32.0, 24.0, 20.0]}
    for known, more in (
        (field, field | {"newly": 1}),
        (size | {"parts": [field, field]}, size | {"parts": [field, field | {"newly": 1}]}),
    ):
        one, other = (
            EXPORT.validate_python(facts | {"statistics": facts["statistics"] | {"field": said_so}})
            for said_so in (known, more)
        )
        assert one == other


def test_an_image_is_made_again_within_the_field_that_it_says(tmp_path: Path) -> None:
    """Whatever a later version finds."""
    used, name = said("enhanced.png")["statistics"], said("enhanced.png")["source"]["name"]
    seen = read_image(next(BEFORE.rglob(name)))
    height, width = seen.shape[:2]
    field = FieldOfView(width, height, circle=(width / 2, height / 2, height / 4))
    used |= {"scope": "image", "field": plain(field)}
    replay(
        changed("enhanced.png", tmp_path, pixels="automatic", statistics=used), SOURCES, tmp_path / "new.png"
    )
    again, inside = read_image(tmp_path / "new.png"), field.mask()
    assert np.array_equal(again[~inside], seen[~inside])
    assert not np.array_equal(again[inside], seen[inside])


def test_vessels_are_made_again_with_what_was_measured(tmp_path: Path) -> None:
    """Whatever a later version measures: of an image without red, they keep their hue."""
    name, least = said("enhanced.png")["source"]["name"], replace(VesselParams(), least_redness=1.0)
    seen = read_image(next(BEFORE.rglob(name)))
    told = replace(enhance_vessels(seen, least, pixels="all").statistics, redness=0.0, bright_level=60.0)
    path = changed(
        "enhanced.png", tmp_path, pixels="all", method="vessel", params=plain(least), statistics=plain(told)
    )
    replay(path, SOURCES, tmp_path / "new.png")
    wanted = enhance_vessels(seen, least, statistics=told, pixels="all").image
    assert np.array_equal(read_image(tmp_path / "new.png"), wanted)
    assert not np.array_equal(wanted, enhance_vessels(seen, least, pixels="all").image)


@pytest.mark.parametrize(
    "wrong", [{"supersampling": 0}, {"camera": {"fx": 1}}, {"renderer": 3}, {"time": "now"}, {"time": 2.0}]
)
def test_what_pixels_need_is_one_line(tmp_path: Path, wrong: dict[str, object]) -> None:
    path = changed("render-color.png", tmp_path, **wrong)
    with pytest.raises(UserError, match=next(iter(wrong))) as caught:
        replay(path, SOURCES, tmp_path / "again.png")
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("wrong", [{"scale": 0}, {"width": 1 << 20}, {"panes": [{"title": "A"}]}])
def test_a_page_that_none_is_is_one_line(tmp_path: Path, wrong: dict[str, object]) -> None:
    path = changed("panes.png", tmp_path, **wrong)
    with pytest.raises(UserError, match=next(iter(wrong))) as caught:
        replay(path, SOURCES, tmp_path / "again.png")
    assert "\n" not in str(caught.value)


def test_a_record_of_a_later_schema_is_refused(tmp_path: Path) -> None:
    path = changed("render-color.png", tmp_path, schema=SCHEMA + 1)
    with pytest.raises(UserError, match=f"schema {SCHEMA}, got {SCHEMA + 1}.*render-color.png"):
        replay(path, SOURCES, tmp_path / "again.png")


def test_a_folder_of_exports_is_asked_for_one_of_its_files(tmp_path: Path) -> None:
    with pytest.raises(UserError, match="got a folder; name one of its files"):
        recorded(tmp_path)
    with pytest.raises(UserError, match="got no such file"):
        recorded(tmp_path / "a.png")
