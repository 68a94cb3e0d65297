"""Splats drawn with OpenGL against the float64 reference."""

from __future__ import annotations

from dataclasses import replace

import moderngl
import numpy as np
import pytest

from renderer.camera import Camera
from renderer.draw import splat_view
from renderer.draw.offscreen import Offscreen, read_image, render_offscreen
from renderer.draw.sorting import DepthKeys, depth_order
from renderer.draw.splat_view import Precision, SplatView
from renderer.measuring.stability.scenes import joined
from renderer.rasterize.cpu import render
from renderer.rasterize.rendered import Rendered
from renderer.splats import Splats
from tests.renderer.draw.oracle import levels, psnr, reference
from tests.renderer.scenes import random_splats, turned_camera

pytestmark = pytest.mark.gl

BACKGROUND = (0.2, 0.35, 0.5)
CAMERA = turned_camera(96, 72)
NONE = np.zeros((0, 0, 3), dtype=np.float32)


def scene(seed: int, camera: Camera = CAMERA) -> Splats:
    """300 small splats in front of 30 that reach over the borders of the picture."""
    small = random_splats(300, camera, seed)
    large = random_splats(30, camera, seed + 1000, sigma=(20.0, 60.0))
    return joined(small, large)


def splat(
    mean: tuple[float, float, float] = (0.0, 0.0, 5.0),
    scales: tuple[float, float, float] = (0.3, 0.3, 0.3),
    opacity: float = 0.8,
    color: tuple[float, float, float] = (0.9, 0.5, 0.2),
) -> Splats:
    values = ([mean], [(0.9, 0.1, -0.3, 0.2)], [scales], [opacity], [color])
    means, quats, scales_, opacities, colors = (np.array(value, dtype=np.float32) for value in values)
    return Splats(means, quats, scales_, opacities, colors)


def layers(ctx: moderngl.Context, splats: Splats, camera: Camera) -> Rendered:
    offscreen = Offscreen(ctx)
    seen = offscreen.layers(splats, camera, 0.01)
    offscreen.release()
    return seen


@pytest.mark.parametrize(("precision", "least"), [("half", 60.0), ("float", 75.0)])
@pytest.mark.parametrize("seed", range(3))
def test_the_picture_is_that_of_the_reference(
    ctx: moderngl.Context, precision: Precision, least: float, seed: int
) -> None:
    """Measured with llvmpipe: 65 dB with half floats, which it truncates, and 138 dB with floats."""
    splats = scene(seed)
    oracle = reference(splats, CAMERA, BACKGROUND).image.numpy()
    image = render_offscreen(ctx, splats, CAMERA, BACKGROUND, precision)
    assert oracle.std() > 0.05
    assert psnr(image, oracle) >= least
    assert levels(image, oracle, 0.999) <= 1.0


def test_pictures_one_after_another_are_those_drawn_alone(ctx: moderngl.Context) -> None:
    """Other splats, sizes and near planes leave nothing behind."""
    offscreen = Offscreen(ctx)
    wide = CAMERA.resized(128, 40)
    asked = [(scene(1), CAMERA, 0.01), (random_splats(50, wide, 2), wide, 0.01), (scene(1), CAMERA, 60.0)]
    for splats, camera, near in (*asked, asked[0]):
        alone = Offscreen(ctx)
        got, wanted = (vars(one.layers(splats, camera, near)) for one in (offscreen, alone))
        assert [name for name in got if not np.array_equal(got[name], wanted[name])] == []
        alone.release()
    offscreen.release()


def test_half_floats_hold_hundreds_of_faint_layers(ctx: moderngl.Context) -> None:
    """As trained models have them. Summed up from black, the steps that a driver cuts off at every layer come
    to several grey levels: 42 dB with llvmpipe, against 62 about the mean colour."""
    many = random_splats(4000, CAMERA, 30, sigma=(4.0, 16.0))
    tissue = (np.array([0.8, 0.4, 0.35]) + 0.3 * (many.colors - 0.5)).astype(np.float32)
    splats = replace(many, opacities=0.1 * many.opacities, colors=tissue)
    oracle = reference(splats, CAMERA, BACKGROUND)
    image = render_offscreen(ctx, splats, CAMERA, BACKGROUND, "half")
    assert oracle.alpha.mean() > 0.9
    assert psnr(image, oracle.image.numpy()) >= 60
    assert levels(image, oracle.image.numpy(), 0.999) <= 1.0


