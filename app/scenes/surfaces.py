"""The tissue surface of a scene, worked out once and remembered as long as the scene is."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Final
from weakref import WeakKeyDictionary

from app.errors import UserError
from app.scenes.cpu_rendering import Draw, DrawOptions
from app.scenes.scene import Scene
from renderer.camera import Camera
from renderer.model_windows import ModelWindow, window_at, windows_of
from renderer.rasterize.rendered import Rendered
from renderer.splats import Splats
from renderer.surface.fineness import AS_IT_COMES, Fineness
from renderer.surface.mesh import Mesh

if TYPE_CHECKING:
    from renderer.surface.following import Follower


MOST_FOLLOWED: Final = 4
"""Windows, or finenesses, of a scene whose surface can be followed at once: each holds the motion of its
window."""
MOST_MESHES: Final = 256
"""Moments of a scene whose surface is kept: half a megabyte each."""


@dataclass
class _Known:
    """What has been worked out of a scene."""

    followers: dict[tuple[Fineness, int], Follower] = field(default_factory=dict)
    """By window."""
    meshes: dict[float, Mesh] = field(default_factory=dict)
    """By time, the oldest first."""


_known: Final[WeakKeyDictionary[Scene, _Known]] = WeakKeyDictionary()
"""It goes with its scene: a window opens many."""


def surface(scene: Scene, fineness: Fineness = AS_IT_COMES) -> Follower:
    """One mesh for all of the clip. Takes a second or less.

    Raises:
        UserError: there is none, it cannot be simplified here, or its Gaussians are others at other times.
    """
    scene.require_one_model()
    return surface_of_window(scene, window_at(scene.model, 0.0), fineness)


def surface_of_window(scene: Scene, window: ModelWindow, fineness: Fineness) -> Follower:
    """The same of a window of the scene's model, by the clock of that window. Raises UserError: there is
    none, it cannot be simplified here, or nothing says what moves where."""
    follower = _follower(scene, fineness, window)
    if not len(follower.mesh.faces):
        raise UserError(_missing(scene, window))
    return follower


def moment_of_surface(scene: Scene, time: float, fineness: Fineness) -> Mesh:
    """Of the window that shows most at a time in [0, 1], at that time. Raises UserError as
    `surface_of_window`."""
    window = window_at(scene.model, time)
    return surface_of_window(scene, window, fineness).at(window.local(time))


def surface_at(scene: Scene, time: float) -> Mesh:
    """The same as it comes, remembered; of no faces where nothing is left of a scene. Raises UserError: it
    cannot be worked out."""
    window = window_at(scene.model, time)
    follower, meshes = _follower(scene, AS_IT_COMES, window), _known[scene].meshes
    if not len(follower.mesh.faces):
        return follower.mesh
    if time not in meshes:
        if len(meshes) == MOST_MESHES:
            del meshes[next(iter(meshes))]
        meshes[time] = follower.at(window.local(time))
    return meshes[time]


def _missing(scene: Scene, window: ModelWindow) -> str:
    """Why there is no surface, and in a model in windows at which frames."""
    name, where, why = scene.name, "", "covers nothing of what its cameras see"
    if len(windows_of(scene.model)) > 1:
        frames = window.frames(len(scene.cameras))
        where = f" in window {window.index + 1}, frames {frames[0]} to {frames[-1]}"
        if not len(window):
            return f"expected a surface{where}, got none: the window is empty; maybe all was removed: {name}"
    return f"expected a surface{where}, got none: {name} {why}"


def _follower(scene: Scene, fineness: Fineness, window: ModelWindow) -> Follower:
    scene.require_same_tissue()
    followers = _known.setdefault(scene, _Known()).followers
    key = fineness, window.index
    if key not in followers:
        if len(followers) == MOST_FOLLOWED:
            del followers[next(iter(followers))]
        followers[key] = _made(scene, fineness, window)
    return followers[key]


def _made(scene: Scene, fineness: Fineness, window: ModelWindow) -> Follower:
    # Its kernels take seconds to import on a first start; the window must not wait for them.
    from renderer.surface.of_model import surface_of

    frames = window.frames(len(scene.cameras))
    cameras = scene.cameras[frames.start : frames.stop]
    try:
        return surface_of(window.model, cameras, scene.near, scene.mode, fineness)
    except RuntimeError as error:
        raise UserError(str(error)) from error


def drawing_surface(scene: Scene, time: float) -> Draw:
    """Draws it at that time, whatever splats are asked for. Raises UserError as `surface_at`."""
    mesh = surface_at(scene, time)

    def draw(splats: Splats, camera: Camera, options: DrawOptions) -> Rendered:
        from renderer.surface.triangles import render_mesh

        return render_mesh(mesh, camera, options.near)

    return draw
