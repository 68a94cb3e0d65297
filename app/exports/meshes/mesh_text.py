"""One moment of a surface as PLY or OBJ, in the clip's own unit and axes, as its splat files are."""

from __future__ import annotations

import io
from collections.abc import Callable, Iterator, Mapping
from typing import Any, Final

import numpy as np

from app.files.embedded import KEYWORD
from app.files.provenance import ascii_json, comments
from renderer.ply_comments import START, split
from renderer.surface.mesh import Mesh

AXES: Final = "x right, y down, z forward"
VERTEX: Final = np.dtype(
    [(name, "<f4") for name in ("x", "y", "z", "nx", "ny", "nz")]
    + [(name, "u1") for name in ("red", "green", "blue")]
)
FACE: Final = np.dtype([("count", "u1"), ("corners", "<i4", 3)])


def mesh_ply(mesh: Mesh, unit: str, facts: Mapping[str, Any]) -> bytes:
    """Binary, with normals and colours of 8 bits."""
    vertices, faces = np.zeros(len(mesh.vertices), VERTEX), np.zeros(len(mesh.faces), FACE)
    values = np.concatenate([mesh.vertices, mesh.normals], axis=1)
    for place, name in enumerate(("x", "y", "z", "nx", "ny", "nz")):
        vertices[name] = values[:, place]
    colors = np.rint(mesh.colors.clip(0, 1) * 255)
    for place, name in enumerate(("red", "green", "blue")):
        vertices[name] = colors[:, place]
    faces["count"], faces["corners"] = 3, mesh.faces
    head = [
        "ply", "format binary_little_endian 1.0",
        *(f"{START}{line}" for line in (f"unit {unit}", f"axes {AXES}", *comments(facts))),
        f"element vertex {len(vertices)}",
        *(f"property {'uchar' if kind.itemsize == 1 else 'float'} {name}"
          for name, kind in ((name, VERTEX[name]) for name in VERTEX.names or ())),
        f"element face {len(faces)}", "property list uchar int vertex_indices", "end_header", "",
    ]  # fmt: skip
    return "\n".join(head).encode("ascii", "replace") + vertices.tobytes() + faces.tobytes()


def mesh_obj(mesh: Mesh, unit: str, facts: Mapping[str, Any]) -> bytes:
    """With colours behind the coordinates, as MeshLab and Blender read them."""
    text = io.StringIO()
    for line in (f"unit {unit}", f"axes {AXES}", *split(KEYWORD, ascii_json(facts))):
        text.write(f"# {line}\n")
    rows = np.concatenate([mesh.vertices, mesh.colors.clip(0, 1)], axis=1)
    np.savetxt(text, rows, "v %.9g %.9g %.9g %.4f %.4f %.4f")
    np.savetxt(text, mesh.normals, "vn %.5f %.5f %.5f")
    np.savetxt(text, np.repeat(mesh.faces + 1, 2, axis=1), "f %d//%d %d//%d %d//%d")
    return text.getvalue().encode()


def obj_comments(content: bytes) -> tuple[str, ...]:
    """The lines before the first vertex."""
    head = content[: content.find(b"\nv ")].decode("ascii", "replace")
    return tuple(line[2:] for line in head.splitlines() if line.startswith("# "))


def obj_rows(content: bytes) -> Iterator[np.ndarray[tuple[int, int], np.dtype[np.float64]]]:
    """(V, 6) vertices with their colours, (V, 3) normals and (F, 6) corners, each a vertex and its normal.
    Raises ValueError for others than these."""
    lines = content.decode("ascii", "replace").splitlines()
    for kind, columns in (("v", 6), ("vn", 3), ("f", 6)):
        start = f"{kind} "
        rows = [line[len(start) :].replace("//", " ").split() for line in lines if line.startswith(start)]
        yield np.array(rows, np.float64).reshape(len(rows), columns)


MOMENTS: Final[Mapping[str, Callable[[Mesh, str, Mapping[str, Any]], bytes]]] = {
    ".ply": mesh_ply,
    ".obj": mesh_obj,
}
"""By suffix."""
