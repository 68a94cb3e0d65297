"""Training of a clip as a generator of events: terminal, tests and window iterate the same stream."""

from __future__ import annotations

from collections.abc import Generator
from contextlib import closing
from dataclasses import replace
from pathlib import Path

from renderer.clip import Clip, ClipError
from renderer.train.config import TrainConfig
from renderer.train.events import Started, TrainEvent
from renderer.train.gradient_backend import GradientBackend
from renderer.train.trainer import require_depth, split, train_window
from renderer.train.window_files import clear
from renderer.train.windowed import WindowedTraining
from renderer.train.windows import left_out, windows_of


def train(
    clip: Clip,
    config: TrainConfig,
    *,
    folder: str | Path | None = None,
    resume: bool = False,
    pictures: GradientBackend | None = None,
) -> Generator[TrainEvent, None, None]:
    """Reconstruct `clip` from its training frames, as a generator of events: Started first, Finished with the
    model last; closing it early ends the training. A long clip is cut into windows that overlap, which are
    trained one after the other.

    With a `folder`, which exists when Started has been taken, checkpoints are written there, one of them when
    it is closed early, and windows that are finished, of which the model reads what it needs; `resume`
    continues from the newest, without it they take the place of those of earlier trainings. `pictures`
    renders; without it, the numba kernels do. One seed gives the same bytes on the CPU, whether interrupted
    or not and whatever the number of threads.

    Nobody looks here whether brightness pumps: the gains that frames have count, and the program finds them
    before it trains (`renderer.frame_gains`).

    Raises:
        ClipError: frames cannot be read, or there are none; there is no depth to start from, or a single
            frame to train on with `hold_out`.
        TrainingError: the checkpoint belongs to another run, the loss is no longer finite, or no frame shows
            anything of the model.
        TypeError: `clip` is none, such as its path, or `config`.

    Example:
        >>> from pathlib import Path
        >>> from tempfile import TemporaryDirectory
        >>> from renderer import PhantomParams, TrainConfig, open_clip, train, write_phantom
        >>> with TemporaryDirectory() as folder:
        ...     write_phantom(Path(folder, "clip"), PhantomParams(n_frames=4, width=48, height=32))
        ...     clip = open_clip(Path(folder, "clip"))
        ...     events = list(train(clip, TrainConfig(iterations=4, n_gaussians=100)))
        >>> type(events[0]).__name__, type(events[-1]).__name__
        ('Started', 'Finished')
        >>> model = events[-1].model
        >>> model.at(0.5).means.shape == (len(model), 3)
        True
    """
    if not isinstance(clip, Clip):
        raise TypeError(f"expected a Clip, as open_clip gives it, got {type(clip).__name__}")
    if not isinstance(config, TrainConfig):
        raise TypeError(f"expected a TrainConfig, got {type(config).__name__}")
    if not len(clip):
        raise ClipError(f"expected a clip of at least one frame, got none: {clip.path}")
    require_depth(clip)
    folder = None if folder is None else Path(folder)
    windows = windows_of(clip, config)
    if len(windows) > 1:
        events = WindowedTraining(clip, config, windows, folder, resume, pictures).events()
    else:
        _, held_out = split(clip, config)
        events = train_window(clip, config, held_out, folder=folder, resume=resume, pictures=pictures)
    with closing(events):
        for event in events:
            if isinstance(event, Started):
                yield replace(event, omitted=(*event.omitted, *left_out(windows, config)))
                # Whoever takes it has made the folder its own: not before is anything removed there.
                if folder and not resume:
                    clear(folder)
            else:
                yield event
