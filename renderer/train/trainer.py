"""Training of a clip, or of one window of a long one, as a generator of events."""

from __future__ import annotations

import time
from collections.abc import Generator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from renderer.clip import BoolImage, Clip, ClipError
from renderer.deformation.spline_motion import SplineMotion
from renderer.gaussians import DynamicGaussians
from renderer.near_plane import NEAR_SHARE
from renderer.stored_arrays import Stored, check
from renderer.train.checkpoint import Checkpoint, clear_checkpoints, read_newest_checkpoint, write_checkpoint
from renderer.train.config import TrainConfig
from renderer.train.events import (
    Finished,
    Finishing,
    Omission,
    Snapshot,
    Started,
    TrainEvent,
    Warned,
)
from renderer.train.fading import ROUNDS as FADED
from renderer.train.fading import faded_out_of_sight
from renderer.train.fingerprint import fingerprint, former_fingerprint
from renderer.train.frame_store import FrameStore, nearest_folder
from renderer.train.frames import TrainFrame, as_fitted, halved, seen_by, train_frame, unseen_beyond
from renderer.train.gaps import EVERY as LOOKED_AT
from renderer.train.gaps import ROUNDS, closed_gaps
from renderer.train.gradient_backend import GradientBackend
from renderer.train.guards import LossWatch, Trouble
from renderer.train.held_out import HeldOut, evaluated
from renderer.train.hidden import smooth_occluded_motion
from renderer.train.initialize import require_resolved, scene_size, with_points
from renderer.train.meter import Meter
from renderer.train.methods import recipe_for
from renderer.train.model import TrainModel
from renderer.train.needs import Begun, Needs, decide
from renderer.train.outlines import without_outlines
from renderer.train.recipe import Recipe, Stage
from renderer.train.unseen import without_overhang, without_unseen

LOSSES, TROUBLE = "loss_watch", "trouble"
"""Among a checkpoint's arrays."""
HELD_OUT_PHASE, HELD_OUT_EVERY = 4, 7
"""In training frames; of a clip split as the field does, those with index % 8 == 5."""
REMOVING, SMOOTHING = "removing what no frame shows", "smoothing hidden motion"
FADING, CLOSING = "fading what moves out of sight", "closing gaps in hidden tissue"
MEASURING = "measuring held-out frames"
"""What follows the last step."""
RENDERED, SMOOTHED = 0.45, 0.6
"""Of the time of a step, what drawing a frame takes, and finding what it hides; only the time left depends on
them."""


class TrainingError(RuntimeError):
    """Training cannot continue: the text says why and what to do.

    Example:
        >>> from pathlib import Path
        >>> from tempfile import TemporaryDirectory
        >>> from renderer import PhantomParams, TrainConfig, TrainingError, open_clip, train, write_phantom
        >>> with TemporaryDirectory() as folder:
        ...     run = Path(folder, "run")
        ...     run.mkdir()
        ...     write_phantom(Path(folder, "clip"), PhantomParams(n_frames=4, width=48, height=32))
        ...     clip = open_clip(Path(folder, "clip"))
        ...     for seed in (0, 1):
        ...         config = TrainConfig(iterations=2, n_gaussians=100, seed=seed)
        ...         try:
        ...             last = list(train(clip, config, folder=run, resume=True))[-1]
        ...         except TrainingError as error:
        ...             print(error)
        expected a checkpoint of this clip and configuration, got another: run
    """


