"""How near poses that are estimated come to the true ones, on phantoms whose camera circles.

python -m tests.benchmarks.camera_poses [--frames N] [--seeds N] [--without-depth] [--path PATH]

`rest`: tissue at rest. `pull`: one place is pulled and let go, a third of the view follows. `all`: it
breathes, too, so that nothing in view is at rest. `bound` is what exact places and depths of all tissue leave
when each frame is fitted to their mean: no search by the tissue can do much better. Depth is exact, or off by
a smooth error of 0.3 px (standard deviation) of the disparity of eyes 4.5 mm apart.

`--without-depth`: by structure from motion instead, both paths laid over each other with one scale, the focal
length known, or sought from a guess of 60 and of 75 degrees (it is 58).

`--path`: `back`, along a line and beside it back; `around` a field; `away`, without a return. The camera is
nearer then, and little of what it shows first is in view half way. `between its ends` is how far the last
frames are off as seen from the first ones, which show the same where the path returns. 256 x 208 px.
"""

from __future__ import annotations

import argparse
import math
import time
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np

from renderer.camera import Camera, FloatArray
from renderer.clip import Clip, Frame
from renderer.phantom import Phantom, PhantomParams
from renderer.phantom.surface import DISTANCE
from renderer.poses.from_motion import followed_features, structure_of
from renderer.poses.search import FoundPoses, PosesError, find_poses
from renderer.rigid import rigid_fit

DISPARITY_ERROR, REACH = 0.3, 3.0
BASELINE = 4.5  # mm
GUESSES = (60.0, 75.0)
"""Degrees across the image."""
BREATHS = slice(-3, -1)
"""Of the phantom's bumps."""
NEAR = 22.0
"""mm along the view, of a camera on a way of its own."""
ENDS = 0.1
"""Of the frames, at either end."""


class OnItsWay(Phantom):
    """A camera that leaves the place where it begins, and may come back to it."""

    path = "back"

    def camera(self, index: int) -> Camera:
        time = index / (self.params.n_frames - 1)
        centre = _centre(self.path, time)
        toward = [
            0.7 * centre[0] + 4 * math.sin(7 * time),
            0.7 * centre[1] + 4 * math.sin(5 * time),
            DISTANCE,
        ]
        forward = np.array(toward) - centre
        forward /= np.linalg.norm(forward)
        roll = math.radians(8) * math.sin(3 * math.pi * time)
        right = np.cross([math.sin(roll), math.cos(roll), 0.0], forward)
        right /= np.linalg.norm(right)
        matrix = np.eye(4)
        matrix[:3, :3] = np.stack([right, np.cross(forward, right), forward])
        matrix[:3, 3] = -matrix[:3, :3] @ centre
        return self._lens.moved(matrix)


def _centre(path: str, time: float) -> FloatArray:
    """(3,) mm."""
    turn = 2 * math.pi * time
    places = {
        "back": (
            -26 * math.cos(turn),
            5 * math.sin(2 * turn) + 3 * math.sin(turn / 2),
            2 * math.sin(3 * turn),
        ),
        "around": (-27 * math.cos(turn), 22 * math.sin(turn), 2 * math.sin(2 * turn)),
        "away": (54 * time - 27, 5 * math.sin(turn), 2 * math.sin(2 * turn)),
    }
    return np.add(places[path], (0, 0, NEAR))


def phantom(tissue: str, frames: int, seed: int, size: tuple[int, int] = (320, 256)) -> Phantom:
    return _of_tissue(Phantom(_params(tissue, frames, seed, size)), tissue)


def on_its_way(path: str, tissue: str, frames: int, seed: int, size: tuple[int, int] = (256, 208)) -> Phantom:
    scene = OnItsWay(replace(_params(tissue, frames, seed, size), tools=0))
    scene.path = path
    return _of_tissue(scene, tissue)


def _params(tissue: str, frames: int, seed: int, size: tuple[int, int]) -> PhantomParams:
    return PhantomParams(
        n_frames=frames, width=size[0], height=size[1], seed=seed,
        camera="moving", tissue="static" if tissue == "rest" else "moving",
    )  # fmt: skip


def _of_tissue(scene: Phantom, tissue: str) -> Phantom:
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


def between_ends(
    found: Sequence[Camera], true: Sequence[Camera], *, scaled: bool = False
) -> tuple[float, float]:
    """Per cent of the way, and degrees, by which frames near the end are off as seen from those as near the
    beginning, in the mean."""
    ours, theirs = (np.stack([each.camera_from_world for each in cameras]) for cameras in (found, true))
    places, truth = (np.array([each.position for each in cameras]) for cameras in (found, true))
    spreads = [np.linalg.norm(each - each.mean(axis=0)) for each in (places, truth)]
    ours[:, :3, 3] *= spreads[1] / spreads[0] if scaled else 1.0
    way = float(np.linalg.norm(np.diff(truth, axis=0), axis=1).sum())
    off = []
    for at in range(max(round(ENDS * len(ours)), 1)):
        one, other = (np.linalg.inv(each[-1 - at] @ np.linalg.inv(each[at])) for each in (ours, theirs))
        turn = np.linalg.norm(cv2.Rodrigues(one[:3, :3] @ other[:3, :3].T)[0])
        off.append((100 * np.linalg.norm(one[:3, 3] - other[:3, 3]) / way, np.degrees(turn)))
    return float(np.mean(off, axis=0)[0]), float(np.mean(off, axis=0)[1])


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
    parser.add_argument("--path", choices=("circle", "back", "around", "away"), default="circle")
    flags = parser.parse_args()
    measure = from_motion if flags.without_depth else by_depth
    for tissue in ("rest", "pull", "all"):
        for seed in range(flags.seeds):
            scene = (
                phantom(tissue, flags.frames, seed)
                if flags.path == "circle"
                else on_its_way(flags.path, tissue, flags.frames, seed)
            )
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
            f"(bound {least[0]:.2f}, {least[1]:.2f}); "
            f"{_said_of_ends(found, true)}; {len(found.cameras)} of {len(views)} frames, "
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
            f"{turned:.2f} degrees; "
            f"{_said_of_ends(found, true, scaled=True)}; {residual:.2f} px; "
            f"{len(found.cameras)} of {len(views)} frames, "
            f"{1000 * seconds / len(views):.0f} ms of one core a frame"
        )


def _said_of_ends(found: FoundPoses, true: Sequence[Camera], *, scaled: bool = False) -> str:
    held = true[found.first : found.last + 1]
    off, turned = between_ends(found.cameras, held, scaled=scaled)
    return f"between its ends {off:.2f} % and {turned:.2f} degrees, closed by {len(found.closed)} pairs"


if __name__ == "__main__":
    main()
