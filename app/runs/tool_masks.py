"""Which tool masks a reconstruction leaves out: those in a folder, of which a run keeps a copy."""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Final

from pydantic import ConfigDict
from pydantic.dataclasses import dataclass

from app.enhancement.settable import PathText, at_most
from app.files.atomic import filled
from renderer.clip import Clip, ClipError
from renderer.tools.mask_files import MaskFiles, digest_of, masks_in, with_tool_masks

FOLDER: Final = "tool-masks"
"""Of a run's own copies, in its folder."""


@dataclass(frozen=True, kw_only=True, config=ConfigDict(extra="forbid"))
class ToolMasks:
    """Masks of a clip's tools, an image a frame; frames without one are searched as ever."""

    folder: PathText
    """Of a run's own copies relative to the run, in its file."""
    sha256: Annotated[str, at_most(64)] | None = None
    """Of a run's own copies, numbered by the frames of the whole clip; None: they are a person's, named as
    the frames."""

    def files(self, clip: Clip) -> MaskFiles:
        """Of the whole clip. Raises ClipError: they are not there, or belong to no frame."""
        folder = Path(self.folder)
        if self.sha256 is None:
            return masks_in(folder, clip.labels)
        if not folder.is_dir():
            raise ClipError(f"expected the run's tool masks, got no such folder: {folder}")
        numbered = {int(path.stem): path for path in folder.glob("*.png") if path.stem.isdecimal()}
        return MaskFiles(folder, numbered)

    def of(self, clip: Clip) -> Clip:
        """The whole clip without these tools. Raises ClipError, also when a frame is read."""
        return with_tool_masks(clip, self.files(clip))

    def digest(self, clip: Clip) -> str:
        """Raises ClipError or OSError."""
        return self.sha256 or digest_of(self.files(clip).files)

    @property
    def of_anywhere(self) -> ToolMasks:
        """Without the folders above."""
        return replace(self, folder=Path(self.folder).name)

    def kept_in(self, run: Path) -> ToolMasks:
        """The run's own, as read from its file."""
        return replace(self, folder=str(run / self.folder))


def keep_copies(masks: ToolMasks, clip: Clip, run: Path) -> None:
    """In the run's folder, all or none of them, unless they are there. Raises ClipError or OSError."""
    if (run / FOLDER).is_dir():
        return
    found = masks.files(clip).files
    with filled(run / FOLDER) as staging:
        for index, path in found.items():
            shutil.copyfile(path, staging / f"{index:06d}.png")
