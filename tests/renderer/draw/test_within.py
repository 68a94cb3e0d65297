"""What lies beyond the image or field of a camera is not drawn: CPU, OpenGL and reference, against lines in
space."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import moderngl
import numpy as np
import pytest
import torch

from renderer.camera import Camera, FloatArray
from renderer.draw.splat_view import SplatView
from renderer.in_view import FieldInView, InView
from renderer.rasterize.cpu import render
from renderer.rasterize.crossings import crossings, margins
from renderer.rasterize.reference import rasterize_reference, rotations
from renderer.rasterize.rendered import Rendered
from renderer.splats import Splats
from tests.renderer.scenes import random_splats

CLIP = Camera.from_fov(60, 64, 48)
FAR = 80.0
OCTAGON = FieldInView(
    CLIP, np.array([(30, 4), (50, 11), (58, 28), (50, 41), (30, 46), (13, 40), (5, 25), (14, 9)], np.float64)
)


def _aside(degrees: float) -> Camera:
    """Looks at the point at FAR on the axis of CLIP from beside it."""
    angle = np.radians(degrees)
    pose, to_pivot, back = np.eye(4), np.eye(4), np.eye(4)
    pose[0, [0, 2]], pose[2, [0, 2]] = (np.cos(angle), np.sin(angle)), (-np.sin(angle), np.cos(angle))
    to_pivot[2, 3], back[2, 3] = -FAR, 1.2 * FAR
    return Camera(90.0, 95.0, 46.0, 37.0, 96, 72, back @ pose @ to_pivot)


ASIDE = _aside(30)


class Planes(NamedTuple):
    sides: FloatArray


Draw = Callable[[Splats, Camera, InView | None], Rendered]


@pytest.fixture(params=["processor", "reference", pytest.param("opengl", marks=pytest.mark.gl)])
def draw(request: pytest.FixtureRequest) -> Draw:
    if request.param == "processor":
        return lambda splats, camera, within: render(splats, camera, within=within)
    if request.param == "reference":
        return _reference
    ctx: moderngl.Context = request.getfixturevalue("ctx")

    def drawn(splats: Splats, camera: Camera, within: InView | None) -> Rendered:
        view = SplatView(ctx, precision="float")
        view.upload(splats)
        color, depth = view.read_color(camera, within=within), view.read_depth(camera, within=within)
        view.release()
        return Rendered(color[..., :3], color[..., 3], depth)

    return drawn


def _reference(splats: Splats, camera: Camera, within: InView | None) -> Rendered:
    names = ("means", "quats", "scales", "opacities", "colors")
    values = (torch.from_numpy(getattr(splats, name)) for name in names)
    drawn = rasterize_reference(*values, camera, within=within)
    layers = (drawn.image, drawn.alpha, drawn.depth)
    return Rendered(*(layer.numpy().astype(np.float32) for layer in layers))


def wall() -> Splats:
    """A plane of overlapping discs, square to the axis of CLIP and wider than its field of view."""
    side = np.linspace(-FAR, FAR, 76)
    x, y = (grid.ravel() for grid in np.meshgrid(side, side))
    means = np.stack([x, y, np.full_like(x, FAR)], axis=1).astype(np.float32)
    count = len(means)
    scales = np.tile(np.float32([2.2, 2.2, 3e-3]), (count, 1))
    colors = np.full((count, 3), 0.7, np.float32)
    quats = np.tile(np.float32([1, 0, 0, 0]), (count, 1))
    return Splats(means, quats, scales, np.full(count, 0.95, np.float32), colors)


def seen_by_clip(outline: FloatArray) -> FloatArray:
    """(H, W) by how many pixels of ASIDE the wall's point behind each of its pixels lies within the outline
    in CLIP's image; negative beyond it."""
    origin = ASIDE.position
    rays = ASIDE.unproject(np.ones((ASIDE.height, ASIDE.width))) - origin
    points = origin + rays * ((FAR - origin[2]) / rays[..., 2])[..., None]
    pixels, _ = CLIP.project(points.reshape(-1, 3))
    ahead = np.roll(outline, -1, axis=0) - outline
    inwards = np.stack([-ahead[:, 1], ahead[:, 0]], axis=1)
    edges = (inwards @ pixels.T - (inwards * outline).sum(axis=1)[:, None]).reshape(
        -1, ASIDE.height, ASIDE.width
    )
    slopes = np.stack([np.hypot(*np.gradient(edge)) for edge in edges])
    return np.asarray((edges / slopes).min(axis=0))


