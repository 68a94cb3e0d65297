"""The phantom as two lenses with distortion show it, whose rows do not agree, with their calibration."""

from __future__ import annotations

import json
from pathlib import Path

import cv2
import numpy as np

from renderer.camera import Camera
from renderer.phantom import Phantom, PhantomParams
from renderer.readers.lenses.calibration import Calibration, LensCalibration, SecondEye

SIZE = 320, 256
BENT = -0.32, 0.1, 0.0, 0.0, -0.01
LEFT = LensCalibration(fx=300, fy=300, cx=162, cy=125, distortion=BENT, size=SIZE)
RIGHT = LensCalibration(fx=303, fy=304, cx=157, cy=131, distortion=BENT, size=SIZE)
TURN = cv2.Rodrigues(np.array([0.01, -0.05, 0.02]))[0]
SHIFT = -4.2, 0.1, -0.05
EYES = Calibration(lens=LEFT, right=SecondEye(lens=RIGHT, turn=tuple(TURN.ravel().tolist()), shift=SHIFT))
WIDE = Camera(500.0, 500.0, 400.0, 320.0, 800, 640)
"""Drawn by it first: finer, and of more of the tissue."""


class Seen(Phantom):
    """The phantom through one camera that does not move."""

    def __init__(self, camera: Camera, n_frames: int) -> None:
        super().__init__(PhantomParams(n_frames=n_frames, tools=0, noise=0))
        self._seen_by = camera

    def camera(self, index: int) -> Camera:
        return self._seen_by


def raw(image: np.ndarray, lens: LensCalibration) -> np.ndarray:
    """What the lens shows of an image of WIDE; OpenCV's own inverse, to a hundredth of a pixel."""
    columns, rows = np.meshgrid(np.arange(SIZE[0], dtype=float), np.arange(SIZE[1], dtype=float))
    pixels = np.stack([columns, rows], axis=-1).reshape(-1, 1, 2)
    slants = cv2.undistortPoints(pixels, lens.matrix, lens.coefficients).reshape(SIZE[1], SIZE[0], 2)
    x, y = np.moveaxis(slants * (WIDE.fx, WIDE.fy) + (WIDE.cx - 0.5, WIDE.cy - 0.5), -1, 0).astype(np.float32)
    return cv2.remap(cv2.GaussianBlur(image, (0, 0), 0.6), x, y, cv2.INTER_LINEAR)


def raw_pairs(count: int) -> list[tuple[np.ndarray, np.ndarray]]:
    """Left and right image of each frame."""
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = TURN, SHIFT
    left, right = Seen(WIDE, count), Seen(WIDE.moved(pose), count)
    return [
        (raw(left.view(at).frame.image, LEFT), raw(right.view(at).frame.image, RIGHT)) for at in range(count)
    ]


def write_calibration(path: Path) -> Path:
    """In OpenCV's names."""
    lenses = {"M1": LEFT, "M2": RIGHT}
    values = {name: lens.matrix.tolist() for name, lens in lenses.items()}
    values |= {name.replace("M", "D"): [list(lens.distortion)] for name, lens in lenses.items()}
    values |= {"R": TURN.tolist(), "T": [[each] for each in SHIFT], "image_width": 320, "image_height": 256}
    path.write_text(json.dumps(values))
    return path
