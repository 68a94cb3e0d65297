"""The oracle against closed forms, invariances and finite differences."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
import torch
from torch import Tensor

from renderer.camera import Camera
from renderer.rasterize.reference import Rendered, blend, project, rasterize_reference, rotations

CAMERA = Camera(fx=40.0, fy=44.0, cx=14.5, cy=9.25, width=32, height=24)
BACKGROUND = (0.1, 0.3, 0.6)
Arguments = tuple[Tensor, Tensor, Tensor, Tensor, Tensor]


def random_splats(seed: int, count: int = 60) -> Arguments:
    """Anisotropic splats around (0, 0, 4), some off the image and some behind the camera."""
    random = torch.Generator().manual_seed(seed)

    def uniform(low: float, high: float, *shape: int) -> Tensor:
        return low + (high - low) * torch.rand(*shape, generator=random, dtype=torch.float64)

    means = uniform(-2.5, 2.5, count, 3) + torch.tensor([0.0, 0.0, 2.0])
    quats = torch.randn(count, 4, generator=random, dtype=torch.float64)
    scales = torch.exp(uniform(math.log(0.02), math.log(0.6), count, 3))
    return means, quats, scales, uniform(0.0, 1.0, count), uniform(0.0, 1.0, count, 3)


def one_splat(mean: tuple[float, float, float], scale: float, opacity: float) -> Arguments:
    return (
        torch.tensor([mean], dtype=torch.float64),
        torch.tensor([[1.0, 0.0, 0.0, 0.0]], dtype=torch.float64),
        torch.full((1, 3), scale, dtype=torch.float64),
        torch.tensor([opacity], dtype=torch.float64),
        torch.tensor([[0.9, 0.5, 0.2]], dtype=torch.float64),
    )


def render(splats: Arguments, camera: Camera = CAMERA, **options: Any) -> Rendered:
    return rasterize_reference(*splats, camera, BACKGROUND, **options)


def assert_same(left: Rendered, right: Rendered, atol: float) -> None:
    torch.testing.assert_close(left.image, right.image, rtol=0, atol=atol)
    torch.testing.assert_close(left.alpha, right.alpha, rtol=0, atol=atol)
    torch.testing.assert_close(left.depth, right.depth, rtol=0, atol=10 * atol)


def test_one_isotropic_splat_has_its_closed_form() -> None:
    x, y, z, scale, opacity = 0.4, -0.3, 5.0, 0.5, 0.7
    seen = render(one_splat((x, y, z), scale, opacity))
    jacobian = np.array([[40 / z, 0, -40 * x / z**2], [0, 44 / z, -44 * y / z**2]])
    conic = np.linalg.inv(scale**2 * jacobian @ jacobian.T + 0.3 * np.eye(2))
    center = np.array([40 * x / z + 14.5, 44 * y / z + 9.25])
    for row, column in np.ndindex(24, 32):
        offset = np.array([column + 0.5, row + 0.5]) - center
        alpha = opacity * math.exp(-0.5 * offset @ conic @ offset)
        alpha = alpha if alpha >= 1 / 255 else 0.0
        expected = alpha * np.array([0.9, 0.5, 0.2]) + (1 - alpha) * np.array(BACKGROUND)
        np.testing.assert_allclose(seen.image[row, column], expected, rtol=0, atol=1e-12)
        assert seen.alpha[row, column].item() == pytest.approx(alpha, abs=1e-12)
        assert seen.depth[row, column].item() == pytest.approx(z if alpha else 0.0, abs=1e-12)


def test_a_literal_point_falls_on_its_literal_pixel() -> None:
    """x = (20.5 - 14.5) / 40 * 2 and y = (7.5 - 9.25) / 44 * 2 is the centre of column 20, row 7."""
    seen = render(one_splat((0.3, -1.75 / 22, 2.0), 1e-8, 0.8)).alpha
    assert divmod(int(seen.argmax()), CAMERA.width) == (7, 20)
    assert seen[7, 20].item() == pytest.approx(0.8, abs=1e-9)
    neighbours = [seen[7, 19], seen[7, 21], seen[6, 20], seen[8, 20]]
    torch.testing.assert_close(torch.stack(neighbours), torch.full((4,), 0.8 * math.exp(-0.5 / 0.3)).double())


def test_the_principal_point_shifts_the_picture() -> None:
    wide = Camera(fx=40.0, fy=44.0, cx=16.0, cy=12.0, width=32, height=24)
    shifted = Camera(fx=40.0, fy=44.0, cx=13.0, cy=14.0, width=32, height=24)
    splats = one_splat((0.05, 0.02, 3.0), 0.1, 0.9)
    straight, moved = render(splats, wide).image, render(splats, shifted).image
    torch.testing.assert_close(moved[2:, :-3], straight[:-2, 3:], rtol=0, atol=1e-12)
    assert straight.std() > 0.01


def literally(splats: Arguments, camera: Camera) -> Rendered:
    """Every pixel looks at every splat."""
    means, quats, scales, opacities, colors = splats
    projected = project(means, quats, scales, camera)
    rows, columns = (torch.arange(side) + 0.5 for side in (camera.height, camera.width))
    front = projected.indices
    background = torch.tensor(BACKGROUND, dtype=torch.float64)
    return blend(projected, opacities[front], colors[front], rows, columns, background)


def needles(seed: int) -> Arguments:
    """A thousand times as long as thick, at every angle, with opacities on both sides of the cut-off."""
    means, quats, scales, _, colors = random_splats(seed, 300)
    scales[:, 0] *= 30
    scales[:, 1:] *= 0.03
    random = torch.Generator().manual_seed(seed)
    return means, quats, scales, torch.rand(300, generator=random, dtype=torch.float64) ** 6, colors


@pytest.mark.parametrize("splats", [random_splats(10, 300), needles(11)])
def test_windows_show_what_every_pixel_sees_of_every_splat(splats: Arguments) -> None:
    """Values and gradients; the picture takes a hundred windows."""
    camera = Camera(fx=140.0, fy=150.0, cx=61.5, cy=40.25, width=128, height=96)
    slope = torch.linspace(-1, 1, 96 * 128 * 3, dtype=torch.float64).reshape(96, 128, 3)
    m, q, s, o, c = (value.clone().requires_grad_() for value in splats)
    whole, windows = literally((m, q, s, o, c), camera), render((m, q, s, o, c), camera)
    assert_same(whole, windows, atol=1e-12)
    assert whole.alpha.mean() > 0.1
    wanted, got = (
        torch.autograd.grad((seen.image * slope).sum() + seen.depth.sum(), (m, q, s, o, c))
        for seen in (whole, windows)
    )
    for one, other in zip(wanted, got, strict=True):
        torch.testing.assert_close(other, one, rtol=1e-9, atol=1e-9 * float(one.abs().max()))


def test_a_broken_splat_is_seen_wherever_the_literal_reading_sees_it() -> None:
    splats = random_splats(12, 300)
    splats[2][5] = math.nan
    camera = Camera(fx=140.0, fy=150.0, cx=61.5, cy=40.25, width=128, height=96)
    whole, windows = literally(splats, camera).image, render(splats, camera).image
    torch.testing.assert_close(windows, whole, rtol=0, atol=1e-12, equal_nan=True)


@pytest.mark.parametrize("seed", range(3))
def test_the_order_of_the_input_does_not_matter(seed: int) -> None:
    splats = random_splats(seed)
    shuffle = torch.randperm(len(splats[0]), generator=torch.Generator().manual_seed(seed))
    means, quats, scales, opacities, colors = (value[shuffle] for value in splats)
    assert_same(render(splats), render((means, quats, scales, opacities, colors)), atol=1e-12)


def test_equal_depths_are_blended_by_row() -> None:
    first, second = one_splat((0.0, 0.0, 3.0), 0.4, 0.9), one_splat((0.0, 0.0, 3.0), 0.4, 0.9)
    second[4][:] = torch.tensor([0.0, 0.0, 1.0])
    means, quats, scales, opacities, colors = (torch.cat(pair) for pair in zip(first, second, strict=True))
    middle = render((means, quats, scales, opacities, colors)).image[9, 14]
    assert middle[0] > middle[2]


def test_a_splat_of_no_opacity_has_no_effect() -> None:
    splats = random_splats(4)
    means, quats, scales, opacities, colors = splats
    opacities = opacities.clone()
    opacities[::2] = 0.0
    kept = (means[1::2], quats[1::2], scales[1::2], opacities[1::2], colors[1::2])
    assert_same(render((means, quats, scales, opacities, colors)), render(kept), atol=1e-12)


def test_the_background_enters_linearly_behind_the_splats() -> None:
    splats = random_splats(5)
    dark = rasterize_reference(*splats, CAMERA, (0.0, 0.0, 0.0))
    light = rasterize_reference(*splats, CAMERA, torch.tensor([0.5, 1.0, 2.0]))
    difference = (1 - dark.alpha)[..., None] * torch.tensor([0.5, 1.0, 2.0], dtype=torch.float64)
    torch.testing.assert_close(light.image - dark.image, difference, rtol=0, atol=1e-12)


@pytest.mark.parametrize("factor", [-1.0, 2.0, 1e-30])
def test_the_length_and_sign_of_a_quaternion_mean_nothing(factor: float) -> None:
    means, quats, scales, opacities, colors = random_splats(6)
    scaled = (means, factor * quats, scales, opacities, colors)
    assert_same(render((means, quats, scales, opacities, colors)), render(scaled), atol=1e-12)


def test_the_zero_quaternion_is_no_rotation_and_has_no_gradient() -> None:
    quats = torch.zeros(1, 4, dtype=torch.float64, requires_grad=True)
    matrix = rotations(quats)
    matrix.sum().backward()  # type: ignore[no-untyped-call]
    assert torch.equal(matrix.detach()[0], torch.eye(3, dtype=torch.float64))
    assert quats.grad is not None
    assert torch.equal(quats.grad, torch.zeros(1, 4, dtype=torch.float64))


def test_a_quarter_turn_about_z_takes_x_to_y() -> None:
    half = math.sqrt(0.5)
    turned = rotations(torch.tensor([[half, 0.0, 0.0, half]])) @ torch.tensor([1.0, 0.0, 0.0])
    torch.testing.assert_close(turned, torch.tensor([[0.0, 1.0, 0.0]]))


def test_moving_world_and_camera_together_changes_nothing() -> None:
    means, quats, scales, opacities, colors = random_splats(7)
    turn = torch.tensor([0.8, 0.3, -0.4, 0.2], dtype=torch.float64)
    shift = torch.tensor([3.0, -1.0, 2.0], dtype=torch.float64)
    matrix = rotations(turn[None])[0]
    w, xyz, v, u = turn[0], turn[1:], quats[:, 0, None], quats[:, 1:]
    vector = w * u + v * xyz + torch.linalg.cross(xyz.expand_as(u), u)
    product = torch.cat([w * v - (u @ xyz)[:, None], vector], dim=1)  # Hamilton product turn * quats
    world_from_moved = np.eye(4)
    world_from_moved[:3, :3] = matrix.T.numpy()
    world_from_moved[:3, 3] = (-matrix.T @ shift).numpy()
    camera = CAMERA.moved(CAMERA.camera_from_world @ world_from_moved)
    moved = (means @ matrix.T + shift, product, scales, opacities, colors)
    assert_same(render((means, quats, scales, opacities, colors)), render(moved, camera), atol=1e-10)


def test_only_splats_beyond_the_near_plane_are_seen() -> None:
    splats = one_splat((0.0, 0.0, 2.0), 0.3, 0.9)
    assert render(splats, near=2.0).alpha.max() == 0
    assert render(splats, near=1.999).alpha.max() > 0.5
    assert render(one_splat((0.0, 0.0, -2.0), 0.3, 0.9)).alpha.max() == 0


def test_no_splats_show_the_background() -> None:
    means, quats, scales, opacities, colors = (value[:0] for value in random_splats(0))
    seen = render((means, quats, scales, opacities, colors))
    torch.testing.assert_close(seen.image, torch.tensor(BACKGROUND).double().expand(24, 32, 3))
    assert seen.alpha.max() == 0
    assert seen.depth.max() == 0


def test_a_pixel_stops_once_its_transmittance_is_below_the_limit() -> None:
    """Alpha 0.99 three times leaves 1e-2, 1e-4 and then less: only three of five are blended."""
    layers = [one_splat((0.0, 0.0, 2.0 + layer), 50.0, 1.0) for layer in range(5)]
    means, quats, scales, opacities, colors = (torch.cat(parts) for parts in zip(*layers, strict=True))
    alpha = render((means, quats, scales, opacities, colors)).alpha[9, 14].item()
    transmittance, blended = 1.0, 0
    while transmittance >= 1e-4:
        transmittance *= 1 - 0.99
        blended += 1
    assert blended < len(layers)
    assert 1 - alpha == pytest.approx(0.01**blended, rel=1e-6)


def test_the_jacobian_follows_the_mean_no_further_than_the_guard_band() -> None:
    """Beyond the band the covariance is that of the ray at the band's edge, measured off centre."""
    edge = (CAMERA.width - CAMERA.cx) / CAMERA.fx + 0.3 * 0.5 * CAMERA.width / CAMERA.fx
    inside, outside = 0.999 * edge, 3.0 * edge
    _, quats, scales, _, _ = one_splat((0.0, 0.0, 1.0), 0.3, 1.0)
    means = [torch.tensor([[slope, 0.0, 1.0]]) for slope in (inside, edge, outside)]
    seen = [project(mean, quats, scales, CAMERA) for mean in means]
    torch.testing.assert_close(seen[1].covariances, seen[2].covariances, rtol=1e-6, atol=0)
    assert not torch.allclose(seen[0].covariances, seen[1].covariances, rtol=1e-6)
    assert seen[2].centers[0, 0].item() == pytest.approx(40 * outside + 14.5, rel=1e-6)


