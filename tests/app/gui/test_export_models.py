"""Models exported for other programs: splats, surfaces, cameras, tracks, pages for browsers."""

from __future__ import annotations

import csv
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh

from app.exports.browser.page import read_page
from app.exports.browser.tracks import tracks_of
from app.exports.replay.again import replay
from app.exports.replay.recorded import recorded
from app.gui.actions import actions, export_actions
from app.gui.actions.export_doubts import MOST_ORDERED, doubts
from app.gui.actions.export_offers import OFFERS
from app.gui.panels.export import draw_export
from app.gui.state.app_state import AppState
from app.gui.state.exports import What
from app.gui.style.widgets import choose_row
from app.gui.views.measurement import Located, Measurement
from app.scenes.scene import open_scene
from renderer.camera_files import read_cameras
from renderer.camera_path import CameraPath, Keyframe
from renderer.picking import surface_point
from renderer.sources import open_clip
from renderer.splat_files import read_splats
from renderer.surface.maps import maps_of, read
from tests.app.gui.exporting import Exporter, exported, same
from tests.app.gui.ui import Ui


def test_splats_of_a_moment_and_of_all_frames_come_again(run: Exporter, runs: dict[str, Path]) -> None:
    state, count = run.state, len(run.state.scene.model.cameras) if run.state.scene.model else 0
    actions.seek(state, 4)
    path = exported(run, "splats of this moment")
    assert path.name == "original-frame-5-splats.ply"
    assert same(path, runs["original"])
    folder = exported(run, "splats of all frames")
    files = sorted(folder.iterdir())
    assert [file.name for file in files] == [f"frame-{at:06d}.ply" for at in range(count)]
    assert files[4].read_bytes() == path.read_bytes()
    assert same(files[7], runs["original"])
    export_actions.choose_degree(state, 3)
    assert read_splats(exported(run, "splats of this moment")).raw.harmonics.shape[1] == 15


def test_splats_without_what_no_frame_shows_come_again(run: Exporter, runs: dict[str, Path]) -> None:
    state, scene = run.state, open_scene(runs["original"])
    assert scene.shown is not None
    every = read_splats(exported(run, "splats of this moment")).raw
    export_actions.choose_unobserved(state, False)
    path = exported(run, "splats of this moment")
    raw = read_splats(path).raw
    assert len(raw) == scene.shown.sum() < len(every)
    assert np.array_equal(raw.means, every.means[scene.shown])
    assert recorded(path)["unobserved"] is False
    assert same(path, runs["original"])


def test_the_panel_asks_for_what_no_frame_shows_where_that_is_known(
    run: Exporter, ui: Ui, monkeypatch: pytest.MonkeyPatch
) -> None:
    state, rows = run.state, list[str]()
    assert state.scene.model is not None

    def chosen(label: str, *given: Any) -> Any:
        rows.append(label)
        return False if label == "Unobserved" else choose_row(label, *given)

    monkeypatch.setattr("app.gui.panels.export.choose_row", chosen)
    state.exports.shown = True
    asked: tuple[What, ...] = ("splats of this moment", "splats through time", "page for browsers")
    for what in asked:
        rows.clear()
        export_actions.choose_what(state, what)
        for _ in range(2):
            ui.frame(lambda: draw_export(state))
        assert ("Unobserved" in rows) == (what != "page for browsers")
    assert not state.exports.unobserved
    state.scene.model = replace(state.scene.model, live=True)
    rows.clear()
    export_actions.choose_what(state, "splats of this moment")
    ui.frame(lambda: draw_export(state))
    assert "Unobserved" not in rows


def test_what_a_format_does_not_hold_is_said(run: Exporter) -> None:
    state = run.state
    assert state.scene.model is not None
    state.scene.model = replace(state.scene.model, frames_per_second=10.0)
    raw = state.scene.model.model.raw
    colored = replace(raw, harmonics=np.zeros((len(raw.means), 3, 3), np.float32))
    export_actions.choose_what(state, "page for browsers")
    assert not doubts(state)
    model = replace(state.scene.model.model, raw=colored)
    state.scene.model = replace(state.scene.model, model=model)
    assert doubts(state) == "Colours by direction are left out of the file."
    export_actions.choose_what(state, "splats through time")
    assert not doubts(state)
    export_actions.choose_format(state, "moving splats", ".4dgs")
    assert doubts(state)


