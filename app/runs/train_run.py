"""Training as the app asks for it: from a clip on disk to a run folder, as a stream of events."""

from __future__ import annotations

from collections.abc import Callable, Generator, Mapping
from contextlib import ExitStack, closing, nullcontext
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from functools import partial
from itertools import chain
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Annotated, Final, Literal

from app.enhancement.image_mask import NO_MASK
from app.enhancement.methods import (
    PAPER,
    VESSEL,
    EnhancementSettings,
    Preset,
    RecordedSettings,
    measure_for,
    preset_of,
)
from app.enhancement.settable import LONGEST_PATH, at_most
from app.errors import UserError
from app.files.atomic import make_folder
from app.files.legible import require_utf8
from app.files.provenance import digest, version
from app.runs.clip_selection import WHOLE, ClipPart
from app.runs.dark_surround import as_dense
from app.runs.device import Asked, Choice, Device, choose, pictures_on
from app.runs.left_out import left_out_of, with_found
from app.runs.memory import peak_memory_mb, planned_in
from app.runs.posing import Posed, posed, unposed, within_whole
from app.runs.preparing import ReadAhead, reading, told_meanwhile
from app.runs.run_folder import (
    OMITTED,
    SAVING,
    ClipRecord,
    Enhancement,
    Input,
    RunFolder,
    RunRecord,
)
from app.runs.run_lock import locked, require_free
from app.runs.steadying import STAGE, found_exposure, in_exposure
from app.runs.structuring import structured
from app.runs.tool_masks import FOLDER, ToolMasks, keep
from app.runs.trained_clip import input_clip
from app.runs.unmasked_tools import untold_in
from app.runs.wall_clock import WallClock
from enhance import EnhanceParams
from enhance.vessel import VesselParams
from renderer.clip import Clip
from renderer.readers.clip_options import DEFAULTS, ClipOptions
from renderer.sources import open_bare, require_depth_source, with_chosen_depth
from renderer.train.checkpoint import read_newest_checkpoint
from renderer.train.config import TrainConfig
from renderer.train.events import Finished, Finishing, Progress, Snapshot, Started, TrainEvent, Warned
from renderer.train.frame_store import nearest_folder
from renderer.train.trainer import TrainingError, require_depth
from renderer.train.training import train
from renderer.train.window_files import next_of
from renderer.train.windows import windows_of

RECONSTRUCTION_PARAMS = EnhanceParams(d_factor=0.5)
"""For frames that are reconstructed (Tables 1-2 of the paper)."""
Measured = Literal["tissue", "whole image"]
"""The pixels that statistics of enhanced frames are of; the paper's Eqs 2 and 12 take the whole image."""
PRESETS: Final[Mapping[Preset, EnhancementSettings]] = {PAPER: RECONSTRUCTION_PARAMS, VESSEL: VesselParams()}
"""For frames that are reconstructed, by the names of --preset."""


@dataclass(frozen=True, kw_only=True)
class TrainRequest:
    """One training run, by value: crosses to the training process as it stands."""

    clip_path: Annotated[Path, at_most(LONGEST_PATH)]
    run_path: Annotated[Path, at_most(LONGEST_PATH)]
    config: TrainConfig
    clip_options: ClipOptions = DEFAULTS
    part: ClipPart = WHOLE
    """Of the clip: frames to train on, pixels left out."""
    input: Input = "original"
    enhance_params: RecordedSettings = RECONSTRUCTION_PARAMS
    """Used when `input` is "enhanced"."""
    measured: Measured = "tissue"
    """For the statistics of enhanced frames."""
    device: Asked = "auto"
    """For a run that goes on, "auto" is what it began with."""
    resume: bool = False
    """Go on from the newest checkpoint in `run_path`; start when there is nothing there yet."""


def run_training(request: TrainRequest) -> Generator[TrainEvent, None, None]:
    """Train, log and save; the run folder holds all that came of it, also when this is cut short.

    Raises:
        ClipError: the clip cannot be read.
        UserError: the clip has no such part; the run folder holds something else, or another run than the
            one to resume; the path of the clip is not UTF-8, so that run.json cannot name it; the device that
            is asked for is not there; or the training does not converge.
    """
    clock = WallClock()
    masked = request.part.tool_masks is not None
    with TemporaryDirectory(prefix="vesselsplat-") if masked else nullcontext() as place:
        yield from clock.over(_run(request, clock, Path(place or "")))


