"""What training says while it runs: small immutable messages, the same for terminal, tests and window."""

from __future__ import annotations

from dataclasses import dataclass

from renderer.gaussians import DynamicGaussians
from renderer.train.config import Part


@dataclass(frozen=True)
class Omission:
    """One thing that this clip does not need and that is therefore left out."""

    what: str
    why: str
    saves: str
    part: Part | None = None
    """By which it can be kept; None where it was asked for, or there is no such thing in the method."""


@dataclass(frozen=True)
class Preparing:
    """What is done before training starts, where that takes a while."""

    stage: str
    """In a few words, such as "read frames"."""
    done: int
    total: int
    """0: not known."""
    seconds: float
    """Of this stage, so far."""
    seconds_left: float | None
    """Of this stage; None: not known yet."""


@dataclass(frozen=True)
class Planned:
    """About what the training will need, in bytes, before it starts."""

    memory: int
    disk: int


@dataclass(frozen=True)
class Started:
    """Training begins; comes first.

    Example:
        >>> from renderer import Started
        >>> event = Started(iteration=0, iterations=3000, n_gaussians=500, omitted=())
        >>> [f"{one.what}: {one.why}" for one in event.omitted]  # nothing that this clip does without
        []
    """

    iteration: int
    """0, or the iteration of the checkpoint that is resumed."""
    iterations: int
    n_gaussians: int
    omitted: tuple[Omission, ...]


@dataclass(frozen=True)
class Progress:
    """How far training is; comes a few times a second.

    Example:
        >>> from renderer import Progress
        >>> event = Progress(50, 100, loss=0.02, psnr=30.0, seconds=1.5, seconds_left=1.5, n_gaussians=500)
        >>> f"{100 * event.iteration / event.iterations:.0f} %, {event.seconds_left:.1f} s left"
        '50 %, 1.5 s left'
    """

    iteration: int
    iterations: int
    loss: float
    """Mean loss since the last Progress."""
    psnr: float
    """dB, of the training frames' tissue pixels since the last Progress."""
    seconds: float
    """Of steps so far, pauses, checkpoints and snapshots excluded."""
    seconds_left: float
    """Of what is still to come, after the last step too."""
    n_gaussians: int
    wall_seconds: float | None = None
    """So far, of all that `train` does; None: not recorded."""


@dataclass(frozen=True, eq=False)
class Snapshot:
    """A copy of the model, for the live preview. The newest replaces all older ones.

    Example:
        >>> from renderer import Snapshot
        >>> def preview(event):
        ...     return event.model.at(0.5) if isinstance(event, Snapshot) else None
        >>> preview("another event") is None
        True
    """

    iteration: int
    model: DynamicGaussians


@dataclass(frozen=True)
class Evaluated:
    """The model as it stands, on frames that training does not see: means over them.

    Example:
        >>> from renderer import Evaluated
        >>> event = Evaluated(iteration=3000, psnr=33.7, depth_rmse=0.47)
        >>> f"{event.psnr} dB, {event.depth_rmse} mm"
        '33.7 dB, 0.47 mm'
    """

    iteration: int
    psnr: float
    """dB, masked over all pixels (the convention of the field)."""
    depth_rmse: float | None = None
    """In the clip's unit along z, over evaluated pixels with depth; None where none is measured."""


@dataclass(frozen=True)
class Finishing:
    """What is done after the last step, when it begins.

    Example:
        >>> from renderer import Finishing
        >>> event = Finishing("measuring held-out frames", seconds_left=4.0)
        >>> f"{event.stage}, {event.seconds_left:.0f} s left"
        'measuring held-out frames, 4 s left'
    """

    stage: str
    """In a few words."""
    seconds_left: float
    """About, of this and all that comes after it; 0: it is short, or nothing tells."""


@dataclass(frozen=True)
class Warned:
    """Something is wrong, but training continues.

    Example:
        >>> from renderer import Warned
        >>> Warned("the camera moves").message
        'the camera moves'
    """

    message: str


@dataclass(frozen=True, eq=False)
class Finished:
    """Training is done; comes last, with the model.

    Example:
        >>> from renderer import Finished
        >>> def trained(events):
        ...     return next((event.model for event in events if isinstance(event, Finished)), None)
        >>> trained(["another event"]) is None
        True
    """

    iteration: int
    seconds: float
    """Of steps."""
    model: DynamicGaussians
    omitted: tuple[Omission, ...] = ()
    """What the end of training found to be unneeded."""
    wall_seconds: float | None = None
    """Of all that `train` did; None: not recorded."""


TrainEvent = Preparing | Planned | Started | Progress | Snapshot | Evaluated | Finishing | Warned | Finished
