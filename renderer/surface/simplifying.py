"""Fewer faces: quadric edge collapse (Garland and Heckbert, SIGGRAPH 1997) by fast-simplification."""

from __future__ import annotations

import numpy as np

from renderer.surface.mesh import Mesh

NO_SIMPLIFICATION = "simplifying a surface needs fast-simplification: pip install fast-simplification"


def simplified(mesh: Mesh, faces: int) -> Mesh:
    """At most about so many faces; as it is where it has no more. Colours are to be read anew.

    Raises:
        RuntimeError: the package is not there.
    """
    if len(mesh.faces) <= faces:
        return mesh
    try:
        import fast_simplification
    except ImportError as error:
        raise RuntimeError(NO_SIMPLIFICATION) from error
    vertices, triangles = fast_simplification.simplify(mesh.vertices, mesh.faces, target_count=faces)
    colors = np.full(vertices.shape, 0.5, np.float32)
    return Mesh(vertices.astype(np.float32), triangles.astype(np.int32), colors)
