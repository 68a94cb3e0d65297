"""A run on disk: run.json to repeat it, events.jsonl to follow it, checkpoints, and the model at the end; and
the clip as it was trained on.

Run folders are private: run.json names the clip by its absolute path, so that training can go on.
"""

from __future__ import annotations

import shutil
from collections.abc import Mapping, Sequence
from dataclasses import dataclass as plain_dataclass
from dataclasses import fields, replace
from itertools import chain
from pathlib import Path
from typing import Annotated, Any, Final, Literal

import numpy as np
from annotated_types import Interval
from pydantic import ConfigDict, FiniteFloat, TypeAdapter, ValidationError
from pydantic.dataclasses import dataclass

from app.console.flags import problem
from app.enhancement.methods import RecordedSettings
from app.enhancement.settable import FrameNumber
from app.errors import UserError
from app.files.atomic import make_folder, write_bytes
from app.files.provenance import digest, strict_json
from app.files.records import RecordedReading
from app.runs.clip_selection import WHOLE, ClipPart
from app.runs.device import Device
from app.runs.exposure_record import ExposureRecord
from app.runs.run_lock import LOCK, NAME
from enhance import Statistics
from renderer.atomic_files import unlinked
from renderer.budget import budget
from renderer.camera import Camera
from renderer.clip import Clip, SparsePoints, held_out_frames
from renderer.deformation.windowed_motion import WindowedMotion
from renderer.gaussians import DynamicGaussians
from renderer.json_files import parsed
from renderer.leftovers import written_as
from renderer.poses.lost_frame import LostFrame
from renderer.poses.told_apart import TissueMotion
from renderer.readers.clip_options import DEFAULTS
from renderer.regular_files import read_regular
from renderer.train.config import TrainConfig
from renderer.train.events import Finished, Omission, TrainEvent
from renderer.train.window_files import FOLDER as WINDOWS

Input = Literal["original", "enhanced"]


@dataclass(frozen=True, kw_only=True, config=ConfigDict(extra="forbid"))
class PosesRecord:
    """How well the cameras of a clip without poses were estimated, see `renderer.poses.search.FoundPoses`."""

    residuals: tuple[float | None, ...]
    """px, one a frame of the part."""
    points: tuple[int, ...]
    lost: tuple[LostFrame, ...] = ()
    """Frames of what was asked for that have no pose of their own."""
    bridged: tuple[FrameNumber, ...] = ()
    """Those of the part that are neither trained on nor measured; none where the record does not say."""
    structure: tuple[FiniteFloat, ...] = ()
    """Points of the tissue, where they were found with the poses, in lack of depth: x, y and z in turn."""
    tissue: TissueMotion | None = None
    """Whether poses are told apart from motions of the tissue; None: the record does not say, as of earlier
    versions."""

    def __post_init__(self) -> None:
        """Raises ValueError: points that are not all of three numbers."""
        if len(self.structure) % 3:
            raise ValueError(f"expected x, y and z of each point, got {len(self.structure)} numbers")

    @property
    def sparse_points(self) -> SparsePoints | None:
        return SparsePoints(np.reshape(self.structure, (-1, 3))) if self.structure else None


