"""Arrays of models and checkpoints that are not what they must be: refused by name, before any kernel."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any, get_args

import numpy as np
import pytest
from numpy.typing import NDArray
from safetensors.numpy import save_file

from renderer.gaussians import DynamicGaussians
from renderer.rasterize.cpu import render
from renderer.stored_arrays import Arrays, write_arrays
from renderer.train.checkpoint import Checkpoint, checkpoint_paths, read_newest_checkpoint, write_checkpoint
from renderer.train.config import Method, TrainConfig
from renderer.train.events import Finished
from renderer.train.needs import Begun, Needs, decide
from renderer.train.trainer import TrainingError, train_window
from renderer.train.training import train
from tests.renderer.plane import plane_clip

Damage = Callable[[NDArray[Any]], NDArray[Any]]
DAMAGES: dict[str, Damage] = {
    "one row more": lambda array: np.concatenate([array, array[-1:]]),
    "one row less": lambda array: array[:-1],
    "another type": lambda array: array.astype(np.float16),
    "another axis": lambda array: array[..., None],
    "wider": lambda array: np.repeat(array, 2, axis=-1) if array.ndim > 1 else np.tile(array, 3),
}
MOMENTS = ("one row more", "another type")
"""Damages of Adam's moments, each of which has its array's shape: one check for all."""
SMALL = TrainConfig(iterations=12, n_gaussians=60, keep=("deformation",), leave_out=("tracks",))
"""A few steps of each method: all that their files hold. A start from tracks is of the same arrays."""
FREE = ("node_controls", "bumps", "time_cells")
"""A model may have as many nodes, bumps and rows in time as it likes; one that trains on may not."""


@pytest.fixture(scope="module", params=get_args(Method))
def run(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> tuple[TrainConfig, Path]:
    config = replace(SMALL, method=request.param)
    if config.method == "static":
        config = replace(config, keep=())
    folder = tmp_path_factory.mktemp(config.method)
    *_, last = train(plane_clip(slide=1.0), config, folder=folder)
    assert isinstance(last, Finished)
    last.model.save(folder / "model.safetensors")
    return config, folder


def arrays_of(path: Path) -> Arrays:
    return {name: value.copy() for name, value in DynamicGaussians.load(path).arrays().items()}


def refused(arrays: Arrays, path: Path, expected: str) -> None:
    save_file({name: np.ascontiguousarray(value) for name, value in arrays.items()}, path)
    with pytest.raises(ValueError, match=expected) as caught:
        DynamicGaussians.load(path)
    assert str(path) in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("damage", DAMAGES)
def test_every_array_of_a_model_has_its_shape_and_type(
    run: tuple[TrainConfig, Path], tmp_path: Path, damage: str
) -> None:
    own = arrays_of(run[1] / "model.safetensors")
    for name, array in own.items():
        if array.size and not (damage.startswith("one row") and name in FREE):
            damaged = own | {name: DAMAGES[damage](array)}
            refused(damaged, tmp_path / "model.safetensors", "expected")


def test_every_array_of_a_model_is_finite_and_there(run: tuple[TrainConfig, Path], tmp_path: Path) -> None:
    own = arrays_of(run[1] / "model.safetensors")
    optional = {"harmonics", "opacity_controls", *last_names()}
    for name, array in own.items():
        if name not in optional:
            left = {other: value for other, value in own.items() if other != name}
            refused(left, tmp_path / "model.safetensors", name)
        if array.size and array.dtype == np.float32:
            for value in (np.nan, np.inf):
                broken = array.copy()
                broken.flat[-1] = value
                refused(own | {name: broken}, tmp_path / "model.safetensors", f"finite values in {name}")


def last_names() -> tuple[str, ...]:
    """By which the kind of motion is known: without it, the model is another, at rest."""
    return "node_weights", "bumps", "time_cells"


def test_indices_and_cells_lie_within_what_they_point_to(
    run: tuple[TrainConfig, Path], tmp_path: Path
) -> None:
    own = arrays_of(run[1] / "model.safetensors")
    worst = {"node_indices": (-1, 10**6, 2**31 - 1), "resolutions": (0, 1, -3, 5000, 2**31 - 1)}
    for name, values in worst.items():
        for value in values:
            if name in own:
                broken = own[name].copy()
                broken.flat[-1] = value
                refused(own | {name: broken}, tmp_path / "model.safetensors", "expected")


def test_every_array_of_a_checkpoint_is_checked_before_training_goes_on(
    run: tuple[TrainConfig, Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    config, folder = run
    checkpoint = read_newest_checkpoint(folder)
    assert checkpoint is not None
    clip = plane_clip(slide=1.0)
    # What each try would find out again of the same frames, and has no part in the check.
    clip, decided = replace(clip, read_frame=cache(clip.read_frame)), dict[Begun | None, Needs]()

    def decide_once(*given: Any, begun: Begun | None, **named: Any) -> Needs:
        if begun not in decided:
            decided[begun] = decide(*given, begun=begun, **named)
        return decided[begun]

    monkeypatch.setattr(sys.modules[train_window.__module__], "decide", decide_once)

    def not_resumed(arrays: Arrays, iteration: int = 6) -> None:
        for path in checkpoint_paths(tmp_path):
            path.unlink()
        write_checkpoint(tmp_path, Checkpoint(iteration, 1.0, checkpoint.fingerprint, arrays))
        with pytest.raises(TrainingError, match="expected"):
            next(iter(train(clip, config, folder=tmp_path, resume=True)))

    for name, array in checkpoint.arrays.items():
        if array.size:
            for kind in MOMENTS if name.startswith(("first.", "second.")) else DAMAGES:
                not_resumed(checkpoint.arrays | {name: DAMAGES[kind](array)})
        if array.size and array.dtype.kind == "f" and name != "loss_watch":
            not_resumed(checkpoint.arrays | {name: np.full_like(array, np.nan)})
        if name.startswith("second.") and array.size:
            not_resumed(checkpoint.arrays | {name: np.full_like(array, -1)})
    not_resumed(dict(checkpoint.arrays), iteration=10**9)


def test_numbers_that_a_file_may_hold_are_drawn_whatever_they_are(run: tuple[TrainConfig, Path]) -> None:
    """Finite is all that is asked for: 1e30 gives no picture of tissue, and no crash."""
    own = arrays_of(run[1] / "model.safetensors")
    camera = plane_clip().cameras[0]
    for name, array in own.items():
        for value in (1e30, -1e30, 3e38, 1e-38, 0.0):
            if array.dtype == np.float32 and array.size:
                changed = array.copy()
                changed[::2] = value
                model = DynamicGaussians.checked(own | {name: changed})
                with np.errstate(all="ignore"):
                    picture = render(model.at(0.5), camera)
                assert picture.image.shape[:2] == (camera.height, camera.width)


@pytest.mark.skipif(os.name == "nt", reason="Windows has no such modes")
def test_others_may_read_what_the_user_lets_them_read(tmp_path: Path) -> None:
    (tmp_path / "usual").touch()
    write_arrays(tmp_path / "a.safetensors", {"x": np.ones(3, np.float32)})
    assert (tmp_path / "a.safetensors").stat().st_mode == (tmp_path / "usual").stat().st_mode
