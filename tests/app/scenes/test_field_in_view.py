"""Seen from beside, a reconstruction ends where the field of view of its camera at rest does."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import get_args

import cv2
import numpy as np
import pytest
from pydantic import TypeAdapter

from app.enhancement.image_mask import PictureMask
from app.exports.browser.of_scene import browser_model
from app.exports.browser.page import read_page
from app.exports.make import make
from app.exports.sources import Opened
from app.files.stepping import run_to_end
from app.runs.clip_selection import ClipPart
from app.scenes.cpu_rendering import draw_on_cpu
from app.scenes.free_camera import FreeView
from app.scenes.records import Ends, ViewRecord
from app.scenes.scene import Scene, open_scene
from app.scenes.view_request import ViewRequest, view_record
from enhance.field import FieldOfView
from renderer.in_view import FieldInView

ROUND = FieldOfView(width=64, height=48, circle=(31.0, 25.0, 16.0))


@pytest.fixture
def scene(runs: dict[str, Path]) -> Scene:
    """As of a clip whose frames show tissue in a round field alone."""
    scene = open_scene(runs["original"])
    assert scene.record.clip is not None
    clip = replace(scene.record.clip, part=ClipPart(field_of_view=ROUND))
    return replace(scene, record=replace(scene.record, clip=clip))


def aside_of(scene: Scene) -> ViewRequest:
    camera = FreeView.of(scene.cameras[0]).flown(0, 0, -scene.distance).camera
    return ViewRequest(scene, 0.0, camera)


def test_nothing_is_drawn_beyond_the_field(scene: Scene) -> None:
    aside = aside_of(scene)
    own = scene.cameras[0]
    kept, drawn = ROUND.mask(), aside.drawn(draw_on_cpu)
    before = replace(aside, ends="image").drawn(draw_on_cpu)
    assert drawn.alpha.sum() < 0.7 * before.alpha.sum()
    there = drawn.alpha > 0.5
    pixels, _ = own.project(aside.camera.unproject(np.maximum(drawn.depth, scene.near))[there])
    columns, rows = np.clip(pixels, 0, (63, 47)).astype(int).T
    assert cv2.dilate(kept.astype(np.uint8), np.ones((3, 3), np.uint8))[rows, columns].all()
    assert there.sum() > 100


def test_the_endoscopes_own_view_stays_as_it_is_to_the_bit(scene: Scene) -> None:
    own = ViewRequest.of_frame(scene, 2)
    for camera in (own.camera, own.camera.fitted(200, 50)):
        views = [replace(own, camera=camera, ends=ends) for ends in get_args(Ends)]
        one, *others = (view.drawn(draw_on_cpu) for view in views)
        assert len(others) == 2
        assert all(np.array_equal(one.image, other.image) for other in others)


def test_a_field_that_a_hand_has_drawn_counts_too(scene: Scene) -> None:
    assert scene.record.clip is not None
    drawn = ClipPart(mask=PictureMask(view=(31.0, 25.0, 16.0)))
    by_hand = replace(scene, record=replace(scene.record, clip=replace(scene.record.clip, part=drawn)))
    whole = replace(scene, record=replace(scene.record, clip=replace(scene.record.clip, part=None)))
    found, told = by_hand.field_in_view, scene.field_in_view
    assert isinstance(found, FieldInView)
    assert isinstance(told, FieldInView)
    assert np.allclose(found.sides, told.sides)
    assert whole.field_in_view is whole.camera_at_rest
    assert replace(scene, cameras=(aside_of(scene).camera, *scene.cameras[1:])).field_in_view is None


def test_a_field_of_another_size_is_none(scene: Scene) -> None:
    assert scene.record.clip is not None
    part = ClipPart(field_of_view=replace(ROUND, width=128))
    odd = replace(scene, record=replace(scene.record, clip=replace(scene.record.clip, part=part)))
    assert odd.field_in_view is odd.camera_at_rest


def test_what_0_7_0_drew_comes_again(scene: Scene) -> None:
    """Its records do not say where tissue ends."""
    facts = view_record(aside_of(scene), "numba on the CPU").signed
    assert facts.pop("ends") == "even"
    adapter = TypeAdapter(ViewRecord)
    assert adapter.validate_python(facts).ends == "image"
    assert replace(aside_of(scene), ends="image").within is scene.camera_at_rest


def test_the_page_has_the_field_where_the_record_says_so(scene: Scene, tmp_path: Path) -> None:
    record, told = browser_model(scene, scene.cameras[0], 25.0), {}
    assert record.ends == "even"
    for name, one in ((ends, replace(record, ends=ends)) for ends in get_args(Ends)):
        run_to_end(make(one, Opened(model=scene), tmp_path / f"{name}.html"))
        _, told[name], _ = read_page((tmp_path / f"{name}.html").read_text())
    assert scene.field_in_view is not None
    sides = scene.field_in_view.sides
    assert np.allclose(told["even"]["field"], sides[4:])
    assert np.allclose(told["field"]["field"], sides[4:])
    assert np.allclose(told["field"]["sides"], sides[:4])
    assert told["field"]["free"] is False
    assert "field" not in told["image"]
    assert np.allclose(told["image"]["sides"], sides[:4])
