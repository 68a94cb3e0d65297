"""Tools found by a network of the user's: what it is given, and how its scores are read."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from renderer.clip import BoolImage, ByteImage
from renderer.tools import onnx_model
from renderer.tools.onnx_model import OnnxError, OnnxTools
from tests.renderer.tools.onnx_files import write_convolution

pytest.importorskip("onnxruntime")
BLUE = np.array([[0, 0, 0], [-1, 0, 1]], np.float32)
"""Nothing, and how much bluer than red a pixel is."""
ALL = np.ones((96, 128), bool)


def image() -> tuple[ByteImage, BoolImage]:
    """Red, with a blue square."""
    made, tool = np.full((96, 128, 3), (180, 90, 80), np.uint8), np.zeros((96, 128), bool)
    tool[32:64, 32:96] = True
    made[tool] = (60, 90, 200)
    return made, tool


@pytest.mark.parametrize("size", [("h", "w"), (96, 128), (48, 64)])
def test_a_class_of_a_network_is_the_tool(size: tuple[int, int], tmp_path: Path) -> None:
    made, tool = image()
    path = write_convolution(tmp_path / "net.onnx", BLUE, np.zeros(2, np.float32), size)
    np.testing.assert_array_equal(OnnxTools.open(path, "unit").find(made, ALL), tool)
    np.testing.assert_array_equal(OnnxTools.open(path, "unit", [0]).find(made, ALL), ~tool)
    assert not OnnxTools.open(path, "unit").find(made, ~ALL).any()


def test_values_are_given_as_asked(tmp_path: Path) -> None:
    made, tool = image()
    # Set where blue, as it is given, is above a threshold between the square's and the ground's.
    for values, threshold in (("bytes", 140.0), ("unit", 0.55), ("imagenet", (0.55 - 0.406) / 0.225)):
        weights, bias = np.array([[0, 0, 1]], np.float32), np.array([-threshold], np.float32)
        path = write_convolution(tmp_path / "one.onnx", weights, bias)
        np.testing.assert_array_equal(OnnxTools.open(path, values).find(made, ALL), tool)  # type: ignore[arg-type]


def test_probabilities_of_one_class_are_halved(tmp_path: Path) -> None:
    made, tool = image()
    weights = np.array([[0, 0, 1]], np.float32)
    path = write_convolution(tmp_path / "one.onnx", weights, np.zeros(1, np.float32))
    np.testing.assert_array_equal(OnnxTools.open(path, "unit").find(made, ALL), tool)


def test_what_is_no_network_of_images_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(OnnxError, match="no such file"):
        OnnxTools.open(tmp_path / "none.onnx")
    with pytest.raises(OnnxError, match="got a folder"):
        OnnxTools.open(tmp_path)
    (tmp_path / "text.onnx").write_text("no network")
    with pytest.raises(OnnxError, match=r"cannot be loaded .*text\.onnx"):
        OnnxTools.open(tmp_path / "text.onnx")
    wide = write_convolution(
        tmp_path / "wide.onnx", np.ones((1, 5), np.float32), np.zeros(1, np.float32), channels=5
    )
    with pytest.raises(OnnxError, match=r"takes one RGB image, got one that takes float \[1, 5"):
        OnnxTools.open(wide)
    monkeypatch.setattr(onnx_model, "find_spec", lambda name: None)
    with pytest.raises(OnnxError, match="pip install onnxruntime"):
        OnnxTools.open(wide)


def test_the_network_is_opened_without_telemetry(tmp_path: Path) -> None:
    """Which onnxruntime begins when it is loaded, with a number for the user in the cache."""
    path = write_convolution(tmp_path / "one.onnx", BLUE, np.zeros(2, np.float32))
    home = tmp_path / "home"
    home.mkdir()
    code = (
        f"from pathlib import Path; from {OnnxTools.__module__} import *; OnnxTools.open(Path({str(path)!r}))"
    )
    names = ("HOME", "LOCALAPPDATA", "XDG_CACHE_HOME")
    environment = {name: value for name, value in os.environ.items() if name != "ORT_DISABLE_TELEMETRY"}
    environment |= dict.fromkeys(names, str(home))
    subprocess.run([sys.executable, "-c", code], env=environment, check=True, timeout=120)
    assert list(home.rglob("*onnxruntime*")) == []
