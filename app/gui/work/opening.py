"""Opens what a person points at: a clip, a run with its clip and model, or splats; off the main thread."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final, Literal

from app.enhancement.clip_statistics import IMAGES
from app.errors import UserError
from app.exports.replay.enhanced_already import enhanced_already
from app.files.provenance import digest
from app.gui.session_file import SUFFIX, Session, SessionSource, mended_session
from app.gui.work.opened_run import OpenedRun, clip_of, model_of, place_of, request_of
from app.gui.work.reported import Reported, read_reported, read_sweep_report
from app.report.section import holds_report
from app.runs.progress_log import told
from app.runs.run_edits import read_edits
from app.runs.run_folder import RunFolder
from app.runs.run_lock import holder
from app.scenes.scene import Scene, series_scene, splat_scene
from app.sweeps.folder import SWEEP, is_sweep
from renderer.camera_files import CameraFileError
from renderer.clip import Clip, ClipError
from renderer.listing import listed
from renderer.readers.clip_options import DEFAULTS, ClipOptions
from renderer.readers.cut_off import CUT_OFF
from renderer.readers.dicom.opening import is_dicom
from renderer.readers.image_folders.passed_over import NOT_READABLE
from renderer.readers.lenses.calibration_files import read_calibration
from renderer.regular_files import require_file_or_folder
from renderer.sources import open_case, with_chosen_depth
from renderer.splat_files import is_named_as_splats
from renderer.splat_series import series_files
from renderer.view_files import Views, import_views, may_hold_views

Content = Literal["clip", "stills", "run"]
"""Kinds of what is opened: each has its layout of the window."""
VIEW_SUFFIXES: Final = (".json", ".txt")
"""Of reports, of views, and of cameras of other programs."""
CONTINUES: Final = "Continue resumes from its last checkpoint"


@dataclass(frozen=True, eq=False)
class OpenRequest:
    """One wish to open something; a second wish for the same path is another request."""

    path: Path
    options: ClipOptions = DEFAULTS
    onward: tuple[Path, ...] | None = None
    """Of one of a folder's images after another, those behind it: the first that can be read is opened."""
    calibration: Path | None = None
    """To be read, instead of that of the options."""
    source: Path | None = None
    """Where the clip of a run lies now, or what a session is of, as a person says."""
    beside: Path | None = None
    """The clip that is open: it may be that of a run, which lay elsewhere then."""


class SourceLost(UserError):
    """The clip of a run, or what a session is of, is not where it was."""

    def __init__(self, said: str, asked: Path, old: Path) -> None:
        """asked: the run or the session; old: where its source was."""
        super().__init__(said)
        self.asked, self.old = asked, old


@dataclass(frozen=True, eq=False)
class Opened:
    """A clip, a run, a run with its clip, or a file of splats."""

    clip: Clip | None
    run: OpenedRun | None = None
    bare: Clip | None = None
    """The clip with no depth but that of its own files."""
    is_enhanced: bool = False
    """The clip is a file that VesselSplat enhanced before."""
    is_dicom: bool = False
    splats: Scene | None = None
    """Of a file of splats."""
    notices: tuple[str, ...] = ()
    options: ClipOptions = DEFAULTS
    """How the clip was read."""
    session: Session | None = None
    """To take up, of a session file."""
    second: Path | None = None
    """Of a session file: what its second 3D view showed, where that is still there."""
    pictures: tuple[Path | None, ...] = ()
    """Of a session file: where those of its case summary are; None: no longer there."""
    path: Path | None = None
    """What was opened: of a session file, its source."""
    report: Reported | None = None
    """Nothing else is opened with one."""
    views: Views | None = None
    """Nothing else is opened with them."""
    warning: str = ""
    """What could not be opened of it."""
    lost: SourceLost | None = None
    """The clip of a run: it is looked at without."""
    in_passing: bool = False
    """One of a folder's images after another: not worth remembering."""

    @property
    def to_be_read(self) -> tuple[str, ...]:
        """Beside the images, but for the warning above them."""
        said = read_as(self.clip) if self.clip is not None else ()
        return tuple(notice for notice in said if notice != self.warning)

    @property
    def model(self) -> Scene | None:
        """Of a file of splats, or of a run."""
        return self.splats or (self.run.model if self.run is not None else None)

    @property
    def content(self) -> Content:
        """Folders of images without depth count as stills."""
        if self.run is not None or self.clip is None:
            return "run"
        is_folder = self.clip.format == IMAGES and not self.clip.has_depth
        return "stills" if is_folder or len(self.clip) == 1 else "clip"