@pytest.mark.parametrize("scale", [(1e-8, 1e-8, 1e-8), (1e8, 1e8, 1e8), (1e8, 1e-8, 1e-8), (1e3, 1.0, 1e-3)])
def test_extreme_scales_stay_finite_and_positive_definite(scale: tuple[float, float, float]) -> None:
    means, quats, _, opacities, colors = random_splats(8)
    scales = torch.tensor(scale).expand(len(means), 3).double().requires_grad_()
    seen = render((means, quats, scales, opacities, colors))
    seen.image.sum().backward()  # type: ignore[no-untyped-call]
    assert scales.grad is not None
    assert all(value.isfinite().all() for value in (seen.image, seen.depth, scales.grad))
    assert 0 <= seen.alpha.min() <= seen.alpha.max() <= 1
    assert (project(means, quats, scales, CAMERA).determinants >= 0.09).all()


def test_the_determinant_is_that_of_the_covariance() -> None:
    means, quats, scales, _, _ = random_splats(9)
    projected = project(means, quats, scales, CAMERA)
    torch.testing.assert_close(
        projected.determinants, torch.linalg.det(projected.covariances), rtol=1e-9, atol=0
    )


def test_gradients_agree_with_finite_differences() -> None:
    """Four overlapping splats wide enough that no pixel sits on a cut-off, alpha between 0.03 and 0.8."""
    splats = (
        torch.tensor([[-0.1, 0.05, 2.0], [0.12, -0.04, 2.5], [0.03, 0.1, 3.1], [-0.06, -0.1, 3.7]]),
        torch.tensor(
            [[1.0, 0.1, 0.2, -0.3], [0.4, -0.7, 0.2, 0.5], [-0.3, 0.1, 0.9, 0.2], [0.5, 0.5, -0.5, 0.4]]
        ),
        torch.tensor([[0.8, 0.9, 0.7], [0.7, 1.0, 0.8], [1.1, 0.9, 0.9], [1.2, 1.0, 1.3]]),
        torch.tensor([0.6, 0.8, 0.5, 0.7]),
        torch.tensor([[0.9, 0.2, 0.1], [0.1, 0.8, 0.3], [0.2, 0.3, 0.9], [0.7, 0.6, 0.1]]),
    )
    inputs = tuple(value.double().requires_grad_() for value in splats)
    camera = Camera(fx=9.0, fy=8.0, cx=4.3, cy=2.8, width=8, height=6)

    def picture(m: Tensor, q: Tensor, s: Tensor, o: Tensor, c: Tensor) -> tuple[Tensor, Tensor, Tensor]:
        seen = rasterize_reference(m, q, s, o, c, camera, BACKGROUND)
        return seen.image, seen.alpha, seen.depth

    assert torch.autograd.gradcheck(picture, inputs, eps=1e-6, atol=1e-7, rtol=1e-5)
