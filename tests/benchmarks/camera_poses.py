"""How near poses that are estimated come to the true ones, on phantoms whose camera circles.

python -m tests.benchmarks.camera_poses [--frames N] [--seeds N] [--without-depth]

`rest`: tissue at rest. `pull`: one place is pulled and let go, a third of the view follows. `all`: it
breathes, too, so that nothing in view is at rest. `bound` is what exact places and depths of all tissue leave
when each frame is fitted to their mean: no search by the tissue can do much better. Depth is exact, or off by
a smooth error of 0.3 px (standard deviation) of the disparity of eyes 4.5 mm apart.

`--without-depth`: by structure from motion instead, both paths laid over each other with one scale, the focal
length known, or sought from a guess of 60 and of 75 degrees (it is 58).
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np

from renderer.camera import Camera, FloatArray
from renderer.clip import Clip, Frame
from renderer.phantom import Phantom, PhantomParams
from renderer.poses.from_motion import followed_features, structure_of
from renderer.poses.search import PosesError, find_poses
from renderer.rigid import rigid_fit

DISPARITY_ERROR, REACH = 0.3, 3.0
BASELINE = 4.5  # mm
GUESSES = (60.0, 75.0)
"""Degrees across the image."""
BREATHS = slice(-3, -1)
"""Of the phantom's bumps."""


def phantom(tissue: str, frames: int, seed: int, size: tuple[int, int] = (320, 256)) -> Phantom:
    params = PhantomParams(
        n_frames=frames, width=size[0], height=size[1], seed=seed,
        camera="moving", tissue="static" if tissue == "rest" else "moving",
    )  # fmt: skip
    scene = Phantom(params)
    if tissue == "pull":
        amplitudes = scene.surface.amplitudes.copy()
        amplitudes[BREATHS] = 0
        scene.surface = replace(scene.surface, amplitudes=amplitudes)
    return scene


def unposed(scene: Phantom, views: Sequence[Frame], error: float) -> Clip:
    camera, rng = scene.camera(0), np.random.default_rng(0)

    def read_frame(index: int) -> Frame:
        return replace(frames[index], camera=camera)

    def noisy(frame: Frame) -> Frame:
        assert frame.depth is not None
        off = cv2.GaussianBlur(rng.standard_normal(frame.depth.shape).astype(np.float32), (0, 0), REACH)
        product = camera.fx * BASELINE
        disparity = product / np.maximum(frame.depth, 1) + off * (error / off.std())
        return replace(frame, depth=np.where(frame.depth > 0, product / disparity, 0).astype(np.float32))

    frames = [noisy(frame) if error else frame for frame in views]
    return Clip(
        name="phantom", path=Path("phantom"), format="endonerf", cameras=(camera,) * len(frames),
        read_frame=read_frame, read_image=lambda index: frames[index].image,
        labels=tuple(map(str, range(len(frames)))), has_depth=True, unit="mm",
    )  # fmt: skip


def bound(scene: Phantom, cameras: Sequence[Camera]) -> list[Camera]:
    grid = np.stack(np.meshgrid(np.linspace(-30, 30, 25), np.linspace(-24, 24, 20)), -1).reshape(-1, 2)
    count = len(cameras)
    moments = [scene.surface.evaluate(grid[:, 0], grid[:, 1], at / count)[0] for at in range(count)]
    mean, found = np.mean(moments, axis=0), []
    for camera, points in zip(cameras, moments, strict=True):
        pose, seen = np.eye(4), camera.camera_from_world
        pose[:3, :3], pose[:3, 3] = rigid_fit(mean, points @ seen[:3, :3].T + seen[:3, 3])
        found.append(camera.moved(pose))
    return found


