"""What an export cannot heed: flags without effect on its files, and places among the model's own files."""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Final

from app.commands.outside import require_no_overwriting, require_outside
from app.commands.view_selection import Moment
from app.errors import UserError
from app.exports.meshes.writing import CLIPS
from app.exports.splats import fourdgs
from app.exports.splats.writing import COMPRESSED
from app.scenes.scene import Scene
from renderer.listing import listed
from renderer.surface.fineness import VERTICES

FOLDERS: Final[Mapping[str, tuple[str, str]]] = MappingProxyType(
    {
        "ply": (".ply", "one numbered splat file per frame, as viewers play them"),
        "compressed_ply": (
            COMPRESSED,
            "the same as PLY of 16 bytes per Gaussian, for PlayCanvas and SuperSplat",
        ),
        "spz": (
            ".spz",
            "the same as SPZ 3, a third as large or less: sizes to 3 %%; a JSON file beside each",
        ),
        "spz4": (".v4.spz", "the same as SPZ 4, for newer programs, a little smaller"),
        "sog": (
            ".sog",
            "the same as SOG, for PlayCanvas and SuperSplat: 8 bits a value; a JSON file beside each",
        ),
        "glb": (".glb", "the same as glTF, in metres, by its extension KHR_gaussian_splatting"),
    }
)
"""How the splat files in each end, and what is said of it."""
FILES: Final = ("usd", "fourdgs", "mesh", "video", "html", "npz", "tracks", "cameras")
WHOLE: Final = ("usd", "fourdgs", "html")
"""Hold all of the clip, as does a mesh in one file."""
SUFFIXES: Final[Mapping[str, str]] = MappingProxyType(
    {"usd": ".usdc", "fourdgs": fourdgs.SUFFIX, "html": ".html", "npz": ".npz", "tracks": ".csv"}
)
"""Of files that have one format."""
MOMENTS: Final = ("frames", "time", "path")
HEEDED: Final[Mapping[str, tuple[object, tuple[str, ...]]]] = MappingProxyType(
    {
        "camera": (None, ("video", "html", "npz", "tracks", "cameras")),
        "size": (None, ("video", "html", "npz", "tracks", "cameras")),
        "sh_degree": (None, tuple(FOLDERS)),
        "supersampling": (1, ("video",)),
        "background": ("grey", ("video",)),
        "without_unobserved": (False, (*FOLDERS, "usd", "fourdgs")),
        "unobserved": (False, ("video", "html")),
        "view": ("color", ("video",)),
        "mesh_format": ("ply", ("mesh",)),
        "vertices": (VERTICES, ("mesh",)),
        "faces": (None, ("mesh",)),
        "cameras_format": ("splatting", ("cameras",)),
        "renderer": ("cpu", ("video", "npz")),
    }
)
"""Of each flag what it is where it is not given, and the exports that it applies to."""
SPELLED: Final[Mapping[str, str]] = MappingProxyType({"fourdgs": "4dgs", "renderer": "with"})


def outputs(flags: argparse.Namespace) -> Iterator[tuple[str, Path]]:
    """The flag and the path of each export that is asked for."""
    for name in (*FOLDERS, *FILES):
        if (path := getattr(flags, name)) is not None:
            yield name, path


def check(flags: argparse.Namespace) -> None:
    """Raises UserError: nothing is asked for, a file whose name is of another format, or a flag without
    effect."""
    asked = dict(outputs(flags))
    if not asked:
        files = (f"{flag(one)} {'FILE|DIR' if one in ('mesh', 'cameras') else 'FILE'}" for one in FILES)
        *most, last = (*(f"{flag(one)} DIR" for one in FOLDERS), *files)
        raise UserError(f"expected what to export: {', '.join(most)} or {last}")
    for name, suffix in SUFFIXES.items():
        if name in asked and asked[name].suffix.lower() != suffix:
            kind = f"an {suffix}" if suffix == ".html" else f"a {suffix}"
            raise UserError(f"{flag(name)}: expected the name of {kind} file, got {asked[name].name}")
    whole = [name for name, path in asked.items() if name in WHOLE or _is_film(name, path)]
    for name in MOMENTS:
        if whole and getattr(flags, name) is not None:
            raise UserError(
                f"{flag(name)}: {flag(whole[0])} holds all of the clip; export it without this flag"
            )
    for name, (absent, heeding) in HEEDED.items():
        if getattr(flags, name) != absent and not set(heeding) & set(asked):
            which = listed([flag(one) for one in heeding])
            raise UserError(f"{flag(name)}: expected an export that it applies to, such as {which}")
    if flags.frames_per_second is not None and flags.path is None and not goes_through_time(flags):
        raise UserError("--frames-per-second: expected an export through time, such as --video, or --path")


def require_apart(flags: argparse.Namespace, scene: Scene) -> None:
    """Raises UserError: a place among the files that the scene is made of, or that it is itself."""
    for name, path in outputs(flags):
        require_outside(flag(name), path, scene)
        require_no_overwriting(flag(name), path, scene)


def goes_through_time(flags: argparse.Namespace) -> bool:
    """Whether any of what is asked for plays at a speed: a file of all of the clip, or a video."""
    return any(name in (*WHOLE, "video") or _is_film(name, path) for name, path in outputs(flags))


def require_one_camera(flags: argparse.Namespace, wanted: Sequence[Moment]) -> None:
    """Raises UserError: a page is asked for, of several cameras."""
    # Frames are seen by one camera, several cameras at one moment.
    if flags.html and flags.camera and len(wanted) > 1 and wanted[0].frame is None:
        raise UserError(f"--html: expected one --camera, got {len(wanted)}: {flags.camera}")


def require_movement(flags: argparse.Namespace, scene: Scene) -> None:
    """Raises UserError: what shows one tissue as it moves is asked for, of other models."""
    if any(name not in (*FOLDERS, "video", "cameras") for name, _ in outputs(flags)):
        scene.require_same_tissue()


def flag(name: str) -> str:
    """As it is typed."""
    return f"--{SPELLED.get(name, name).replace('_', '-')}"


def _is_film(name: str, path: Path) -> bool:
    return name == "mesh" and path.suffix.lower() in CLIPS