IMAGE = np.array([(0, 0), (CLIP.width, 0), (CLIP.width, CLIP.height), (0, CLIP.height)], np.float64)


@pytest.mark.parametrize(("within", "outline"), [(CLIP, IMAGE), (OCTAGON, OCTAGON.outline)])
def test_a_wall_ends_where_the_image_or_field_of_the_other_camera_does(
    draw: Draw, within: InView, outline: FloatArray
) -> None:
    inside = seen_by_clip(outline)
    assert 0.1 < (inside > 0).mean() < 0.95
    free, bounded = draw(wall(), ASIDE, None), draw(wall(), ASIDE, within)
    assert free.alpha[np.abs(inside) < 3].min() > 0.98
    assert bounded.alpha[inside < -1].max() == 0
    assert bounded.alpha[inside > 1].min() > 0.98
    assert np.abs(bounded.image - free.image)[inside > 1].max() < 2e-3


@pytest.mark.parametrize("sigma", [(0.2, 1.0), (2.0, 6.0), (5.0, 30.0)])
@pytest.mark.parametrize("within", [CLIP, OCTAGON])
def test_cpu_and_opengl_draw_what_the_reference_does(
    draw: Draw, within: InView, sigma: tuple[float, float]
) -> None:
    splats = random_splats(300, ASIDE, 4, sigma=sigma)
    told, oracle = draw(splats, ASIDE, within), _reference(splats, ASIDE, within)
    assert np.abs(oracle.image - _reference(splats, ASIDE, None).image).max() > 0.1
    assert np.sqrt(np.mean((told.image - oracle.image) ** 2)) < 2e-4
    assert np.quantile(np.abs(told.alpha - oracle.alpha), 0.999) < 4e-3


def test_what_the_camera_sees_itself_stays(draw: Draw) -> None:
    """But for what the affine approximation of large splats moves at the outermost pixels."""
    splats = random_splats(300, CLIP, 1)
    off = np.abs(draw(splats, CLIP, CLIP).image - draw(splats, CLIP, None).image)
    assert off[2:-2, 2:-2].max() < 1e-5
    assert off.max() < 0.1


def test_lines_are_those_of_the_likeliest_point_behind_a_pixel() -> None:
    """Of 3-D points drawn from a Gaussian, those that fall near a pixel lie, on average, where it says."""
    splats = random_splats(1, ASIDE, 5, sigma=(4.0, 9.0))
    given = splats.means, splats.quats, splats.scales
    means, quats, scales = (values.astype(np.float64) for values in given)
    ((lines),) = crossings(means, quats, scales, ASIDE, CLIP)
    turn = rotations(torch.from_numpy(quats))[0].numpy()
    rng = np.random.default_rng(0)
    points = means + (rng.normal(size=(400_000, 3)) * scales) @ turn.T
    pixels, _ = ASIDE.project(points)
    center, _ = ASIDE.project(means)
    # What the low-pass adds to a pixel's position tells nothing of the point.
    offsets = pixels - center + rng.normal(size=pixels.shape) * np.sqrt(0.3)
    distances = points @ CLIP.sides[:, :3].T + CLIP.sides[:, 3]
    fit = np.linalg.lstsq(np.column_stack([np.ones(len(offsets)), offsets]), distances, rcond=None)[0].T
    fit /= np.linalg.norm(fit[:, 1:], axis=1, keepdims=True)
    assert np.allclose(fit[:, 1:], lines[:, 1:], atol=0.05)
    assert np.allclose(fit[:, 0], lines[:, 0], rtol=0.05, atol=0.3)


@pytest.mark.gl
def test_what_is_not_shown_is_not_drawn_until_it_is(ctx: moderngl.Context) -> None:
    splats = random_splats(200, CLIP, 8)
    some = np.arange(200) % 3 > 0
    view = SplatView(ctx, precision="float")
    view.upload(splats)
    whole = view.read_color(CLIP)
    part = view.read_color(CLIP, shown=some)
    left = replace(splats, opacities=np.where(some, splats.opacities, np.float32(0)))
    assert np.abs(part[..., :3] - render(left, CLIP).image).max() < 2e-3
    assert np.abs(part - whole).max() > 0.1
    assert np.array_equal(view.read_color(CLIP), whole)
    view.release()


