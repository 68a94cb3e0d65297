"""What can be drawn and exported: the model of a run, being trained, finished or edited, or a splat file."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from operator import attrgetter
from pathlib import Path
from typing import Final

from app.errors import UserError
from app.files.provenance import digest
from app.files.records import Source
from app.runs.clip_selection import WHOLE, ClipPart
from app.runs.run_edits import RecordedEdits, read_edits
from app.runs.run_folder import RunFolder, RunRecord
from app.scenes.records import ClipSource, RunSource, SceneRecord
from app.scenes.view_kinds import SCENE_UNITS
from renderer.camera import BoolArray, Camera, IntArray
from renderer.clip import Clip
from renderer.deformation.frame_by_frame import FrameByFrame
from renderer.deformation.motion import Still
from renderer.deformation.windowed_motion import WindowedMotion
from renderer.editing.edits import Edits
from renderer.framing import framing
from renderer.gaussians import DynamicGaussians
from renderer.in_view import FieldInView, InView, outline_of
from renderer.near_plane import NEAR_SHARE, middle_distance
from renderer.shown import looks
from renderer.splat_files import SplatFileError, is_named_as_splats, read_splats, whole
from renderer.splat_series import read_series, series_files
from renderer.splats import RenderMode
from renderer.train.config import TrainConfig

ESTIMATES: Final = ("monocular", "brightness", "motion")
"""Depths that no length follows from."""


@dataclass(frozen=True, eq=False, kw_only=True)
class Scene:
    """A model with what is needed to look at it and to say what it is."""

    name: str
    model: DynamicGaussians
    cameras: tuple[Camera, ...]
    """One a frame; of a file of splats, one that sees nearly all of them."""
    distance: float
    """From the first camera to the middle of the tissue, along its axis."""
    mode: RenderMode
    """How it was trained, so how it is drawn."""
    unit: str
    """Of lengths."""
    is_guessed: bool = False
    """Its depth was estimated: shapes are coarse, and lengths tell nothing."""
    record: SceneRecord
    """What an export says of it."""
    path: Path | None = None
    """The run folder or the file; None when that left nothing to read."""
    clip_path: Path | None = None
    """Where the clip lies that it was made of; None: not known."""
    iteration: int = 0
    iterations: int = 0
    """0 for a file of splats."""
    live: bool = False
    """Not finished: still being trained, or cut short."""
    first: int | None = None
    """The frame of the whole clip that its first one is, of a run of a part; None: it is of all frames."""
    frames_per_second: float | None = None
    """Of the clip, as it is or as the run records it; None: not known."""
    test_indices: tuple[int, ...] = ()
    notices: tuple[str, ...] = ()
    """What was repaired or left out."""
    poses_are_estimated: bool = False
    """Its cameras were worked out in training: the clip itself has one for all frames."""
    saved_edits: Edits | None = None
    """What was saved of edits of `model`, which is without them."""
    of: tuple[Scene, IntArray] | None = None
    """Whose Gaussians it has, and which of them, where it is edited or tinted: what frames show of tissue is
    as it was trained. None: its own."""

    @cached_property
    def camera_at_rest(self) -> Camera | None:
        """Of a run whose camera does not move, that camera; None: it moves, or there is none."""
        first = self.cameras[0]
        return first if self.is_of_run and all(camera == first for camera in self.cameras) else None

    @cached_property
    def field_in_view(self) -> InView | None:
        """What that camera has in view: its image, or of that the field in which the clip shows tissue."""
        camera, clip = self.camera_at_rest, self.record.clip
        if camera is None or clip is None or clip.part is None:
            return camera
        outline = outline_of(clip.part.kept(camera.width, camera.height))
        return camera if outline is None else FieldInView(camera, outline)

    @cached_property
    def shown(self) -> BoolArray | None:
        """(N,) Gaussians whose centre some frame shows, see renderer/shown.py; takes seconds at first. None:
        not known, of a file, of a preview, or of Gaussians that are others at other times."""
        if not self.tells_shown:
            return None
        if self.of is not None:
            whole, rows = self.of
            return None if whole.shown is None else whole.shown[rows]
        *_, found = looks(self.model, self.cameras, self.near, self.mode)
        return found

    @property
    def tells_shown(self) -> bool:
        return self.is_finished_run and not self.split_by_time

    @property
    def shown_so_far(self) -> BoolArray | None:
        """The same, where that has been worked out."""
        if self.of is not None and self.of[0].shown_so_far is not None:
            return self.shown
        known: BoolArray | None = self.__dict__.get("shown")
        return known

    def find_shown(self) -> Iterator[None]:
        """Work it out, a frame at a time."""
        if self.of is not None:
            yield from self.of[0].find_shown()
            return
        found = None
        for latest in looks(self.model, self.cameras, self.near, self.mode):
            found = latest
            yield
        self.__dict__["shown"] = found

    @property
    def near(self) -> float:
        """The near plane in scene units, the same share of the scene as in training."""
        return NEAR_SHARE * self.distance

    @property
    def start(self) -> int:
        """The frame of the whole clip that its first one is."""
        return self.first or 0

    @property
    def identity(self) -> str:
        """What tells it from others that are open: files of one name may lie in two folders."""
        return str(self.path or self.name)

    @property
    def is_of_run(self) -> bool:
        """Not of a file of splats."""
        return self.iterations > 0

    @property
    def is_series(self) -> bool:
        """Of a file per moment: other Gaussians at each."""
        return isinstance(self.model.motion, FrameByFrame)

    @property
    def split_by_time(self) -> str:
        """What makes its Gaussians others at other times, in words; empty: they are the same at all."""
        if self.is_series:
            return "a splat file per moment"
        motion = self.model.motion
        return f"a model in {len(motion)} windows" if isinstance(motion, WindowedMotion) else ""

    @property
    def is_finished_run(self) -> bool:
        return self.is_of_run and not self.live

    @property
    def title(self) -> str:
        """Of the clip, and which frames of it a window is of; of a file its name."""
        name = self.record.clip.name if self.record.clip else self.name
        if self.record.window is None:
            return name
        return f"{name}, frames {1 + self.start} to {self.start + len(self.cameras)}"

    @property
    def motion_since(self) -> str:
        """The moment from which its Gaussians are followed."""
        return "the start of the window" if isinstance(self.model.motion, WindowedMotion) else "the start"

    def require_same_tissue(self) -> None:
        """Raises UserError: nothing says which of its Gaussians are the same tissue at another moment."""
        if self.is_series:
            raise UserError(f"expected a model that moves, got {self.split_by_time}: {self.name}")

    def require_one_model(self) -> None:
        """Raises UserError: its Gaussians are others at other times."""
        if not self.split_by_time:
            return
        said, motion = f"expected one model that moves, got {self.split_by_time}", self.model.motion
        if isinstance(motion, WindowedMotion):
            said += f" (--window 1 to {len(motion)} takes one of them)"
        raise UserError(f"{said}: {self.name}")

    def time(self, index: int) -> float:
        """Of frame `index`, in [0, 1)."""
        return index / len(self.cameras)

    def frame_at(self, time: float) -> int:
        """The frame that is nearest to `time` in [0, 1]."""
        return min(int(time * len(self.cameras) + 0.5), len(self.cameras) - 1)

    def camera_at(self, time: float) -> Camera:
        """Of the frame nearest to `time`."""
        return self.cameras[self.frame_at(time)]

    def number_at(self, time: float) -> float:
        """Of the clip's frames, counted from 1, the one at `time` in [0, 1]; between two a fraction."""
        return round(1 + self.start + time * len(self.cameras), 2)

    def time_of(self, number: float) -> float:
        """In [0, 1], of a frame of the clip counted from 1, or of a moment between two."""
        return (number - 1 - self.start) / len(self.cameras)

    def moment(self, time: float) -> str:
        """`time` in [0, 1] as a person says it."""
        return f"frame {self.number_at(time):g}"

    def form(self, time: float) -> str:
        """How a control writes that number: with decimals only between two frames."""
        return "%.0f" if self.number_at(time).is_integer() else "%.2f"

    def has_clip_frame(self, frame: int) -> bool:
        return 0 <= frame - self.start < len(self.cameras)

    def is_of_other(self, clip: Clip) -> bool:
        """It was made of a clip elsewhere, or, where that is not known, of another name: of two patients,
        the cameras may be the same, and the names of folders."""
        if self.record.clip is None:
            return False
        if self.clip_path is not None:
            return not clip.lies_at(self.clip_path)
        return self.record.clip.name != clip.name

    def is_of(self, clip: Clip) -> bool:
        """Its cameras are those of the clip, or of a part of it; where poses were estimated, and maybe focal
        lengths, its images are. Those that are undistorted are told by their focal length."""
        if self.is_of_other(clip):
            return False
        theirs = clip.cameras if self.first is None else clip.cameras[self.first :][: len(self.cameras)]
        if self.cameras == theirs or not self.poses_are_estimated or len(theirs) != len(self.cameras):
            return self.cameras == theirs
        focal = ("fx", "fy") if self.record.clip and self.record.clip.calibration else ()
        alike = attrgetter("width", "height", "cx", "cy", *focal)
        return all(alike(one) == alike(other) for one, other in zip(self.cameras, theirs, strict=True))

    def edited(self, edits: Edits) -> Scene:
        """What is left of it; its record says so."""
        if edits.is_empty:
            return self
        record = replace(self.record, edits=RecordedEdits.of(edits))
        kept = self, edits.visible.indices()
        return replace(self, model=edits.applied(self.model), record=record, of=kept)


