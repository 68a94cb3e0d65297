"""The file of a sweep: what it asks for, and one line for what it cannot mean."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.errors import UserError
from app.sweeps.design import Range, Sample
from app.sweeps.plan import planned
from app.sweeps.settings import Enhancing
from app.sweeps.spec import Spec, all_settings, clip_paths, jobs_asked_for, read_spec, spec_of
from app.sweeps.spec_file import spec_text
from enhance import EnhanceParams
from tests.app.conftest import Cli

PLACE = Path("sweep.toml")


def spec(**given: object) -> Spec:
    return spec_of({"clips": ["a.png"], "task": "enhance"} | given, PLACE)


def test_every_variant_meets_every_point_of_the_grid_and_every_seed() -> None:
    asked = spec(
        task="train",
        variants=[{"method": "static"}, {"method": "vesselsplat", "smoothing": 0.01}],
        grid={"iterations": [10, 20], "node_columns": [5, 8, 9]},
        seeds=[3, 4],
    )
    settings = [one.told() for one in all_settings(asked)]
    found = {(s["method"], s["iterations"], s["node_columns"], s["seed"]) for s in settings}
    assert len(settings) == len(found) == 2 * 2 * 3 * 2 == jobs_asked_for(asked, clips=1)
    assert {s["smoothing"] for s in settings if s["method"] == "vesselsplat"} == {0.01}
    assert asked.varied == ("method", "smoothing", "iterations", "node_columns")


def test_settings_may_be_written_as_their_flags_are() -> None:
    for first, second, third, fourth in (
        ("n-gaussians", "node-columns", "depth-weight", "mean-rate"),
        ("n_gaussians", "node_columns", "depth_weight", "mean_rate"),
    ):
        asked = spec(
            task="train",
            settings={fourth: 0.5},
            variants=[{third: 0.5}],
            grid={first: [8000, 30000]},
            sample={"count": 2, "ranges": {second: {"from": 5, "to": 9, "whole": True}}},
        )
        assert asked.varied == ("depth_weight", "n_gaussians", "node_columns")
        assert [one.told()["n_gaussians"] for one in all_settings(asked)] == [8000, 8000, 30000, 30000]


def test_automatic_is_what_every_setting_is_without_it() -> None:
    for task, names in (
        ("train", ("depth", "stereo", "bottom_rows", "window_frames")),
        ("enhance", ("z", "p")),
    ):
        settings = dict.fromkeys(names, "auto")
        assert all_settings(spec(task=task, settings=settings)) == all_settings(spec(task=task))


def test_combinations_that_say_the_same_are_one_job() -> None:
    assert len(all_settings(spec(grid={"z": ["auto", 0.5, 0.5]}))) == 2


@pytest.mark.parametrize(
    ("given", "told"),
    [
        ({"clips": []}, "clips"),
        ({"task": "mash"}, "task: expected 'enhance', 'train' or 'mesh'"),
        ({"task": "mesh", "settings": {"vertices": 3}}, "vertices: expected a whole number from 100"),
        ({"task": "mesh", "settings": {"faces": 2.5}}, "faces: expected a whole number from 50"),
        ({"colour": 1}, "colour"),
        ({"grid": {"z": []}}, "grid.z"),
        ({"grid": {"z": [0.5, math.nan]}}, "grid.z.1: expected a finite number, got nan"),
        ({"variants": [{"eps": math.inf}]}, "variants.0.eps: expected a finite number, got inf"),
        ({"settings": {"z": 2.0}}, "z: expected"),
        ({"settings": {"z": 16**5000}}, "got a number of thousands of digits"),
        ({"frames": 16**5000}, "got a number of thousands of digits"),
        ({"settings": {"zz": 0.2}}, "expected settings among"),
        ({"settings": {"method": "clahe", "z": 0.2}}, "method clahe: expected settings among deinterlacing,"),
        ({"settings": {"statistics": "all"}}, "statistics: expected one of automatic, image, clip"),
        ({"settings": {"stereo": "both"}}, "stereo: expected"),
        ({"settings": {"method": "best"}}, "method: expected one of paper, vessel"),
        ({"settings": {"z": 0.1}, "grid": {"z": [0.2]}}, "expected each setting in one place, got z in two"),
        ({"settings": {"d-factor": 1}, "grid": {"d_factor": [2]}}, "in one place, got d_factor in two"),
        ({"grid": {"d-factor": [1.0], "d_factor": [2.0]}}, "grid: expected d_factor once, got {'d-f"),
        ({"variants": [{"d-factor": 1.0, "d_factor": 2.0}]}, "variants.0: expected d_factor once"),
        ({"seeds": [1]}, "seeds: expected none"),
        ({"task": "train", "settings": {"preset": "vessel"}}, "preset: has no effect"),
        ({"task": "train", "seeds": [1], "settings": {"seed": 2}}, "got seed in two"),
        ({"task": "train", "seeds": [-1]}, "seeds.0"),
        ({"sample": {"count": 3, "ranges": {"z": {"from": 0.5, "to": 0.2}}}}, "expected from < to"),
        ({"sample": {"count": 3, "ranges": {"z": {"from": 0, "to": 1, "scale": "log"}}}}, "from > 0"),
        (
            {"sample": {"count": 3, "ranges": {"z": {"from": 0.2, "to": 0.8, "whole": True}}}},
            "sample.ranges.z: expected a whole number between, got 0.2 and 0.8",
        ),
        ({"sample": {"count": 0, "ranges": {"z": {"from": 0, "to": 1}}}}, "sample.count"),
        ({"threads": 0}, "threads"),
        ({"slurm": {"minutes": 0}}, "slurm.minutes"),
    ],
)
def test_a_mistake_is_one_line_with_its_place(given: dict[str, object], told: str) -> None:
    with pytest.raises(UserError) as caught:
        all_settings(spec(**given))
    assert told in str(caught.value)
    assert "\n" not in str(caught.value)


def test_more_jobs_than_can_be_meant_are_refused_before_they_are_made() -> None:
    asked = spec(grid={"z": [0.1] * 1000, "p": [0.1] * 1000})
    with pytest.raises(UserError, match="expected at most 100000 jobs, got 1000000"):
        jobs_asked_for(asked, clips=1)


@pytest.mark.parametrize("text", [b"clips = [", b"\xff\xfe", b"a = 1\na = 2\n", b"frames = " + b"9" * 5000])
def test_a_file_that_is_no_toml_is_one_line(tmp_path: Path, text: bytes) -> None:
    (tmp_path / "sweep.toml").write_bytes(text)
    with pytest.raises(UserError, match=r"expected a sweep in TOML"):
        read_spec(tmp_path / "sweep.toml")


def test_a_file_that_is_not_there_is_one_line(tmp_path: Path, vesselsplat: Cli) -> None:
    called = vesselsplat("sweep", tmp_path / "none.toml", "--out", tmp_path / "out")
    wanted = "expected a sweep in TOML, got no such file"
    assert (called.code, called.error) == (2, f"vesselsplat: {wanted}: {tmp_path / 'none.toml'}\n")


def test_a_byte_order_mark_is_no_part_of_the_file(tmp_path: Path) -> None:
    (tmp_path / "sweep.toml").write_text('clips = ["a.png"]\ntask = "enhance"\n', encoding="utf-8-sig")
    assert read_spec(tmp_path / "sweep.toml").clips == ["a.png"]


def test_a_file_that_is_written_is_read_whatever_its_clip_is_called(tmp_path: Path) -> None:
    clip = Path('a "b" \\ \x01\t\x7f é')
    text = spec_text(clip, Enhancing("paper", EnhanceParams(), "all"), {"z": [0.1, 0.2]})
    (tmp_path / "sweep.toml").write_text(text, encoding="utf-8")
    assert read_spec(tmp_path / "sweep.toml").clips == [str(clip)]


def test_a_setting_that_is_refused_names_the_file(tmp_path: Path) -> None:
    (tmp_path / "a.png").touch()
    path = tmp_path / "sweep.toml"
    for asked, told in (
        ({"settings": {"z": "high"}}, "z: expected a valid number"),
        ({"grid": {"z": [0.1] * 1000, "p": [0.1] * 1000}}, "expected at most 100000 jobs"),
    ):
        with pytest.raises(UserError, match=told) as caught:
            planned(spec(**asked), path)
        assert str(caught.value).endswith(f": {path}")


def test_what_a_file_lacks_or_names_wrongly_is_said(tmp_path: Path) -> None:
    for facts, told in (
        ({}, "expected clips, got none"),
        ({"clips": ["a"], "task": "enhance", "clip": 1}, "clip: expected nothing"),
    ):
        with pytest.raises(UserError, match=told):
            spec_of(facts, tmp_path / "sweep.toml")


def test_patterns_find_images_videos_and_folders_alone(tmp_path: Path) -> None:
    for name in ("b.png", "a.mp4", "notes.txt", ".hidden.png"):
        (tmp_path / name).write_bytes(b"")
    (tmp_path / "clip").mkdir()
    found = clip_paths(spec(clips=["*", "b.png"]), tmp_path)
    assert [path.name for path in found] == ["a.mp4", "b.png", "clip"]
    with pytest.raises(UserError, match=r"found nothing at c\*\.png"):
        clip_paths(spec(clips=["c*.png"]), tmp_path)


def test_a_name_with_signs_of_patterns_is_that_name(tmp_path: Path) -> None:
    study, other = tmp_path / "study [2024]", tmp_path / "study 2"
    for folder in (study / "s1", study / "clip [1]", study / "clip 1", other / "s1"):
        folder.mkdir(parents=True)
    assert clip_paths(spec(clips=["s*"]), study) == (study / "s1",)
    assert clip_paths(spec(clips=["clip [1]"]), study) == (study / "clip [1]",)
    assert clip_paths(spec(clips=[f"{study}/clip [1]"]), other) == (study / "clip [1]",)
    assert clip_paths(spec(clips=["../study [2024]/s?"]), other) == (other / "../study [2024]/s1",)


def test_patterns_leave_out_what_sweeps_wrote(tmp_path: Path) -> None:
    for name in ("clip", "out/jobs/1"):
        (tmp_path / name).mkdir(parents=True)
    (tmp_path / "out" / "sweep.json").touch()
    (tmp_path / "out" / "jobs" / "1" / "picture.png").touch()
    for pattern in ("*", "*/**", "**/*"):
        assert clip_paths(spec(clips=[pattern]), tmp_path) == (tmp_path / "clip",)
    # Asked for by its name, or from a folder that the sweep is written into.
    assert clip_paths(spec(clips=["out/jobs/1/*"]), tmp_path) == (tmp_path / "out/jobs/1/picture.png",)
    (tmp_path / "sweep.json").touch()
    (tmp_path / "jobs").mkdir()
    assert clip_paths(spec(clips=["*"]), tmp_path) == (tmp_path / "clip",)


@pytest.mark.parametrize("text", ["a**b", "~nobody-of-this-name/x"])
def test_a_text_that_is_no_pattern_is_one_line(tmp_path: Path, text: str) -> None:
    with pytest.raises(UserError, match="clips: expected a path or a pattern, got") as caught:
        clip_paths(spec(clips=[text]), tmp_path)
    assert repr(text) in str(caught.value)


@given(count=st.integers(1, 40), seed=st.integers(0, 1000), names=st.integers(1, 4))
def test_a_latin_hypercube_has_a_point_in_each_part_of_each_range(count: int, seed: int, names: int) -> None:
    ranges = {f"x{i}": Range(**{"from": 0.0, "to": 1.0}) for i in range(names)}
    points = Sample(count=count, ranges=ranges, seed=seed).points()
    for name in ranges:
        found = count * np.sort([point[name] for point in points])
        # To six digits, so that a value may lie on the edge of its part.
        assert np.all(np.abs(found - 0.5 - np.arange(count)) <= 0.5 + 1e-4)


@given(share=st.floats(0, 1), low=st.floats(1e-3, 10), span=st.floats(0.1, 100))
def test_values_stay_within_their_range(share: float, low: float, span: float) -> None:
    for scale in ("linear", "log"):
        one = Range(**{"from": low, "to": low + span, "scale": scale})
        assert low <= one.at(share) <= low + span
    whole = Range(**{"from": 2, "to": 9, "whole": True})
    assert isinstance(whole.at(share), int)
    assert 2 <= whole.at(share) <= 9


def test_a_log_range_is_even_in_ratios() -> None:
    assert Range(**{"from": 0.01, "to": 1.0, "scale": "log"}).at(0.5) == pytest.approx(0.1)


def test_a_sample_repeats_by_its_seed_and_differs_by_another() -> None:
    ranges = {"z": Range(**{"from": 0.0, "to": 1.0})}
    first, again, other = (Sample(count=5, ranges=ranges, seed=seed).points() for seed in (1, 1, 2))
    assert first == again != other
