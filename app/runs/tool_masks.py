"""Which tool masks a reconstruction leaves out: those in a folder, of which a run keeps copies."""

from __future__ import annotations

import shutil
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Annotated, Final

from pydantic import ConfigDict
from pydantic.dataclasses import dataclass

from app.enhancement.settable import PathText, at_most
from app.files.atomic import filled
from renderer.clip import Clip, ClipError
from renderer.tools.mask_files import MaskFiles, digest_of, masks_in, read_all, save_mask, with_tool_masks
from renderer.tools.polarity import with_doubt

FOLDER: Final = "tool-masks"
"""Of a run's own copies, in its folder."""


@dataclass(frozen=True, kw_only=True, config=ConfigDict(extra="forbid"))
class ToolMasks:
    """Masks of a clip's tools, an image a frame; frames without one are searched as ever."""

    folder: PathText
    """Of a run's own copies relative to the run, in its file."""
    sha256: Annotated[str, at_most(64)] | None = None
    """Of copies, numbered by the frames of the whole clip; None: they are a person's, named as the frames."""

    def files(self, clip: Clip) -> MaskFiles:
        """Of the whole clip. Raises ClipError: they are not there, or belong to no frame."""
        folder = Path(self.folder)
        if self.sha256 is None:
            return masks_in(folder, clip.labels)
        if not folder.is_dir():
            raise ClipError(f"expected the run's tool masks, got no such folder: {folder}")
        numbered = {int(path.stem): path for path in folder.glob("*.png") if path.stem.isdecimal()}
        return MaskFiles(folder, numbered)

    def told(self, clip: Clip) -> Clip:
        """The whole clip, whose notices say how a person's masks were paired with it, and whether they look
        inverted. Raises ClipError."""
        return replace(clip, notices=(*clip.notices, *with_doubt(self.files(clip), clip).notices))

    def of(self, clip: Clip) -> Clip:
        """The whole clip without these tools; their files are looked for when a frame is read, which raises
        ClipError where they are not there."""
        return with_tool_masks(clip, cache(lambda: self.files(clip)))

    def digest(self, clip: Clip) -> str:
        """Of what they mask, however it is stored. Raises ClipError."""
        return self.sha256 or digest_of(read_all(self.files(clip), clip))

    def require_unchanged(self, clip: Clip) -> None:
        """Of a run's own copies. Raises ClipError: some of them are lost, new or other ones."""
        files = self.files(clip)
        is_whole = max(files.files, default=0) < len(clip)
        if not is_whole or digest_of(read_all(files, clip)) != self.sha256:
            wanted = "expected the tool masks that the run began with"
            raise ClipError(f"{wanted}, got lost or changed ones: {self.folder}")

    @property
    def of_anywhere(self) -> ToolMasks:
        """Without the folders above."""
        return replace(self, folder=Path(self.folder).name)

    def kept_in(self, run: Path) -> ToolMasks:
        """The run's own, as read from its file."""
        return replace(self, folder=str(run / self.folder))

    def copied(self, clip: Clip, place: Path) -> ToolMasks:
        """Copies that stay as they are while a person goes on with the masks. Raises ClipError or OSError."""
        files = self.files(clip)
        for index, mask in read_all(files, clip):
            save_mask(place / f"{index:06d}.png", mask)
        own = ToolMasks(folder=str(place), sha256="")
        return replace(own, sha256=digest_of(read_all(own.files(clip), clip)))


def keep(copies: ToolMasks, run: Path) -> None:
    """In the run's folder, all or none of them, unless they are there. Raises OSError."""
    if (run / FOLDER).is_dir():
        return
    with filled(run / FOLDER) as staging:
        for path in Path(copies.folder).iterdir():
            shutil.copyfile(path, staging / path.name)
