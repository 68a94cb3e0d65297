"""Tools as a segmentation network of the user's finds them: an ONNX file, run on the CPU."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import Any, Final, Literal, get_args

import cv2
import numpy as np
from numpy.typing import NDArray

from renderer.clip import BoolImage, ByteImage

Values = Literal["imagenet", "unit", "bytes"]
"""Of the pixels that a network takes: less ImageNet's mean, by its spread; in [0, 1]; in [0, 255]."""
VALUES: Final[tuple[Values, ...]] = get_args(Values)
NO_ONNX: Final = "expected onnxruntime to run a network (pip install onnxruntime), got none"

_MEAN, _SPREAD = (0.485, 0.456, 0.406), (0.229, 0.224, 0.225)
_LONGEST, _STEP = 640, 32
"""px: the longer side that networks of any size are given, and what sides are whole multiples of."""
_KINDS = {"tensor(float)": np.float32, "tensor(float16)": np.float16, "tensor(uint8)": np.uint8}


class OnnxError(ValueError):
    """A network that cannot be used: what was expected, what came, and where."""


@dataclass(frozen=True, eq=False)
class OnnxTools:
    """Finds tools by a network."""

    path: Path
    values: Values
    tools: tuple[int, ...]
    """Classes that are tools; empty: all but the first, of a network with a single one where it is set."""
    session: Any
    """onnxruntime's."""

    @classmethod
    def open(cls, path: Path, values: Values = "imagenet", tools: Sequence[int] = ()) -> OnnxTools:
        """Raises OnnxError: no onnxruntime, no file, no network in it, or one that takes no RGB image."""
        if find_spec("onnxruntime") is None:
            raise OnnxError(NO_ONNX)
        if not path.is_file():
            came = "a folder" if path.is_dir() else "no such file"
            raise OnnxError(f"expected an ONNX file, got {came}: {path}")
        # Read when it is loaded, which else gives this user a number and keeps what is to be sent.
        os.environ.setdefault("ORT_DISABLE_TELEMETRY", "1")
        import onnxruntime

        options = onnxruntime.SessionOptions()
        options.log_severity_level = 4  # What is wrong is raised.
        onnxruntime.disable_telemetry_events()
        try:
            session = onnxruntime.InferenceSession(path, options, providers=["CPUExecutionProvider"])
        except Exception as error:
            why = str(error).split("\n", 1)[0]
            raise OnnxError(
                f"expected an ONNX network, got a file that cannot be loaded ({why}): {path}"
            ) from error
        made = cls(path, values, tuple(tools), session)
        made._require_image()
        return made

    def find(self, image: ByteImage, seen: BoolImage) -> BoolImage:
        """(H, W), True = tool, of an RGB image (H, W, 3). Raises OnnxError: it fails, or gives no map."""
        given = self.session.get_inputs()[0]
        height, width = self._size(given.shape, image)
        small = cv2.resize(image, (width, height), interpolation=cv2.INTER_AREA)
        prepared = self._prepared(np.asarray(small, dtype=np.uint8), _KINDS[given.type])
        batch = prepared[None] if self._is_last(given.shape) else np.moveaxis(prepared, 2, 0)[None]
        try:
            found = self.session.run(None, {given.name: np.ascontiguousarray(batch)})[0]
        except Exception as error:
            why = str(error).split("\n", 1)[0]
            raise OnnxError(
                f"the network fails on an image of {width}x{height} ({why}): {self.path}"
            ) from error
        tool = self._tools(np.asarray(found), (height, width)).astype(np.uint8)
        large = cv2.resize(tool, (image.shape[1], image.shape[0]), interpolation=cv2.INTER_NEAREST)
        return np.asarray(large > 0) & seen

    def _require_image(self) -> None:
        inputs = self.session.get_inputs()
        kind, shape = inputs[0].type, inputs[0].shape
        if (
            len(inputs) == 1
            and kind in _KINDS
            and len(shape) == 4
            and (shape[1] == 3 or self._is_last(shape))
        ):
            return
        got = ", ".join(f"{each.type[7:-1]} {each.shape}" for each in inputs)
        raise OnnxError(f"expected a network that takes one RGB image, got one that takes {got}: {self.path}")

    @staticmethod
    def _is_last(shape: Sequence[Any]) -> bool:
        """Whether colours are the last axis."""
        return bool(shape[1] != 3 and shape[3] == 3)

    def _size(self, shape: Sequence[Any], image: ByteImage) -> tuple[int, int]:
        """Height and width that the network takes: its own, or near the image's."""
        scale = min(1.0, _LONGEST / max(image.shape[:2]))
        asked = shape[1:3] if self._is_last(shape) else shape[2:4]
        near = (max(_STEP, _STEP * round(side * scale / _STEP)) for side in image.shape[:2])
        height, width = (
            one if isinstance(one, int) else other for one, other in zip(asked, near, strict=True)
        )
        return height, width

    def _prepared(self, small: ByteImage, kind: Any) -> NDArray[Any]:
        if self.values == "bytes" or kind is np.uint8:
            return small.astype(kind)
        unit = small.astype(np.float32) / 255
        if self.values == "imagenet":
            unit = (unit - np.array(_MEAN, np.float32)) / np.array(_SPREAD, np.float32)
        return np.asarray(unit.astype(kind))

    def _tools(self, found: NDArray[Any], size: tuple[int, int]) -> BoolImage:
        """(h, w) of what the network gives: a score a class and pixel, one score, or the class itself."""
        maps = found[0] if found.ndim in (3, 4) and found.shape[0] == 1 else None
        if maps is not None and maps.ndim == 3 and maps.shape[0] == 1:
            maps = maps[0]
        elif maps is not None and maps.ndim == 3 and maps.shape[2] == 1:
            maps = maps[:, :, 0]
        if maps is None or min(maps.shape) < 1:
            raise OnnxError(f"expected a map of the image, got values of {found.shape}: {self.path}")
        if maps.ndim == 3:
            classes = maps.argmax(axis=2 if maps.shape[:2] == size else 0)
        elif np.issubdtype(maps.dtype, np.integer):
            classes = maps
        else:
            # Scores of a single class: probabilities, or their logits, which are of either sign.
            is_probability = maps.min() >= 0 and maps.max() <= 1
            return np.asarray(maps > (0.5 if is_probability else 0))
        return np.asarray(np.isin(classes, self.tools) if self.tools else classes != 0)
