"""What a lens that bends straight lines costs poses from motion, and whether the motion tells how much.

python -m tests.benchmarks.lens_distortion [--frames N] [--seed N] [--k1 K1 ...] [--tissue NAME ...]

Features on the phantom's tissue, off by 0.15 px, are seen through a lens of which nothing is known, on a full
circle of the camera and on a third of one, which goes one way; the field of view is sought from a guess of 60
degrees. The tissue rests, is pulled in a third of the view, or all of it breathes, see camera_poses.py. Paths
are laid over each other with one scale; depths are those of points in each frame, with one scale for all.
`told`: k1, its standard deviation and error, the focal length that belongs to it, the share of the features
that agree with one body, and whether it is used. `then`: the same measures as training goes on where it is,
from features that are straightened by it, with that focal length. Whole reconstructions: lens_runs.py.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from renderer.camera import BoolArray, Camera, FloatArray
from renderer.phantom import Phantom
from renderer.poses.bundle import FocalGuess
from renderer.poses.distortion import Distortion, distortion_of
from renderer.poses.from_motion import FOCAL_SPREAD, Solved, focused
from renderer.poses.radial import bent, straightened
from renderer.poses.rigid_motion import local, projected
from renderer.poses.tracks import Sight, Tracked
from tests.benchmarks.camera_poses import errors, phantom

SIZE = 320, 256
FOCAL = 1.0
"""By the width: 53 degrees across."""
DISTORTIONS = 0.0, -0.1, -0.2, -0.3
TISSUES = "rest", "pull", "all"
ROUNDS = 1, 3
"""The camera goes around once in as many times the frames."""
GUESS = 60.0
"""Degrees across the image."""
SHOWN, KEYED, LASTING = 300, 4, 16.0
"""Features of a frame, frames between keyframes, and how many a feature is followed through in the mean."""
NOISE, BORDER = 0.15, 8.0  # px


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
    track, until, count = np.full(len(where), -1), np.zeros(len(where)), 0
    sights, depths, cameras = list[Sight](), list[FloatArray](), list[Camera]()
    for frame in range(frames):
        points = scene.surface.evaluate(where[:, 0], where[:, 1], frame / frames)[0]
        camera = lens.moved(scene.camera(frame).camera_from_world)
        there = local(camera.camera_from_world, points)
        places, inside = through(lens, there, k1)
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


def through(lens: Camera, places: FloatArray, k1: float) -> tuple[FloatArray, BoolArray]:
    """(N, 2) px of points (N, 3) in camera axes, and (N,) whether they are in view."""
    squares = ((places[:, :2] / places[:, 2:]) ** 2).sum(axis=1)
    seen = bent(lens, projected(lens, places), k1)[:, :2]
    inside = ((seen > BORDER) & (seen < np.array(SIZE) - BORDER)).all(axis=1)
    return seen, inside & (1 + 3 * k1 * squares > 0)


def lines(tissue: str, around: int, k1: float, frames: int, seed: int) -> Iterator[str]:
    focal = FOCAL * SIZE[0]
    lens = Camera(focal, focal, SIZE[0] / 2, SIZE[1] / 2, *SIZE)
    truth = footage(phantom(tissue, around * frames, seed), lens, k1, frames, seed)
    guess = Camera.from_fov(GUESS, *SIZE)
    unknown = FocalGuess(guess.fx, FOCAL_SPREAD)
    found = focused(guess, [truth.tracked], unknown, lambda done, total: None)
    yield f"{tissue}, 1/{around} of a circle, k1 {k1}: {measures(found, truth)}"
    began = time.process_time()
    told = distortion_of(found.done, [truth.tracked], unknown)
    if told is None:
        return
    seconds = time.process_time() - began
    longer, usable = told.lens.fx / lens.fx, "used" if told.is_certain else "not used"
    yield (
        f"  told: k1 {told.k1:.3f} +- {told.deviation:.3f}, off by {told.k1 - k1:+.3f}, focal length "
        f"{longer:.3f} as long, {told.rigid:.0%} agree, {usable}, {seconds:.1f} s of one core"
    )
    if told.is_certain:
        again = straight(truth, told)
        began = time.process_time()
        then = focused(told.lens, [again.tracked], None, lambda done, total: None)
        yield f"  then: {measures(then, again)}, {time.process_time() - began:.1f} s"


def straight(seen: Footage, told: Distortion) -> Footage:
    sights = tuple(
        replace(sight, places=straightened(told.lens, sight.places, told.k1)) for sight in seen.tracked.sights
    )
    return replace(seen, tracked=replace(seen.tracked, sights=sights))


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
    parser.add_argument("--tissue", nargs="+", default=TISSUES)
    flags = parser.parse_args()
    for tissue, around, k1 in product(flags.tissue, ROUNDS, flags.k1):
        for line in lines(tissue, around, k1, flags.frames, flags.seed):
            print(line, flush=True)


if __name__ == "__main__":
    main()
