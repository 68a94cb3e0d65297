"""Error of the surface against its cost, on the phantom, whose tissue is known at every time.

`python -m tests.benchmarks.mesh_accuracy RUN... [--frames 40]`: runs on `vesselsplat phantom --frames
40`, with a fixed or a moving camera. Per number of vertices, over several times and all vertices: mean
and 95 % distance, error of the normals; the same where vertices follow the model's motion alone, and
where a surface is made anew at each time; how far vertices slip along the tissue; seconds for one
surface and for the whole clip; size of the file.
"""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter

import numpy as np

from app.exports.make import make
from app.exports.meshes.of_scene import surface_mesh
from app.exports.sources import Opened
from app.files.stepping import run_to_end
from app.scenes.scene import Scene, open_scene
from renderer.phantom import Phantom, PhantomParams
from renderer.phantom.surface import Surface
from renderer.surface.fineness import Fineness
from renderer.surface.following import Follower
from renderer.surface.height_field import height_field
from renderer.surface.maps import maps_of
from renderer.surface.mesh import Mesh
from renderer.surface.of_model import surface_of
from tests.renderer.surface.phantom_errors import SurfaceErrors, material, surface_errors

TIMES = (0.05, 0.25, 0.5, 0.75, 0.95)
SIZES = (Fineness(1000), Fineness(5000), Fineness(20_000), Fineness(80_000), Fineness(80_000, faces=10_000))
HEAD = "surface                     vertices    mean   95 %  normal   slip  seconds   clip s     MB"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("runs", nargs="+", type=Path)
    parser.add_argument("--frames", type=int, default=40)
    flags = parser.parse_args()
    for run in flags.runs:
        scene = open_scene(run)
        moving = len(set(scene.cameras)) > 1
        params = PhantomParams(n_frames=flags.frames, camera="moving" if moving else "fixed")
        print(f"\n{run.name}: {len(scene.model)} Gaussians, mm and degrees over times {TIMES}\n{HEAD}")
        for fineness in SIZES:
            measure(scene, Phantom(params).surface, fineness)


def measure(scene: Scene, truth: Surface, fineness: Fineness) -> None:
    began = perf_counter()
    follower = surface_of(scene.model, scene.cameras, scene.near, scene.mode, fineness)
    seconds = perf_counter() - began
    owned = material(follower.mesh.vertices, truth, follower.time)
    found = [surface_errors(follower.at(time), truth, time, owned) for time in TIMES]
    clip_seconds, size = exported(scene, fineness)
    name = f"{fineness.vertices}" + (f" to {fineness.faces} faces" if fineness.faces else "")
    row(name, follower.mesh, mean_of(found), f"{seconds:8.2f} {clip_seconds:8.1f} {size / 1e6:6.1f}")
    if fineness.faces:
        return
    moved = [surface_errors(by_motion_alone(follower, time), truth, time, owned) for time in TIMES]
    row("  motion alone", follower.mesh, mean_of(moved))
    if len(follower.cameras) == 1:
        anew = [surface_errors(new(scene, time, fineness), truth, time) for time in TIMES]
        row("  new at each time", follower.mesh, mean_of(anew))


def by_motion_alone(follower: Follower, time: float) -> Mesh:
    moved = follower.mesh.vertices + follower._displaced(time)
    return replace(follower.mesh, vertices=moved)


def new(scene: Scene, time: float, fineness: Fineness) -> Mesh:
    camera = scene.cameras[0]
    step = max(1, round(float(np.sqrt(camera.width * camera.height / fineness.vertices))))
    return height_field(maps_of(scene.model, time, camera, scene.near, scene.mode), step)


def exported(scene: Scene, fineness: Fineness) -> tuple[float, int]:
    """Seconds and bytes of the whole clip as GLB."""
    scene = replace(scene)  # Of which nothing is remembered.
    record = surface_mesh(scene, 15.0, vertices=fineness.vertices, faces=fineness.faces)
    with TemporaryDirectory() as folder:
        began, target = perf_counter(), Path(folder, "surface.glb")
        run_to_end(make(record, Opened(model=scene), target))
        return perf_counter() - began, target.stat().st_size


def mean_of(errors: list[SurfaceErrors]) -> SurfaceErrors:
    return SurfaceErrors(*np.mean([list(vars(one).values()) for one in errors], axis=0).tolist())


def row(name: str, mesh: Mesh, errors: SurfaceErrors, costs: str = "") -> None:
    numbers = f"{errors.mean:7.3f} {errors.most:6.3f} {errors.normal:7.1f} {errors.drift:6.2f}"
    print(f"{name:26} {len(mesh.vertices):9} {numbers} {costs}")


if __name__ == "__main__":
    main()
