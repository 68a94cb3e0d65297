"""Many files and folders enhanced with the same settings, by value, an image at a time."""

from __future__ import annotations

import os
from collections.abc import Generator, Mapping
from contextlib import suppress
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Final

from app.enhancement.batch import Failed, Step, enhance_batch, items_in
from app.enhancement.enhance_files import STOPPED, Setting
from app.gui.work.tidying import clear_below
from renderer.readers.clip_options import ClipOptions
from renderer.readers.cut_off import CUT_OFF
from renderer.readers.passed_over import NOT_READABLE

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
    without folders that hold nothing, and without what killed windows have left of earlier ones beside it."""
    for earlier in request.output.parent.glob(f"{NAMED}*"):
        clear_below(earlier)
    failed, noted = tuple[Failed, ...](), tuple[Noted, ...]()
    items = [
        replace(item, clip_options=request.clip_options.get(str(item.source)))
        for item in items_in(request.inputs, request.output, below=True)
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
        for folder, _, _ in os.walk(request.output, topdown=False):
            with suppress(OSError):
                os.rmdir(folder)