@dataclass(frozen=True)
class Training:
    """How far the training of a model has come."""

    iteration: int
    iterations: int
    live: bool
    """Not finished."""


def open_scene(path: Path, *, as_trained: bool = False) -> Scene:
    """A file of splats, a folder of numbered ones, or a run with what was edited by hand, unless it is wanted
    as trained.

    Raises:
        UserError: no finished run and no splats, or the edits are of another model.
    """
    if is_named_as_splats(path) or path.is_file():
        return splat_scene(path)
    folder = RunFolder(path)
    if not folder.is_run and series_files(path):
        return series_scene(path)
    record = folder.record()
    place = Path(record.clip.path)
    scene = replace(finished_scene(folder, record), clip_path=place if place.exists() else None)
    edits = None if as_trained else read_edits(folder, len(scene.model))
    if edits is None:
        return scene
    said = (
        f"edited: {edits.count - len(edits.visible)} of {edits.count} Gaussians are removed "
        "(--as-trained keeps them)"
    )
    return replace(scene.edited(edits), notices=(said,))


def splat_scene(path: Path) -> Scene:
    """Raises UserError: the file cannot be read, or is damaged."""
    try:
        file = read_splats(path)
    except SplatFileError as error:
        raise UserError(str(error)) from error
    notices = (*file.notices, *(() if len(file.raw) else ("no Gaussians to render: nothing is seen",)))
    return _without_cameras(whole(path), DynamicGaussians(file.raw, Still()), 1, file.mode, notices)


