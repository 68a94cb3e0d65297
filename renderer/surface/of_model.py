"""The surface of a model: at one time as a mesh, from there followed through time."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np

from renderer.camera import Camera
from renderer.clip import ByteImage
from renderer.gaussians import DynamicGaussians
from renderer.splats import Float32Array, RenderMode
from renderer.surface.fineness import AS_IT_COMES, Fineness
from renderer.surface.following import Follower, seen_colors, sight
from renderer.surface.fusion import fused
from renderer.surface.height_field import height_field
from renderer.surface.maps import Maps, maps_of
from renderer.surface.mesh import Mesh
from renderer.surface.simplifying import simplified
from renderer.surface.surface_nets import surface_net

REFERENCE: Final = 0.5
"""The time whose surface is followed: the middle, from which the tissue has the shortest way."""
MOST_CAMERAS: Final = 12
"""Of a clip whose camera moves, that are looked through; evenly spread over its frames."""


def surface_of(
    model: DynamicGaussians,
    cameras: Sequence[Camera],
    near: float,
    mode: RenderMode = "default",
    fineness: Fineness = AS_IT_COMES,
) -> Follower:
    """Through the clip's own cameras; what none of them sees at the middle of the clip is a hole.

    A fixed camera's depth map becomes triangles; those of a moving camera are fused.

    Raises:
        RuntimeError: simplifying is asked for and cannot be done here.
    """
    taken = looked_through(cameras)
    views = [maps_of(model, REFERENCE, cameras[index], near, mode) for index in taken]
    mesh = _mesh(views, fineness.vertices)
    if fineness.faces is not None:
        mesh = simplified(mesh, fineness.faces)
    sights = tuple(sight(view, mesh) for view in views)
    colors = seen_colors(views, sights, mesh.vertices, mesh.colors)
    return Follower(
        model=model,
        cameras=tuple(view.camera for view in views),
        near=near,
        mode=mode,
        mesh=mesh.moved(mesh.vertices, colors),
        time=REFERENCE,
        sights=sights,
        taken=tuple(index / len(cameras) for index in taken),
        picture=_rounded(views[0].color) if len(views) == 1 else None,
    )


def looked_through(cameras: Sequence[Camera]) -> tuple[int, ...]:
    """Frames whose cameras together see what all do: one of those that are the same; else a few."""
    different = list({camera: index for index, camera in reversed([*enumerate(cameras)])}.values())[::-1]
    places = np.unique(np.rint(np.linspace(0, len(different) - 1, MOST_CAMERAS)).astype(int))
    return tuple(different[place] for place in places)


def _rounded(color: Float32Array) -> ByteImage:
    levels: ByteImage = np.rint(color.clip(0, 1) * 255).astype(np.uint8)
    return levels


def _mesh(views: Sequence[Maps], vertices: int) -> Mesh:
    if len(views) == 1:
        camera = views[0].camera
        return height_field(views[0], max(1, round(float(np.sqrt(camera.width * camera.height / vertices)))))
    return surface_net(fused(views, _voxel(views, vertices))).without_specks()


def _voxel(views: Sequence[Maps], vertices: int) -> float:
    """The distance between so many points in the picture that sees most, at the middle of its depths."""
    largest = max(views, key=lambda view: np.count_nonzero(view.seen))
    depths = largest.depth[largest.seen]
    camera = largest.camera
    pixels = float(np.sqrt(camera.width * camera.height / vertices))
    return pixels * float(np.median(depths)) / camera.fx if len(depths) else 1.0