def errors(found: Sequence[Camera], true: Sequence[Camera], *, scaled: bool = False) -> tuple[float, float]:
    """RMS of places in per cent of the way, and of turns in degrees, both worlds laid over each other;
    `scaled`: with the scale that fits best."""
    ours, theirs = (np.stack([each.camera_from_world for each in cameras]) for cameras in (found, true))
    u, _, vt = np.linalg.svd(np.einsum("nji,njk->ik", theirs[:, :3, :3], ours[:, :3, :3]))
    turn = u @ np.diag([1, 1, np.linalg.det(u @ vt)]) @ vt
    places, truth = (np.array([each.position for each in cameras]) for cameras in (found, true))
    ours_there, there = places @ turn.T, truth - truth.mean(axis=0)
    ours_there -= ours_there.mean(axis=0)
    scale = (ours_there * there).sum() / (ours_there**2).sum() if scaled else 1.0
    off = scale * ours_there - there
    way = float(np.linalg.norm(np.diff(truth, axis=0), axis=1).sum())
    return 100 * _rms(np.linalg.norm(off, axis=1)) / way, _rms(_angles(ours, theirs, turn))


def _angles(ours: FloatArray, theirs: FloatArray, turn: FloatArray) -> FloatArray:
    apart = np.einsum("nij,kj,nlk->nil", ours[:, :3, :3], turn, theirs[:, :3, :3])
    cosine = (np.trace(apart, axis1=1, axis2=2) - 1) / 2
    return np.degrees(np.arccos(np.clip(cosine, -1, 1)))


def _rms(values: FloatArray) -> float:
    return float(np.sqrt(np.mean(values**2)))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--frames", type=int, default=60)
    parser.add_argument("--seeds", type=int, default=2)
    parser.add_argument("--without-depth", action="store_true")
    flags = parser.parse_args()
    measure = from_motion if flags.without_depth else by_depth
    for tissue in ("rest", "pull", "all"):
        for seed in range(flags.seeds):
            scene = phantom(tissue, flags.frames, seed)
            views = [scene.view(index).frame for index in range(flags.frames)]
            true = [scene.camera(index) for index in range(flags.frames)]
            for line in measure(scene, views, true):
                print(f"{tissue} seed {seed} {line}", flush=True)


def by_depth(scene: Phantom, views: Sequence[Frame], true: Sequence[Camera]) -> Iterator[str]:
    least = errors(bound(scene, true), true)
    for error in (0.0, DISPARITY_ERROR):
        began = time.perf_counter()
        found = find_poses(unposed(scene, views, error))
        seconds = time.perf_counter() - began
        off, turned = errors(found.cameras, true[found.first : found.last + 1])
        yield (
            f"depth off by {error} px: {off:.2f} % of the way, {turned:.2f} degrees "
            f"(bound {least[0]:.2f}, {least[1]:.2f}); {len(found.cameras)} of {len(views)} frames, "
            f"{1000 * seconds / len(views):.0f} ms a frame"
        )


def from_motion(scene: Phantom, views: Sequence[Frame], true: Sequence[Camera]) -> Iterator[str]:
    clip, known = unposed(scene, views, 0.0), scene.camera(0)
    for view in (None, *GUESSES):
        lens = known if view is None else Camera.from_fov(view, known.width, known.height)
        began = time.process_time()
        try:
            seen = clip.through((lens,) * len(clip))
            features = followed_features(seen)
            found = structure_of(seen, features, focal_is_known=view is None).poses
        except PosesError as error:
            yield f"without depth: {error}"
            continue
        seconds = time.process_time() - began
        off, turned = errors(found.cameras, true[found.first : found.last + 1], scaled=True)
        focal = "known" if view is None else f"guessed {lens.fx / known.fx:.2f} as long"
        residual = np.median([each for each in found.residuals if each is not None])
        length = f"{focal}, found {found.cameras[0].fx / known.fx:.3f}"
        yield (
            f"without depth, focal length {length}: {off:.2f} % of the way, "
            f"{turned:.2f} degrees; {residual:.2f} px; {len(found.cameras)} of {len(views)} frames, "
            f"{1000 * seconds / len(views):.0f} ms of one core a frame"
        )


if __name__ == "__main__":
    main()