def _run(request: TrainRequest, clock: WallClock, place: Path) -> Generator[TrainEvent, None, None]:
    """See `run_training`; `place` is for copies of tool masks."""
    require_utf8(request.clip_path)
    run = RunFolder(request.run_path)
    _check_vacancy(request, run)
    require_depth_source(request.clip_path, request.clip_options)
    record = run.record() if run.is_run else None
    bare, whole, part, copies = yield from _open_part(request, run, record, place)
    clip, start = part.of(whole), part.first or 0
    if record is None and clip.depth_origin != "motion":
        require_depth(clip)
    if run.is_finished:
        yield _finished_before(run)
        return
    if record is not None:
        record.clip.part.require_own_masks(whole)
    yield planned_in(run.path, clip, request.config)
    clock.before = run.wall_before()
    device = device_of(request).device
    seen = clip if record is None else record.clip.through(clip)
    window = next_of(run.path, windows_of(seen, request.config))
    ahead = ReadAhead(clip, nearest_folder(run.path), window)
    yield from told_meanwhile(reading(clip), ahead.fill)
    through = yield from _through_cameras(request, record, ahead.clip, start)
    begin: Callable[[], None] | None = None
    if record is None:
        record = yield from told_meanwhile(
            "recording the clip", lambda _: _new_record(request, through, device, copies)
        )
        record = yield from _with_exposure(record, _by_images(ahead, through, part.of(bare)))
        begin = partial(_begin, run, record, copies)
    is_told = record.clip.part.tools is not None or "tools" in record.config.keep
    tools = () if is_told else untold_in(ahead.clip)
    ahead.hand_over()
    through = replace(through, notices=(*clip.notices, *through.notices, *tools))
    try:
        yield from _train(record, run, in_exposure(through, record.exposure, record.config), clock, begin)
    except TrainingError as error:
        raise UserError(f"{error}; run: {run.path}") from error


def _open_part(
    request: TrainRequest, run: RunFolder, record: RunRecord | None, place: Path
) -> Generator[TrainEvent, None, tuple[Clip, Clip, ClipPart, ToolMasks | None]]:
    """The whole clip, bare and with depth, the part to train on, and the copies of its tool masks, made in
    `place`; a run that has a record is checked against the clip, and keeps the copies."""
    part = request.part if record is None else record.clip.part.as_asked
    options = request.clip_options if record is None else record.clip.options
    bare, whole = yield from told_meanwhile(
        "opening the clip", lambda _: _opened(request.clip_path, options, part)
    )
    if record is not None:
        _check_same(request, record, whole)
    masks = request.part.tool_masks
    copies = None if masks is None else masks.copied(whole, place)
    whole = whole if masks is None else masks.told(whole)
    if record is None:
        part = replace(part, tool_masks=copies)
    elif copies is not None:
        keep(copies, run.path)
    return bare, whole, part, copies


def _through_cameras(
    request: TrainRequest, record: RunRecord | None, clip: Clip, start: int
) -> Generator[TrainEvent, None, Posed]:
    """The clip as the run's record has its cameras, or as they are found; `start`: see `posed`."""
    if record is not None and record.clip.poses is not None:
        return Posed(record.clip.through(clip))
    if clip.depth_origin == "motion":
        drawn_on = request.part.mask != NO_MASK or request.part.tool_masks is not None
        return (yield from structured(clip, request.config, request.clip_options, start, drawn_on=drawn_on))
    if record is not None:  # It began without: another version may find some, which it was not trained by.
        return (yield from unposed(clip, request.config))
    return (yield from posed(clip, request.config, start))


def _by_images(ahead: ReadAhead, through: Posed, bare: Clip) -> Clip:
    """The clip for what looks at images alone: two eyes are not matched once more. `bare`: before that, and
    before cameras were found."""
    if through.clip.depth_origin != "stereo":
        return through.clip
    clip = ahead.in_place_of(bare)
    clip = clip if through.part is None else clip.between(*through.part)
    return replace(clip, passed_over=through.clip.passed_over)


def _with_exposure(record: RunRecord, clip: Clip) -> Generator[TrainEvent, None, RunRecord]:
    """With the gains of the frames as they are trained on, or why there are none."""
    seen = input_clip(record.clip.part.lit(clip), record)
    found = yield from told_meanwhile(STAGE, partial(found_exposure, seen, record.config))
    return replace(record, exposure=found)


def _opened(path: Path, options: ClipOptions, part: ClipPart) -> tuple[Clip, Clip]:
    """Bare, and with depth, which may have to be matched first: of a clip that has no such part it is not."""
    bare = open_bare(path, options)
    part.require_within(bare)
    return bare, with_chosen_depth(bare, options)