@pytest.mark.parametrize("seed", range(3))
def test_expected_depth_is_that_of_the_reference(ctx: moderngl.Context, seed: int) -> None:
    splats = random_splats(150, CAMERA, seed)
    oracle = reference(splats, CAMERA)
    depth, alpha = layers(ctx, splats, CAMERA).depth, oracle.alpha.numpy()
    assert (alpha > 0.5).any()
    assert (alpha == 0).any()
    np.testing.assert_allclose(depth[alpha > 0], oracle.depth.numpy()[alpha > 0], rtol=1e-5)
    assert not depth[alpha == 0].any()


@pytest.mark.parametrize("opacity", [0.0, 0.5 / 255, 0.3, 1.0])
@pytest.mark.parametrize(
    "scales",
    [
        (1e-8, 1e-8, 1e-8),
        (1e8, 1e8, 1e8),
        (1e30, 1e30, 1e30),
        (1e8, 1e-8, 1e-8),
        (1e-8, 1.0, 1e-8),
        (30.0, 3e-5, 30.0),
        (0.0, 0.0, 0.0),
    ],
)
def test_extreme_scales_agree_with_the_reference(
    ctx: moderngl.Context, scales: tuple[float, float, float], opacity: float
) -> None:
    camera = Camera(fx=40.0, fy=44.0, cx=14.5, cy=9.25, width=32, height=24)
    splats = joined(
        *[splat(mean, scales, opacity) for mean in ((0.4, 0.3, 5.0), (-3.0, 1.0, 2.0), (9.0, 0.0, 1.0))]
    )
    image = render_offscreen(ctx, splats, camera, BACKGROUND)
    oracle = reference(splats, camera, BACKGROUND).image.numpy()
    assert levels(image, oracle, 1.0) <= 1.0
    assert psnr(image, oracle) >= 75


@pytest.mark.parametrize("factor", [-1.0, 1e-30, 1e30])
def test_the_length_and_sign_of_a_quaternion_mean_nothing(ctx: moderngl.Context, factor: float) -> None:
    splats = scene(4)
    scaled = replace(splats, quats=np.float32(factor) * splats.quats)
    image = render_offscreen(ctx, scaled, CAMERA)
    assert psnr(image, render_offscreen(ctx, splats, CAMERA)) >= 100


def test_the_zero_quaternion_is_no_rotation(ctx: moderngl.Context) -> None:
    splats = replace(splat(scales=(0.5, 0.1, 0.02)), quats=np.zeros((1, 4), dtype=np.float32))
    camera = Camera.from_fov(60, 24, 16)
    assert psnr(render_offscreen(ctx, splats, camera), reference(splats, camera).image.numpy()) >= 75


def test_splats_that_pass_beside_the_camera_agree_with_the_reference(ctx: moderngl.Context) -> None:
    """Depths from the near plane on, where the Jacobian is held inside the guard band."""
    camera = Camera(fx=40.0, fy=44.0, cx=14.5, cy=9.25, width=32, height=24)
    random = np.random.default_rng(3)
    depths = np.geomspace(0.011, 3.0, 60)
    slopes = random.uniform(-3, 3, (60, 2))
    parts = [
        splat((x * z, y * z, z), (0.05, 0.02, 0.1), 0.2, (x % 1, 0.5, y % 1))
        for (x, y), z in zip(slopes, depths, strict=True)
    ]
    splats = joined(*parts)
    oracle = reference(splats, camera, BACKGROUND).image.numpy()
    assert psnr(render_offscreen(ctx, splats, camera, BACKGROUND), oracle) >= 75
    assert psnr(oracle, reference(joined(*parts[20:]), camera, BACKGROUND).image.numpy()) < 50