def train_window(
    clip: Clip,
    config: TrainConfig,
    held_out: Sequence[int],
    *,
    folder: Path | None,
    resume: bool,
    pictures: GradientBackend | None,
) -> Generator[TrainEvent, None, None]:
    """Reconstruct all of `clip` with one set of Gaussians, see `renderer.train.training.train`. It is not
    fitted to the training frames `held_out`.

    Closed between two steps, it leaves a checkpoint of those that are done.
    """
    opened = time.perf_counter()
    if config.hold_out and not held_out:
        got = len(clip.train_indices)
        raise ClipError(f"hold_out expects two frames to train on, or more, got {got}: {clip.path}")
    training, model, needs, checkpoint = _prepared(clip, config, held_out, folder, resume, pictures)
    watch, start, seconds = LossWatch(), 0, 0.0
    if checkpoint:
        training.restore(model, watch, checkpoint)
        start, seconds = checkpoint.iteration, checkpoint.seconds
    is_new = checkpoint is None
    del checkpoint
    yield Started(start, training.recipe.iterations, len(model), needs.omitted)

    if folder and is_new:
        # Of another training, or damaged: as the newest by number, they would stay in place of new ones.
        clear_checkpoints(folder)
    meter = Meter(training.recipe, seconds, sum(training.after.values()))
    yield from training.steps(model, watch, meter, start)
    ending = training.ending(model.result, model.trouble, meter.after_steps())
    del model  # The moments are twice as large as what they are of.
    gaussians, omitted = yield from ending
    wall = time.perf_counter() - opened
    yield Finished(training.recipe.iterations, meter.seconds, gaussians, omitted, wall)


def _prepared(
    clip: Clip,
    config: TrainConfig,
    held_out: Sequence[int],
    folder: Path | None,
    resume: bool,
    pictures: GradientBackend | None,
) -> tuple[_Training, TrainModel, Needs, Checkpoint | None]:
    """Everything before the first step, and what `resume` goes on from."""
    spilled = nearest_folder(folder) if folder else None
    fit = fitted(clip, held_out)
    frames = FrameStore.of((as_fitted(clip.read_frame(index)) for index in fit), spilled)
    seeds = frames if clip.points is None else FrameStore.of(with_points(frames, clip.points), spilled)
    size = scene_size(seeds)
    require_resolved(clip, size)
    identity = fingerprint(clip, config, fit, frames[0])
    checkpoint = read_newest_checkpoint(folder) if folder and resume else None
    # A checkpoint holds all that tracks would give.
    follow, begun = (None, _begun(checkpoint)) if checkpoint else (seeds, None)
    needs = decide(clip, frames, config, follow=follow, begun=begun)
    recipe = recipe_for(config, needs)
    judged = clip.camera_is_fixed and recipe.losses.opacity > 0
    if needs.apart is not None:
        bare = without_outlines(frames, needs.apart, spilled)
        seeds, frames = (bare if seeds is frames else seeds), bare
    raw = recipe.initialize(seeds)
    model = TrainModel(raw, recipe.make_trainer(raw, seeds, size), recipe, size, pictures)
    seen = seen_by(frames) if judged else None
    unseen = unseen_beyond(seen) if seen is not None else None
    taken = (train_frame(frames.take(place), unseen, seen) for place in range(len(frames)))
    pool = _Pool(FrameStore.of(taken, spilled), config.seed, needs.has_masks, spilled)
    measured = held_out if config.hold_out else clip.test_indices

    bends = isinstance(model.gaussians.motion, SplineMotion)
    hides = needs.has_masks or not clip.camera_is_fixed
    after = dict[str, float]()
    if "unseen" not in config.keep:
        after[REMOVING] = (RENDERED if clip.camera_is_fixed else RENDERED + SMOOTHED) * len(fit)
    if bends and hides and "hidden" not in config.keep:
        after[SMOOTHING] = SMOOTHED * len(fit)
    if bends and unseen is not None and unseen.any():
        after[FADING] = SMOOTHED * FADED * len(fit)
    if SMOOTHING in after and needs.has_masks and unseen is not None:
        after[CLOSING] = RENDERED * ROUNDS * len(fit) / LOOKED_AT
    after[MEASURING] = RENDERED * len(measured)
    training = _Training(clip, config, recipe, folder, identity, pool, size, unseen, measured, after)
    return training, model, needs, checkpoint