def device_of(request: TrainRequest) -> Choice:
    """What the request is trained on. Raises UserError: that is not there, or the run began with another."""
    run = RunFolder(request.run_path)
    began = run.record().device if request.resume and run.is_run else request.device
    if request.device not in ("auto", began):
        raise UserError(f"cannot resume: expected the run's device {began}, got {request.device}")
    return choose(began)


def _train(
    record: RunRecord, run: RunFolder, posed: Posed, clock: WallClock, begin: Callable[[], None] | None
) -> Generator[TrainEvent, None, None]:
    """`begin` makes the run's folder what it is; None: the run goes on. Others may begin runs meanwhile."""
    part = record.clip.part
    clip, config = input_clip(part.lit(posed.clip), record), as_dense(record.config, part.field_of_view)
    pictures = pictures_on(record.device)
    with ExitStack() as meanwhile:
        if begin is None:
            meanwhile.enter_context(locked(run.path))
        events = train(clip, config, folder=run.path, resume=begin is None, pictures=pictures)
        first = yield from told_meanwhile("analysing the clip", lambda _: next(events))
        # Closed while the run is locked: a checkpoint is written then.
        with closing(events):
            # A clip that cannot be trained on has failed by now: nothing is left behind for it.
            if begin is not None:
                make_folder(run.path)
                meanwhile.enter_context(locked(run.path))
                begin()
            for event in chain((first,), events):
                yield from _told(event, run, posed, part, clock)


def _begin(run: RunFolder, record: RunRecord, copies: ToolMasks | None) -> None:
    """Its folder, with copies of the tool masks."""
    run.create(record)
    if copies is not None:
        keep(copies, run.path)


def _told(
    event: TrainEvent,
    run: RunFolder,
    posed: Posed,
    part: ClipPart,
    clock: WallClock,
) -> Generator[TrainEvent, None, None]:
    """The event, with what the clip's notices and its part add to it and the time in all; kept, said."""
    if isinstance(event, Finished):
        yield Finishing("saving the model", 0.0)
        run.log_saving(replace(event, wall_seconds=clock.seconds()), **_facts(event))
        event = replace(event, model=run.save_model(event.model))
    if isinstance(event, Progress | Finished):
        event = replace(event, wall_seconds=clock.seconds())
    warnings = list[Warned]()
    if isinstance(event, Started):
        omitted, found = left_out_of(part)
        event = replace(event, omitted=(*omitted, *posed.omitted, *event.omitted))
        warnings += map(Warned, (*posed.notices, *found))
    for told in (event, *warnings):
        if not isinstance(told, Snapshot | Finishing):
            facts = _facts(told) if isinstance(told, Finished) else {}
            run.log(told, **facts)
        yield told


def _facts(finished: Finished) -> dict[str, float]:
    """What the log says beside the event's own fields."""
    return {"peak_memory_mb": peak_memory_mb(), "n_gaussians": len(finished.model)}


def pooled(clip: Clip, params: EnhancementSettings, measured: Measured = "tissue") -> Enhancement:
    """`params` with statistics pooled over the training frames, so that colours agree."""
    if measured == "whole image":
        whole = ((clip.read_image(index), None) for index in clip.train_indices)
        return Enhancement(params=params, statistics=measure_for(params, whole, "all"))
    frames = map(clip.read_frame, clip.train_indices)
    tissue = ((frame.image, frame.tissue_mask) for frame in frames)
    return Enhancement(params=params, statistics=measure_for(params, tissue))


def _new_record(request: TrainRequest, posed: Posed, device: Device, copies: ToolMasks | None) -> RunRecord:
    clip = posed.clip
    cameras = clip.cameras[:1] if clip.camera_is_fixed else clip.cameras
    is_enhanced = request.input == "enhanced"
    asked, is_followed = within_whole(request.part, posed.part), posed.poses is not None
    part = with_found(asked, clip.read_frame, clip.train_indices, request.config.keep, is_followed)
    measured, options = part.lit(clip), request.clip_options
    if posed.lens is not None:
        options = replace(options, calibration=posed.lens)
    if copies is not None:
        part = replace(part, tool_masks=replace(copies, folder=FOLDER))
    return RunRecord(
        version=version(),
        created=datetime.now(UTC).isoformat(timespec="seconds"),
        clip=ClipRecord(
            path=str(request.clip_path.absolute()),
            name=clip.name,
            options=options,
            part=part,
            sha256=digest(request.clip_path),
            frames=len(clip),
            unit=clip.unit,
            cameras=tuple(camera.to_json() for camera in cameras),
            poses=posed.poses,
            frames_per_second=clip.frames_per_second,
            asked=request.part.trim if posed.poses else None,
        ),
        input=request.input,
        config=request.config,
        enhancement=pooled(measured, request.enhance_params, request.measured) if is_enhanced else None,
        device=device,
    )