def read_as(clip: Clip) -> tuple[str, ...]:
    """What a video or one image is read as, to be read beside it; of folders that is for the log."""
    return clip.notices if clip.format == "video" or len(clip) == 1 else ()


def open_path(request: OpenRequest) -> Iterator[Opened]:
    """Raises ClipError, UserError or OSError: one line for the banner."""
    if request.onward is not None:
        yield _open_next(request.path, request.onward, request.options)
    else:
        yield _open(request)


def _open_next(first: Path, onward: tuple[Path, ...], options: ClipOptions) -> Opened:
    """The first image that can be read; those before it are passed over, in one line."""
    passed, trouble = list[str](), ClipError(f"expected an image, got none: {first}")
    for path in (first, *onward):
        try:
            opened = _open(OpenRequest(path, options))
        except (ClipError, UserError, OSError) as error:
            passed.append(path.name)
            trouble = ClipError(str(error)) if len(passed) == 1 else trouble
        else:
            said = f"passed over, not readable: {listed(passed)}" if passed else opened.warning
            return replace(opened, path=path, warning=said, in_passing=True)
    raise trouble


def _open(request: OpenRequest) -> Opened:
    _require_file_or_folder(request.path)
    if request.path.suffix == SUFFIX:
        return _open_session(request.path, request.source)
    if is_named_as_splats(request.path):
        return _open_splats(splat_scene(request.path))
    if request.path.suffix.lower() in VIEW_SUFFIXES and may_hold_views(request.path):
        return _open_beside(request.path)
    if is_sweep(request.path):
        return Opened(None, report=read_sweep_report(request.path))
    folder = request.path.parent if request.path.suffix == ".safetensors" else request.path
    run = RunFolder(folder)
    if run.is_run or request.path.suffix == ".safetensors":
        # One run is known by one path, however it is written.
        return _open_run(RunFolder(folder.resolve()), request.source, request.beside)
    if series_files(request.path):
        return _open_splats(series_scene(request.path))
    read = (_calibrated if request.calibration else _read_anyhow)(request)
    # A folder that lists but does not decode is found out here, not in the middle of a session.
    read.bare.read_image(0)
    return _opened(read)


@dataclass(frozen=True, eq=False)
class _Read:
    clip: Clip
    bare: Clip
    options: ClipOptions
    warning: str = ""


def _calibrated(request: OpenRequest) -> _Read:
    """Raises ClipError, also for a calibration that does not fit: it was chosen for this clip."""
    assert request.calibration is not None
    calibration = read_calibration(request.calibration)
    return _read(request.path, replace(request.options, calibration=calibration))


def _read_anyhow(request: OpenRequest) -> _Read:
    """Without its calibration, where the clip does not open with that. Raises ClipError."""
    path, options = request.path, request.options
    try:
        return _read(path, options)
    except ClipError as error:
        if options.calibration is None:
            raise
        read = _read(path, replace(options, calibration=None))
        return replace(read, warning=f"opened without the calibration: {error}")


def _read(path: Path, options: ClipOptions) -> _Read:
    """With depth as the options say, or as the clip has it where there is no such depth. Raises ClipError."""
    bare = open_case(path, options)
    lost = next((said for said in bare.notices if said.startswith((NOT_READABLE, CUT_OFF))), "")
    if not bare.has_one_size:
        return _Read(bare, bare, options, lost)
    try:
        return _Read(with_chosen_depth(bare, options), bare, options, lost)
    except ClipError as error:
        if options.depth == "auto":
            raise
        plain = replace(options, depth="auto")
        return _Read(with_chosen_depth(bare, plain), bare, plain, f"opened without the chosen depth: {error}")


def _opened(read: _Read) -> Opened:
    """Of a file that is enhanced already, that is said as it is said what a video is read as."""
    said = tuple(filter(None, (enhanced_already(read.bare.path),)))
    clip, bare = (replace(each, notices=(*said, *each.notices)) for each in (read.clip, read.bare))
    opened = Opened(clip, bare=bare, notices=clip.notices, options=read.options, warning=read.warning)
    return replace(opened, is_enhanced=bool(said), is_dicom=is_dicom(bare.path))


