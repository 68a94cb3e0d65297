"""Many files and folders enhanced with the same settings, by value, an image at a time."""

from __future__ import annotations

import os
from collections.abc import Generator, Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Final

from app.enhancement.batch import Failed, Item, Step, enhance_batch, items_in
from app.enhancement.enhance_files import STOPPED, Setting
from renderer.readers.clip_options import ClipOptions
from renderer.readers.cut_off import CUT_OFF
from renderer.readers.image_folders.passed_over import NOT_READABLE

NAMED: Final = "enhanced-"
"""How the name of a batch's folder begins."""


@dataclass(frozen=True, eq=False)
class BatchRequest:
    """One batch; a second wish for the same is another request."""

    inputs: tuple[Path, ...]
    output: Path
    """A folder that is not there yet, with the structure of the inputs."""
    setting: Setting
    clip_options: Mapping[str, ClipOptions] = field(default_factory=dict)
    """How clips are read for which eyes or a lens were chosen, by path."""


@dataclass(frozen=True)
class Noted:
    """A sentence about what was written."""

    name: str
    """Of the item."""
    notice: str

    @property
    def is_loss(self) -> bool:
        """Of the source, not all could be read."""
        return self.notice.startswith((CUT_OFF, NOT_READABLE, STOPPED))


@dataclass(frozen=True)
class Progressed:
    """How far a batch has come, with all that has failed or is to be told so far: answers in between may be
    passed over."""

    step: Step
    failed: tuple[Failed, ...]
    noted: tuple[Noted, ...] = ()
    has_ended: bool = False


def batch(request: BatchRequest) -> Generator[Progressed, None, None]:
    """Raises OSError or UserError where there is nothing to enhance; what fails later is in the answers. Ends
    without folders that hold nothing."""
    failed, noted = tuple[Failed, ...](), tuple[Noted, ...]()
    items = [
        replace(item, clip_options=request.clip_options.get(str(item.source))) for item in _items(request)
    ]
    steps = enhance_batch(items, request.setting)
    try:
        for step in steps:
            if step.failed is not None:
                failed = (*failed, step.failed)
            if step.written is not None:
                item = items[step.place - 1]
                failed += tuple(Failed(item, one.reason, one.name) for one in step.written.failed)
                noted += tuple(Noted(item.name, notice) for notice in step.written.notices)
            yield Progressed(step, failed, noted, has_ended=step.place == step.count)
    finally:
        steps.close()
        _remove_empty(request.output, items)


def _items(request: BatchRequest) -> list[Item]:
    """With those that have been moved away since they were chosen, of which `enhance_batch` says so."""
    there = tuple(path for path in request.inputs if os.path.exists(path))
    found = items_in(there or request.inputs, request.output, below=True)
    gone = (Item(path, request.output, path.name) for path in request.inputs if path not in there)
    return [*gone, *found]


def _remove_empty(output: Path, items: Iterable[Item]) -> None:
    """Folders that were made for items of which nothing came."""
    own = {item.folder for item in items}
    made = {place for folder in own for place in (folder, *folder.parents) if place.is_relative_to(output)}
    for folder in sorted(made, reverse=True):  # Those within others come first.
        with suppress(OSError):
            folder.rmdir()