def test_the_near_plane_is_configurable(ctx: moderngl.Context) -> None:
    splats = joined(splat((0.0, 0.0, 2.0)), splat((0.0, 0.0, 3.0)))
    camera = Camera.from_fov(60, 24, 16)
    image = render_offscreen(ctx, splats, camera, near=2.0)
    np.testing.assert_allclose(image, render_offscreen(ctx, splat((0.0, 0.0, 3.0)), camera), atol=1e-6)
    with pytest.raises(ValueError, match="near must be > 0, got 0"):
        SplatView(ctx, near=0.0)


def test_blending_beyond_the_stop_changes_a_channel_by_less_than_its_bound(ctx: moderngl.Context) -> None:
    """Sixty opaque layers: the reference stops after three, blending goes on."""
    layers = [
        splat((0.0, 0.0, 2.0 + 0.1 * layer), (9.0, 9.0, 9.0), 1.0, (1.0, 0.0, layer % 2))
        for layer in range(60)
    ]
    camera = Camera.from_fov(60, 24, 16)
    image = render_offscreen(ctx, joined(*layers), camera, (0.0, 1.0, 0.0))
    oracle = reference(joined(*layers), camera, (0.0, 1.0, 0.0)).image.numpy()
    assert np.abs(image - oracle).max() <= 1e-4 + 1e-6


def no_splats() -> Splats:
    empty = np.zeros((0, 3), dtype=np.float32)
    return Splats(empty, np.zeros((0, 4), dtype=np.float32), empty, np.zeros(0, dtype=np.float32), empty)


@pytest.mark.parametrize(
    "splats", [no_splats(), splat((0.0, 0.0, -5.0)), splat((0.0, 0.0, 0.0)), splat(opacity=0.0)],
    ids=["none", "behind", "at the camera", "transparent"],
)  # fmt: skip
def test_nothing_to_see_shows_the_background(ctx: moderngl.Context, splats: Splats) -> None:
    camera = Camera.from_fov(60, 24, 16)
    image = render_offscreen(ctx, splats, camera, BACKGROUND)
    np.testing.assert_allclose(image, np.broadcast_to(BACKGROUND, (16, 24, 3)), atol=1e-7)
    assert not layers(ctx, splats, camera).depth.any()


def test_a_view_without_an_upload_shows_the_background(ctx: moderngl.Context) -> None:
    view, framebuffer = SplatView(ctx), ctx.simple_framebuffer((24, 16))
    view.draw(CAMERA, framebuffer, background=(1.0, 0.0, 1.0))
    assert framebuffer.read(components=4) == bytes((255, 0, 255, 255)) * (24 * 16)
    view.release()
    framebuffer.release()


def test_one_splat_falls_on_its_pixel_and_the_framebuffer_starts_at_the_bottom(ctx: moderngl.Context) -> None:
    """x = (20.5 - 14.5) / 40 * 2 and y = (7.5 - 9.25) / 44 * 2 is the centre of column 20, row 7."""
    camera = Camera(fx=40.0, fy=44.0, cx=14.5, cy=9.25, width=32, height=24)
    point = splat((0.3, -1.75 / 22, 2.0), (1e-8, 1e-8, 1e-8), 0.8, (1.0, 0.0, 0.0))
    view, framebuffer = SplatView(ctx), ctx.simple_framebuffer((32, 24))
    view.upload(point)
    view.draw(camera, framebuffer)
    stored = np.frombuffer(framebuffer.read(components=4), dtype=np.uint8).reshape(24, 32, 4)
    assert divmod(int(stored[..., 0].argmax()), 32) == (24 - 1 - 7, 20)
    assert abs(int(stored[24 - 1 - 7, 20, 0]) - 0.8 * 255) <= 1
    assert (stored[..., 3] == 255).all()
    image, depth = read_image(framebuffer), view.read_depth(camera)
    assert divmod(int(image[..., 0].argmax()), 32) == (7, 20)
    assert depth[7, 20] == pytest.approx(2.0, rel=1e-6)
    view.release()
    framebuffer.release()