@dataclass(frozen=True, kw_only=True, config=ConfigDict(extra="forbid", allow_inf_nan=False))
class ClipRecord:
    """The clip that a run was trained on."""

    path: str
    """Absolute."""
    name: str
    options: RecordedReading = DEFAULTS
    """How it is read."""
    part: ClipPart = WHOLE
    """What of it counts: frames, cameras and times are of this part."""
    sha256: str
    """Of the manifest, see `app.files.provenance.digest`."""
    files: Literal["read"] = "read"
    """Which files the manifest holds: those that are read."""
    frames: int
    unit: str
    cameras: tuple[dict[str, Any], ...]
    """`Camera.to_json`: one a frame, or a single one when the camera is fixed."""
    poses: PosesRecord | None = None
    """Where the cameras were estimated; None: they are the clip's."""
    frames_per_second: Annotated[float, Interval(gt=0)] | None = None
    """Of the part; None: the clip does not tell, or the record does not, as of earlier versions."""
    asked: tuple[FrameNumber, FrameNumber] | None = None
    """With poses that were estimated: the frames that were asked for, as `part` may be less; None: all."""

    def __post_init__(self) -> None:
        """Raises ValueError: no frames or too many, another number of cameras, or one that sees nothing."""
        budget().require(frames=self.frames)
        if self.frames < 1 or len(self.cameras) not in (1, self.frames):
            got = f"{len(self.cameras)} cameras of {self.frames} frames"
            raise ValueError(f"expected one camera, or one per frame, got {got}")
        for camera in self.cameras:
            Camera.from_json(camera)

    @property
    def seen_from(self) -> tuple[Camera, ...]:
        """The camera of each frame."""
        cameras = tuple(map(Camera.from_json, self.cameras))
        return cameras if len(cameras) == self.frames else cameras * self.frames

    @property
    def wanted(self) -> ClipPart:
        """What was asked for of the clip, without what training found."""
        return ClipPart(trim=self.part.trim if self.poses is None else self.asked, mask=self.part.mask)

    def through(self, part: Clip) -> Clip:
        """The part of the clip, with the cameras that were estimated, if any were, and the points."""
        if self.poses is None:
            return part
        seen = part.through(self.seen_from)
        bridged, points = frozenset(self.poses.bridged), self.poses.sparse_points or part.points
        return replace(seen, passed_over=bridged, points=points)

    def as_trained(self, whole: Clip) -> Clip:
        """The part of the whole clip that was trained on, without what was left out of its frames."""
        return self.through(self.part.of(whole))

    def through_whole(self, clip: Clip) -> Clip:
        """The same of the whole clip: frames outside the part have the camera of the nearest one in it."""
        if self.poses is None:
            return clip
        cameras, start = self.seen_from, self.part.first or 0
        places = (min(max(at - start, 0), len(cameras) - 1) for at in range(len(clip)))
        return clip.through(tuple(cameras[place] for place in places))

    def is_of(self, path: Path) -> bool:
        """Whether the clip there has the bytes of this one. Raises OSError: there is none."""
        return self.sha256 == digest(path)


@dataclass(frozen=True, kw_only=True, config=ConfigDict(extra="forbid", allow_inf_nan=False))
class Enhancement:
    """What turned the clip's frames into the run's own."""

    params: RecordedSettings
    """Of either method; all of them are recorded, so that they tell which."""
    statistics: Statistics
    """Pooled over the training frames."""


@dataclass(frozen=True, kw_only=True, config=ConfigDict(extra="forbid"))
class RunRecord:
    """Everything needed to repeat a run: the content of run.json."""

    schema: Literal[1] = 1
    version: str
    created: str
    """UTC, ISO 8601."""
    clip: ClipRecord
    input: Input
    config: TrainConfig
    enhancement: Enhancement | None = None
    """None when the run was trained on the original frames."""
    device: Device = "cpu"
    exposure: ExposureRecord | None = None
    """None: not looked at, as by earlier versions."""

    @property
    def cameras(self) -> tuple[Camera, ...]:
        """One a frame."""
        return self.clip.seen_from

    @property
    def unit(self) -> str:
        """Of lengths."""
        return self.clip.unit

    @property
    def frames_per_second(self) -> float | None:
        """Of the frames that it was trained on; None: not known."""
        return self.clip.frames_per_second

    @property
    def test_indices(self) -> tuple[int, ...]:
        """The frames held out of training, as `Clip.test_indices`, without the clip."""
        bridged = () if self.clip.poses is None else self.clip.poses.bridged
        return held_out_frames(self.clip.frames, self.clip.options.split, bridged)

    def time(self, index: int) -> float:
        """The time of frame `index`, in [0, 1)."""
        return index / self.clip.frames


