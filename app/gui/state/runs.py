"""Reconstructions: the present one, those that wait, and those that lie on disk. A part of the state."""

from __future__ import annotations

from dataclasses import dataclass, field

from app.gui.state.reconstruction import Reconstruction, Waiting
from app.gui.work.omissions import Omissions
from app.gui.work.run_list import FoundRuns
from app.gui.work.run_models import ModelRequest
from app.scenes.scene import Scene


@dataclass
class Runs:
    """Job, queue and run actions change it; drawing reads it."""

    reconstruction: Reconstruction = field(default_factory=Reconstruction)
    queue: tuple[Waiting, ...] = ()
    """Reconstructions to be made after the present one, the next one first."""
    starts: bool = False
    """A person has asked for the next one: it starts with the next frame, where none is under way."""
    wakings: int = 0
    """How often a person has said that some of an earlier session are to be made."""
    model_wish: ModelRequest | None = None
    """The newest model of the present run, or of the last one, until something else is shown."""
    preview: Scene | None = None
    """The model as it was last seen, of the newest run that was cut short."""
    is_listed: bool = False
    """The list of the clip's runs was drawn in the last frame."""
    found: FoundRuns | None = None
    """The newest such list."""
    trouble: str = ""
    asks_for_omissions: bool = False
    """The list of what the next reconstruction leaves out is unfolded."""
    omissions: Omissions | None = None
    """The newest such list."""

    @property
    def next_waiting(self) -> Waiting | None:
        """The reconstruction that is to be made next: the first that is not asleep."""
        return next((waiting for waiting in self.queue if not waiting.asleep), None)
