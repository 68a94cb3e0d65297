"""LPIPS, how different two pictures look to AlexNet: Zhang et al., CVPR 2018. Its weights come from files."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from renderer.clip import BoolImage
from renderer.metrics import AnyFloat, masked

if TYPE_CHECKING:
    from torch import Tensor

WEIGHT_FILES: Final = "alexnet*.pth and alex.pth, or one .safetensors with the arrays of both"
SHIFT: Final = (-0.030, -0.088, -0.188)
SCALE: Final = (0.458, 0.448, 0.450)
EPSILON: Final = 1e-10
LEAST_SIDE: Final = 31
"""Pixels: below, nothing is left to the second pooling."""


class LpipsWeightsError(ValueError):
    """The weights cannot be used: the text says what was expected, what came, and where."""


@dataclass(frozen=True)
class _Layer:
    """One convolution of AlexNet; `pooled` means that the maximum over 3x3, stride 2, comes before it."""

    number: int
    """In torchvision's `features`."""
    shape: tuple[int, int, int, int]
    """Channels out, channels in, rows, columns."""
    stride: int
    padding: int
    pooled: bool


LAYERS: Final = (
    _Layer(0, (64, 3, 11, 11), 4, 2, False),
    _Layer(3, (192, 64, 5, 5), 1, 2, True),
    _Layer(6, (384, 192, 3, 3), 1, 1, True),
    _Layer(8, (256, 384, 3, 3), 1, 1, False),
    _Layer(10, (256, 256, 3, 3), 1, 1, False),
)


@dataclass(frozen=True, eq=False)
class Lpips:
    """The distance, version 0.1 with AlexNet, in float32 on the CPU."""

    kernels: tuple[Tensor, ...]
    biases: tuple[Tensor, ...]
    heads: tuple[Tensor, ...]
    """(1, C, 1, 1) >= 0: what each channel counts."""

    def distance(self, image: AnyFloat, reference: AnyFloat, mask: BoolImage) -> float:
        """0 for equal pictures, larger the more different they look.

        Pictures (H, W, 3) RGB in [0, 1]; mask (H, W), True = counted. Both pictures times the mask, then
        taken to [-1, 1], as the field publishes it. The squared difference of the features, of unit length
        over the channels, weighted, mean over all positions, summed over five layers (Eq 1). NaN for an
        empty mask, and below 31 pixels either way.

        Raises:
            ValueError: shapes that do not agree, or pictures without three channels.
        """
        import torch

        pair = masked(image, reference, mask)
        if pair[0].shape[2] != 3:
            raise ValueError(f"expected images of three channels, got {pair[0].shape}")
        if not mask.any() or min(mask.shape) < LEAST_SIDE:
            return float("nan")
        with torch.inference_mode():
            layers = zip(self.heads, *(self._features(picture) for picture in pair), strict=True)
            return float(sum((head * (x - y) ** 2).sum(dim=1).mean() for head, x, y in layers))

    def _features(self, picture: AnyFloat) -> Iterator[Tensor]:
        """(1, C, h, w) after each of the five ReLUs, of unit length over C."""
        import torch
        from torch.nn.functional import conv2d, max_pool2d

        scaled = (2.0 * picture - 1.0 - np.array(SHIFT)) / np.array(SCALE)
        signal = torch.from_numpy(scaled.astype(np.float32)).permute(2, 0, 1)[None]
        for layer, kernel, bias in zip(LAYERS, self.kernels, self.biases, strict=True):
            signal = max_pool2d(signal, 3, 2) if layer.pooled else signal
            signal = conv2d(signal, kernel, bias, layer.stride, layer.padding).relu()
            yield signal / (signal.square().sum(dim=1, keepdim=True).sqrt() + EPSILON)


def weight_files(folder: Path) -> list[Path]:
    """What could be weights, in the order of names."""
    return sorted(path for path in folder.glob("*") if path.suffix in (".pth", ".safetensors"))


def read_lpips(folder: Path) -> Lpips:
    """Read torchvision's AlexNet (`features.N.weight` and `.bias`) and LPIPS's `lin0` to `lin4`.

    Nothing that a file could run is run: pickled files are read as weights only.

    Raises:
        LpipsWeightsError: files that are missing, ambiguous or damaged; arrays of other names or shapes.
    """
    arrays = {name: value for path in _chosen(folder) for name, value in _arrays(path).items()}

    def taken(name: str, shape: tuple[int, ...]) -> Tensor:
        return _checked(arrays.get(name), name, shape, folder)

    heads = tuple(
        taken(f"lin{index}.model.1.weight", (1, layer.shape[0], 1, 1)) for index, layer in enumerate(LAYERS)
    )
    if any(bool((head < 0).any()) for head in heads):
        raise LpipsWeightsError(f"expected linear weights of 0 or more, got negative ones: {folder}")
    return Lpips(
        kernels=tuple(taken(f"features.{layer.number}.weight", layer.shape) for layer in LAYERS),
        biases=tuple(taken(f"features.{layer.number}.bias", layer.shape[:1]) for layer in LAYERS),
        heads=heads,
    )


def _chosen(folder: Path) -> list[Path]:
    found = weight_files(folder)
    safe = [path for path in found if path.suffix == ".safetensors"]
    network = [path for path in found if path.match("alexnet*.pth")]
    linear = [path for path in found if path.name == "alex.pth"]
    if len(safe) == 1:
        return safe
    if not safe and len(network) == len(linear) == 1:
        return network + linear
    listed = ", ".join(path.name for path in found) or "none"
    raise LpipsWeightsError(f"expected the weights of LPIPS, {WEIGHT_FILES}, got {listed}: {folder}")


def _arrays(path: Path) -> dict[str, Any]:
    import torch
    from safetensors.torch import load_file

    try:
        if path.suffix == ".safetensors":
            return load_file(path)
        stored = torch.load(path, map_location="cpu", weights_only=True)
    except Exception as error:  # A damaged pickle raises nearly anything.
        reason = str(error).partition("\n")[0] or type(error).__name__
        raise LpipsWeightsError(f"expected a file of weights, got {reason}: {path}") from error
    if not isinstance(stored, dict):
        raise LpipsWeightsError(f"expected named arrays, got {type(stored).__name__}: {path}")
    return stored


def _checked(array: Any, name: str, shape: tuple[int, ...], folder: Path) -> Tensor:
    import torch

    if not isinstance(array, torch.Tensor) or tuple(array.shape) != shape:
        came = tuple(array.shape) if isinstance(array, torch.Tensor) else "none"
        raise LpipsWeightsError(f"expected {name} of shape {shape}, got {came}: {folder}")
    if not bool(array.isfinite().all()):
        raise LpipsWeightsError(f"expected finite numbers in {name}: {folder}")
    return array.float()
