"""How near depth that is not measured comes to the truth, and what it costs.

python -m tests.benchmarks.depth_sources
"""

from __future__ import annotations

import time
from pathlib import Path

import cv2
import numpy as np

from renderer.clip import Frame
from renderer.depth.depth_prior import depth_from_brightness
from renderer.depth.sparse_depth import depth_between
from renderer.depth.stereo import disparity, feature_shifts
from renderer.phantom import Phantom, PhantomParams
from renderer.readers.data_sets.endonerf import open_endonerf
from renderer.readers.image_files.pictures import read_rgb, read_stored
from tests.renderer.eyes import BASELINE, look

DATA = Path(__file__).resolve().parents[2] / "../shared/data"
SEEDS = range(41, 47)
"""None of which a constant was chosen on."""


def stereo_on_the_phantom(width: int, height: int) -> None:
    rows = []
    for seed in SEEDS:
        eyes = look(width=width, height=height, seed=seed)
        began = time.perf_counter()
        found = disparity(eyes.left.image, eyes.right.image)
        seconds = time.perf_counter() - began
        known = eyes.seen & (found > 0)
        off = np.abs(found - eyes.disparity)[known]
        assert eyes.left.depth is not None
        depth = eyes.left.camera.fx * BASELINE / found[known]
        millimetres = np.abs(depth - eyes.left.depth[known])
        hidden = (found > 0)[eyes.hidden].mean()
        share = known.sum() / eyes.seen.sum()
        rows.append((share, np.median(off), (off > 1).mean(), np.median(millimetres), hidden, seconds))
    share, middle, wrong, millimetre, hidden, seconds = np.mean(rows, axis=0)
    print(
        f"stereo, phantom {width}x{height}: matched {share:.3f} of what both eyes see, median error "
        f"{middle:.3f} px = {millimetre:.2f} mm, beyond 1 px {wrong:.4f}; hidden pixels with a match "
        f"{hidden:.3f}; {1000 * seconds:.0f} ms a pair"
    )


def stereo_on_a_real_pair(folder: Path) -> None:
    left, right = read_rgb(folder / "left.png"), read_rgb(folder / "right.png")
    began = time.perf_counter()
    found = disparity(left, right)
    seconds = time.perf_counter() - began
    known = found > 0
    grid = np.indices(found.shape).astype(np.float32)
    warped = cv2.remap(right, grid[1] - found, grid[0], cv2.INTER_LINEAR)
    errors = [np.abs(eye.astype(float) - left).mean(axis=2)[known].mean() for eye in (warped, right)]
    seen = grid[1] >= np.median(found[known])
    charted = read_stored(folder / "occ_left.png") == 255
    rows = np.median(np.abs(feature_shifts(left, right)[:, 1]))
    print(
        f"stereo, SCARED pair {left.shape[1]}x{left.shape[0]}: photometric error {errors[0]:.2f} levels, "
        f"unwarped {errors[1]:.2f}; matched {known.mean():.3f} of all, {known[seen].mean():.3f} of the right "
        f"eye's view, {known[seen & charted].mean():.3f} where occ_left is white, "
        f"{known[seen & ~charted].mean():.3f} where black; rows {rows:.2f} px apart; {1000 * seconds:.0f} ms"
    )


def brightness(name: str, frames: list[Frame]) -> None:
    correlations, errors = [], []
    for frame in frames:
        assert frame.depth is not None
        tissue = frame.depth_mask
        guess, depth = depth_from_brightness(frame)[tissue], frame.depth[tissue]
        ranks = [np.argsort(np.argsort(values, kind="stable")) for values in (guess, depth)]
        correlations.append(np.corrcoef(ranks)[0, 1])
        relative = guess / np.median(guess) * np.median(depth) / depth - 1
        errors.append((np.median(np.abs(relative)), np.median(np.abs(np.median(depth) / depth - 1))))
    own, flat = np.mean(errors, axis=0)
    print(
        f"brightness, {name}: rank correlation {np.mean(correlations):.2f} (lowest {min(correlations):.2f}), "
        f"median relative error {own:.3f} at the right scale; of a flat wall {flat:.3f}"
    )


def sparse_on_the_phantom(noise: float) -> None:
    errors, milliseconds = [], []
    for seed in SEEDS:
        frame = Phantom(PhantomParams(seed=seed)).view(0).frame
        assert frame.depth is not None
        rng = np.random.default_rng(seed)
        spread = np.exp(noise * rng.standard_normal(frame.depth.shape)).astype(np.float32)
        chosen = rng.choice(np.flatnonzero(frame.tissue_mask), 200, replace=False)
        points = frame.camera.unproject(frame.depth * spread).reshape(-1, 3)[chosen]
        began = time.perf_counter()
        found = depth_between(points, frame.camera, frame.tissue_mask)
        milliseconds.append(1000 * (time.perf_counter() - began))
        known = found > 0
        errors.append(np.median(np.abs(found[known] / frame.depth[known] - 1)))
    print(
        f"200 points with {noise:.0%} noise, phantom: median relative error {np.mean(errors):.4f}, "
        f"{np.median(milliseconds):.0f} ms"
    )


def main() -> None:
    stereo_on_the_phantom(320, 256)
    stereo_on_the_phantom(640, 512)
    if (pair := DATA / "scared/d1k1_rectified_pair").is_dir():
        stereo_on_a_real_pair(pair)
    brightness("phantom", [Phantom(PhantomParams(seed=seed)).view(0).frame for seed in SEEDS])
    if (folder := DATA / "endonerf/pulling_soft_tissues").is_dir():
        clip = open_endonerf(folder)
        brightness("pulling, training frames", [clip.read_frame(index) for index in clip.train_indices[::6]])
    for noise in (0.0, 0.01, 0.03):
        sparse_on_the_phantom(noise)


if __name__ == "__main__":
    main()
