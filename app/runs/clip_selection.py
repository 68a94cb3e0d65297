"""What of a clip counts: the frames that a person has kept, and the pixels that are neither masked by hand
nor dark surround."""

from __future__ import annotations

from dataclasses import field, replace
from pathlib import Path
from typing import Final

from pydantic import ConfigDict
from pydantic.dataclasses import dataclass

from app.enhancement.image_mask import NO_MASK, PictureMask
from app.enhancement.settable import FrameNumber
from app.errors import UserError
from app.runs.burned_in import BurnedIn
from app.runs.tool_masks import ToolMasks
from app.runs.unmasked_tools import FoundTools
from enhance.field import FieldOfView
from renderer.camera import BoolArray
from renderer.clip import Clip, Frame, within
from renderer.tools.search import without_still, without_tools


@dataclass(frozen=True, kw_only=True, config=ConfigDict(extra="forbid"))
class ClipPart:
    """What counts of a clip, its frames and their pixels; by default all of it."""

    trim: tuple[FrameNumber, FrameNumber] | None = None
    """First and last frame that count, from 0."""
    mask: PictureMask = field(default_factory=PictureMask)
    field_of_view: FieldOfView | None = None
    """What the endoscope sees, as training found it; None: there was no surround, or nobody looked for it."""
    tools: FoundTools | None = None
    """What training found of them; None: the clip has masks of its own, shows none, or nobody looked."""
    burned_in: BurnedIn | None = None
    """What training found beside masks of tools; None: nothing, there were none, or nobody looked, as in
    versions before."""
    tool_masks: ToolMasks | None = None
    """Masks of them that were made for the clip; None: none but its own."""

    @property
    def first(self) -> int | None:
        """Of its frames, in the whole clip; None where all of them count."""
        return None if self.trim is None else self.trim[0]

    def span(self, count: int) -> tuple[int, int]:
        """First and last frame of a clip of `count` frames."""
        if self.trim is None:
            return 0, count - 1
        first = min(max(self.trim[0], 0), count - 1)
        return first, min(max(self.trim[1], first), count - 1)

    def of(self, clip: Clip) -> Clip:
        """These frames as a clip of their own, numbered and timed anew; what is masked is neither trained on
        nor evaluated. The very same clip where all of it counts.

        Raises:
            UserError: the clip has no such frames, the mask leaves no pixel, or the field of view has another
                size.
        """
        masked = clip if self.tool_masks is None else self.tool_masks.of(clip)
        return self.lit(self._unmasked(self._trimmed(masked)))

    def require_within(self, clip: Clip) -> None:
        """Looks at no frame, and so may come before depth is matched.

        Raises:
            UserError: the clip has no such frames, or the box of the mask lies outside of them.
        """
        first, last = (0, len(clip) - 1) if self.trim is None else self.trim
        if not 0 <= first <= last < len(clip):
            raise UserError(
                f"expected frames from 0 to {len(clip) - 1}, the first before the last, got {first}:{last}: "
                f"{clip.path}"
            )
        left, top, right, bottom = self.mask.text or (0, 0, *clip.size)
        width, height = clip.size
        # Of a hand, a click is an empty box.
        if left < right and top < bottom and not (left < width and top < height and right > 0 and bottom > 0):
            said = " ".join(f"{edge:g}" for edge in (left, top, right, bottom))
            raise UserError(
                f"expected a text box that overlaps the {width}x{height} pixels of a frame, got {said}: "
                f"{clip.path}"
            )

    def lit(self, clip: Clip) -> Clip:
        """The clip without its dark surround and the tools and burned-in text that were found, alone.

        Raises:
            UserError: the field of view has another size.
        """
        field = self.field_of_view
        if field is None and self.tools is None and self.burned_in is None:
            return clip
        if field is not None and (field.width, field.height) != clip.size:
            got, wanted = f"{field.width}x{field.height}", "x".join(map(str, clip.size))
            raise UserError(f"expected a field of view of {wanted} pixels, got one of {got}: {clip.path}")
        return replace(clip, read_frame=lambda index: self.cleared(clip.read_frame(index)))

    def kept(self, width: int, height: int) -> BoolArray:
        """(H, W) pixels that count in every frame of that size, but for tools."""
        field = self.field_of_view
        kept = self.mask.kept((height, width))
        return (
            kept & field.mask()
            if field is not None and (field.width, field.height) == (width, height)
            else kept
        )

    def cleared(self, frame: Frame) -> Frame:
        """The same for a frame, of the size of the field of view."""
        lit = frame if self.field_of_view is None else within(frame, self.field_of_view.mask())
        bare = lit if self.burned_in is None else without_still(lit, self.burned_in.still)
        found = self.tools
        return bare if found is None else without_tools(bare, found.still, found.reach)

    def _trimmed(self, clip: Clip) -> Clip:
        self.require_within(clip)
        if self.trim is None or self.trim == (0, len(clip) - 1):
            return clip
        return clip.between(*self.trim)

    def _unmasked(self, clip: Clip) -> Clip:
        if self.mask == NO_MASK:
            return clip
        width, height = clip.size
        kept = self.mask.kept((height, width))
        if not kept.any():
            raise UserError(
                f"expected a mask that keeps some of the {width}x{height} pixels, got one that "
                f"keeps none: {clip.path}"
            )
        return clip if kept.all() else clip.within(kept)

    @property
    def as_asked(self) -> ClipPart:
        """Without what training found."""
        return replace(self, field_of_view=None, tools=None, burned_in=None)

    @property
    def of_anywhere(self) -> ClipPart:
        """Without the folder of masks, for what leaves this computer."""
        return self if self.tool_masks is None else replace(self, tool_masks=self.tool_masks.of_anywhere)

    def kept_in(self, run: Path) -> ClipPart:
        """With the copies of the masks that a run keeps in its folder."""
        return self if self.tool_masks is None else replace(self, tool_masks=self.tool_masks.kept_in(run))

    def require_own_masks(self, whole: Clip) -> None:
        """Of a run's part of the clip. Raises ClipError: its tool masks are not what they were."""
        if self.tool_masks is not None:
            self.tool_masks.require_unchanged(whole)

    def told(self, count: int | None = None) -> str:
        """In words, of a clip of `count` frames, None: not known; empty for all of it."""
        is_whole = self.trim is None or (count is not None and self.span(count) == (0, count - 1))
        frames = "" if is_whole or self.trim is None else f"frames {self.trim[0] + 1} to {self.trim[1] + 1}"
        of = f" of {count}" if frames and count is not None else ""
        masked = "without masked pixels" if self.mask != NO_MASK else ""
        lit = "without the dark surround" if self.field_of_view is not None else ""
        bare = "without tools" if self.tools is not None or self.tool_masks is not None else ""
        textless = "without text or tools at rest" if self.burned_in is not None else ""
        return ", ".join(filter(None, (frames + of, masked, lit, bare, textless)))


WHOLE: Final = ClipPart()
