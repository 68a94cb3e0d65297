"""The rasteriser for cards against the float64 reference: on a card, and as gsplat states it on a processor.

Where opacities stay below the caps of both the two agree to rounding; what differs is said in the module.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import torch

from renderer.camera import Camera
from renderer.rasterize import rasterize
from renderer.rasterize.cuda import Drawn, rasterize_cuda
from renderer.rasterize.reference import Rendered
from renderer.raw_gaussians import FIELDS
from renderer.splats import RenderMode, Splats
from renderer.torch_train.card import trouble
from renderer.torch_train.gradient_backend import TorchBackend
from renderer.train.events import Evaluated
from renderer.train.gradient_backend import CpuBackend
from renderer.train.losses import LossWeights
from renderer.train.training import train
from tests.renderer import gsplat_on_cpu
from tests.renderer.scenes import random_splats, turned_camera
from tests.renderer.sheet import SMALL, moving_sheet
from tests.renderer.test_densify import blobs
from tests.renderer.test_torch_train import before, losses, noisy_frame

BACKGROUND = (0.2, 0.5, 0.1)
PARTS = ("image", "alpha", "depth")


@pytest.fixture(params=["cpu", pytest.param("cuda", marks=pytest.mark.cuda)])
def device(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> str:
    if request.param == "cpu":
        gsplat_on_cpu.install(monkeypatch)
    elif not torch.cuda.is_available():
        pytest.skip("no NVIDIA GPU with CUDA here")
    else:
        pytest.importorskip("gsplat", reason=gsplat_on_cpu.INSTALL)
    return str(request.param)


def leaves(splats: Splats, device: str) -> list[torch.Tensor]:
    values = (splats.means, splats.quats, splats.scales, splats.opacities, splats.colors)
    return [torch.tensor(value, device=device, requires_grad=True) for value in values]


def drawn(
    splats: Splats, camera: Camera, device: str, near: float = 0.01, mode: RenderMode = "default"
) -> Drawn:
    values = leaves(splats, device)
    return rasterize_cuda(*values, camera, BACKGROUND, near=near, mode=mode)  # type: ignore[misc]


def reference(splats: Splats, camera: Camera, near: float = 0.01, mode: RenderMode = "default") -> Rendered:
    values = leaves(splats, "cpu")
    return rasterize(*values, camera, BACKGROUND, backend="reference", near=near, mode=mode)  # type: ignore[misc]


def apart(got: Rendered, expected: Rendered) -> dict[str, float]:
    """Largest difference of each part."""
    return {
        name: (getattr(got, name).cpu().double() - getattr(expected, name)).abs().max().item()
        for name in PARTS
    }


def test_pictures_agree_with_the_reference(device: str) -> None:
    """Off-centre principal point, fx != fy, a turned camera, no whole number of tiles, a background."""
    camera = turned_camera(70, 45)
    splats = random_splats(300, camera)
    difference = apart(drawn(splats, camera, device).picture, reference(splats, camera))
    assert difference["image"] < 3e-5
    assert difference["alpha"] < 3e-5
    assert difference["depth"] < 3e-3  # of 40 to 120


def test_splats_narrower_than_a_pixel_are_made_up_for(device: str) -> None:
    camera = turned_camera(70, 45)
    splats = random_splats(300, camera, sigma=(0.3, 1.0))
    expected = reference(splats, camera, mode="mip")
    assert apart(drawn(splats, camera, device, mode="mip").picture, expected)["image"] < 3e-5
    assert apart(drawn(splats, camera, device).picture, expected)["image"] > 0.05


@pytest.mark.parametrize("mode", ["default", "mip"])
def test_slopes_agree_with_the_reference(device: str, mode: RenderMode) -> None:
    camera = turned_camera(50, 40)
    splats = random_splats(200, camera, seed=3)
    generator = torch.Generator().manual_seed(0)
    weights = [torch.randn(shape, generator=generator) for shape in ((40, 50, 3), (40, 50), (40, 50))]
    weights[2] *= (reference(splats, camera).alpha > 0.5) / 50

    def slopes(backend: str, on: str) -> list[torch.Tensor]:
        values = leaves(splats, on)
        picture = rasterize(*values, camera, backend=backend, mode=mode)  # type: ignore[arg-type, misc]
        parts = (getattr(picture, name) for name in PARTS)
        torch.stack(
            [(part * by.to(on)).sum() for part, by in zip(parts, weights, strict=True)]
        ).sum().backward()
        return [value.grad.cpu() for value in values if value.grad is not None]

    got, expected = slopes("cuda", device), slopes("reference", "cpu")
    assert len(got) == len(expected) == 5
    for one, other in zip(got, expected, strict=True):
        assert (one - other).abs().max() < 1e-4 * other.abs().max()


def test_near_plane_and_the_quaternion_zero(device: str) -> None:
    camera = turned_camera(40, 40)
    splats = random_splats(60, camera, seed=1)
    splats = replace(splats, quats=np.where(np.arange(60)[:, None] % 3 == 0, 0, splats.quats))
    with_all = reference(splats, camera, near=0.01)
    cut = reference(splats, camera, near=70.0)
    assert apart(with_all, cut)["image"] > 0.1
    assert apart(drawn(splats, camera, device, near=70.0).picture, cut)["image"] < 3e-5
    assert torch.isfinite(drawn(splats, camera, device).picture.image).all()


def test_what_opaque_stacks_differ_by(device: str) -> None:
    """The caps, and the splat that fills a pixel: two grey levels at most."""
    camera = turned_camera(40, 40)
    splats = random_splats(400, camera, seed=2, sigma=(3.0, 6.0))
    opaque = replace(splats, opacities=np.ones(400, np.float32))
    difference = apart(drawn(opaque, camera, device).picture, reference(opaque, camera))
    assert 1e-4 < difference["image"] < 0.01
    assert 1e-4 < difference["alpha"] < 0.01


def test_an_opacity_above_the_cap_can_fall(device: str) -> None:
    splats = random_splats(1, turned_camera(20, 20), seed=4, sigma=(5.0, 6.0))
    values = leaves(replace(splats, opacities=np.float32([0.999])), device)
    rasterize_cuda(*values, turned_camera(20, 20)).picture.alpha.sum().backward()  # type: ignore[misc]
    assert values[3].grad is not None
    assert values[3].grad.item() > 1


def test_gradients_are_those_of_the_kernels(device: str) -> None:
    """By raw values, and by the centres on screen, which density control lives on."""
    camera = turned_camera(64, 48)
    frame, raw = noisy_frame(camera), before(camera, blobs(150))
    raw.means[:] *= np.linspace(0.95, 1.05, 150, dtype=np.float32)[:, None]
    kernels, card = CpuBackend(), TorchBackend(device)
    expected, got = (
        pictures.loss_and_gradients(raw, frame, LossWeights(depth=0.2), 50.0, every_tile=True)
        for pictures in (kernels, card)
    )
    assert got.measured.loss == pytest.approx(expected.measured.loss, rel=1e-4)
    pairs = [(getattr(got.by, name), getattr(expected.by, name)) for name in FIELDS if name != "harmonics"]
    for one, other in (*pairs, (card.by_centers(), kernels.by_centers())):
        assert np.abs(other).max() > 0
        assert np.linalg.norm(one - other) < 3e-3 * np.linalg.norm(other)


def test_a_run_begins_as_on_the_processor(device: str) -> None:
    expected, _ = losses("vesselsplat", CpuBackend(), steps=10)
    got, _ = losses("vesselsplat", TorchBackend(device), steps=10)
    assert np.allclose(got, expected, rtol=0.02)


@pytest.mark.cuda
@pytest.mark.skipif(not torch.cuda.is_available(), reason="no NVIDIA GPU with CUDA here")
def test_a_run_on_a_card_ends_as_on_the_processor() -> None:
    pytest.importorskip("gsplat", reason=gsplat_on_cpu.INSTALL)
    told = [list(train(moving_sheet(), SMALL, pictures=one)) for one in (None, TorchBackend("cuda"))]
    psnr, other = ([event.psnr for event in each if isinstance(event, Evaluated)][-1] for each in told)
    assert other == pytest.approx(psnr, abs=0.3)


def test_a_trial_drawing_finds_no_trouble(device: str) -> None:
    assert trouble(device) is None
