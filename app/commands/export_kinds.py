"""What `vesselsplat export` writes: a row for each of its flags that name a file or a folder."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

from app.exports.splats import fourdgs
from app.exports.splats.writing import COMPRESSED

SEEN: Final = ("camera", "size")
"""What shows the model to a camera heeds them."""
LIKE_SPLATS: Final = ("sh_degree", "without_unobserved")


@dataclass(frozen=True)
class Kind:
    """One export."""

    text: str
    """In the help."""
    metavar: str = "FILE"
    suffix: str = ""
    """Of its file, or of each file in its folder; empty: it has several formats."""
    is_whole: bool = False
    """It always holds all of the clip, as a mesh does in one file."""
    is_of_tissue: bool = True
    """It shows one tissue as it moves, which a model of other Gaussians at every moment does not."""
    heeds: tuple[str, ...] = ()
    """Other flags that apply to it."""

    @property
    def is_splat_folder(self) -> bool:
        return self.metavar == "DIR"


def _splats(suffix: str, text: str) -> Kind:
    """A folder of splat files."""
    return Kind(text, "DIR", suffix, is_of_tissue=False, heeds=LIKE_SPLATS)


KINDS: Final[Mapping[str, Kind]] = {
    "ply": _splats(".ply", "one numbered splat file per frame, as viewers play them"),
    "compressed_ply": _splats(
        COMPRESSED, "the same as PLY of 16 bytes per Gaussian, for PlayCanvas and SuperSplat"
    ),
    "spz": _splats(
        ".spz", "the same as SPZ 3, a third as large or less: sizes to 3 %%; a JSON file beside each"
    ),
    "spz4": _splats(".v4.spz", "the same as SPZ 4, for newer programs, a little smaller"),
    "sog": _splats(
        ".sog", "the same as SOG, for PlayCanvas and SuperSplat: 8 bits a value; a JSON file beside each"
    ),
    "glb": _splats(".glb", "the same as glTF, in metres, by its extension KHR_gaussian_splatting"),
    "usd": Kind(
        "the Gaussians through the clip as one .usdc file: USD's 3D Gaussian splats, time-sampled",
        suffix=".usdc", is_whole=True, heeds=("without_unobserved",),
    ),
    "4dgs": Kind(
        "the same as one .4dgs file, half as large, rounded (needs fourdgs); a JSON file beside it",
        suffix=fourdgs.SUFFIX, is_whole=True, heeds=("without_unobserved",),
    ),
    "mesh": Kind(
        "the tissue surface: as glTF or USD with one topology that moves through the clip, or a folder "
        "with a mesh per frame",
        "FILE.glb|FILE.usdc|DIR", heeds=("mesh_format", "vertices", "faces"),
    ),
    "video": Kind(
        "the frames as a video, with a JSON file beside it", is_of_tissue=False,
        heeds=(*SEEN, "supersampling", "background", "unobserved", "view", "renderer"),
    ),
    "html": Kind(
        "the model over time as one page that any browser plays, without a network; it opens as "
        "--camera sees it (default the first frame's)",
        suffix=".html", is_whole=True, heeds=(*SEEN, "unobserved"),
    ),
    "npz": Kind(
        "Gaussians at each moment, depth and cameras as numpy arrays, with a README inside",
        suffix=".npz", heeds=(*SEEN, "renderer"),
    ),
    "tracks": Kind(
        "where the surface behind --points goes, as .csv; a JSON file beside it",
        suffix=".csv", heeds=SEEN,
    ),
    "cameras": Kind(
        "the poses as cameras.json", "FILE|DIR", is_of_tissue=False, heeds=(*SEEN, "cameras_format")
    ),
}  # fmt: skip
"""By the name of the flag, in the order of the help."""