def _require_file_or_folder(path: Path) -> None:
    """What is nothing at all is told by the reader of its kind."""
    try:
        require_file_or_folder(path)
    except FileNotFoundError:
        return
    except OSError as error:
        raise UserError(f"{error.strerror}: {path}") from error


def _open_beside(path: Path) -> Opened:
    """A report, or views and cameras: what joins the present session."""
    if path.name == SWEEP and is_sweep(path.parent):
        return Opened(None, report=read_sweep_report(path.parent))
    if holds_report(path):
        return Opened(None, report=read_reported(path))
    try:
        return Opened(None, views=import_views(path))
    except CameraFileError as error:
        raise UserError(f"expected a report, views or cameras: {error}") from error


def _open_session(path: Path, source: Path | None) -> Opened:
    """Its run where that can be opened, else its clip or file of splats; or what is named in their place."""
    session, damage = mended_session(path)
    run = session.run.found(path) if session.run else None
    if source is not None and RunFolder(source).is_run:
        run, source = source, None
    wanted, place = session.source, source or (session.source.found(path) if session.source else None)
    if session.run is not None and run is not None and RunFolder(run).is_run:
        wanted, place = session.run, run
    if wanted is None or place is None:
        named = session.source or session.run
        if named is None:
            return Opened(None, session=session, pictures=_pictures(session, path), warning=damage)
        old = named.place(path)
        raise SourceLost(f"{_expected(old)}: {path}", path, old)
    of_run = source if place == run else None
    opened = _open(OpenRequest(place, session.clip_options, source=of_run))
    lost = opened.lost and SourceLost(str(opened.lost), path, opened.lost.old)
    if session.run is not None and place != run:
        lost = lost or _run_lost(session.run, path, place)
    notices = opened.notices
    if wanted.sha256 is not None and wanted.sha256 != digest(place):
        notices = (*notices, f"{place.name} has changed since the session was saved")
    second = session.second.found(path) if session.second else None
    opened = replace(opened, session=session, second=second, pictures=_pictures(session, path), lost=lost)
    return replace(opened, path=place, notices=notices, warning=damage or opened.warning)


def _run_lost(run: SessionSource, path: Path, shown: Path) -> SourceLost:
    """Of the session at `path`, of which only `shown` is there."""
    old = run.place(path)
    return SourceLost(f"{_expected(old, 'the reconstruction ')}; {shown.name} is shown without it", path, old)


def _expected(old: Path, kind: str = "") -> str:
    return f"expected {kind}{old.name} at its old place {old.parent} or beside the session, found neither"


def _pictures(session: Session, path: Path) -> tuple[Path | None, ...]:
    """Of its case summary: where they are now."""
    return tuple(one.file.found(path) for one in session.summary.pictures)


def _open_splats(scene: Scene) -> Opened:
    is_empty = not len(scene.model) and not scene.split_by_time
    warning = f"there are no Gaussians to show in {scene.title}" if is_empty else ""
    return Opened(None, splats=scene, notices=scene.notices, warning=warning)


def _open_run(folder: RunFolder, source: Path | None, beside: Path | None) -> Opened:
    record, lost = folder.record(), None
    if source is not None and not record.clip.is_of(source):
        raise UserError(f"expected the clip that {folder.path.name} was trained on, got another: {source}")
    place = source or place_of(record, beside)
    try:
        clip, bare = clip_of(record, place)
        # Of this name and place it is from now on.
        record = replace(record, clip=replace(record.clip, path=str(place.absolute()), name=clip.name))
    except ClipError as error:
        trouble = f"the run's clip cannot be opened; only its model is shown: {error}"
        clip, bare, lost = None, None, SourceLost(trouble, folder.path, place)
    notices = clip.notices if clip is not None else ()
    finished, warning, said = folder.is_finished, "", told(folder)
    is_trained = not finished and holder(folder.path) is not None
    model = model_of(folder, record, clip, said)
    if model is not None and finished:
        try:
            model = replace(model, saved_edits=read_edits(folder, len(model.model)))
        except UserError as error:
            warning = f"the model is shown as trained: {error}"
    if not finished:
        shown = ", shown here" if model is not None else ""
        onward = "is still in training elsewhere" if is_trained else f"is not finished: {CONTINUES}{shown}"
        notices = (*notices, f"{folder.path.name} {onward}")
    run = OpenedRun(folder.path, record, request_of(folder, record), model, said, is_trained)
    options = record.clip.options
    return Opened(clip, run, bare, notices=notices, options=options, warning=warning, lost=lost)
