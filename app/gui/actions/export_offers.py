"""What can be exported, in words; each with the name that its files begin with."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, Literal

from app.exports.camera_set import ENDINGS
from app.files.codecs import HEVC, MP4, WEBM
from app.gui.state.exports import What
from app.gui.views.comparison import SIDES, Side

Form = Literal[
    "picture", "DICOM still", "panes video", "view video", "DICOM video", "measures", "splats",
    "splat folder", "moving splats", "browser model", "surface mesh", "surface folder", "model arrays",
    "tracks", "cameras",
]  # fmt: skip
OF_MODEL: Final[tuple[Form, ...]] = (
    "splats",
    "splat folder",
    "moving splats",
    "browser model",
    "surface mesh",
    "surface folder",
    "model arrays",
    "tracks",
    "cameras",
)
"""Of the reconstruction alone."""
OF_TISSUE: Final[tuple[Form, ...]] = (
    "moving splats",
    "browser model",
    "surface mesh",
    "model arrays",
    "surface folder",
    "tracks",
)
"""Of one that says where tissue goes: a splat file per moment does not."""
THROUGH_TIME: Final[tuple[Form, ...]] = ("moving splats", "browser model", "surface mesh")
"""One file that plays as fast as the clip."""
DICOM: Final[tuple[Form, ...]] = ("DICOM still", "DICOM video")
"""Of the enhanced frames alone."""
VIDEOS: Final[tuple[Form, ...]] = ("panes video", "view video", "DICOM video")


@dataclass(frozen=True)
class Offer:
    """One kind of export, in words."""

    label: str
    form: Form
    text: str
    name: str = ""
    """What it is, in the name of its file."""
    sides: tuple[Side, ...] = ()
    as_shown: bool = False
    """The panes as the mode of comparison sets them against each other."""
    sees: Literal["no", "still", "time", "path"] = "no"
    """What is made of the 3D view."""

    @property
    def within(self) -> str:
        """The label behind other words."""
        return self.label if self.label[1].isupper() else f"{self.label[0].lower()}{self.label[1:]}"


OFFERS: Final[dict[What, Offer]] = {
    "panes and 3D view": Offer(
        "All as shown", "picture", "The panes as shown and the 3D view, on one page. S saves it as PNG.", "",
        SIDES, True, "still",
    ),
    "panes as shown": Offer(
        "Panes as shown", "picture", "Side by side, wipe, one pane, or the difference.", "panes", SIDES, True
    ),
    "left pane": Offer("Left pane", "picture", "What the left side shows.", "left", ("left",)),
    "right pane": Offer("Right pane", "picture", "What the right side shows.", "right", ("right",)),
    "both panes": Offer("Both panes", "picture", "Side by side, whatever the mode.", "both", SIDES),
    "3D view": Offer(
        "3D view", "picture", "The 3D view as shown, with the second one.", "3d-view", sees="still"
    ),
    "window": Offer(
        "Whole window", "picture",
        "The window as it is on screen, without this panel: also by F12. It cannot be replayed.", "window",
    ),
    "enhanced frame": Offer(
        "Enhanced frame (DICOM)", "DICOM still",
        "The frame enhanced as set in the Enhancement panel, at its own size, as a VL Endoscopic Image for "
        "archives (PACS). It does not identify the patient unless you choose so.",
        "enhanced",
    ),
    "video of the panes": Offer(
        "Panes as shown", "panes video", "Every frame from In to Out, compared as on screen.", "panes",
        SIDES, True,
    ),
    "video of the right pane": Offer(
        "Right pane", "panes video", "Every frame from In to Out, of what the right side shows.", "right",
        ("right",),
    ),
    "video of both panes": Offer(
        "Both panes", "panes video", "Every frame from In to Out, side by side.", "both", SIDES
    ),
    "enhanced clip": Offer(
        "Enhanced clip (DICOM)", "DICOM video",
        "All frames enhanced as set in the Enhancement panel, as a Video Endoscopic Image for archives "
        "(PACS). It does not identify the patient unless you choose so.",
        "enhanced",
    ),
    "video through time": Offer(
        "3D through time", "view video", "The 3D view as shown, and the second one, through the clip.",
        "through-time", sees="time",
    ),
    "video along the path": Offer(
        "3D along the path", "view video", "The 3D view, and the second one, along the camera path.",
        "along-path", sees="path",
    ),
    "measures of both panes": Offer(
        "Table of both panes", "measures",
        "DV/BV, contrast, noise and more, from In to Out: CSV, and the same as JSON beside it.", "measures",
        SIDES,
    ),
    "splats of this moment": Offer(
        "Splat file, this moment", "splats",
        "The reconstruction as it is now: its Gaussians as PLY, SPZ, SOG or glTF, for viewers and other "
        "programs.",
        "splats",
    ),
    "splats of all frames": Offer(
        "Splat files, all frames", "splat folder",
        "A folder with a splat file per frame, as PLY, SPZ, SOG or glTF.", "splats",
    ),
    "splats through time": Offer(
        "Splat file that moves", "moving splats",
        "The reconstruction through the clip as one splat file: USD, or 4DGS.",
        "moving-splats",
    ),
    "page for browsers": Offer(
        "Page for browsers (HTML)", "browser model",
        "The reconstruction through time as one file that any browser plays, without a network: to send to "
        "others. It begins at the clip's camera.", "model",
    ),
    "surface through time": Offer(
        "Surface that moves", "surface mesh",
        "The tissue surface through time as glTF or USD, which 3D programs play: one mesh that moves.",
        "surface",
    ),
    "surface of all frames": Offer(
        "Surfaces, all frames", "surface folder",
        "A folder with a mesh of the tissue surface per frame, as PLY or OBJ, in the clip's unit.",
        "surfaces",
    ),
    "arrays of all frames": Offer(
        "Arrays for research (NPZ)", "model arrays",
        "Gaussians, depth and cameras of every frame as numpy arrays, with a README inside.", "arrays",
    ),
    "tracks of the measured points": Offer(
        "Tracks of measured points", "tracks",
        "Where the points of the measurement (M) go through the clip, by the model's motion: CSV, a row for "
        "each point and frame.",
        "tracks",
    ),
    "cameras of the clip": Offer(
        "Cameras of the clip", "cameras",
        "The camera of each frame for other programs: cameras.json, transforms.json or COLMAP's text model.",
        "cameras",
    ),
    "cameras of the path": Offer(
        "Cameras of the path", "cameras",
        "The cameras along the camera path for other programs, in the same formats.",
        "path-cameras", sees="path",
    ),
}  # fmt: skip
GROUPS: Final[tuple[tuple[str, tuple[Form, ...]], ...]] = (
    ("Image", ("picture", "DICOM still")), ("Video", VIDEOS), ("Measures", ("measures",)),
    ("3D model", OF_MODEL),
)  # fmt: skip
SPLATS: Final = {
    ".ply": "PLY, exact",
    ".compressed.ply": "Compressed PLY (PlayCanvas)",
    ".spz": "SPZ (Niantic)",
    ".v4.spz": "SPZ 4 (Niantic), smaller",
    ".sog": "SOG (PlayCanvas)",
    ".glb": "glTF (Khronos), in metres",
}
CODED: Final = {MP4: "MP4, H.264", WEBM: "WebM, VP9", HEVC: "MP4, HEVC"}
FORMATS: Final[dict[Form, dict[str, str]]] = {
    "picture": {".png": "PNG, lossless", ".tiff": "TIFF, lossless", ".jpg": "JPEG"},
    "DICOM still": {".dcm": "DICOM"},
    "DICOM video": {".dcm": "DICOM"},
    "panes video": CODED,
    "view video": CODED,
    "measures": {".csv": "CSV"},
    "splats": SPLATS,
    "splat folder": SPLATS,
    "moving splats": {".usdc": "USD, exact", ".4dgs": "4DGS, half as large"},
    "browser model": {".html": "HTML"},
    "surface mesh": {".glb": "glTF, in metres", ".usdc": "USD, in the clip's unit"},
    "surface folder": {".ply": "PLY", ".obj": "OBJ"},
    "model arrays": {".npz": "NPZ"},
    "tracks": {".csv": "CSV"},
    "cameras": {
        ENDINGS["splatting"]: "cameras.json (3D Gaussian Splatting)",
        ENDINGS["transforms"]: "transforms.json (NeRF), with times",
        ENDINGS["colmap"]: "COLMAP, a folder",
    },
}
"""By suffix, in words; the first unless another is chosen."""
ONE_COLOR: Final = (".4dgs", ".html")
"""Formats that hold one colour a Gaussian, not colours by direction."""
FOLDERS: Final[tuple[Form, ...]] = ("splat folder", "surface folder")
"""Of which each file has that suffix."""
