"""What a checkpoint must have in common with the training that goes on from it."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Sequence
from dataclasses import asdict

import numpy as np

from renderer.camera import Camera
from renderer.clip import Clip, Frame
from renderer.train.config import TrainConfig

_READ = ("measured", "beside")
"""Depth of files; any other is reckoned, and its last bits may depend on the computer."""


def fingerprint(clip: Clip, config: TrainConfig, fit: Sequence[int], first: Frame) -> str:
    """Of the configuration, the frames `fit` and all cameras of a clip, and what its `first` frame of the fit
    shows."""
    digest = hashlib.sha256(former_fingerprint(clip, config).encode())
    digest.update(np.array(fit, np.int64).tobytes())
    for camera in clip.cameras:
        digest.update(_numbers(camera))
    digest.update(np.ascontiguousarray(first.image).tobytes())
    digest.update(np.packbits(first.tissue_mask).tobytes())
    if first.depth is not None and clip.depth_origin in _READ:
        digest.update(np.asarray(first.depth, np.float32).tobytes())
    return digest.hexdigest()


def former_fingerprint(clip: Clip, config: TrainConfig) -> str:
    """That of earlier versions, whose trainings go on as well: of names and size alone."""
    identity = {"clip": clip.name, "labels": clip.labels, "size": clip.size, "config": asdict(config)}
    return hashlib.sha256(json.dumps(identity, sort_keys=True).encode()).hexdigest()


def _numbers(camera: Camera) -> bytes:
    lens = (*camera.lens, camera.width, camera.height)
    return np.array([*lens, *camera.camera_from_world.ravel()], np.float64).tobytes()
