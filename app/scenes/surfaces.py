"""The tissue surface of a scene, worked out once and remembered while the scene is looked at."""

from __future__ import annotations

from functools import lru_cache

from app.errors import UserError
from app.scenes.scene import Scene
from renderer.surface.following import Follower
from renderer.surface.mesh import Mesh
from renderer.surface.of_model import AS_IT_COMES, Fineness, surface_of


@lru_cache(maxsize=2)
def surface(scene: Scene, fineness: Fineness = AS_IT_COMES) -> Follower:
    """Takes a second or less. Raises UserError: there is none, or it cannot be simplified here."""
    try:
        follower = surface_of(scene.model, scene.cameras, scene.near, scene.mode, fineness)
    except RuntimeError as error:
        raise UserError(str(error)) from error
    if not len(follower.mesh.faces):
        raise UserError(f"expected a surface, got none: {scene.name} covers nothing of what its cameras see")
    return follower


@lru_cache(maxsize=256)
def surface_at(scene: Scene, time: float) -> Mesh:
    """At a time in [0, 1]. Raises UserError as `surface`."""
    return surface(scene).at(time)