def _check_vacancy(request: TrainRequest, run: RunFolder) -> None:
    if run.is_run and not request.resume:
        state = "a finished" if run.is_finished else "an unfinished"
        hint = "choose another folder" if run.is_finished else "add --resume to continue it"
        raise UserError(f"{run.path} already holds {state} run: {hint}")
    if not run.is_run:
        run.require_vacant()
    elif not run.is_finished:
        require_free(run.path)
    there = nearest_folder(run.path)
    try:
        # Rights alone do not tell: the superuser has all, also where nothing can be made.
        with TemporaryDirectory(prefix=".vesselsplat-", dir=there):
            pass
    except OSError as error:
        raise UserError(f"expected a writable folder for the run, got one that is not: {there}") from error


def _check_same(request: TrainRequest, record: RunRecord, whole: Clip) -> None:
    """A run goes on as it began, or not at all: anything else would not be repeatable."""
    if not record.clip.is_of(request.clip_path):
        raise UserError(
            "cannot resume: expected the clip the run was started with, got another or a "
            f"changed one: {request.clip_path}"
        )
    read, reads = record.clip.options.as_asked, request.clip_options.as_asked
    began = {"input": record.input} | vars(read) | vars(record.clip.part) | vars(record.config)
    asked = {"input": request.input} | vars(reads) | vars(request.part) | vars(request.config)
    if record.enhancement is not None:
        params = record.enhancement.params
        began |= {"preset": preset_of(params)} | vars(params)
        asked |= {"preset": preset_of(request.enhance_params)} | vars(request.enhance_params)
        measured = record.enhancement.statistics
        known = {"most_exposure": measured.bright_level, "least_redness": measured.redness}
        known |= {"color_smoothing": measured.color_noise}
        before = {name for name, value in known.items() if value is None}  # There was no such thing.
        if asked.get("spare_grey") == VesselParams().spare_grey and began.get("spare_grey") in (0.0, 1.0):
            before.add("spare_grey")  # That was the default: before 0.14.0, then in it.
        asked |= {name: began[name] for name in asked.keys() & began.keys() & before}
    for found in ("field_of_view", "bits", "alpha", "tools", "burned_in", "tool_masks"):
        if asked[found] is None:  # Nobody asks for it.
            del began[found]
    if "tool_masks" in began and began["tool_masks"] is not None:
        began["tool_masks"], asked["tool_masks"] = (
            f"of digest {each.digest(whole)[:12]}" for each in (began["tool_masks"], asked["tool_masks"])
        )
    if record.clip.poses is not None and request.part.trim == record.clip.asked:
        del began["trim"]
    for name, value in began.items():
        if asked[name] != value:
            raise UserError(f"cannot resume: expected the run's {name} {value}, got {asked[name]}")


def _finished_before(run: RunFolder) -> Finished:
    """As the log tells; of a run that was killed after its model was written, the log is completed."""
    run.clear_windows()
    if events := run.events("Finished"):
        steps, seconds = int(events[-1]["iteration"]), float(events[-1]["seconds"])
        return Finished(steps, seconds, run.model(), wall_seconds=run.wall_seconds())
    finished, memory = _saved(run)
    run.log(finished, peak_memory_mb=memory, n_gaussians=len(finished.model))
    return finished


def _saved(run: RunFolder) -> tuple[Finished, float | None]:
    """What was about to be logged with the model, and the peak memory; of logs of earlier versions, which do
    not tell, as the checkpoint says."""
    if events := run.events(SAVING):
        told = events[-1]
        omitted, wall = OMITTED.validate_python(told.get("omitted", ())), run.wall_seconds()
        finished = Finished(int(told["iteration"]), float(told["seconds"]), run.model(), omitted, wall)
        return finished, told.get("peak_memory_mb")
    last = read_newest_checkpoint(run.path)
    iteration, seconds = (last.iteration, last.seconds) if last else (run.record().config.iterations, 0.0)
    return Finished(iteration, seconds, run.model(), wall_seconds=run.wall_seconds()), None