RECORD = TypeAdapter(RunRecord)


@plain_dataclass(frozen=True)
class RunFolder:
    """Paths and files of one run."""

    path: Path

    @property
    def record_path(self) -> Path:
        return self.path / "run.json"

    @property
    def events_path(self) -> Path:
        return self.path / "events.jsonl"

    @property
    def model_path(self) -> Path:
        return self.path / "model.safetensors"

    @property
    def edits_path(self) -> Path:
        """What was done to the model by hand, see run_edits.py."""
        return self.path / "edits.json"

    @property
    def is_run(self) -> bool:
        return self.record_path.is_file()

    @property
    def is_finished(self) -> bool:
        return self.is_run and self.model_path.is_file()

    @property
    def has_checkpoint(self) -> bool:
        left = chain(self.path.glob("checkpoint-*.safetensors"), self.path.glob(f"{WINDOWS}/*/*.safetensors"))
        return any(left)

    def require_vacant(self) -> None:
        """Raises UserError: something is here that a new run could harm."""
        there = self.path
        if not there.exists():
            if not next(place for place in there.absolute().parents if place.exists()).is_dir():
                raise UserError(f"expected a folder, got a file as a parent of {there}")
            return
        if not there.is_dir():
            raise UserError(f"expected an empty or new folder for the run, got a file: {there}")
        # The lock is of a process that is about to begin a run here, or was killed then.
        others = (each.name for each in there.iterdir() if each.name not in (NAME, LOCK))
        if not all(name.startswith(".") and written_as(name) for name in others):
            raise UserError(f"expected an empty or new folder for the run, got one with other files: {there}")

    def create(self, record: RunRecord) -> None:
        """Start a run here. Raises UserError when the folder holds anything."""
        self.require_vacant()
        make_folder(self.path)
        write_bytes(self.record_path, strict_json(record, indent=2).encode())

    def record(self) -> RunRecord:
        """Read run.json. Raises UserError when this is no run, or a damaged one."""
        if not self.is_run:
            got = f"found none in {self.path}" if self.path.exists() else f"got no such path: {self.path}"
            raise UserError(f"expected a run folder with run.json, {got}")
        try:
            return self._with_own_masks(RECORD.validate_json(read_regular(self.record_path)))
        except ValidationError as error:
            raise UserError(f"{self.record_path}: {problem(error)}") from error

    def _with_own_masks(self, record: RunRecord) -> RunRecord:
        """Found wherever the folder lies now."""
        part = record.clip.part.kept_in(self.path)
        return replace(record, clip=replace(record.clip, part=part))

    def log(self, event: TrainEvent, **facts: Any) -> None:
        """Append one event to events.jsonl: its name and plain fields, without the model, and `facts`."""
        self._append({"event": type(event).__name__} | _plain(event) | facts)

    def log_saving(self, event: Finished, **facts: Any) -> None:
        """Append what `event` will say, before its model is written: a kill between the two loses nothing."""
        self._append({"event": SAVING} | _plain(event) | facts)

    def _append(self, told: Mapping[str, Any]) -> None:
        line = strict_json(told)
        if self.events_path.is_symlink():
            raise UserError(f"expected the run's own log, got a link to another file: {self.events_path}")
        # A killed run can leave half a line behind: start on a new one.
        with self.events_path.open("ab+") as file:
            end = file.seek(0, 2)
            if end > 0:
                file.seek(end - 1)
                line = line if file.read(1) == b"\n" else f"\n{line}"
            file.write(f"{line}\n".encode())

    def events(self, *names: str) -> list[dict[str, Any]]:
        """The events logged so far, oldest first, of these names or all; half a line left by a killed run is
        passed over."""
        if not self.events_path.exists():
            return []
        text = read_regular(self.events_path).decode(errors="replace")
        events = (event for line in text.split("\n") if (event := _parsed(line)))
        return [event for event in events if not names or event["event"] in names]

    def omitted(self) -> tuple[Omission, ...]:
        """What the run left out, as it said when it started last and when it finished."""
        told = {event["event"]: OMITTED.validate_python(event.get("omitted", ())) for event in self.events()}
        return tuple(each for name in ("Started", "Finished") for each in told.get(name, ()))

    def train_seconds(self) -> float | None:
        """Of the steps of the finished run, None when it was not logged."""
        finished = self.events("Finished")
        return float(finished[-1]["seconds"]) if finished else None

    def wall_seconds(self) -> float | None:
        """Of all work on the run that its log tells of; None: not recorded, by an earlier version."""
        return wall_seconds_of(self.events())

    def wall_before(self) -> float | None:
        """The same, before a run goes on: 0 where it has not begun."""
        return self.wall_seconds() if self.events(*TIMED) else 0.0

    def save_model(self, model: DynamicGaussians) -> DynamicGaussians:
        """The same to go on with: one in windows reads them from its own file, and theirs are removed."""
        model.save(unlinked(self.model_path))
        if isinstance(model.motion, WindowedMotion):
            model = DynamicGaussians.load(self.model_path)
            self.clear_windows()
        return model

    def clear_windows(self) -> None:
        """Of a finished run nothing needs them."""
        shutil.rmtree(self.path / WINDOWS, ignore_errors=True)

    def model(self) -> DynamicGaussians:
        """The finished model. Raises UserError when there is none or it cannot be read."""
        if not self.is_finished:
            self.record()
            raise UserError(f"expected a finished run with model.safetensors: {self.path} (train --resume)")
        try:
            return DynamicGaussians.load(self.model_path)
        except ValueError as error:
            raise UserError(str(error)) from error


