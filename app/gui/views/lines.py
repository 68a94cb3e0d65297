"""Lines of the world as a camera sees them."""

from __future__ import annotations

import numpy as np

from renderer.camera import Camera, FloatArray


def frustum(camera: Camera, depth: float) -> FloatArray:
    """(9, 2, 3) segments in the world: from a camera's eye to the corners of its picture, `depth` before it,
    the edges of that, and a tick at its top."""
    left, right = -camera.cx / camera.fx, (camera.width - camera.cx) / camera.fx
    top, bottom = -camera.cy / camera.fy, (camera.height - camera.cy) / camera.fy
    middle, tip = (left + right) / 2, top - (bottom - top) / 4
    eye = (0.0, 0.0, 0.0)
    corners = [(x, y, 1.0) for x, y in ((left, top), (right, top), (right, bottom), (left, bottom))]
    edges = zip(corners, (*corners[1:], corners[0]), strict=True)
    tick = ((middle, top, 1.0), (middle, tip, 1.0))
    local = np.array([*((eye, corner) for corner in corners), *edges, tick])
    pose = camera.world_from_camera
    return np.asarray(depth * local @ pose[:3, :3].T + pose[:3, 3])


def seen(camera: Camera, segments: FloatArray, near: float) -> FloatArray:
    """(M, 2, 2) pixel positions of those of (N, 2, 3) segments that reach beyond `near` > 0, cut off there.

    `near` is in scene units along the camera's axis.
    """
    local = segments @ camera.camera_from_world[:3, :3].T + camera.camera_from_world[:3, 3]
    local = local[(local[..., 2] > near).any(axis=1)]
    depths = local[..., 2]
    behind = depths < near
    rise = np.where(behind.any(axis=1), depths[:, 1] - depths[:, 0], 1.0)
    share = ((near - depths[:, 0]) / rise)[:, None]
    crossing = local[:, 0] + share * (local[:, 1] - local[:, 0])
    local = np.where(behind[..., None], crossing[:, None], local)
    focal, middle = np.array([camera.fx, camera.fy]), np.array([camera.cx, camera.cy])
    return np.asarray(focal * local[..., :2] / local[..., 2:] + middle)