def test_a_speed_that_is_assumed_is_told_of_every_video_of_the_clip(state: AppState, clip_path: Path) -> None:
    clip, told = open_clip(clip_path), "How fast the clip goes is not known: 15 frames a second are assumed."
    assert clip.frames_per_second is None
    videos: list[What] = [
        what for what, offer in OFFERS.items() if offer.form in ("panes video", "DICOM video")
    ]
    assert videos
    for what in videos:
        export_actions.choose_what(state, what)
        state.source.clip = clip
        assert doubts(state) == told
        state.source.clip = replace(clip, frames_per_second=10.0)
        assert not doubts(state)


def test_what_is_beyond_spz_is_said(run: Exporter) -> None:
    state = run.state
    assert state.scene.model is not None
    raw = state.scene.model.model.raw
    tiny = replace(raw, log_scales=np.full_like(raw.log_scales, -12.0))
    state.scene.model = replace(state.scene.model, model=replace(state.scene.model.model, raw=tiny))
    export_actions.choose_what(state, "splats of this moment")
    assert not doubts(state)
    export_actions.choose_format(state, "splats", ".spz")
    assert doubts(state).endswith("which SPZ does not hold: they are clipped.")


@pytest.mark.parametrize(("suffix", "told"), [(".compressed.ply", False), (".spz", True)])
def test_only_what_is_soon_counted_is_told_of_a_large_model(run: Exporter, suffix: str, told: bool) -> None:
    state = run.state
    assert state.scene.model is not None
    raw = state.scene.model.model.raw
    many = raw.rows(np.arange(MOST_ORDERED + 1) % len(raw))
    for count in (len(raw), MOST_ORDERED + 1):
        beyond = replace(many.rows(np.arange(count)), harmonics=np.full((count, 3, 3), 9.0, np.float32))
        model = replace(state.scene.model.model, raw=beyond)
        state.scene.model = replace(state.scene.model, model=model)
        export_actions.choose_what(state, "splats of this moment")
        export_actions.choose_format(state, "splats", suffix)
        assert ("they are clipped" in doubts(state)) is (told or count == len(raw))


@pytest.mark.parametrize("suffix", [".compressed.ply", ".spz", ".sog", ".glb"])
def test_splats_in_the_format_that_is_chosen_come_again(
    run: Exporter, runs: dict[str, Path], suffix: str
) -> None:
    for form in ("splats", "splat folder"):
        export_actions.choose_format(run.state, form, suffix)
    paths = [exported(run, "splats of this moment") for _ in range(2)]
    names = [f"original-frame-1-splats{end}{suffix}" for end in ("", "-2")]
    assert [path.name for path in paths] == names
    assert replay(paths[1], (runs["original"],), paths[1].with_name(f"again{suffix}")).difference.is_none
    files = {path.name for path in exported(run, "splats of all frames").iterdir()}
    assert f"frame-000009{suffix}" in files


@pytest.mark.parametrize(
    ("what", "name"),
    [
        ("splats through time", "original-moving-splats.usdc"),
        ("splats through time", "original-moving-splats.4dgs"),
        ("surface through time", "original-surface.usdc"),
        ("arrays of all frames", "original-arrays.npz"),
    ],
)
def test_the_model_through_time_comes_again(
    run: Exporter, runs: dict[str, Path], what: What, name: str
) -> None:
    export_actions.choose_what(run.state, what)
    export_actions.choose_format(run.state, OFFERS[what].form, Path(name).suffix)
    assert export_actions.suffix_of(run.state) == Path(name).suffix
    path = exported(run, what)
    assert path.name == name
    assert same(path, runs["original"])


def test_the_page_for_browsers_holds_the_model_and_comes_again(run: Exporter, runs: dict[str, Path]) -> None:
    export_actions.choose_what(run.state, "page for browsers")
    assert export_actions.suffix_of(run.state) == ".html"
    path = exported(run, "page for browsers")
    assert path.name == "original-model.html"
    facts, scene, content = read_page(path.read_text())
    model = run.state.scene.model
    assert model is not None
    assert scene["windows"][0]["tracks"][0]["count"] == len(model.model)
    assert scene["frames"] == len(model.cameras)
    assert content.tobytes() == tracks_of(model.model).content
    assert facts["run"]
    assert same(path, runs["original"])


