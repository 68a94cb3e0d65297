"""View: surface in the window: drawn by the processor, and measured on as splats are."""

from __future__ import annotations

import gc
import weakref
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from app.errors import UserError
from app.files.records import Source
from app.gui.actions import camera_actions
from app.gui.update import wishes
from app.gui.views.measurement import Located, Measurement
from app.gui.work.selecting import PickRequest, pick
from app.gui.work.settings import Places
from app.scenes import surfaces
from app.scenes.drawer import draw_view
from app.scenes.records import SceneRecord
from app.scenes.scene import Scene
from app.scenes.surfaces import surface
from app.scenes.view_kinds import SCENE_UNITS
from app.scenes.view_request import ViewRequest
from renderer.editing.edits import Edits
from renderer.near_plane import middle_distance
from tests.app.gui.exporting import Exporter
from tests.renderer.surface.sheets import CAMERA, HOLE, sheet


@pytest.fixture(scope="module")
def scene() -> Scene:
    model = sheet()
    record = SceneRecord(splats=Source(name="sheet.ply", sha256=""))
    return Scene(name="sheet", model=model, cameras=(CAMERA,) * 4, distance=middle_distance(model, CAMERA),
                 mode="default", unit=SCENE_UNITS, record=record)  # fmt: skip


def located(view: ViewRequest, pixel: tuple[int, int]) -> Located | None:
    (found,) = pick(PickRequest(view, pixel, "measure"))
    return found


def test_distances_on_the_surface_are_those_on_splats(scene: Scene) -> None:
    splats = ViewRequest(scene, 0.25, CAMERA)
    mesh = splats.of_kind("surface")
    ends = []
    for view in (splats, mesh):
        first, second = located(view, (15, 20)), located(view, (80, 55))
        assert first is not None
        assert second is not None
        assert first.error > 0
        ends.append(Measurement((first, second)).length)
    assert ends[0] == pytest.approx(ends[1], rel=0.003)
    assert ends[1] == pytest.approx(30.6, rel=0.03)
    assert located(mesh, (48, 36)) is None
    assert located(mesh, (500, 3)) is None


def test_the_hole_is_seen_and_the_view_is_remembered(scene: Scene) -> None:
    request = ViewRequest(scene, 0.5, CAMERA, "surface", background=(0.0, 0.0, 0.0))
    (first,), (again,) = draw_view(request), draw_view(request)
    assert np.array_equal(first.image, again.image)
    radius = np.sqrt((first.image.sum(axis=2) == 0).sum() / np.pi)
    assert radius == pytest.approx(HOLE * 120 / 51, rel=0.2)
    assert surface(scene) is surface(scene)


def test_a_scene_of_which_nothing_is_left_is_an_empty_view_and_no_mesh(scene: Scene) -> None:
    bare = scene.edited(Edits.none(len(scene.model)).selecting_all().deleting())
    request = ViewRequest(bare, 0.5, CAMERA, "surface", background=(1.0, 0.0, 0.0))
    (view,) = draw_view(request)
    assert (view.image == (255, 0, 0)).all()
    with pytest.raises(UserError, match="expected a surface, got none"):
        surface(bare)


def test_what_is_remembered_goes_with_its_scene(scene: Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(surfaces, "MOST_MESHES", 2)
    own = replace(scene)
    kept = [weakref.ref(surfaces.surface_at(own, time)) for time in (0.1, 0.2, 0.3)]
    follower = weakref.ref(surface(own))
    gc.collect()
    assert [one() is None for one in kept] == [True, False, False]
    again = surfaces.surface_at(own, 0.3)
    assert again is kept[2]()
    del own, again
    gc.collect()
    assert [one() for one in (*kept, follower)] == [None] * 4


def test_the_processor_draws_it_though_there_is_a_card(runs: dict[str, Path], tmp_path: Path) -> None:
    places = Places(tmp_path / "config", tmp_path / "runs", tmp_path / "pictures")
    window = Exporter(places, runs["original"])
    state = window.state
    state.scene.processor_draws = False
    assert wishes.view_wish(state) is None
    camera_actions.choose_view(state, "surface")
    window.turn(6)
    assert state.scene.view is not None
    assert state.scene.view.request.kind == "surface"
    assert state.scene.view.image.std() > 3
