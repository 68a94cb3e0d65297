"""What can be exported, in words; each with the name that its files begin with."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final, Literal, get_args

from app.exports.camera_set import ENDINGS
from app.files.codecs import HEVC, MP4, WEBM
from app.gui.state.exports import What
from app.gui.views.comparison import SIDES, Side

Form = Literal[
    "picture", "DICOM still", "panes video", "view video", "DICOM video", "measures", "splats",
    "splat folder", "moving splats", "browser model", "surface mesh", "surface folder", "model arrays",
    "tracks", "cameras",
]  # fmt: skip
Group = Literal["Image", "Video", "Measures", "3D model"]
GROUPS: Final[tuple[Group, ...]] = get_args(Group)


@dataclass(frozen=True)
class Traits:
    """What all exports of one form have in common."""

    group: Group
    formats: Mapping[str, str]
    """By suffix, in words; the first unless another is chosen."""
    format_text: str = ""
    """What is said of the choice, where there is one."""
    is_folder: bool = False
    """Of files that have the suffix each."""
    is_of_tissue: bool = False
    """It says where tissue goes, which a splat file per moment does not."""
    plays: bool = False
    """One file of the reconstruction that plays as fast as the clip."""


SPLATS: Final = {
    ".ply": "PLY, exact",
    ".compressed.ply": "Compressed PLY (PlayCanvas)",
    ".spz": "SPZ (Niantic)",
    ".v4.spz": "SPZ 4 (Niantic), smaller",
    ".sog": "SOG (PlayCanvas)",
    ".glb": "glTF (Khronos), in metres",
}
SPLATS_TEXT: Final = "What the viewer reads. All but PLY and glTF are a third as large or less, and rounded."
CODED: Final = {MP4: "MP4, H.264", WEBM: "WebM, VP9", HEVC: "MP4, HEVC"}
CODED_TEXT: Final = "Which programs play the video, and how large it is."
FORMS: Final[Mapping[Form, Traits]] = {
    "picture": Traits(
        "Image", {".png": "PNG, lossless", ".tiff": "TIFF, lossless", ".jpg": "JPEG"},
        "Each format records how the image was made. JPEG files are smaller, and lose detail.",
    ),
    "DICOM still": Traits("Image", {".dcm": "DICOM"}),
    "panes video": Traits("Video", CODED, CODED_TEXT),
    "view video": Traits("Video", CODED, CODED_TEXT),
    "DICOM video": Traits("Video", {".dcm": "DICOM"}),
    "measures": Traits("Measures", {".csv": "CSV"}),
    "splats": Traits("3D model", SPLATS, SPLATS_TEXT),
    "splat folder": Traits("3D model", SPLATS, SPLATS_TEXT, is_folder=True),
    "moving splats": Traits(
        "3D model", {".usdc": "USD, exact", ".4dgs": "4DGS, half as large"},
        "USD holds the model as it is. 4DGS rounds it, and leaves out colours by direction.",
        is_of_tissue=True, plays=True,
    ),
    "browser model": Traits("3D model", {".html": "HTML"}, is_of_tissue=True, plays=True),
    "surface mesh": Traits(
        "3D model", {".glb": "glTF, in metres", ".usdc": "USD, in the clip's unit"},
        "Both hold one mesh that moves.", is_of_tissue=True, plays=True,
    ),
    "surface folder": Traits(
        "3D model", {".ply": "PLY", ".obj": "OBJ"}, "PLY holds colours as bytes, OBJ is text.",
        is_folder=True, is_of_tissue=True,
    ),
    "model arrays": Traits("3D model", {".npz": "NPZ"}, is_of_tissue=True),
    "tracks": Traits("3D model", {".csv": "CSV"}, is_of_tissue=True),
    "cameras": Traits(
        "3D model",
        {
            ENDINGS["splatting"]: "cameras.json (3D Gaussian Splatting)",
            ENDINGS["transforms"]: "transforms.json (NeRF), with times",
            ENDINGS["colmap"]: "COLMAP, a folder",
        },
        "For whichever program reads it next.",
    ),
}  # fmt: skip
ONE_COLOR: Final = (".4dgs", ".html")
"""Formats that hold one colour a Gaussian, not colours by direction."""


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
    def traits(self) -> Traits:
        return FORMS[self.form]

    @property
    def is_of_model(self) -> bool:
        """Of the reconstruction alone."""
        return self.traits.group == "3D model"

    @property
    def is_dicom(self) -> bool:
        """Of the enhanced frames alone."""
        return ".dcm" in self.traits.formats

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
        "3D view", "picture", "The 3D view as shown, and the second view where there is one.",
        "3d-view", sees="still",
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
        "3D through time", "view video",
        "The 3D view through the clip, and the second view where there is one.",
        "through-time", sees="time",
    ),
    "video along the path": Offer(
        "3D along the path", "view video",
        "The 3D view along the camera path, and the second view where there is one.",
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
