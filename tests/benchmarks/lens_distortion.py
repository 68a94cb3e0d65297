"""What a lens that bends straight lines costs poses from motion, and whether the motion tells how much.

python -m tests.benchmarks.lens_distortion [--frames N] [--seed N] [--k1 K1 ...]

Features on the phantom's tissue at rest, off by 0.15 px, are seen through a lens of which nothing is known,
on a full circle of the camera and on a third of one, which goes one way; the field of view is sought from a
guess of 60 degrees. Paths are laid over each other with one scale; depths are those of points in each frame,
with one scale for all. `told`: k1 of OpenCV's model with which most of what is seen fits, sought from poses
and points that know of none, and the share by which it lowers the robust cost. `then`: the same measures from
features that are straightened by it.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from renderer.camera import BoolArray, Camera, FloatArray
from renderer.phantom import Phantom
from renderer.poses.bundle import Bundle, FocalGuess, adjusted, misfit
from renderer.poses.from_motion import FOCAL_SPREAD, Solved, focused
from renderer.poses.resection import robust
from renderer.poses.rigid_motion import Seen, local
from renderer.poses.tracks import Sight, Tracked
from tests.benchmarks.camera_poses import errors, phantom

SIZE = 320, 256
FOCAL = 1.0
"""By the width: 53 degrees across."""
DISTORTIONS = 0.0, -0.1, -0.2, -0.3
ROUNDS = 1, 3
"""The camera goes around once in as many times the frames."""
GUESS = 60.0
"""Degrees across the image."""
SHOWN, KEYED, LASTING = 300, 4, 16.0
"""Features of a frame, frames between keyframes, and how many a feature is followed through in the mean."""
NOISE, BORDER = 0.15, 8.0  # px
APART, MOST, SEEN_BY = 4, 24, 3
"""Frames between views by which k1 is sought, how many views, and how many of them see a point at least."""
STEP, FARTHEST, TURNS, ADJUSTED = 0.05, 0.15, 3, 10
"""Of that search: a parabola through three costs at `STEP` from each other, and how far one turn goes."""


@dataclass(frozen=True, eq=False)
class Footage:
    """What frames show, and what is true of it."""

    tracked: Tracked
    depths: tuple[FloatArray, ...]
    """mm, of what each frame shows."""
    cameras: tuple[Camera, ...]


def footage(scene: Phantom, lens: Camera, k1: float, frames: int, seed: int) -> Footage:
    """Each feature is followed from one keyframe on until it is lost, or out of view."""
    rng = np.random.default_rng(seed)
    where = rng.uniform(-1, 1, (9 * SHOWN, 2)) * np.array(SIZE) * 70 / lens.fx
    points = scene.surface.evaluate(where[:, 0], where[:, 1], 0.0)[0]
    track, until, count = np.full(len(points), -1), np.zeros(len(points)), 0
    sights, depths, cameras = list[Sight](), list[FloatArray](), list[Camera]()
    for frame in range(frames):
        camera = lens.moved(scene.camera(frame).camera_from_world)
        there = local(camera.camera_from_world, points)
        places, inside = bent(lens, there, k1)
        track[~inside | (frame > until)] = -1
        if frame % KEYED == 0:
            free = rng.permutation(np.flatnonzero(inside & (track < 0)))[: SHOWN - int((track >= 0).sum())]
            track[free] = count + np.arange(len(free))
            until[free] = frame + KEYED + rng.exponential(LASTING, len(free))
            count += len(free)
        shown = np.flatnonzero(track >= 0)
        noisy = places[shown] + rng.normal(0, NOISE, (len(shown), 2))
        sights.append(Sight(frame, track[shown], noisy))
        depths.append(there[shown, 2])
        cameras.append(camera)
    return Footage(
        Tracked(tuple(sights), tuple(range(0, frames, KEYED)), count), tuple(depths), tuple(cameras)
    )


def bent(lens: Camera, places: FloatArray, k1: float) -> tuple[FloatArray, BoolArray]:
    """(N, 2) px of points (N, 3) in camera axes, and (N,) whether they are in view."""
    slants = places[:, :2] / places[:, 2:]
    squares = (slants**2).sum(axis=1)
    seen = slants * (1 + k1 * squares)[:, None] * (lens.fx, lens.fy) + (lens.cx, lens.cy)
    inside = ((seen > BORDER) & (seen < np.array(SIZE) - BORDER)).all(axis=1)
    return seen, inside & (1 + 3 * k1 * squares > 0)


def straightened(lens: Camera, places: FloatArray, k1: float) -> tuple[FloatArray, FloatArray]:
    """Where a pinhole camera sees what is seen at (N, 2) px, and (N,) how much shorter lengths are there."""
    there = seen = (places - (lens.cx, lens.cy)) / (lens.fx, lens.fy)
    for _ in range(40):
        there = seen / np.maximum(1 + k1 * (there**2).sum(axis=1), 0.3)[:, None]
    squares = (there**2).sum(axis=1)
    area = np.maximum((1 + k1 * squares) * (1 + 3 * k1 * squares), 1e-3)
    return there * (lens.fx, lens.fy) + (lens.cx, lens.cy), np.sqrt(area)


def told(found: Solved, focal: FocalGuess) -> tuple[float, float]:
    """k1 in units of the focal length that was found, and the share of the cost that it takes away."""
    bundle, noise = _bundle(found, focal), found.done.noise.pixel
    best, before = 0.0, _cost(bundle, 0.0, noise)
    for _ in range(TURNS):
        less, here, more = (_cost(bundle, best + step, noise) for step in (-STEP, 0.0, STEP))
        curve, slope = less - 2 * here + more, (more - less) / 2
        lowest = -slope / curve * STEP if curve > 0 else -np.sign(slope) * FARTHEST
        step = float(np.clip(lowest, -FARTHEST, FARTHEST))
        best += step
        if abs(step) < STEP / 4:
            break
    return best, 1 - _cost(bundle, best, noise) / before


def _bundle(found: Solved, focal: FocalGuess) -> Bundle:
    views, points = found.done.views[::APART][:MOST], found.done.points
    ids = np.concatenate([view.ids for view in views])
    places = np.concatenate([view.seen.measured for view in views])
    of = np.repeat(np.arange(len(views)), [len(view.ids) for view in views])
    often = np.bincount(ids, minlength=len(points))[ids] >= SEEN_BY
    kept, seen_points = np.unique(ids[often], return_inverse=True)
    return Bundle(
        lens=found.done.lens, poses=np.stack([view.pose for view in views]), points=points[kept],
        views=of[often], seen_points=seen_points, seen=Seen(places[often], np.zeros((int(often.sum()), 3))),
        focal=focal,
    )  # fmt: skip


def _cost(bundle: Bundle, k1: float, noise: float) -> float:
    """Of the best poses and points for what is straightened by `k1`, in px as they are seen."""
    measured, weights = bundle.seen.measured.copy(), np.zeros_like(bundle.seen.weights)
    measured[:, :2], shorter = straightened(bundle.lens, measured[:, :2], k1)
    weights[:, :2] = (shorter / noise)[:, None]
    best = adjusted(replace(bundle, seen=Seen(measured, weights)), ADJUSTED)
    return float(robust((misfit(best) ** 2).sum(axis=1)).sum())


def lines(around: int, k1: float, frames: int, seed: int) -> Iterator[str]:
    focal = FOCAL * SIZE[0]
    lens = Camera(focal, focal, SIZE[0] / 2, SIZE[1] / 2, *SIZE)
    truth = footage(phantom("rest", around * frames, seed), lens, k1, frames, seed)
    guess = Camera.from_fov(GUESS, *SIZE)
    unknown = FocalGuess(guess.fx, FOCAL_SPREAD)
    found = focused(guess, [truth.tracked], unknown, lambda done, total: None)
    yield f"1/{around} of a circle, k1 {k1}: {measures(found, truth)}"
    began = time.process_time()
    best, gain = told(found, unknown)
    seconds = time.process_time() - began
    scaled = best * (lens.fx / found.done.lens.fx) ** 2
    yield f"  told: k1 {scaled:.3f}, cost lower by {gain:.1%}, {seconds:.1f} s of one core"
    straight = tuple(
        replace(sight, places=straightened(found.done.lens, sight.places, best)[0])
        for sight in truth.tracked.sights
    )
    again = replace(truth, tracked=replace(truth.tracked, sights=straight))
    then = focused(guess, [again.tracked], unknown, lambda done, total: None)
    yield f"  then: {measures(then, again)}"


def measures(found: Solved, truth: Footage) -> str:
    views = found.done.views
    ours = [found.done.lens.moved(view.pose) for view in views]
    off, turned = errors(ours, [truth.cameras[view.frame] for view in views], scaled=True)
    apart = np.concatenate([_depths_apart(found, truth, place) for place in range(len(views))])
    spread = float(np.median(np.abs(apart - np.median(apart))))
    longer = found.done.lens.fx / truth.cameras[0].fx
    return (
        f"{off:.2f} % of the way, {turned:.2f} degrees, depths off by {100 * spread:.2f} % (median), "
        f"focal length {longer:.3f} as long, {found.done.noise.pixel:.3f} px"
    )


def _depths_apart(found: Solved, truth: Footage, place: int) -> FloatArray:
    """(N,) logarithms of depths by the true ones, of points that a view shows."""
    view = found.done.views[place]
    places = truth.tracked.sights[view.frame].places
    order = {tuple(each): number for number, each in enumerate(places.tolist())}
    numbers = [order[tuple(each)] for each in view.seen.measured[:, :2].tolist()]
    depths = local(view.pose, found.done.points[view.ids])[:, 2]
    return np.asarray(np.log(depths / truth.depths[view.frame][numbers]))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--frames", type=int, default=40)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--k1", type=float, nargs="+", default=DISTORTIONS)
    flags = parser.parse_args()
    for around in ROUNDS:
        for k1 in flags.k1:
            for line in lines(around, k1, flags.frames, flags.seed):
                print(line, flush=True)


if __name__ == "__main__":
    main()
