"""What files are made of: opened already by a window or a command, or found again for a replay."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Protocol

from app.enhancement.clip_statistics import ClipStatistics, OfClip, StatisticsRequest
from app.errors import UserError
from app.files.image_series import Series
from app.files.provenance import digest
from app.files.records import Source
from app.scenes.drawer import Drawer
from app.scenes.records import SceneRecord
from app.scenes.scene import Scene
from app.scenes.view_request import FrameImage, FrameRequest, ViewRequest
from renderer.clip import Clip
from renderer.readers.clip_options import ClipOptions


class Sources(Protocol):
    """Each raises UserError or ClipError for what is not there."""

    def series(self, source: Source, options: ClipOptions) -> Series:
        """The pictures of a file or a folder."""

    def clip(self, source: Source, options: ClipOptions) -> Clip: ...

    def saved(self, source: Source) -> Path:
        """Where a file with these bytes lies."""

    def scene(self, record: SceneRecord) -> Scene:
        """A model with the edits that the record tells of."""

    def reference(
        self, record: SceneRecord, frame: int | None, *, trained: bool
    ) -> FrameImage | FrameRequest:
        """What a difference at a frame of the scene is to: what its run was `trained` on, or the clip's own
        frame."""

    def drawer(self, renderer: str) -> Drawer:
        """What draws, of the kind that a record names."""

    def of_clip(self, request: StatisticsRequest) -> OfClip:
        """The statistics of a clip where they are known already."""


@dataclass(frozen=True, eq=False)
class Opened:
    """What a window or a command has open, and asks to be written."""

    views: tuple[ViewRequest, ...] = ()
    """With their scenes, and what differences are to."""
    own: Clip | None = None
    model: Scene | None = None
    """Of splats or panes, where it need be of no view."""
    pen: Drawer = field(default_factory=Drawer)
    measured: ClipStatistics | None = None
    """Of the clip, as it is shown."""
    files: tuple[Path, ...] = ()
    """Of pictures that were saved."""

    def series(self, source: Source, options: ClipOptions) -> Series:
        raise UserError(f"expected panes or views, got a record of images of {source.name}")

    def clip(self, source: Source, options: ClipOptions) -> Clip:
        if self.own is None:
            raise UserError(f"expected the clip {source.name} to be open")
        return self.own

    def saved(self, source: Source) -> Path:
        found = (path for path in self.files if path.name == source.name and digest(path) == source.sha256)
        path = next(found, None)
        if path is None:
            raise UserError(f"expected the image {source.name}, which is gone or has changed")
        return path

    def scene(self, record: SceneRecord) -> Scene:
        wanted = record.scene
        return next(scene for scene in self._scenes if scene.record == wanted)

    def reference(
        self, record: SceneRecord, frame: int | None, *, trained: bool
    ) -> FrameImage | FrameRequest:
        return self._references[id(self.scene(record)), frame]

    def drawer(self, renderer: str) -> Drawer:
        return self.pen

    def of_clip(self, request: StatisticsRequest) -> OfClip:
        return self.measured.told(request) if self.measured is not None else None

    @cached_property
    def _scenes(self) -> Iterable[Scene]:
        own = () if self.model is None else (self.model,)
        return tuple({id(one): one for one in (*own, *(view.scene for view in self.views))}.values())

    @cached_property
    def _references(self) -> dict[tuple[int, int | None], FrameImage | FrameRequest]:
        return {
            (id(view.scene), view.frame): view.reference for view in self.views if view.reference is not None
        }
