"""What pictures of splats show beside their colours, and what their scales say."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from app.evaluation.evaluate import open_evaluation
from app.files.provenance import read_provenance
from app.runs.run_folder import RunFolder
from app.scenes.color_bar import LEAST_HEIGHT, color_bar, with_bar
from app.scenes.cpu_rendering import DrawOptions, draw_on_cpu
from app.scenes.renderers import Renderer, drawer
from app.scenes.view_kinds import (
    EXPLAINED,
    SHAPES,
    Composed,
    Scale,
    composed,
    difference,
    facing,
    has_scale,
    nice_step,
)
from renderer.camera import Camera
from renderer.camera_path import CameraPath, Keyframe
from renderer.near_plane import near_plane
from renderer.paint import by_motion
from renderer.rasterize.rendered import Rendered
from renderer.splats import Shape, Splats
from renderer.view_files import Views, views_json
from tests.app.conftest import Cli
from tests.renderer.scenes import random_splats, turned_camera

CAMERA = turned_camera(96, 80)


def flat(color: tuple[float, float, float] = (0.9, 0.5, 0.2)) -> Splats:
    """A disc of radius about 1 at depth 5 before `EYE`, that lies in the picture's plane."""
    values = ([(0, 0, 5)], [(1, 0, 0, 0)], [(1.0, 1.0, 0.01)], [0.95], [color])
    means, quats, scales, opacities, colors = (np.array(value, np.float32) for value in values)
    return Splats(means, quats, scales, opacities, colors)


EYE = Camera.from_fov(60, 65, 65)


@pytest.mark.parametrize("renderer", ["cpu", pytest.param("gl", marks=pytest.mark.gl)])
@pytest.mark.parametrize("tilt", [0.0, 40.0, -40.0])
def test_normals_are_those_of_the_surface_whatever_the_shape_of_its_splats(
    renderer: Renderer, tilt: float
) -> None:
    """Balls, of which no axis is the shortest, on a plane whose lower end is farther by the tilt: it faces
    down, which is less green."""
    draw = drawer(renderer).draw
    slope = math.tan(math.radians(tilt))
    across, down = (grid.ravel() for grid in np.meshgrid(np.arange(-2, 2, 0.05), np.arange(-2, 2, 0.05)))
    means = np.stack([across, down, 5 + slope * down], axis=1).astype(np.float32)
    count = len(means)
    splats = Splats(
        means, np.tile(np.float32([1, 0, 0, 0]), (count, 1)), np.full((count, 3), 0.05, np.float32),
        np.full(count, 0.9, np.float32), np.full((count, 3), 0.5, np.float32),
    )  # fmt: skip
    drawn = facing(draw(splats, EYE, DrawOptions(0.01, "default")), EYE)
    seen = drawn.image[20:45, 20:45] / drawn.alpha[20:45, 20:45, None]
    wanted = 0.5 + 0.5 * np.array([0, -math.sin(math.radians(tilt)), math.cos(math.radians(tilt))])
    assert np.abs(seen.mean(axis=(0, 1)) - wanted).max() < 0.02
    assert seen.std(axis=(0, 1)).max() < 0.03
    assert not facing(draw(splats, EYE, DrawOptions(100.0, "default")), EYE).image.any()


def test_motion_is_the_way_from_the_start_in_scene_units() -> None:
    moved = replace(flat(), means=flat().means + np.float32([3, 0, 4]))
    np.testing.assert_allclose(by_motion(moved, flat()).colors, [[5, 5, 5]])


