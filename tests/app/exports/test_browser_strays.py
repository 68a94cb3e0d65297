"""One stray Gaussian makes no other coarse on a page for browsers; ordinary models stay small."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from app.exports.browser.of_scene import ROUNDING, browser_model, page_windows
from app.exports.browser.page import read_page
from app.exports.browser.tracks import CUBIC, tracks_of
from app.exports.make import make
from app.exports.replay.difference import difference
from app.exports.sources import Opened
from app.files.stepping import run_to_end
from app.scenes.records import SceneRecord
from app.scenes.scene import Scene
from renderer.camera import Camera
from renderer.deformation.motion import Still
from renderer.gaussians import DynamicGaussians
from renderer.raw_gaussians import RawGaussians
from tests.app.exports.test_browser import COUNT, drawn, raw, spline

ROUNDED = 1e-3
CAMERA = Camera.from_fov(60.0, 640, 512)
BYTES = {"means": 2, "colors": 1, "quats": 2, "log_scales": 2, "opacity_logits": 2}
Change = dict[str, float]


def ordinary() -> RawGaussians:
    one = raw(np.random.default_rng(8))
    return replace(one, colors=one.colors.clip(0, 1))


def with_stray(change: Change) -> RawGaussians:
    values = {name: value.copy() for name, value in ordinary().arrays().items()}
    for name, value in change.items():
        values[name][0] = value
    return RawGaussians(**values)


def bytes_of(one: RawGaussians) -> dict[str, int]:
    tracks = tracks_of(DynamicGaussians(one, Still()), rounding=ROUNDED)
    return {track["name"]: track["bytes"] for track in tracks.told()}


@pytest.mark.parametrize(
    ("change", "wider"),
    [
        ({}, {}),
        ({"means": 1e3}, {"means": 4}),
        ({"means": 1e14}, {"means": 4}),
        ({"colors": 10}, {"colors": 2}),
        ({"colors": 1e5}, {"colors": 4}),
        ({"opacity_logits": 1e6}, {"opacity_logits": 4}),
    ],
)
def test_all_others_stay_where_and_what_they_are(change: Change, wider: dict[str, int]) -> None:
    one = with_stray(change)
    assert bytes_of(one) == BYTES | wider
    tracks = tracks_of(DynamicGaussians(one, Still()), rounding=ROUNDED)
    page = drawn(tracks, 0.0)
    assert np.linalg.norm(page["means"] - one.means, axis=1).max() <= ROUNDED
    assert np.abs(page["colors"] - one.colors).max() <= 1 / 128
    assert np.abs(page["opacity_logits"][:, 0] - one.opacity_logits).max() <= 0.01
    assert tracks.error is not None
    assert np.linalg.norm(page["means"] - one.means, axis=1).max() <= tracks.error * 1.001 + 1e-6


def test_control_values_that_are_far_away_are_kept_as_they_are() -> None:
    random = np.random.default_rng(9)
    motion = spline(random, moving=COUNT, colored=0, fading=0, nodes=False)
    motion.position_controls[0, 3] = 1e5
    model = DynamicGaussians(ordinary(), motion)
    tracks = tracks_of(model, rounding=ROUNDED)
    assert (tracks.degree, tracks.told()[0]["bytes"], tracks.error) == (CUBIC, 4, 0.0)
    moved = model.motion.moved(model.raw, 0.4).means
    assert np.abs(drawn(tracks, 0.4)["means"] - moved)[1:].max() < 1e-5


def scene_of(one: RawGaussians) -> Scene:
    return Scene(
        name="splats", model=DynamicGaussians(one, Still()), cameras=(CAMERA,), distance=9.0, mode="default",
        unit="mm", record=SceneRecord(), iterations=10,
    )  # fmt: skip


def told(page: Path) -> tuple[dict[str, Any], dict[str, int]]:
    facts, said, _ = read_page(page.read_text())
    return facts, {track["name"]: track["bytes"] for track in said["windows"][0]["tracks"]}


def test_the_page_says_to_what_it_is_rounded_and_one_of_before_comes_again(tmp_path: Path) -> None:
    scene = scene_of(with_stray({"means": 1e5}))
    record = browser_model(scene, CAMERA, 25.0)
    assert record.tolerance is not None
    assert record.rounding == pytest.approx(ROUNDING * record.tolerance)
    run_to_end(make(record, Opened(model=scene), tmp_path / "a.html"))
    facts, kinds = told(tmp_path / "a.html")
    assert (facts["rounding"], facts["error"], kinds) == (record.rounding, 0.0, BYTES | {"means": 4})
    run_to_end(make(replace(record, rounding=None), Opened(model=scene), tmp_path / "before.html"))
    facts, kinds = told(tmp_path / "before.html")
    assert ("rounding" in facts, kinds) == (False, BYTES)
    assert difference(tmp_path / "a.html", tmp_path / "a.html").is_none
    assert difference(tmp_path / "a.html", tmp_path / "before.html").unlike


def test_samples_and_rounding_are_within_the_tolerance_together() -> None:
    scene = scene_of(ordinary())
    record = browser_model(scene, CAMERA, 25.0)
    (window,) = page_windows(scene, record.tolerance, record.rounding)
    assert window.tracks.error is not None
    assert record.tolerance is not None
    assert 0 < window.tracks.error <= record.tolerance