def test_only_the_viewport_is_filled_and_the_camera_takes_its_size(ctx: moderngl.Context) -> None:
    splats, whole = scene(5), ctx.simple_framebuffer((100, 80), dtype="f4")
    view = SplatView(ctx, precision="float")
    view.upload(splats)
    whole.clear(0.5, 0.5, 0.5)
    whole.viewport = (30, 20, 48, 36)
    view.draw(CAMERA, whole, background=BACKGROUND)
    image = read_image(whole)
    inside = image[80 - 20 - 36 : 80 - 20, 30 : 30 + 48]
    np.testing.assert_allclose(
        inside, render_offscreen(ctx, splats, CAMERA.resized(48, 36), BACKGROUND), atol=1e-6
    )
    outside = np.ones((80, 100), dtype=bool)
    outside[80 - 20 - 36 : 80 - 20, 30 : 30 + 48] = False
    assert (image[outside] == 0.5).all()
    view.release()
    whole.release()


def test_one_view_serves_framebuffers_of_changing_size(ctx: moderngl.Context) -> None:
    splats, view = scene(6), SplatView(ctx, precision="float")
    view.upload(splats)
    for size in ((96, 72), (40, 60), (96, 72)):
        framebuffer = ctx.simple_framebuffer(size, dtype="f4")
        view.draw(CAMERA, framebuffer)
        expected = render_offscreen(ctx, splats, CAMERA.resized(*size))
        np.testing.assert_array_equal(read_image(framebuffer), expected)
        framebuffer.release()
    view.release()


@pytest.mark.parametrize("precision", ["half", "float"])
def test_the_same_input_gives_the_same_bytes(ctx: moderngl.Context, precision: Precision) -> None:
    first = render_offscreen(ctx, scene(7), CAMERA, BACKGROUND, precision)
    assert render_offscreen(ctx, scene(7), CAMERA, BACKGROUND, precision).tobytes() == first.tobytes()


def test_an_upload_replaces_what_is_drawn_whatever_its_size(ctx: moderngl.Context) -> None:
    """1025 splats take two rows of the records' texture, 40 take one."""
    view, framebuffer = SplatView(ctx), ctx.simple_framebuffer((96, 72), dtype="f4")
    for splats in (
        random_splats(1025, CAMERA, 1),
        random_splats(40, CAMERA, 2),
        random_splats(1100, CAMERA, 3),
    ):
        view.upload(splats)
        view.draw(CAMERA, framebuffer)
        assert psnr(read_image(framebuffer), reference(splats, CAMERA).image.numpy()) >= 60
    view.release()
    framebuffer.release()


@pytest.mark.parametrize("field", ["means", "quats", "scales", "opacities", "colors", "harmonics"])
@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_a_value_that_is_not_finite_is_refused_and_changes_nothing(
    ctx: moderngl.Context, field: str, bad: float
) -> None:
    splats, spoilt = random_splats(40, CAMERA, 8), glossy(9)
    getattr(spoilt, field)[13] = bad
    view, framebuffer = SplatView(ctx), ctx.simple_framebuffer((96, 72))
    view.upload(splats)
    view.draw(CAMERA, framebuffer)
    before = framebuffer.read()
    with pytest.raises(ValueError, match=rf"Splats\.{field} must be finite, got .* in row 13"):
        view.upload(spoilt)
    view.draw(CAMERA, framebuffer)
    assert framebuffer.read() == before
    view.release()
    framebuffer.release()


def test_splats_are_sorted_only_when_they_or_the_camera_changed(
    ctx: moderngl.Context, monkeypatch: pytest.MonkeyPatch
) -> None:
    sorts = []

    def counted(depths: np.ndarray, keys: DepthKeys) -> np.ndarray:
        sorts.append(len(depths))
        return depth_order(depths, keys)

    monkeypatch.setattr(splat_view, "depth_order", counted)
    view, framebuffer = SplatView(ctx), ctx.simple_framebuffer((96, 72))
    view.upload(random_splats(40, CAMERA, 1))
    for _ in range(3):
        view.draw(CAMERA, framebuffer)
        view.read_depth(CAMERA)
        view.draw(turned_camera(96, 72, focal=81.0), framebuffer)  # a zoom leaves the order as it is
    assert sorts == [40]
    moved = CAMERA.moved(Camera.from_fov(60, 96, 72).camera_from_world)
    view.draw(moved, framebuffer)
    assert len(sorts) == 2
    view.upload(random_splats(50, CAMERA, 2))
    view.draw(CAMERA, framebuffer)
    assert len(sorts) == 3
    assert sorts[2] == 50
    view.release()
    framebuffer.release()


