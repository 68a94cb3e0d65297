"""What a reconstruction gains where training finds the lens's distortion and undistorts the images by it.

python -m tests.benchmarks.lens_runs DIR [--k1 K1 ...] [--frames N] [--iterations N]

A plain video of the phantom at rest, seen through a lens that bends straight lines, is trained on with
`--depth motion` and nothing else, as the lens is found and with `--leave-out lens`. Test PSNR is over each
run's own frames; depths are rendered at test frames, each compared with the true one of the place that its
pixel shows, with one scale for all; the camera's path as in camera_poses.py. Seconds are of all cores, from
the video to the model.
"""

from __future__ import annotations

import argparse
import math
import time
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import cv2
import numpy as np

from app.files.timing import Timing
from app.files.video import write_video
from app.runs.run_folder import RunFolder
from app.runs.train_run import TrainRequest, run_training
from app.runs.trained_clip import run_clip
from app.scenes.cpu_rendering import DrawOptions, draw_on_cpu
from renderer.camera import Camera, FloatArray
from renderer.clip import ByteImage
from renderer.measuring.closeness import closeness
from renderer.near_plane import near_plane
from renderer.phantom import Phantom, PhantomParams
from renderer.poses.radial import straightened
from renderer.readers.clip_options import ClipOptions
from renderer.readers.lenses.straightening import straightening
from renderer.train.config import TrainConfig
from tests.benchmarks.camera_poses import errors

SIZE = 256, 208
MOTION = ClipOptions(depth="motion")


@dataclass(frozen=True, eq=False)
class Bent:
    """The phantom through a lens with distortion, whose image has no empty corner."""

    k1: float
    frames: int

    @cached_property
    def scene(self) -> Phantom:
        return Phantom(PhantomParams(n_frames=self.frames, camera="moving", tissue="static", tools=0))

    @cached_property
    def lens(self) -> Camera:
        """Without its distortion."""
        wide = self.scene.camera(0)
        corner = math.hypot(wide.width / wide.fx, wide.height / wide.fy) / 2
        focal = 1.02 * math.hypot(*SIZE) / 2 / (corner * (1 + self.k1 * corner**2))
        return Camera(focal, focal, SIZE[0] / 2, SIZE[1] / 2, *SIZE)

    @cached_property
    def _places(self) -> FloatArray:
        """(H, W, 2) px of the phantom that each pixel shows, from the centre of the first."""
        y, x = np.mgrid[: SIZE[1], : SIZE[0]] + 0.5
        seen = straightened(self.lens, np.c_[x.ravel(), y.ravel()], self.k1)
        wide, middle = self.scene.camera(0), (self.lens.cx, self.lens.cy)
        there = (seen - middle) * wide.fx / self.lens.fx + (wide.cx - 0.5, wide.cy - 0.5)
        return there.reshape(SIZE[1], SIZE[0], 2).astype(np.float32)

    def image(self, index: int) -> ByteImage:
        shown = cv2.remap(self.scene.view(index).frame.image, self._places, None, cv2.INTER_CUBIC)
        return np.asarray(shown, np.uint8)

    def depth(self, index: int) -> FloatArray:
        """(H, W) mm."""
        depth = self.scene.view(index).frame.depth
        assert depth is not None
        return np.asarray(cv2.remap(depth, self._places, None, cv2.INTER_LINEAR), np.float64)


def measured(run: RunFolder, truth: Bent) -> str:
    """PSNR and depth at test frames, and the path."""
    record, model = run.record(), run.model()
    clip, found = run_clip(record), record.clip.options.calibration
    first, quality, depths, true = record.clip.part.first or 0, [], [], []
    for index in clip.test_indices:
        frame = clip.read_frame(index)
        near = near_plane(model, frame.camera)
        drawn = draw_on_cpu(model.at(frame.time), frame.camera, DrawOptions(near, record.config.render_mode))
        quality.append(closeness(drawn.bytes, drawn.alpha, frame, None).psnr)
        there = truth.depth(first + index)
        if found is not None:
            there = straightening(found.lens, clip.size).image(there)
        seen = drawn.alpha > 0.9
        depths.append(drawn.depth[seen])
        true.append(there[seen])
    apart = np.log(np.concatenate(depths) / np.concatenate(true))
    spread = np.abs(apart - np.median(apart))
    theirs = [truth.scene.camera(first + index) for index in range(len(clip))]
    off, turned = errors(clip.cameras, theirs, scaled=True)
    return (
        f"PSNR {np.mean(quality):.2f} dB, depth off by {100 * np.median(spread):.2f} % (median), "
        f"{100 * np.quantile(spread, 0.95):.2f} % (95 of 100), path {off:.2f} % and {turned:.2f} degrees"
    )


def lines(folder: Path, k1: float, frames: int, iterations: int) -> Iterator[str]:
    truth, video = Bent(k1, frames), folder / f"k1 {k1}.mp4"
    if not video.exists():
        write_video(video, (truth.image(index) for index in range(frames)), Timing(frames_per_second=25))
    for left_out in ((), ("lens",)):
        run = RunFolder(folder / f"k1 {k1} {'as it is' if left_out else 'found'} {iterations}")
        config = TrainConfig(iterations=iterations, n_gaussians=8000, leave_out=left_out)
        request = TrainRequest(
            clip_path=video, run_path=run.path, config=config, clip_options=MOTION, resume=True
        )
        began = time.process_time()
        list(run_training(request))
        seconds, found = time.process_time() - began, run.record().clip.options.calibration
        told = "not undistorted"
        if found is not None and found.found is not None:
            there, longer = found.lens.distortion[0], found.lens.fx / truth.lens.fx
            told = (
                f"k1 {there:.3f} +- {found.found.deviation:.3f}, off by {there - k1:+.3f}, focal length "
                f"{longer:.3f} as long"
            )
        yield f"k1 {k1}: {told}; {measured(run, truth)}; {seconds:.0f} s"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--k1", type=float, nargs="+", default=(0.0, -0.15, -0.3))
    parser.add_argument("--frames", type=int, default=48)
    parser.add_argument("--iterations", type=int, default=800)
    flags = parser.parse_args()
    flags.folder.mkdir(parents=True, exist_ok=True)
    for k1 in flags.k1:
        for line in lines(flags.folder, k1, flags.frames, flags.iterations):
            print(line, flush=True)


if __name__ == "__main__":
    main()