@pytest.mark.parametrize("renderer", ["cpu", pytest.param("gl", marks=pytest.mark.gl)])
def test_an_ellipsoid_ends_at_one_and_a_half_deviations(renderer: Renderer) -> None:
    draw = drawer(renderer).draw
    drawn = draw(flat(), EYE, DrawOptions(0.01, "default", "ellipsoid"))
    radius = math.sqrt(drawn.alpha.sum() / math.pi)
    assert set(np.unique(drawn.alpha)) == {0.0, 1.0}
    assert radius == pytest.approx(1.5 * math.hypot(EYE.fx / 5, math.sqrt(0.3)), rel=0.02)
    assert drawn.depth[32, 32] == 5
    np.testing.assert_allclose(drawn.image[32, 32], (0.9, 0.5, 0.2), rtol=1e-3)
    row = drawn.image[32, drawn.alpha[32] > 0]
    assert row[0, 0] < 0.6 * row[len(row) // 2, 0]
    faint = replace(flat(), opacities=np.full(1, 0.05, np.float32))
    assert not draw(faint, EYE, DrawOptions(0.01, "default", "ellipsoid")).alpha.any()
    point = draw(faint, EYE, DrawOptions(0.01, "default", "point"))
    assert 3 <= point.alpha.sum() <= 9
    assert point.alpha[32, 32] == 1


@pytest.mark.gl
@pytest.mark.parametrize("shape", ["ellipsoid", "point"])
def test_both_renderers_draw_the_same_bodies(shape: Shape) -> None:
    """But for pixels whose centre is on an edge."""
    splats = random_splats(400, CAMERA, 3, sigma=(1.0, 6.0))
    own, cards = (
        drawer(name).draw(splats, CAMERA, DrawOptions(0.01, "default", shape)) for name in ("cpu", "gl")
    )
    same = np.isclose(own.image, cards.image, atol=1e-3).all(axis=2) & np.isclose(
        own.depth, cards.depth, rtol=1e-4
    )
    assert same.mean() > 0.998
    assert 0.2 < own.alpha.mean() < 1


def test_nearer_bodies_hide_farther_ones_whatever_their_order() -> None:
    near, far = flat((1, 0, 0)), replace(flat((0, 1, 0)), means=np.array([[0, 0, 6]], np.float32))
    for first, second in ((near, far), (far, near)):
        both = Splats(
            *(np.concatenate(pair) for pair in zip(vars(first).values(), vars(second).values(), strict=True))
        )
        np.testing.assert_allclose(
            draw_on_cpu(both, EYE, DrawOptions(0.01, shape="ellipsoid")).image[32, 32], (1, 0, 0), atol=1e-3
        )


def layers(value: float) -> Rendered:
    half = np.zeros((20, 30), np.float32)
    half[:, 15:] = 0.5
    return Rendered(
        np.repeat((half * value)[..., None], 3, axis=2),
        half,
        np.where(half > 0, 40 + value, 0).astype(np.float32),
    )


def test_a_quantity_is_averaged_over_what_a_pixel_shows_and_black_where_nothing_is() -> None:
    picture = composed("motion", layers(7.0), "mm")
    assert picture.scale is not None
    assert picture.scale.unit == "mm since the start"
    assert (picture.scale.low, picture.scale.high) == (0, 8)
    assert not picture.image[:, :15].any()
    place = round(255 * 7 / 8)
    np.testing.assert_array_equal(picture.image[5, 20], picture.scale.table[place])
    grey = composed("opacity", layers(7.0), "mm").image[5, 20]
    assert grey.tolist() == [128] * 3
    depth = composed("depth", layers(7.0), "mm").scale
    assert depth is not None
    assert depth.low <= 47 <= depth.high
    assert depth.high > depth.low


def test_a_difference_is_in_grey_levels_of_the_frame() -> None:
    drawn = Rendered(
        np.full((20, 30, 3), 100 / 255, np.float32),
        np.ones((20, 30), np.float32),
        np.zeros((20, 30), np.float32),
    )
    reference = np.full((40, 60, 3), 100, np.uint8)
    reference[:, 30:] = (130, 100, 100)
    away = difference(drawn.bytes, reference)
    assert away.shape == (20, 30)
    assert (away[:, :15] == 0).all()
    assert (away[:, 15:] == 10).all()
    scale = composed("difference", drawn, "mm", reference).scale
    assert scale is not None
    assert (scale.high, scale.unit) == (10, "grey levels")
    calm = composed("difference", drawn, "mm", np.full((20, 30, 3), 101, np.uint8)).scale
    assert calm is not None
    assert calm.high == 8


@pytest.mark.parametrize(
    ("low", "high"), [(31.0, 78.0), (0.0, 0.0123), (0.0, 1.0), (1e4, 2.5e4), (0.0, 3e-9)]
)
def test_ticks_are_round_and_inside_and_read_as_what_they_are(low: float, high: float) -> None:
    scale = Scale(low, high, "mm")
    assert 2 <= len(scale.ticks) <= 6
    assert all(low - 1e-6 * high <= tick <= high * (1 + 1e-6) for tick in scale.ticks)
    for tick in scale.ticks:
        assert float(scale.text(tick)) == pytest.approx(tick, abs=1e-9 * high)


@pytest.mark.parametrize(("least", "step"), [(0.1, 0.1), (0.11, 0.2), (3, 5), (5.1, 10), (1e-9, 1e-9)])
def test_a_nice_step_is_the_next_round_number(least: float, step: float) -> None:
    assert nice_step(least) == pytest.approx(step)


@pytest.mark.parametrize("height", [20, 96, 480, 1024])
def test_the_bar_stands_beside_the_picture_high_above(height: int) -> None:
    picture = np.full((height, 50, 3), 9, np.uint8)
    scale = Scale(0, 40, "mm", reversed=True)
    page = with_bar(Composed(picture, scale))
    assert page.shape[0] == max(height, LEAST_HEIGHT)
    assert (page[:height, :50] == 9).all()
    bar = color_bar(scale, page.shape[0])
    column = bar[:, np.abs(bar.astype(int) - scale.table[128]).sum(axis=2).min(axis=0).argmin()]
    places = [np.abs(column.astype(int) - scale.table[index]).sum(axis=1).argmin() for index in (255, 128, 0)]
    assert places == sorted(places)
    assert with_bar(Composed(picture)) is picture


@pytest.mark.parametrize("view", EXPLAINED)
def test_render_draws_every_view(runs: dict[str, Path], tmp_path: Path, vesselsplat: Cli, view: str) -> None:
    call = vesselsplat("render", runs["original"], "--out", tmp_path / "out", "--frames", 3, "--view", view)
    assert (call.code, call.error) == (0, "")
    path = tmp_path / "out" / "frame-000003.png"
    picture, facts = cv2.imread(str(path))[..., ::-1], read_provenance(path)
    assert facts["view"] == view
    assert picture.std() > 3
    assert (picture.shape[1] > 64) == has_scale(view)  # type: ignore[arg-type]
    remade = tmp_path / "again.png"
    assert vesselsplat("replay", path, "--out", remade, "--source", runs["original"]).code == 0
    assert np.array_equal(cv2.imread(str(remade))[..., ::-1], picture)


def test_the_difference_is_to_the_frame_that_the_run_was_trained_on(
    runs: dict[str, Path], tmp_path: Path, vesselsplat: Cli
) -> None:
    flags = ("--out", tmp_path / "out", "--frames", 3, "--view", "difference")
    assert vesselsplat("render", runs["enhanced"], *flags).code == 0
    picture = cv2.imread(str(tmp_path / "out" / "frame-000003.png"))[:48, :64, ::-1]
    run = RunFolder(runs["enhanced"])
    record, model = run.record(), run.model()
    camera = record.cameras[3]
    drawn = draw_on_cpu(model.at(record.time(3)), camera, DrawOptions(near_plane(model, camera)))
    reference = open_evaluation(runs["enhanced"]).trained_clip.read_image(3)
    assert np.array_equal(picture, composed("difference", drawn, "mm", reference).image)


@pytest.mark.parametrize(
    ("flags", "word"),
    [
        (("--view", "difference", "--time", 0.5), "own cameras"),
        (("--view", "depth", "--transparent"), "without a scale"),
        (
            ("--view", "depth", "--background", "hatched"),
            "--background hatched: expected a --view without a scale",
        ),
        (("--view", "points", "--depth"), "of unaltered Gaussians"),
        (("--view", "points", "--with", "reference"), "expected cpu or gl for points"),
        (("--view", "surface", "--with", "reference"), "expected cpu for --view surface"),
    ],
)
def test_what_does_not_go_together_is_one_line(
    runs: dict[str, Path], tmp_path: Path, vesselsplat: Cli, flags: tuple[object, ...], word: str
) -> None:
    call = vesselsplat("render", runs["original"], "--out", tmp_path / "out", *flags)
    assert (call.code, call.error.count("\n")) == (2, 1)
    assert word in call.error
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("command", [("render", "--out"), ("export", "--video")])
def test_along_a_path_there_are_no_frames_to_differ_from(
    runs: dict[str, Path], tmp_path: Path, vesselsplat: Cli, command: tuple[str, str]
) -> None:
    file, out = tmp_path / "views.json", tmp_path / "out.mp4"
    camera = RunFolder(runs["original"]).record().cameras[0]
    file.write_bytes(views_json(Views(path=CameraPath((Keyframe(0.0, 0.0, camera),)), unit="mm")))
    call = vesselsplat(command[0], runs["original"], command[1], out, "--path", file, "--view", "difference")
    assert (call.code, call.error.count("\n")) == (2, 1)
    assert "own cameras" in call.error
    assert not out.exists()


def test_every_view_has_a_shape_and_an_explanation() -> None:
    assert SHAPES.keys() == EXPLAINED.keys()


def test_where_nothing_has_moved_the_scale_has_one_value() -> None:
    """As at the first frame: not a row of zeros."""
    nothing = np.zeros((4, 5), np.float32)
    drawn = Rendered(np.zeros((4, 5, 3), np.float32), np.ones_like(nothing), nothing)
    scale = composed("motion", drawn, "mm").scale
    assert scale is not None
    assert [scale.text(tick) for tick in scale.ticks] == ["0"]