def test_the_surface_is_written_through_time_and_a_frame_a_file(run: Exporter, runs: dict[str, Path]) -> None:
    export_actions.choose_what(run.state, "surface through time")
    assert export_actions.suffix_of(run.state) == ".glb"
    path = exported(run, "surface through time")
    assert path.name == "original-surface.glb"
    folder = exported(run, "surface of all frames")
    assert folder.name == "original-surfaces"
    (moving,), still = (
        trimesh.load_scene(path).geometry.values(),
        trimesh.load_mesh(folder / "frame-000000.ply"),
    )
    assert moving.faces.tolist() == still.faces.tolist()
    assert len(list(folder.iterdir())) == 10
    assert same(path, runs["original"])
    assert same(folder / "frame-000007.ply", runs["original"])


def test_cameras_are_exported_for_other_programs(run: Exporter) -> None:
    state = run.state
    assert state.scene.model is not None
    cameras = read_cameras(exported(run, "cameras of the clip"))
    assert len(cameras) == len(state.scene.model.cameras)
    assert "Cameras panel" in export_actions.why_not_export(state, "cameras of the path")
    keys = tuple(Keyframe(at, at / 2, state.scene.model.camera_at(0.0)) for at in (0.0, 1.0))
    state.scene.cameras.views = replace(state.scene.cameras.views, path=CameraPath(keys))
    assert len(read_cameras(exported(run, "cameras of the path"))) == 16


@pytest.mark.parametrize("suffix", [".transforms.json", ""])
def test_cameras_in_other_formats_are_those_of_the_clip(run: Exporter, suffix: str) -> None:
    model = run.state.scene.model
    assert model is not None
    export_actions.choose_format(run.state, "cameras", suffix)
    export_actions.choose_what(run.state, "cameras of the clip")
    assert export_actions.suffix_of(run.state) == suffix
    paths = [exported(run, "cameras of the clip") for _ in range(2)]
    assert [path.name for path in paths] == [f"original-cameras{suffix}", f"original-cameras-2{suffix}"]
    cameras = read_cameras(paths[1])
    assert [one.camera.fx for one in cameras] == pytest.approx([one.fx for one in model.cameras])
    assert np.allclose(cameras[3].camera.camera_from_world, model.cameras[3].camera_from_world, atol=1e-6)
    export_actions.choose_what(run.state, "cameras of the clip")
    export_actions.type_name(run.state, "case.1")
    assert exported(run, "cameras of the clip").name == f"case.1{suffix}"


def test_measured_points_are_followed_through_the_clip(run: Exporter, runs: dict[str, Path]) -> None:
    state, what = run.state, "tracks of the measured points"
    model = state.scene.model
    assert model is not None
    assert "press M" in export_actions.why_not_export(state, what)
    time = model.time(4)
    points = [
        surface_point(model.model.at(time), model.camera_at(time), at, model.near)
        for at in ((30, 20), (12, 40))
    ]
    measured = Measurement()
    for point in points:
        assert point is not None
        x, y, z = point.point
        measured = measured.with_point(Located((float(x), float(y), float(z))), time, model.identity)
    state.scene.viewer = replace(state.scene.viewer, measurement=measured)
    path = exported(run, what)
    assert path.name == "original-tracks.csv"
    table = list(csv.DictReader(path.read_text().splitlines()))
    assert len(table) == 2 * len(model.cameras)
    starts = [row for row in table if row["frame"] == "4"]
    view = maps_of(model.model, time, model.camera_at(time), model.near, model.mode)
    for row, point in zip(starts, measured.points, strict=True):
        place = [float(row[axis]) for axis in "xyz"]
        pixels, depths = view.camera.project(np.array([place]))
        assert depths == pytest.approx(read(view.depth, pixels), rel=1e-4)
        # Followed on the smoothed surface, measured where the pixel's own depth is.
        assert place == pytest.approx(point, rel=0.02)
        assert row["seen"] == "1"
    pixel = [float(starts[0][name]) for name in ("column", "row")]
    assert pixel == pytest.approx([30.5, 20.5], abs=0.1)
    assert len({row["z"] for row in table if row["point"] == "1"}) > 5  # The tissue moves.
    assert same(path, runs["original"])
    state.scene.viewer = replace(state.scene.viewer, measurement=replace(measured, of="another"))
    assert "press M" in export_actions.why_not_export(state, what)
