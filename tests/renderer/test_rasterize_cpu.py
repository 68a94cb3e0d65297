"""The fast rasteriser against the float64 oracle: values, gradients, repeatability, extreme input."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numba
import numpy as np
import pytest
import torch
from torch import Tensor

from renderer.camera import Camera
from renderer.rasterize import rasterize
from renderer.rasterize.cpu import Rasterizer, render
from renderer.rasterize.exp2 import exp2
from renderer.rasterize.reference import rasterize_reference
from renderer.splats import RenderMode, Splats
from tests.renderer.scenes import random_splats, turned_camera

NAMES = ("means", "quats", "scales", "opacities", "colors")


def tensors(splats: Splats, dtype: torch.dtype) -> Any:
    return [torch.tensor(getattr(splats, name), dtype=dtype, requires_grad=True) for name in NAMES]


def four_splats() -> tuple[Splats, Camera]:
    """Four large overlapping splats at clearly different depths, far from every cut-off."""
    camera = Camera(30.0, 32.0, 11.3, 9.6, 24, 20)
    splats = Splats(
        means=np.array([[0.1, 0.2, 8.0], [-0.9, 0.5, 10.0], [0.7, -0.6, 12.0], [0.0, 0.9, 14.0]], np.float32),
        quats=np.array(
            [[1, 0.2, -0.3, 0.1], [0.6, -0.5, 0.4, 0.3], [0.9, 0.1, 0.5, -0.4], [0.3, 0.8, 0.1, 0.2]],
            np.float32,
        ),
        scales=np.array([[4.0, 3.0, 3.5], [5.0, 4.0, 3.2], [6.0, 4.5, 5.0], [7.0, 6.0, 5.0]], np.float32),
        opacities=np.array([0.5, 0.6, 0.4, 0.7], np.float32),
        colors=np.array([[0.9, 0.2, 0.3], [0.1, 0.8, 0.4], [0.3, 0.4, 0.9], [0.7, 0.6, 0.2]], np.float32),
    )
    return splats, camera


def test_exp2_is_accurate_to_float32() -> None:
    call = numba.njit(lambda x: exp2(x))
    x = np.linspace(-9, 3, 20001, dtype=np.float32)
    got = np.array([call(value) for value in x])
    assert np.abs(got / np.exp2(x.astype(np.float64)) - 1).max() < 3e-7


@pytest.mark.parametrize("size", [(64, 48), (50, 37), (15, 70)])
@pytest.mark.parametrize("seed", [0, 1])
def test_picture_agrees_with_the_oracle(size: tuple[int, int], seed: int) -> None:
    camera = turned_camera(*size)
    splats = random_splats(300, camera, seed)
    got = render(splats, camera, (0.2, 0.5, 0.1))
    want = rasterize_reference(*tensors(splats, torch.float64), camera, (0.2, 0.5, 0.1))
    # Single pixels may fall on the other side of the 1/255 cut in float32: 1/255 is the bound there.
    assert np.abs(got.image - want.image.detach().numpy()).mean() < 2e-6
    assert np.abs(got.image - want.image.detach().numpy()).max() < 1.2 / 255
    assert np.abs(got.alpha - want.alpha.detach().numpy()).mean() < 2e-6
    covered = want.alpha.detach().numpy() > 0.05
    assert np.abs(got.depth - want.depth.detach().numpy())[covered].mean() < 2e-3


@pytest.mark.parametrize("length", [1e2, 1e3, 1e4, 1e5])
def test_needles_whose_centres_are_far_outside_agree_with_the_oracle(length: float) -> None:
    """Each goes through the middle of the picture, its centre one standard deviation away, in px."""
    camera = Camera(fx=600.0, fy=600.0, cx=80.0, cy=64.0, width=160, height=128)
    angles = np.linspace(0.1, 3.0, 6)
    along, aside = np.cos(angles), np.sin(angles)
    scale = 60.0 / 600.0  # Of a pixel at this depth.
    splats = Splats(
        np.stack([-length * scale * along, -length * scale * aside, 0 * angles + 60], 1).astype(np.float32),
        np.stack([np.cos(angles / 2), 0 * angles, 0 * angles, np.sin(angles / 2)], 1).astype(np.float32),
        np.tile(np.float32([length * scale, 0.05, 0.05]), (6, 1)),
        np.full(6, 0.8, np.float32),
        np.random.default_rng(0).uniform(0, 1, (6, 3)).astype(np.float32),
    )
    got = render(splats, camera, (0.2, 0.5, 0.1))
    want = rasterize_reference(*tensors(splats, torch.float64), camera, (0.2, 0.5, 0.1))
    apart = np.abs(got.image - want.image.detach().numpy())
    assert (want.alpha > 0.3).any()
    assert apart.max() < 1.2 / 255
    assert apart.mean() < 1e-4


def loss_weights(shape: tuple[int, int]) -> tuple[Tensor, Tensor, Tensor]:
    rng = np.random.default_rng(5)
    by_image, by_alpha, by_depth = (
        rng.normal(size=(*shape, 3)),
        rng.normal(size=shape),
        rng.normal(size=shape) * 0.05,
    )
    return torch.tensor(by_image), torch.tensor(by_alpha), torch.tensor(by_depth)


def thinned(splats: Splats, thinness: float) -> Splats:
    """Every other one a needle: two axes as many times shorter than the third."""
    scales = splats.scales.copy()
    scales[::2, 1:] = scales[::2, :1] / np.float32(thinness)
    return replace(splats, scales=scales)


def gradients_of(
    splats: Splats, camera: Camera, backend: str, mode: RenderMode = "default"
) -> list[np.ndarray]:
    dtype = torch.float64 if backend == "reference" else torch.float32
    inputs = tensors(splats, dtype)
    out = rasterize(*inputs, camera, (0.3, 0.1, 0.6), backend=backend, mode=mode)  # type: ignore[arg-type]
    by_image, by_alpha, by_depth = loss_weights((camera.height, camera.width))
    loss = (out.image * by_image).sum() + (out.alpha * by_alpha).sum() + (out.depth * by_depth).sum()
    loss.backward()
    return [value.grad.double().numpy() for value in inputs if value.grad is not None]


@pytest.mark.parametrize("name", NAMES)
def test_gradients_agree_with_the_oracle_on_random_scenes(name: str) -> None:
    camera = turned_camera(48, 40)
    splats = random_splats(120, camera, 3)
    got = gradients_of(splats, camera, "cpu")[NAMES.index(name)]
    want = gradients_of(splats, camera, "reference")[NAMES.index(name)]
    scale = np.sqrt((want**2).mean())
    assert np.sqrt(((got - want) ** 2).mean()) < 2e-3 * scale


@pytest.mark.parametrize("sigma", [(0.2, 1.0), (2.0, 4.0)], ids=["narrower than a pixel", "wider"])
@pytest.mark.parametrize("thinness", [1.0, 30.0, 1e4], ids=["round", "needles", "hairs"])
def test_compensated_gradients_agree_with_the_oracle(thinness: float, sigma: tuple[float, float]) -> None:
    camera = turned_camera(48, 40)
    splats = thinned(random_splats(200, camera, 3, sigma=sigma), thinness)
    plain = gradients_of(splats, camera, "reference")
    got, want = (gradients_of(splats, camera, backend, "mip") for backend in ("cpu", "reference"))
    for one, other, without in zip(got, want, plain, strict=True):
        scale = np.sqrt((other**2).mean())
        assert np.sqrt(((one - other) ** 2).mean()) < 1e-3 * scale
        assert np.sqrt(((without - other) ** 2).mean()) > 1e-2 * scale


@pytest.mark.parametrize("thinness", [1.0, 300.0], ids=["round", "hairs"])
@pytest.mark.parametrize("mode", ["default", "mip"])
@pytest.mark.parametrize("name", NAMES)
def test_gradients_are_central_differences(name: str, mode: RenderMode, thinness: float) -> None:
    """Not against another backward pass, but against the float64 picture itself."""
    splats, camera = four_splats()
    splats = thinned(splats, thinness)
    got = gradients_of(splats, camera, "cpu", mode)[NAMES.index(name)]
    weights = loss_weights((camera.height, camera.width))

    def loss(change: np.ndarray) -> float:
        inputs = [value.detach() for value in tensors(splats, torch.float64)]
        inputs[NAMES.index(name)] = inputs[NAMES.index(name)] + torch.tensor(change)
        out = rasterize_reference(*inputs, camera, (0.3, 0.1, 0.6), mode=mode)
        return sum(
            float((a * b).sum()) for a, b in zip((out.image, out.alpha, out.depth), weights, strict=True)
        )

    for index in np.ndindex(got.shape):
        step = np.zeros(got.shape)
        step[index] = 1e-5
        slope = (loss(step) - loss(-step)) / 2e-5
        assert got[index] == pytest.approx(slope, rel=5e-4, abs=2e-3)


def test_gradient_along_the_quaternion_vanishes() -> None:
    splats, camera = four_splats()
    got = gradients_of(splats, camera, "cpu")[1]
    assert np.abs((got * splats.quats).sum(axis=1)).max() < 1e-4 * np.abs(got).max()


def test_depth_gradient_moves_a_splat_along_its_ray() -> None:
    """Peers lose this term: the loss on depth must reach z directly, not only through alpha."""
    splats, camera = four_splats()
    inputs = tensors(splats, torch.float32)
    rasterize(*inputs, camera).depth[9, 11].backward()
    assert inputs[0].grad is not None
    assert inputs[0].grad[:, 2].abs().min() > 0.01


def test_results_repeat_bit_for_bit_whatever_the_threads() -> None:
    camera = turned_camera(80, 64)
    splats = random_splats(500, camera, 7)
    pictures = []
    before = numba.get_num_threads()
    try:
        for threads in (1, before, 1):
            numba.set_num_threads(threads)
            rasterizer = Rasterizer(80, 64)
            rasterizer.forward(splats, camera)
            picture = rasterizer.rendered(80, 64, (0, 0, 0))
            ones = np.ones((64, 80))
            rasterizer.set_adjoint(np.ones((64, 80, 3)), ones, ones, (0, 0, 0))
            gradients = rasterizer.backward(splats)
            pictures.append(picture.image.tobytes() + gradients.means.tobytes() + gradients.quats.tobytes())
    finally:
        numba.set_num_threads(before)
    assert pictures[0] == pictures[1] == pictures[2]


def test_graphs_that_live_at_once_do_not_share_what_they_keep() -> None:
    """Nor does one of another number of splats that went before, or a graph that is gone through twice."""
    camera = turned_camera(80, 64)
    given = [random_splats(count, camera, seed) for count, seed in ((500, 7), (60, 8))]

    def graph(splats: Splats) -> tuple[list[torch.Tensor], torch.Tensor]:
        inputs = [torch.from_numpy(getattr(splats, name).copy()).requires_grad_() for name in NAMES]
        drawn = rasterize(*inputs, camera, backend="cpu")
        return inputs, (drawn.image**2).sum() + drawn.depth.sum() + drawn.alpha.sum()

    def alone(splats: Splats) -> list[torch.Tensor]:
        inputs, loss = graph(splats)
        return list(torch.autograd.grad(loss, inputs))

    wanted = [alone(splats) for splats in given]
    together = [graph(splats) for splats in given]
    for _ in range(2):
        for (inputs, loss), right in zip(together, wanted, strict=True):
            found = torch.autograd.grad(loss, inputs, retain_graph=True)
            assert all(torch.equal(*pair) for pair in zip(found, right, strict=True))


POISON = [np.nan, np.inf, -np.inf, 1e-38, 1e-8, 1e8, 1e38, 0.0, -1.0, 1 / 255]


@pytest.mark.parametrize("value", POISON)
@pytest.mark.parametrize("name", NAMES)
def test_poison_leaves_the_rest_of_the_picture_whole(name: str, value: float) -> None:
    camera = turned_camera(40, 32)
    clean = random_splats(40, camera, 2)
    fields = {field: getattr(clean, field).copy() for field in NAMES}
    fields[name][7] = value
    rasterizer = Rasterizer(40, 32)
    splats = Splats(**fields)
    rasterizer.forward(splats, camera)
    picture = rasterizer.rendered(40, 32, (0, 0, 0))
    assert np.isfinite(picture.image).all()
    assert np.isfinite(picture.depth).all()
    ones = np.ones((32, 40))
    rasterizer.set_adjoint(np.ones((32, 40, 3)), ones, ones, (0, 0, 0))
    gradients = rasterizer.backward(splats)
    others = np.arange(40) != 7
    for field in NAMES:
        assert np.isfinite(getattr(gradients, field)[others]).all(), field


def test_tiles_that_are_not_wanted_stay_empty() -> None:
    camera = turned_camera(64, 64)
    splats = random_splats(300, camera, 1)
    wanted = np.zeros((4, 4), bool)
    wanted[1, 2] = True
    rasterizer = Rasterizer(64, 64)
    few = rasterizer.forward(splats, camera, tile_wanted=wanted)
    picture = rasterizer.rendered(64, 64, (0, 0, 0)).image
    whole = render(splats, camera).image
    assert np.array_equal(picture[16:32, 32:48], whole[16:32, 32:48])
    picture[16:32, 32:48] = 0
    assert not picture.any()
    assert 0 < few < rasterizer.forward(splats, camera)


def test_nothing_to_draw_gives_the_background() -> None:
    camera = Camera(20, 20, 8, 8, 17, 16)
    empty = Splats(*(np.zeros((0, *tail), np.float32) for tail in ((3,), (4,), (3,), (), (3,))))
    picture = render(empty, camera, (0.25, 0.5, 1.0))
    assert (picture.image == np.array([0.25, 0.5, 1.0], np.float32)).all()
    assert not picture.alpha.any()
    assert not picture.depth.any()
