"""The CPU rasteriser in a graph of torch: what is changed between its passes, and what is asked of it."""

from __future__ import annotations

import math
from typing import Any

import pytest

torch = pytest.importorskip("torch")

from renderer.camera import Camera  # noqa: E402
from renderer.rasterize import rasterize  # noqa: E402
from renderer.rasterize.cpu import render  # noqa: E402
from renderer.splats import Splats  # noqa: E402

CAMERA = Camera.from_fov(60, 64, 48)


def splats() -> list[Any]:
    return [
        torch.tensor([[0.3, 0.0, 5.0]]),
        torch.tensor([[1.0, 0.0, 0.0, 0.0]]),
        torch.full((1, 3), 0.3),
        torch.tensor([0.9]),
        torch.tensor([[0.8, 0.2, 0.2]]),
    ]


@pytest.mark.parametrize("place", range(5))
def test_what_is_changed_in_place_before_the_backward_pass_is_told(place: int) -> None:
    given = splats()
    given[place].requires_grad_()
    picture = rasterize(*given, CAMERA, backend="cpu")
    with torch.no_grad():
        given[place].mul_(1.1)
    with pytest.raises(RuntimeError, match="modified by an inplace operation"):
        picture.image[:, :32].sum().backward()


def test_gradients_are_of_what_was_drawn() -> None:
    found = []
    for backend in ("cpu", "reference"):
        given = splats()
        given[0].requires_grad_()
        picture = rasterize(*given, CAMERA, backend=backend)  # type: ignore[arg-type]
        picture.image[:, :32].sum().backward()
        assert given[0].grad is not None
        found.append(given[0].grad)
    assert torch.allclose(*found, rtol=1e-3, atol=1e-3)


@pytest.mark.parametrize("backend", ["cpu", "reference", "auto"])
@pytest.mark.parametrize(
    ("asked", "said"),
    [
        ({"near": -1.0}, r"near must be > 0, got -1.0"),
        ({"near": 0.0}, r"near must be > 0, got 0.0"),
        ({"near": math.nan}, r"near must be > 0, got nan"),
        ({"mode": "Mip"}, r"mode must be default or mip, got 'Mip'"),
    ],
)
def test_nothing_is_drawn_from_behind_the_camera_or_in_an_unknown_way(
    asked: dict[str, Any], said: str, backend: Any
) -> None:
    with pytest.raises(ValueError, match=said):
        rasterize(*splats(), CAMERA, backend=backend, **asked)
    arrays = Splats(*(value.numpy() for value in splats()))
    with pytest.raises(ValueError, match=said):
        render(arrays, CAMERA, **asked)


def test_gradients_have_none_of_their_own() -> None:
    """Rather than a penalty on them that is without effect."""
    given = splats()
    given[0].requires_grad_()
    drawn = rasterize(*given, CAMERA, backend="cpu")
    with pytest.raises(RuntimeError, match="can be differentiated twice"):
        torch.autograd.grad(drawn.image[:, :32].sum(), given[0], create_graph=True)


@pytest.mark.parametrize("backend", ["cpu", "reference"])
def test_shapes_that_do_not_agree_are_refused(backend: Any) -> None:
    for place, value in enumerate(splats()):
        given = splats()
        given[place] = torch.cat([value, value])
        with pytest.raises(ValueError, match=r"shape|splats"):
            rasterize(*given, CAMERA, backend=backend)
    with pytest.raises(ValueError, match="background of three numbers"):
        rasterize(*splats(), CAMERA, (0.5,), backend=backend)  # type: ignore[arg-type, call-arg]