def glossy(seed: int) -> Splats:
    """A scene whose colours depend on the view, by harmonics of degree 3."""
    splats = scene(seed)
    harmonics = np.random.default_rng(seed).normal(scale=0.2, size=(len(splats), 15, 3))
    return replace(splats, harmonics=harmonics.astype(np.float32))


def beside(camera: Camera) -> Camera:
    """The camera moved and turned about the scene."""
    turn = np.eye(4)
    turn[[0, 0, 2, 2], [0, 2, 0, 2]] = np.cos(0.3), np.sin(0.3), -np.sin(0.3), np.cos(0.3)
    turn[:3, 3] = (-20.0, 2.0, 1.0)
    return camera.moved(turn @ camera.camera_from_world)


def test_harmonics_show_each_camera_what_the_processor_shows_it(
    ctx: moderngl.Context, monkeypatch: pytest.MonkeyPatch
) -> None:
    """And nothing is uploaded when the camera moves."""
    splats, view = glossy(13), SplatView(ctx, precision="float")
    framebuffer = ctx.simple_framebuffer((96, 72), dtype="f4")
    view.upload(splats)
    monkeypatch.setattr(splat_view, "Storage", None)
    for camera in (CAMERA, beside(CAMERA)):
        view.draw(camera, framebuffer, background=BACKGROUND)
        picture = render(splats, camera, BACKGROUND).image
        assert psnr(read_image(framebuffer), picture) >= 75
        assert psnr(render(replace(splats, harmonics=NONE), camera, BACKGROUND).image, picture) < 40
    view.release()
    framebuffer.release()


def test_exact_keys_draw_a_scene_with_a_far_outlier_right(ctx: moderngl.Context) -> None:
    """The outlier leaves the 65536 levels of coarse keys to empty space: measured 23 dB against 138."""
    camera = Camera.from_fov(60, 96, 72)
    near = joined(random_splats(400, camera, 12, sigma=(3.0, 9.0)), splat((0.0, 0.0, 1e7)))
    oracle = reference(near, camera).image.numpy()
    view = SplatView(ctx, precision="float", keys=16)
    framebuffer = ctx.simple_framebuffer((96, 72), dtype="f4")
    view.upload(near)
    view.draw(camera, framebuffer)
    assert psnr(read_image(framebuffer), oracle) < 40
    assert psnr(render_offscreen(ctx, near, camera), oracle) >= 75
    view.release()
    framebuffer.release()


def test_half_a_million_splats_are_drawn_as_the_processor_draws_them(ctx: moderngl.Context) -> None:
    """Half of them behind the camera, which both leave out."""
    camera = turned_camera(48, 36)
    splats = random_splats(500_000, camera, 21, sigma=(0.2, 0.8))
    behind = camera.world_from_camera[:3, 2] * 500.0
    means = splats.means.copy()
    means[::2] -= behind.astype(np.float32)
    splats = replace(splats, means=means, opacities=splats.opacities * np.float32(0.1))
    image = render_offscreen(ctx, splats, camera, BACKGROUND)
    assert psnr(image, render(splats, camera, BACKGROUND).image) >= 60
    assert image.std() > 0.02


def test_more_splats_than_a_texture_holds_are_refused_in_a_line(
    ctx: moderngl.Context, monkeypatch: pytest.MonkeyPatch
) -> None:
    """And what was drawn before still is."""
    view, framebuffer = SplatView(ctx), ctx.simple_framebuffer((96, 72))
    view.upload(random_splats(40, CAMERA, 2))
    view.draw(CAMERA, framebuffer)
    before = framebuffer.read()
    monkeypatch.setitem(ctx.info, "GL_MAX_TEXTURE_SIZE", 1)
    with pytest.raises(ValueError, match="at most 1024 splats here, got 1025"):
        view.upload(random_splats(1025, CAMERA, 1))
    with pytest.raises(ValueError, match="at most 256 splats here, got 330"):
        view.upload(glossy(1))
    view.draw(CAMERA, framebuffer)
    assert framebuffer.read() == before
    view.release()
    framebuffer.release()
