"""Matrices that are nearly rotations become rotations, and what is none is refused, with the size of it."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from renderer.phantom import PhantomParams, write_phantom
from renderer.readers.geometry.poses import LARGEST_DEVIATION, nearest_rotations
from renderer.rotations import matrix
from renderer.sources import open_clip
from tests.renderer.small_clip import refusal


def spin(seed: int) -> np.ndarray:
    quaternion = np.random.default_rng(seed).normal(size=4)
    return matrix(quaternion / np.linalg.norm(quaternion))


def test_rotations_stay_bit_for_bit():
    given = np.stack([spin(seed) for seed in range(5)])
    found = nearest_rotations(given, list("abcde"))
    np.testing.assert_array_equal(found.matrices, given)
    assert found.notices == ()
    single = given.astype(np.float32).astype(np.float64)
    assert nearest_rotations(single, list("abcde")).notices == ()


@pytest.mark.parametrize("size", [1e-4, 1e-3, 1e-2])
def test_what_is_nearly_a_rotation_is_mended_to_the_nearest(size):
    rng = np.random.default_rng(3)
    truth = np.stack([spin(seed) for seed in range(4)])
    stretch = np.eye(3) + size * np.diag([1, -0.5, 0.2])
    given = truth.copy()
    given[2] = truth[2] @ stretch
    found = nearest_rotations(given, list("abcd"))
    np.testing.assert_array_equal(found.matrices[[0, 1, 3]], truth[[0, 1, 3]])
    np.testing.assert_allclose(found.matrices[2], truth[2], atol=1e-12)
    (said,) = found.notices
    assert "1 of 4 poses" in said
    assert f"{2 * size:.1g}"[0] in said
    assert " in c" in said
    noisy = truth + size * rng.normal(size=truth.shape) / 4
    near = nearest_rotations(noisy, list("abcd")).matrices
    np.testing.assert_allclose(
        near @ near.transpose(0, 2, 1), np.broadcast_to(np.eye(3), near.shape), atol=1e-12
    )
    assert np.abs(near - truth).max() < 2 * size


@pytest.mark.parametrize(
    ("bad", "said"), [(1.2 * np.eye(3), "expected rotations"), (np.diag([1.0, 1, -1]), "mirror")]
)
def test_what_is_none_is_refused_by_its_name(bad, said):
    with pytest.raises(ValueError, match=rf"{said}.* in two$"):
        nearest_rotations(np.stack([np.eye(3), bad]), ["one", "two"])


@pytest.fixture
def turned(tmp_path: Path) -> dict[str, Path]:
    params = PhantomParams(n_frames=4, width=48, height=32, seed=1, camera="moving")
    for layout in ("endonerf", "scared"):
        write_phantom(tmp_path / layout, params, layout)
    return {"endonerf": tmp_path / "endonerf", "scared": tmp_path / "scared"}


def stretch(clip: Path, by: float) -> None:
    """The third pose, in the file of the layout."""
    if clip.name == "endonerf":
        rows = np.load(clip / "poses_bounds.npy")
        rows[2, :15].reshape(3, 5)[:, :3] *= 1 + by
        np.save(clip / "poses_bounds.npy", rows)
        return
    file = sorted((clip / "data/frame_data").iterdir())[2]
    said = json.loads(file.read_text())
    pose = np.array(said["camera-pose"])
    pose[:3, :3] *= 1 + by
    file.write_text(json.dumps(said | {"camera-pose": pose.tolist()}))


@pytest.mark.parametrize("layout", ["endonerf", "scared"])
def test_the_readers_mend_small_deviations_and_say_so(turned, layout):
    path = turned[layout]
    before = open_clip(path).cameras
    stretch(path, 4e-3)
    clip = open_clip(path)
    (said,) = (notice for notice in clip.notices if "not quite" in notice)
    assert "0.008" in said
    for camera, wanted in zip(clip.cameras, before, strict=True):
        assert np.abs(camera.camera_from_world[:3, :3] - wanted.camera_from_world[:3, :3]).max() < 1e-6
    stretch(path, LARGEST_DEVIATION)
    assert "expected rotations" in refusal(path)