def series_scene(path: Path) -> Scene:
    """A folder of numbered splat files, one a moment. Raises UserError: one cannot be read, or is damaged."""
    try:
        series = read_series(path)
    except SplatFileError as error:
        raise UserError(str(error)) from error
    moments = series.moments
    model = DynamicGaussians(moments[0], FrameByFrame(moments))
    mode, notices = series.files[0].mode, series.notices
    if others := sum(file.mode != mode for file in series.files):
        notices = (
            *notices,
            f"all are drawn as the first, {mode}: {others} of {len(series.files)} say another mode",
        )
    return _without_cameras(path, model, len(moments), mode, notices)


def _without_cameras(
    path: Path, model: DynamicGaussians, frames: int, mode: RenderMode, notices: tuple[str, ...]
) -> Scene:
    """Seen at all frames by one camera that has nearly all of it in view at the first."""
    camera = framing(model)
    return Scene(
        name=path.absolute().name,
        model=model,
        cameras=(camera,) * frames,
        distance=middle_distance(model, camera),
        mode=mode,
        unit=SCENE_UNITS,
        record=SceneRecord(splats=Source.of(path), render_mode=mode, notices=notices),
        path=path,
        notices=notices,
    )


def finished_scene(folder: RunFolder, record: RunRecord) -> Scene:
    """A finished run as it was trained. Raises UserError when it is not, or cannot be read."""
    steps = record.config.iterations
    done = Training(steps, steps, live=False)
    return run_scene(folder, folder.model(), record, record.config, record.clip.part, done)


def run_scene(
    folder: RunFolder,
    model: DynamicGaussians,
    footage: Clip | RunRecord,
    config: TrainConfig,
    part: ClipPart,
    training: Training,
) -> Scene:
    """The model of a run, finished or not, through the cameras of what it was trained on: a clip, or what
    run.json says of it."""
    name = folder.path.absolute().name
    record = _readable_record(folder, name)
    return Scene(
        name=name,
        model=model,
        cameras=footage.cameras,
        distance=middle_distance(model, footage.cameras[0]),
        mode=config.render_mode,
        unit=footage.unit,
        is_guessed=_is_guessed(footage),
        record=record or SceneRecord(run=RunSource(name=name)),
        path=folder.path if record else None,
        iteration=training.iteration,
        iterations=training.iterations,
        live=training.live,
        first=part.first,
        frames_per_second=footage.frames_per_second,
        test_indices=footage.test_indices,
        poses_are_estimated=isinstance(footage, RunRecord) and footage.clip.poses is not None,
    )


def _is_guessed(footage: Clip | RunRecord) -> bool:
    """A record holds what was asked for, and an estimate is made only where it is."""
    if isinstance(footage, RunRecord):
        return footage.clip.options.depth in ESTIMATES
    return footage.depth_origin in ESTIMATES


def _readable_record(folder: RunFolder, name: str) -> SceneRecord | None:
    """None for a run that has not been written yet, or is gone."""
    try:
        return _run_record(folder, folder.record(), name)
    except (OSError, UserError):
        return None


def _run_record(folder: RunFolder, record: RunRecord, name: str) -> SceneRecord:
    """Without a model's digest while it is being trained."""
    clip, part = record.clip, None if record.clip.part == WHOLE else record.clip.part.of_anywhere
    return SceneRecord(
        run=RunSource(name=name, model_sha256=digest(folder.model_path) if folder.is_finished else None),
        clip=ClipSource(name=clip.name, sha256=clip.sha256, part=part, calibration=clip.options.calibration),
        input=record.input,
        enhancement=record.enhancement,
        config=record.config,
    )
