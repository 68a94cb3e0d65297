"""Seen from beside, tissue has even edges and no pinholes: in which views, and not in those of before."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from pydantic import TypeAdapter

from app.exports.browser.of_scene import browser_model
from app.exports.browser.page import read_page
from app.exports.make import make
from app.exports.sources import Opened
from app.files.stepping import run_to_end
from app.scenes.cpu_rendering import draw_on_cpu
from app.scenes.free_camera import FreeView, vector
from app.scenes.records import ViewRecord
from app.scenes.scene import Scene, open_scene, splat_scene
from app.scenes.view_request import ViewRequest, view_record
from renderer.closing import closed


@pytest.fixture
def scene(runs: dict[str, Path]) -> Scene:
    return open_scene(runs["original"])


def aside_of(scene: Scene) -> ViewRequest:
    """By 20 degrees, with four times as many pixels as the clip each way."""
    camera = scene.cameras[0]
    pivot = vector(camera.position + scene.distance * camera.camera_from_world[2, :3])
    free = FreeView.of(camera).orbited(pivot, np.radians(20), 0.0)
    return ViewRequest(scene, 0.0, free.camera.resized(4 * camera.width, 4 * camera.height))


def test_views_from_beside_are_closed_and_their_depth_stays(scene: Scene) -> None:
    aside = aside_of(scene)
    before, found = replace(aside, ends="field").drawn(draw_on_cpu), aside.drawn(draw_on_cpu)
    assert aside.closing == round(0.01 * 4 * scene.cameras[0].width)
    assert np.array_equal(found.image, closed(before, aside.closing).image)
    assert not np.array_equal(found.alpha, before.alpha)
    assert np.array_equal(found.depth, before.depth)


def test_the_endoscopes_own_views_and_values_are_not(scene: Scene) -> None:
    aside = aside_of(scene)
    own = ViewRequest.of_frame(scene, 2)
    others = [own, replace(own, camera=own.camera.fitted(200, 50)), replace(aside, unobserved=True)]
    others += [aside.of_kind(kind) for kind in ("depth", "opacity", "motion", "normals", "points")]
    assert [view.closing for view in others] == [0] * len(others)


def test_files_of_splats_and_previews_are_not(scene: Scene, tmp_path: Path) -> None:
    assert replace(aside_of(scene), scene=replace(scene, live=True)).closing == 0
    before = Path(__file__).parents[1] / "exports/before/splats.ply"
    assert replace(aside_of(scene), scene=splat_scene(before)).closing == 0


def test_a_record_says_so_and_one_of_before_is_drawn_as_it_was(scene: Scene) -> None:
    said = TypeAdapter(ViewRecord).dump_python(view_record(aside_of(scene), "cpu"), mode="json")
    assert said["ends"] == "even"
    for told, ends in ((said, "even"), (said | {"ends": "field"}, "field")):
        assert TypeAdapter(ViewRecord).validate_python(told).ends == ends
    del said["ends"]
    assert TypeAdapter(ViewRecord).validate_python(said).ends == "image"


def test_a_page_closes_its_free_views_and_one_of_before_does_not(scene: Scene, tmp_path: Path) -> None:
    camera, told = scene.cameras[0].resized(128, 96), {}
    record = browser_model(scene, camera, 25.0)
    for ends in ("even", "field"):
        run_to_end(make(replace(record, ends=ends), Opened(model=scene), tmp_path / f"{ends}.html"))
        _, told[ends], _ = read_page((tmp_path / f"{ends}.html").read_text(encoding="utf-8"))
    assert told["even"].pop("closing") == pytest.approx(1.28)
    assert json.dumps(told["even"]) == json.dumps(told["field"])
    run_to_end(make(replace(record, unobserved=True), Opened(model=scene), tmp_path / "all.html"))
    _, everything, _ = read_page((tmp_path / "all.html").read_text(encoding="utf-8"))
    assert "closing" not in everything
