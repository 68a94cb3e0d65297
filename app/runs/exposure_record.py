"""What was found of the exposure of a run's clip."""

from __future__ import annotations

from typing import Annotated, Final

from annotated_types import Interval
from pydantic import ConfigDict
from pydantic.dataclasses import dataclass

from renderer.clip import Clip
from renderer.frame_gains import with_gains

MOST: Final = 100.0
Gain = Annotated[float, Interval(ge=1 / MOST, le=MOST)]


@dataclass(frozen=True, kw_only=True, config=ConfigDict(extra="forbid", allow_inf_nan=False))
class ExposureRecord:
    """The exposure of a clip's frames, found before training, which keeps to it when it goes on."""

    jitter: Annotated[float, Interval(ge=0)]
    """By how much the brightness of the training frames changes from one to the next, as a share."""
    gains: tuple[Gain, ...] = ()
    """Brightness of each frame against the clip's common exposure, in which the model is; none where the clip
    does without. That of a frame which is not trained on comes from the frame itself and those beside it."""

    @property
    def said(self) -> str:
        return f"brightness changes by {100 * self.jitter:.1f} % from frame to frame"

    def through(self, clip: Clip) -> Clip:
        """The clip whose frames know their gains; the very same where there are none. Raises ValueError:
        another number of frames."""
        return with_gains(clip, self.gains) if self.gains else clip
