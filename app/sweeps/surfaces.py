"""The surface of a job's run as a file, and its measures."""

from __future__ import annotations

from pathlib import Path
from time import perf_counter
from typing import Final

import numpy as np

from app.evaluation.evaluate import open_evaluation
from app.exports.make import make
from app.exports.meshes.of_scene import surface_mesh
from app.exports.sources import Opened
from app.files.stepping import run_to_end
from app.scenes.clip_speed import FRAMES_PER_SECOND, clip_speed
from app.scenes.scene import open_scene
from app.scenes.surfaces import surface
from app.sweeps.settings import Meshing
from renderer.measuring.surface_accuracy import depth_distances
from renderer.surface.fineness import Fineness

MOST: Final = 95
"""Per cent of the distances, which the second of the two holds."""


def mesh_measures(run: Path, target: Path, wanted: Meshing) -> dict[str, float | None]:
    """Export it to `target`, and compare it with the depth measured on the frames of the evaluation: on a
    phantom that is the true surface. Raises UserError."""
    scene = open_scene(run, as_trained=True)
    record = surface_mesh(
        scene, clip_speed(scene) or FRAMES_PER_SECOND, vertices=wanted.vertices, faces=wanted.faces
    )
    began = perf_counter()
    run_to_end(make(record, Opened(model=scene), target))
    seconds = perf_counter() - began
    follower, evaluation = surface(scene, Fineness(wanted.vertices, wanted.faces)), open_evaluation(run)
    frames = (evaluation.clip.read_frame(index) for index in evaluation.indices)
    found = [depth_distances(follower.at(frame.time), frame) for frame in frames]
    distances = np.concatenate(found)
    unit = "_mm" if scene.unit == "mm" else ""
    return {
        "vertices": float(len(follower.mesh.vertices)),
        "triangles": float(len(follower.mesh.faces)),
        "bytes": float(target.stat().st_size),
        "export_seconds": seconds,
        f"surface{unit}": float(distances.mean()) if len(distances) else None,
        f"surface_{MOST}{unit}": float(np.percentile(distances, MOST)) if len(distances) else None,
    }