def test_of_a_field_the_two_nearest_sides_cut_a_splat() -> None:
    splats = random_splats(50, ASIDE, 5)
    given = splats.means, splats.quats, splats.scales
    means, quats, scales = (values.astype(np.float64) for values in given)
    lines = crossings(means, quats, scales, ASIDE, OCTAGON)
    assert np.array_equal(lines[:, :4], crossings(means, quats, scales, ASIDE, CLIP))
    sides = OCTAGON.sides[4:]
    distances = means @ sides[:, :3].T + sides[:, 3]
    for i, nearest in enumerate(np.argsort(distances, axis=1)[:, :2]):
        two = Planes(np.concatenate([CLIP.sides, sides[nearest]]))
        (alone,) = crossings(means[i : i + 1], quats[i : i + 1], scales[i : i + 1], ASIDE, two)
        assert np.allclose(sorted(lines[i].tolist()), sorted(alone.tolist()))


def test_splats_whose_margin_is_beyond_one_are_not_crossed() -> None:
    splats = random_splats(2000, ASIDE, 6, sigma=(1.0, 20.0))
    margin = margins(splats, CLIP)
    corners = np.array([[i, j, k] for i in (-1, 1) for j in (-1, 1) for k in (-1, 1)]) * 3.33 / np.sqrt(3)
    turns = rotations(torch.from_numpy(splats.quats.astype(np.float64))).numpy()
    points = splats.means[:, None] + (corners * splats.scales[:, None]) @ turns.transpose(0, 2, 1)
    distances = points @ CLIP.sides[:, :3].T + CLIP.sides[:, 3]
    assert (distances[margin > 1] > 0).all()
    assert (distances[margin < -1] < 0).all(axis=1).any(axis=1).all()
    assert min((margin > 1).sum(), (margin < -1).sum(), (np.abs(margin) < 1).sum()) > 50


@pytest.mark.parametrize("size", [0.0, 1e-12, 1e6, 1e12])
@pytest.mark.parametrize("opacity", [1e-3, 1.0])
def test_extreme_splats_are_finite(draw: Draw, size: float, opacity: float) -> None:
    splats = random_splats(40, ASIDE, 7)
    scales = splats.scales.copy()
    scales[::2] = size
    quats = splats.quats.copy()
    quats[::3] = 0
    splats = replace(splats, scales=scales, quats=quats, opacities=np.full(40, opacity, np.float32))
    drawn = draw(splats, ASIDE, CLIP)
    assert all(np.isfinite(layer).all() for layer in (drawn.image, drawn.alpha, drawn.depth))
    assert drawn.alpha.max() <= 1


@pytest.mark.parametrize("length", [1e8, 1e15, 1e30])
def test_needles_of_any_length_are_cut(draw: Draw, length: float) -> None:
    """As long as that, what the low-pass adds is lost beside it, and the covariance is singular."""
    splats = random_splats(200, ASIDE, 9)
    scales = np.full_like(splats.scales, 1e-30)
    scales[:, 2] = length
    drawn = draw(replace(splats, scales=scales), ASIDE, CLIP)
    assert all(np.isfinite(layer).all() for layer in (drawn.image, drawn.alpha, drawn.depth))


def test_a_camera_sees_only_what_another_does() -> None:
    assert CLIP.sees_only(CLIP)
    assert CLIP.resized(333, 250).sees_only(CLIP)
    assert not CLIP.fitted(200, 48).sees_only(CLIP)
    assert CLIP.sees_only(CLIP.fitted(200, 48))
    assert not CLIP.moved(ASIDE.camera_from_world).sees_only(CLIP)


def test_sides_hold_what_projects_into_the_image() -> None:
    rng = np.random.default_rng(3)
    points = ASIDE.position + rng.normal(size=(5000, 3)) * FAR
    pixels, depths = ASIDE.project(points)
    falls = (depths > 0) & (pixels >= 0).all(axis=1) & (pixels <= (ASIDE.width, ASIDE.height)).all(axis=1)
    distances = points @ ASIDE.sides[:, :3].T + ASIDE.sides[:, 3]
    assert np.array_equal((distances >= 0).all(axis=1), falls)
    assert falls.any()
