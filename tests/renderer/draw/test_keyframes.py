"""Moving splats baked into keyframes, against the model itself at the same times."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import moderngl
import numpy as np
import pytest

from renderer.draw import splat_view
from renderer.draw.keyframes import Baker, Keyframes, Tolerance, baked
from renderer.draw.offscreen import read_image, render_offscreen
from renderer.draw.records import PAINT, PLACE, SIZE, TURN
from renderer.draw.splat_view import SplatView
from renderer.draw.storage import Storage
from renderer.gaussians import DynamicGaussians
from renderer.paint import by_motion
from renderer.raw_gaussians import RawGaussians
from renderer.splats import Splats
from tests.renderer.draw.oracle import levels, psnr
from tests.renderer.scenes import random_splats, turned_camera

CAMERA = turned_camera(96, 72)
TIMES = tuple(np.arange(20) / 20)
PIXEL = 80 / CAMERA.fx
"""Scene units at the middle of the scene."""
TOLERANCE = Tolerance(mean=0.02 * PIXEL)
Change = Callable[[RawGaussians, float], RawGaussians]


@dataclass(frozen=True)
class Moving:
    """A motion that is any function of time."""

    change: Change

    def moved(self, raw: RawGaussians, time: float) -> RawGaussians:
        return self.change(raw, time)


def raw_of(splats: Splats) -> RawGaussians:
    logits = np.log(splats.opacities / (1 - splats.opacities))
    return RawGaussians(
        splats.means, splats.quats, np.log(splats.scales), logits, splats.colors, splats.harmonics
    )


def model_of(change: Change, seed: int = 1, count: int = 300) -> DynamicGaussians:
    return DynamicGaussians(raw_of(random_splats(count, CAMERA, seed)), Moving(change))  # type: ignore[arg-type]


def swing(raw: RawGaussians, time: float) -> RawGaussians:
    """All but every third splat go to and fro by ten pixels, in and out of depth, and change colour."""
    means, colors = raw.means.copy(), raw.colors.copy()
    phase = np.arange(len(raw), dtype=np.float32)
    way = 10 * PIXEL * np.sin(2 * np.pi * time + phase)
    means += way[:, None] * np.float32([0.5, 0.3, 0.8])
    colors += 0.2 * np.sin(5 * time + phase)[:, None]
    means[::3], colors[::3] = raw.means[::3], raw.colors[::3]
    return replace(raw, means=means.astype(np.float32), colors=colors.astype(np.float32))


def tumble(raw: RawGaussians, time: float) -> RawGaussians:
    """Turns of one and a half rounds over the clip, given with signs that jump; sizes that breathe."""
    angle = np.float32(1.5 * np.pi * time)
    turn = np.array([np.cos(angle), np.sin(angle), 0, 0]) * (-1) ** round(20 * time)
    w, x = turn[0], turn[1]
    a, b, c, d = raw.quats.T
    quats = np.stack([w * a - x * b, w * b + x * a, w * c - x * d, w * d + x * c], axis=1)
    sizes = raw.log_scales + np.float32(0.5 * np.sin(3 * time))
    return replace(raw, quats=quats.astype(np.float32), log_scales=sizes)


def fade(raw: RawGaussians, time: float) -> RawGaussians:
    """Half of them appear, the others go."""
    logits = np.where(np.arange(len(raw)) % 2, 20 * (time - 0.5), 20 * (0.5 - time)).astype(np.float32)
    return replace(raw, opacity_logits=logits)


@pytest.mark.parametrize(
    ("change", "texels"), [(swing, {PLACE, PAINT}), (tumble, {TURN, SIZE}), (fade, {PLACE})]
)
def test_keyframes_hold_the_model_at_their_times(change: Change, texels: set[int]) -> None:
    model = model_of(change)
    keyframes = baked(model, TIMES, TOLERANCE)
    assert set(keyframes.offsets) == texels
    assert (len(keyframes), keyframes.error) == (len(TIMES), 0.0)
    for time in TIMES:
        held, true = keyframes.at(time), model.at(time)
        assert np.abs(held.means - true.means).max() <= TOLERANCE.mean
        assert np.abs(held.colors - true.colors).max() <= TOLERANCE.color
        assert np.abs(held.opacities - true.opacities).max() <= TOLERANCE.opacity
        assert np.abs(held.scales / true.scales - 1).max() <= TOLERANCE.scale * 1.01
        cosine = np.abs((held.quats * true.quats).sum(axis=1))
        cosine /= np.linalg.norm(held.quats, axis=1) * np.linalg.norm(true.quats, axis=1)
        assert cosine.min() > 1 - 1e-6


def test_what_stands_still_has_no_offsets() -> None:
    keyframes = baked(model_of(swing), TIMES, TOLERANCE)
    assert not (keyframes.moving % 3 == 0).any()
    assert len(keyframes.moving) == 200
    still = baked(model_of(lambda raw, time: raw), TIMES, TOLERANCE)
    assert (len(still.moving), still.n_bytes) == (0, 0)


def test_turns_between_keyframes_go_the_short_way() -> None:
    """Though the signs jump from frame to frame; the chord of an arc halves it within 0.02 rad here."""
    model = model_of(tumble)
    keyframes = baked(model, TIMES, TOLERANCE)
    for index in range(19):
        time = (index + 0.5) / 20
        held = keyframes.at(time).quats
        held = held / np.linalg.norm(held, axis=1, keepdims=True)
        true = tumble(model.raw, time).quats
        true = true / np.linalg.norm(true, axis=1, keepdims=True)
        assert (2 * np.arccos(np.clip(np.abs((held * true).sum(axis=1)), 0, 1))).max() < 0.02


@pytest.mark.gl
@pytest.mark.parametrize("change", [swing, tumble, fade])
def test_the_card_draws_what_is_baked(ctx: moderngl.Context, change: Change) -> None:
    """At keyframes as good as drawing the model itself there: 60 dB, p99.9 within a level."""
    model = model_of(change)
    keyframes = baked(model, TIMES, TOLERANCE)
    view, framebuffer = SplatView(ctx, precision="float"), ctx.simple_framebuffer((96, 72), dtype="f4")
    view.upload_keyframes(keyframes)
    pictures = []
    for time in (0.0, 0.05, 0.45, 0.475, 0.95, 1.0):
        view.seek(time)
        view.draw(CAMERA, framebuffer)
        picture = read_image(framebuffer)
        pictures.append(picture)
        assert psnr(picture, render_offscreen(ctx, keyframes.at(time), CAMERA)) > 90
        if time in TIMES:
            direct = render_offscreen(ctx, model.at(time), CAMERA)
            assert psnr(picture, direct) > 60
            assert levels(picture, direct, 0.999) <= 1
    assert psnr(pictures[0], pictures[3]) < 40
    np.testing.assert_array_equal(pictures[-1], pictures[-2])
    view.release()
    framebuffer.release()


@pytest.mark.gl
def test_a_thousand_frames_are_scrubbed_as_a_few_are(ctx: moderngl.Context) -> None:
    times = [index / 1000 for index in range(1000)]
    model = model_of(swing)
    keyframes = baked(model, times, TOLERANCE)
    assert len(keyframes) == 1000
    view, framebuffer = SplatView(ctx, precision="float"), ctx.simple_framebuffer((96, 72), dtype="f4")
    view.upload_keyframes(keyframes)
    for time in (0.0, 0.371, 0.9985, 0.999):
        view.seek(time)
        view.draw(CAMERA, framebuffer)
        picture, direct = read_image(framebuffer), render_offscreen(ctx, model.at(min(time, 0.999)), CAMERA)
        assert psnr(picture, direct) > 60
        assert levels(picture, direct, 0.999) <= 1
    view.release()
    framebuffer.release()


@pytest.mark.gl
def test_the_card_paints_motion_as_renderer_paint_does(ctx: moderngl.Context) -> None:
    model = model_of(swing)
    keyframes = baked(model, TIMES, TOLERANCE)
    moving, arrays = SplatView(ctx), SplatView(ctx)
    moving.upload_keyframes(keyframes)
    for time in (0.0, 0.37, 0.95):
        splats = keyframes.at(time)
        moving.seek(time)
        arrays.upload(by_motion(splats, keyframes.rest))
        got, wanted = moving.read_color(CAMERA, paint="motion"), arrays.read_color(CAMERA)
        close = np.isclose(got, wanted, rtol=1e-3, atol=1e-3).all(axis=2)
        assert close.mean() > 0.999
    assert wanted[..., :3].std() > 0.05
    moving.release()
    arrays.release()


@pytest.mark.gl
def test_scrubbing_uploads_an_order_and_asks_the_model_nothing(
    ctx: moderngl.Context, monkeypatch: pytest.MonkeyPatch
) -> None:
    model, orders = model_of(swing), []
    keyframes = baked(model, TIMES, TOLERANCE)
    view, framebuffer = SplatView(ctx), ctx.simple_framebuffer((96, 72))
    view.upload_keyframes(keyframes)
    write_order = Storage.write_order

    def counted(storage: Storage, order: np.ndarray) -> None:
        orders.append(order.copy())
        write_order(storage, order)

    def refused(*_: object) -> None:
        raise AssertionError("nothing may be uploaded or evaluated")

    monkeypatch.setattr(Storage, "write_order", counted)
    monkeypatch.setattr(splat_view, "Storage", refused)
    monkeypatch.setattr(DynamicGaussians, "at", refused)
    for time in (0.1, 0.1, 0.3, 0.35):
        view.seek(time)
        view.draw(CAMERA, framebuffer)
    assert len(orders) == 3
    depths = CAMERA.project(keyframes.at(0.35).means.astype(np.float64))[1]
    assert (np.diff(depths[orders[-1]]) <= 1e-5).all()
    assert not np.array_equal(orders[0], orders[-1])
    view.release()
    framebuffer.release()


def test_too_many_frames_become_fewer_keyframes_and_the_error_is_said() -> None:
    model = model_of(swing)
    whole = baked(model, TIMES, TOLERANCE)
    fewer = baked(model, TIMES, TOLERANCE, most_bytes=8 * 2 * 300 * 7)
    assert len(fewer) == 7
    assert {fewer.times[0], fewer.times[-1]} == {TIMES[0], TIMES[-1]}
    assert fewer.n_bytes < whole.n_bytes / 2
    left_out = [time for time in TIMES if time not in fewer.times]
    worst = max(np.linalg.norm(fewer.at(t).means - model.at(t).means, axis=1).max() for t in left_out)
    assert 0.5 * worst <= fewer.error <= worst
    assert worst > 10 * TOLERANCE.mean


def test_where_float16_is_too_coarse_means_are_float32() -> None:
    def travel(raw: RawGaussians, time: float) -> RawGaussians:
        return replace(raw, means=raw.means + np.float32(311.7 * time))

    coarse = baked(model_of(travel), TIMES, Tolerance(mean=1.0))
    fine = baked(model_of(travel), TIMES, TOLERANCE)
    assert (coarse.offsets[PLACE].dtype, fine.offsets[PLACE].dtype) == (np.float16, np.float32)
    assert np.abs(fine.at(0.95).means - model_of(travel).at(0.95).means).max() <= TOLERANCE.mean


def test_baking_goes_on_where_it_was_left() -> None:
    model = model_of(swing)
    baker = Baker(model, TIMES, TOLERANCE)
    steps = 1
    while not baker.advance(0.0):
        steps += 1
        assert 0 < baker.progress < 1
    assert steps == len(TIMES)
    whole, parts = baked(model, TIMES, TOLERANCE), baker.keyframes()
    for texel, offsets in whole.offsets.items():
        np.testing.assert_array_equal(offsets, parts.offsets[texel])


@pytest.mark.gl
def test_a_value_that_ceases_to_be_finite_is_refused(ctx: moderngl.Context) -> None:
    splats = random_splats(10, CAMERA, 1)
    offsets = np.zeros((2, 1, 4), np.float16)
    offsets[1, 0, 2] = np.nan
    keyframes = Keyframes(splats, np.array([0.0, 1.0]), np.array([3]), {PLACE: offsets})
    view = SplatView(ctx)
    with pytest.raises(ValueError, match="finite at every keyframe"):
        view.upload_keyframes(keyframes)
    view.release()
