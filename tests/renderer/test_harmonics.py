"""Spherical harmonics against their definition, and through the rasteriser against automatic derivatives."""

from __future__ import annotations

from math import factorial

import numpy as np
import pytest
import torch
from numpy.typing import NDArray

from renderer.harmonics import BANDS, add_harmonics, harmonics_backward, seen_colors
from renderer.rasterize.cpu import Rasterizer, render
from renderer.rasterize.reference import rasterize_reference
from renderer.splats import Splats
from tests.renderer.scenes import random_splats, turned_camera

FloatArray = NDArray[np.float64]
ORIGIN = np.zeros(3)


def legendre(l: int, m: int, x: FloatArray) -> FloatArray:  # noqa: E741
    """Associated Legendre function P_l^m with the Condon-Shortley phase, by Rodrigues' formula."""
    power = np.polynomial.Polynomial([-1, 0, 1]) ** l / (2**l * factorial(l))
    return np.asarray((-1) ** m * (1 - x**2) ** (m / 2) * power.deriv(l + m)(x))


def literal(directions: FloatArray, count: int) -> FloatArray:
    """(N, 3) unit vectors to the values (N, B) of the real harmonics, in float64 from their definition."""
    x, y, z = directions.T
    azimuth = np.arctan2(y, x)
    columns = []
    for l in range(1, 4):  # noqa: E741
        for m in range(-l, l + 1):
            k = abs(m)
            norm = np.sqrt((2 * l + 1) / (4 * np.pi) * factorial(l - k) / factorial(l + k))
            wave = np.cos(k * azimuth) if m >= 0 else np.sin(k * azimuth)
            columns.append((np.sqrt(2) if m else 1) * norm * legendre(l, k, z) * wave)
    return np.stack(columns[:count], axis=1)


def values(directions: FloatArray, count: int = 15) -> FloatArray:
    """The kernel's functions, one splat and one function at a time, read from its colours."""
    means, columns = directions.astype(np.float32), []
    for band in range(count):
        harmonics = np.zeros((len(means), count, 3), np.float32)
        harmonics[:, band] = 1
        columns.append(seen_colors(means, harmonics, np.zeros_like(means), ORIGIN)[:, 1])
    return np.stack(columns, axis=1).astype(np.float64)


def sphere() -> tuple[FloatArray, FloatArray]:
    """Directions and weights that integrate polynomials up to degree 9 over the sphere exactly."""
    heights, weights = np.polynomial.legendre.leggauss(6)
    turns = (np.arange(12) + 0.5) * (2 * np.pi / 12)
    z, turn = (grid.ravel() for grid in np.meshgrid(heights, turns, indexing="ij"))
    radius = np.sqrt(1 - z**2)
    return np.stack([radius * np.cos(turn), radius * np.sin(turn), z], 1), np.repeat(weights, 12) * (
        np.pi / 6
    )


def random_directions(count: int, seed: int) -> FloatArray:
    vectors = np.random.default_rng(seed).normal(size=(count, 3))
    return np.asarray(vectors / np.linalg.norm(vectors, axis=1, keepdims=True))


def turned_splats(seed: int, bands: int, count: int = 120) -> Splats:
    camera = turned_camera(48, 40)
    plain = random_splats(count, camera, seed)
    harmonics = np.random.default_rng(seed).normal(scale=0.3, size=(count, bands, 3)).astype(np.float32)
    return Splats(plain.means, plain.quats, plain.scales, plain.opacities, plain.colors, harmonics)


@pytest.mark.parametrize("bands", BANDS[1:])
def test_the_functions_are_the_real_spherical_harmonics(bands: int) -> None:
    directions = random_directions(400, 1)
    np.testing.assert_allclose(values(directions, bands), literal(directions, bands), atol=2e-6)