@dataclass(frozen=True, eq=False)
class _Training:
    """Of one window: what it is of, and all that its steps do not change."""

    clip: Clip
    config: TrainConfig
    recipe: Recipe
    folder: Path | None
    """Of checkpoints."""
    identity: str
    """See `fingerprint`."""
    pool: _Pool
    size: float
    """Of the scene, in the clip's unit."""
    unseen: BoolImage | None
    """(H, W) where no frame shows tissue; None: that is not looked at."""
    measured: Sequence[int]
    """Frames of the clip that are not trained on, and evaluated."""
    after: Mapping[str, float]
    """What follows the last step, in this order, each with its time in steps at full resolution."""

    def steps(
        self, model: TrainModel, watch: LossWatch, meter: Meter, start: int
    ) -> Generator[TrainEvent, None, None]:
        """All from `start` on. Closed early, it leaves a checkpoint of those that are done."""
        held = HeldOut(self.clip, self.measured, self.size, self.recipe.mode)
        end = self.recipe.iterations
        done = kept = start
        try:
            for iteration in range(start, end):
                with meter.between():
                    frame = self.pool.frame(iteration, self.recipe.stage_at(iteration))
                began = time.perf_counter()
                result = model.step(frame, iteration)
                meter.add(result, iteration, time.perf_counter() - began, len(model))
                watch.add(result.loss, self.pool.tissue(frame))
                if watch.problem:
                    at = f"at iteration {iteration}"
                    raise TrainingError(f"{watch.problem}, {at}: lower the learning rates")
                done = iteration + 1
                if done % self.config.checkpoint_every == 0 or done == end:
                    with meter.between():
                        kept = self._keep(done, meter.seconds, model, watch)
                if meter.progress_is_due() or done == end:
                    yield meter.progress(done)
                if done < end and held.is_due(meter.seconds):
                    yield held.measure(model.gaussians, done, meter.seconds)
                if meter.snapshot_is_due():
                    yield Snapshot(done, model.snapshot())
        except GeneratorExit:
            # Nobody takes further events: what is trained so far is kept.
            if done > kept:
                self._keep(done, meter.seconds, model, watch)
            raise

    def ending(
        self, gaussians: DynamicGaussians, trouble: Trouble, seconds: float
    ) -> Generator[TrainEvent, None, tuple[DynamicGaussians, tuple[Omission, ...]]]:
        """What follows the last step, in about so many seconds: the model, and what it does without."""
        near, mode, frames = NEAR_SHARE * self.size, self.recipe.mode, self.pool.full
        omitted, costs = tuple[Omission, ...](), list(self.after.values())
        total = sum(costs) or 1.0
        left = {stage: seconds * (sum(costs[place:]) / total) for place, stage in enumerate(self.after)}
        for notice in trouble.notices():
            yield Warned(notice)
        if REMOVING in left:
            yield Finishing(REMOVING, left[REMOVING])
            gaussians, omitted = without_unseen(gaussians, frames, near, mode)
            if isinstance(gaussians.motion, SplineMotion) and not self.clip.camera_is_fixed:
                gaussians, beyond = without_overhang(gaussians, frames, near, mode)
                omitted += beyond
        if not len(gaussians):
            raise TrainingError("no training frame shows any Gaussian: depth and poses are inconsistent")
        if SMOOTHING in left:
            yield Finishing(SMOOTHING, left[SMOOTHING])
            gaussians, resting = smooth_occluded_motion(gaussians, frames, near, mode)
            omitted += resting
        if FADING in left:
            assert self.unseen is not None
            yield Finishing(FADING, left[FADING])
            gaussians = faded_out_of_sight(gaussians, frames, self.unseen, near, mode)
        if CLOSING in left:
            yield Finishing(CLOSING, left[CLOSING])
            gaussians = closed_gaps(gaussians, frames, near, mode)
        yield Finishing(MEASURING, left[MEASURING])
        if self.measured:
            views = (self.clip.read_frame(index) for index in self.measured)
            yield evaluated(gaussians, views, self.recipe.iterations, self.size, mode)
        return gaussians, omitted

    def _keep(self, done: int, seconds: float, model: TrainModel, watch: LossWatch) -> int:
        """Write a checkpoint, where there is a folder. Returns the steps done."""
        if self.folder:
            arrays = {**model.state(), LOSSES: watch.state, TROUBLE: model.trouble.state}
            write_checkpoint(self.folder, Checkpoint(done, seconds, self.identity, arrays))
        return done

    def restore(self, model: TrainModel, watch: LossWatch, checkpoint: Checkpoint) -> None:
        """What a checkpoint holds. Raises TrainingError: it is of another run, or damaged."""
        assert self.folder is not None
        if checkpoint.fingerprint not in (self.identity, former_fingerprint(self.clip, self.config)):
            wanted = "expected a checkpoint of this clip and configuration"
            raise TrainingError(f"{wanted}, got another: {self.folder.name}")
        # Checkpoints of earlier versions have no state of the watch, or do not count trouble.
        arrays = {LOSSES: watch.state, TROUBLE: model.trouble.state, **checkpoint.arrays}
        layout = {LOSSES: Stored(f"{len(watch.state)}", np.float64), TROUBLE: Stored("2", np.int64, least=0)}
        most = self.recipe.iterations
        try:
            if checkpoint.iteration > most:
                raise ValueError(f"expected at most {most} iterations, got {checkpoint.iteration}")
            check(arrays, layout, {})
            model.restore(arrays)
            watch.state[:] = arrays[LOSSES]
            model.trouble.restore(arrays[TROUBLE])
        except ValueError as error:
            reason = f"training cannot continue from the checkpoint ({error})"
            raise TrainingError(f"{reason}: {self.folder}") from error