def _plain(event: TrainEvent) -> dict[str, Any]:
    """Its fields, without the model."""
    values = {item.name: getattr(event, item.name) for item in fields(event)}
    return {name: value for name, value in values.items() if not isinstance(value, DynamicGaussians)}


def _parsed(line: str) -> dict[str, Any] | None:
    try:
        event = parsed(line)
    except ValueError:
        return None
    return event if isinstance(event, dict) and _is_whole(event) else None


def _is_whole(event: dict[str, Any]) -> bool:
    """Whether it has the fields that are read by name; whatever else it holds is taken as it comes."""
    name = event.get("event")
    if name == "Warned" and not isinstance(event.get("message"), str):
        return False
    needed = ("iteration", "seconds") if name in ("Finished", SAVING) else ()
    if not all(is_number(event.get(each)) and event[each] >= 0 for each in needed):
        return False
    told = (event[each] for each in NUMBERS if event.get(each) is not None)
    if not all(is_number(value) and abs(value) < MOST for value in told):
        return False
    try:
        OMITTED.validate_python(event.get("omitted", ()))
    except ValidationError:
        return False
    return isinstance(name, str)


def wall_seconds_of(events: Sequence[Mapping[str, Any]]) -> float | None:
    """See RunFolder.wall_seconds, of what its log holds."""
    timed = [event for event in events if event["event"] in TIMED]
    seconds = timed[-1].get("wall_seconds") if timed else None
    return None if seconds is None else float(seconds)


def is_number(value: object) -> bool:
    """True and False are none."""
    return isinstance(value, int | float) and not isinstance(value, bool)


NUMBERS: Final = ("iteration", "seconds", "wall_seconds", "psnr", "n_gaussians")
"""Fields of events that are read by name."""
SAVING: Final = "Saving"
"""The event of a log that a run ends with, but for the model, which is written next."""
TIMED: Final = ("Progress", SAVING, "Finished")
"""Events that say how long a run has taken."""
MOST: Final = 1e12
"""That any of them may be."""
OMITTED = TypeAdapter(tuple[Omission, ...])