def test_the_order_and_the_signs_are_those_of_splat_files() -> None:
    """Degree 1 is (-y, z, -x); the first of degrees 2 and 3 are +xy and -y (3 x^2 - y^2)."""
    x, y, z = random_directions(1, 2)[0]
    got = values(np.array([[x, y, z]]))[0]
    np.testing.assert_allclose(got[:3], 0.4886025119029199 * np.array([-y, z, -x]), atol=1e-6)
    assert got[3] == pytest.approx(1.0925484305920792 * x * y, abs=1e-6)
    assert got[8] == pytest.approx(-0.5900435899266435 * y * (3 * x * x - y * y), abs=1e-6)


def test_the_functions_are_orthonormal_on_the_sphere_and_to_the_constant() -> None:
    directions, weights = sphere()
    functions = values(directions)
    np.testing.assert_allclose(functions.T * weights @ functions, np.eye(15), atol=1e-5)
    np.testing.assert_allclose(functions.T @ weights, 0, atol=1e-5)


@pytest.mark.parametrize("band", [slice(0, 3), slice(3, 8), slice(8, 15)])
def test_a_rotation_keeps_the_energy_within_a_degree(band: slice) -> None:
    directions, weights = sphere()
    rotation = turned_camera(4, 4).camera_from_world[:3, :3]
    coefficients = np.random.default_rng(3).normal(size=15)
    turned = values(directions @ rotation)[:, band] @ coefficients[band]
    found = (values(directions).T * weights) @ turned
    assert np.linalg.norm(found[band]) == pytest.approx(np.linalg.norm(coefficients[band]), rel=1e-5)
    assert np.linalg.norm(np.delete(found, range(15)[band])) < 1e-5


def test_only_the_direction_counts_and_it_is_that_from_the_camera() -> None:
    directions, center = random_directions(50, 4), np.array([3.0, -20.0, 7.0])
    harmonics = np.random.default_rng(4).normal(size=(50, 15, 3)).astype(np.float32)
    colors = np.full((50, 3), 0.5, np.float32)
    seen = [
        seen_colors((center + distance * directions).astype(np.float32), harmonics, colors, center)
        for distance in (0.5, 80.0)
    ]
    np.testing.assert_allclose(seen[0], seen[1], atol=1e-4)
    expected = 0.5 + np.einsum("nb,nbc->nc", literal(directions, 15), harmonics)
    np.testing.assert_allclose(seen[1], expected, atol=1e-4)


@pytest.mark.parametrize("bands", BANDS[1:])
def test_the_backward_pass_is_the_slope_of_the_literal_colours(bands: int) -> None:
    rng = np.random.default_rng(5)
    means, center = rng.normal(scale=4, size=(9, 3)), rng.normal(size=3)
    harmonics, by_colors = rng.normal(size=(9, bands, 3)), rng.normal(size=(9, 3))
    seen = np.arange(9) != 4

    def loss(means: FloatArray, harmonics: FloatArray) -> float:
        rays = means - center
        functions = literal(rays / np.linalg.norm(rays, axis=1, keepdims=True), bands)
        return float((np.einsum("nb,nbc->nc", functions, harmonics) * by_colors)[seen].sum())

    arrays = (value.astype(np.float32) for value in (means, harmonics))
    by_harmonics, by_means = np.full((9, bands, 3), np.nan, np.float32), np.ones((9, 3), np.float32)
    harmonics_backward(*arrays, center, seen, by_colors.astype(np.float32), by_harmonics, by_means)  # type: ignore[call-arg]
    assert (by_means[4] == 1).all()
    assert not by_harmonics[4].any()
    for index in np.ndindex(by_means.shape):
        step = np.zeros((9, 3))
        step[index] = 1e-5
        slope = (loss(means + step, harmonics) - loss(means - step, harmonics)) / 2e-5
        assert by_means[index] - 1 == pytest.approx(slope, rel=1e-3, abs=1e-4)
    direction = rng.normal(size=harmonics.shape)
    slope = (loss(means, harmonics + direction) - loss(means, harmonics - direction)) / 2
    assert float((by_harmonics * direction).sum()) == pytest.approx(slope, rel=1e-5)