def require_depth(clip: Clip) -> None:
    """Raises ClipError before any frame is read in vain."""
    if not clip.has_depth and clip.points is None:
        way = "--depth brightness estimates it, motion finds it where the camera moves, both without a scale"
        if clip.why_no_depth:
            raise ClipError(f"reconstruction expects depth; {clip.why_no_depth} ({way})")
        raise ClipError(f"reconstruction expects depth, and this clip has none ({way}): {clip.path}")


def split(clip: Clip, config: TrainConfig) -> tuple[tuple[int, ...], tuple[int, ...]]:
    """Frames to fit and training frames held out of the fit; test frames are in neither. Of few training
    frames the middle one is held out, of a single one none."""
    frames = clip.train_indices
    if not config.hold_out or len(frames) < 2:
        return frames, ()
    held_out = frames[HELD_OUT_PHASE::HELD_OUT_EVERY] or (frames[len(frames) // 2],)
    return fitted(clip, held_out), held_out


def fitted(clip: Clip, held_out: Sequence[int]) -> tuple[int, ...]:
    """Training frames of the clip that are not held out of the fit."""
    return tuple(index for index in clip.train_indices if index not in held_out)


def frame_of(iteration: int, frames: Sequence[TrainFrame], seed: int) -> TrainFrame:
    """Every frame once an epoch, in an order that depends on seed and epoch alone."""
    epoch, place = divmod(iteration, len(frames))
    order = np.random.default_rng([seed, epoch]).permutation(len(frames))
    return frames[int(order[place])]


def _begun(checkpoint: Checkpoint) -> Begun | None:
    """None: it is damaged, which is seen when it is restored."""
    try:
        return Begun.with_motion(DynamicGaussians.checked(checkpoint.arrays).motion)
    except ValueError:
        return None


class _Pool:
    """The frames to fit, at the resolutions that are asked for; what memory cannot hold lies in `folder`."""

    def __init__(self, full: FrameStore[TrainFrame], seed: int, has_masks: bool, folder: Path | None) -> None:
        self.full, self._seed, self._has_masks, self._folder = full, seed, has_masks, folder
        self._half: FrameStore[TrainFrame] | None = None
        self._most = max((_share(frame) for frame in full), default=0.0) or 1.0

    def tissue(self, frame: TrainFrame) -> float:
        """Of a frame, as a share of what the fullest one has."""
        return _share(frame) / self._most

    def frame(self, iteration: int, stage: Stage) -> TrainFrame:
        """For one step."""
        if not stage.half:
            self._half = None
        elif self._half is None:
            self._half = FrameStore.of((halved(frame, self._has_masks) for frame in self.full), self._folder)
        frames = self.full if self._half is None else self._half
        return frame_of(iteration, frames[:1] if stage.first_frame_only else frames, self._seed)


def _share(frame: TrainFrame) -> float:
    """Of the pixels, those that are supervised."""
    return frame.n_colors / (frame.camera.width * frame.camera.height)