def test_a_splat_at_the_camera_itself_has_finite_colours_and_slopes() -> None:
    means = np.zeros((1, 3), np.float32)
    harmonics, colors = np.ones((1, 15, 3), np.float32), np.zeros((1, 3), np.float32)
    add_harmonics(means, harmonics, ORIGIN, colors)
    by_harmonics, by_means = np.empty_like(harmonics), np.zeros((1, 3), np.float32)
    harmonics_backward(means, harmonics, ORIGIN, np.ones(1, bool), colors + 1, by_harmonics, by_means)
    for array in (colors, by_harmonics, by_means):
        assert np.isfinite(array).all()


def test_a_picture_shows_what_its_camera_sees() -> None:
    camera, splats = turned_camera(48, 40), turned_splats(6, 15)
    rays = splats.means.astype(np.float64) - camera.position
    functions = literal(rays / np.linalg.norm(rays, axis=1, keepdims=True), 15)
    colors = splats.colors + np.einsum("nb,nbc->nc", functions, splats.harmonics)
    fields = (splats.means, splats.quats, splats.scales, splats.opacities, colors)
    want = rasterize_reference(*(torch.from_numpy(field) for field in fields), camera).image.numpy()  # type: ignore[call-arg]
    got = render(splats, camera).image
    assert np.abs(got - want).mean() < 1e-5
    plain = render(Splats(*fields[:4], splats.colors), camera).image
    assert np.abs(got - plain).mean() > 0.02


def test_gradients_of_a_picture_agree_with_automatic_derivatives() -> None:
    """The literal colours as a function of the means and coefficients, in float64 through the oracle."""
    camera, splats = turned_camera(48, 40), turned_splats(7, 8)
    names = ("means", "quats", "scales", "opacities", "colors", "harmonics")
    tensors = {n: torch.tensor(getattr(splats, n), dtype=torch.float64, requires_grad=True) for n in names}
    rays = tensors["means"] - torch.from_numpy(camera.position)
    x, y, z = (rays / rays.norm(dim=1, keepdim=True)).unbind(1)
    c1, c2 = np.sqrt(3 / (4 * np.pi)), np.sqrt(15 / (4 * np.pi))
    second = [c2 * x * y, -c2 * y * z, c2 / 12**0.5 * (3 * z * z - 1), -c2 * x * z, c2 / 2 * (x * x - y * y)]
    functions = torch.stack([-c1 * y, c1 * z, -c1 * x, *second], dim=1)
    colors = tensors["colors"] + torch.einsum("nb,nbc->nc", functions, tensors["harmonics"])
    by_image = np.random.default_rng(8).normal(size=(40, 48, 3))
    picture = rasterize_reference(*(tensors[n] for n in names[:4]), colors, camera)  # type: ignore[call-arg]
    (picture.image * torch.from_numpy(by_image)).sum().backward()

    rasterizer = Rasterizer(48, 40)
    rasterizer.forward(splats, camera)
    nothing = np.zeros((40, 48))
    rasterizer.set_adjoint(by_image, nothing, nothing, (0, 0, 0))
    got = rasterizer.backward(splats)
    for name in names:
        grad = tensors[name].grad
        assert grad is not None
        error = np.sqrt(((getattr(got, name) - grad.numpy()) ** 2).mean())
        assert error < 2e-3 * np.sqrt((grad.numpy() ** 2).mean()), name


def test_splats_without_harmonics_look_the_same_from_everywhere() -> None:
    splats = turned_splats(9, 0)
    assert splats.seen_from(ORIGIN) is splats
    assert splats.harmonics.shape == (len(splats), 0, 3)


@pytest.mark.parametrize("shape", [(120, 4, 3), (119, 3, 3), (120, 3, 2)])
def test_harmonics_of_another_shape_are_refused(shape: tuple[int, ...]) -> None:
    splats = turned_splats(10, 0)
    with pytest.raises(ValueError, match=r"Splats\.harmonics"):
        Splats(
            splats.means, splats.quats, splats.scales, splats.opacities, splats.colors,
            np.zeros(shape, np.float32),
        )  # fmt: skip
