"""Where the sources of an exported file lie now: known by name, recognised by their bytes."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path, PurePosixPath

from app.enhancement.clip_statistics import OfClip, StatisticsRequest
from app.errors import UserError
from app.files.image_series import Series, open_series
from app.files.provenance import digest
from app.files.records import Source
from app.runs.run_edits import unpacked
from app.runs.run_folder import RunFolder
from app.runs.runs_place import runs_place
from app.runs.trained_clip import input_clip, run_clip
from app.scenes.drawer import Drawer
from app.scenes.records import RunSource, SceneRecord
from app.scenes.renderers import Renderer, drawer
from app.scenes.scene import Scene, open_scene
from app.scenes.view_request import FrameRequest
from app.scenes.window_scene import scene_of_window
from assets import phantom_path
from renderer.clip import Clip
from renderer.readers.clip_files import files_in
from renderer.readers.clip_options import ClipOptions
from renderer.sources import open_case, with_chosen_depth


@dataclass(eq=False)
class Found:
    """Looks for them beside the file, in the current folder, and where it is told to; for runs at last among
    those that the window keeps."""

    file: Path
    given: tuple[Path, ...] = ()
    _drawers: dict[str, Drawer] = field(default_factory=dict, init=False)
    _scenes: dict[object, Scene] = field(default_factory=dict, init=False)
    _references: dict[tuple[RunSource, bool], Clip] = field(default_factory=dict, init=False)

    def series(self, source: Source, options: ClipOptions) -> Series:
        return open_series(self.find(source), options)

    def clip(self, source: Source, options: ClipOptions) -> Clip:
        found = self.find(source)
        case = open_case(found, options)
        return with_chosen_depth(case, options) if case.has_one_size else case

    def saved(self, source: Source) -> Path:
        return self.find(source)

    def scene(self, record: SceneRecord) -> Scene:
        """Without the edits of the run, whatever has been edited since, and with those of the record."""
        key = record.run, record.splats, record.edits, record.window
        if key not in self._scenes:
            self._scenes[key] = self._opened(record)
        return self._scenes[key]

    def _opened(self, record: SceneRecord) -> Scene:
        if record.run is not None:
            scene = open_scene(self.find_run(record.run).path, as_trained=True)
        elif record.splats is not None:
            scene = open_scene(self.find(record.splats))
        else:
            raise UserError("expected the run or splat file it was made from, got neither")
        if record.edits is not None:
            left = unpacked(record.edits.deleted, record.edits.hidden, len(scene.model), self.file)
            scene = scene.edited(left)
        return scene if record.window is None else scene_of_window(scene, record.window)

    def reference(self, record: SceneRecord, frame: int | None, *, trained: bool) -> FrameRequest:
        if record.run is None:
            raise UserError("expected the run of a difference, got none")
        key = record.run, trained
        if key not in self._references:
            run = self.find_run(record.run).record()
            self._references[key] = input_clip(run_clip(run), run) if trained else run_clip(run)
        clip = self._references[key]
        if frame is None or not 0 <= frame < len(clip):
            raise UserError(f"expected a difference to one of {len(clip)} frames, got {frame}")
        return FrameRequest(clip, frame)

    def of_clip(self, request: StatisticsRequest) -> OfClip:
        return None

    def drawer(self, renderer: str) -> Drawer:
        """The kind of renderer that drew, as it is here."""
        if renderer not in self._drawers:
            kinds: dict[str, Renderer] = {"OpenGL": "gl", "float64": "reference"}
            found = (kind for word, kind in kinds.items() if renderer.startswith(word))
            self._drawers[renderer] = drawer(next(found, "cpu"))
        return self._drawers[renderer]

    def find(self, source: Source) -> Path:
        """The file or folder with these bytes. Raises UserError: missing, or its bytes have changed."""
        return self._found(source.name, source.sha256, digest)

    def find_run(self, run: RunSource) -> RunFolder:
        """The run with this model. Raises UserError: missing, with another model, or never finished."""
        if run.model_sha256 is None:
            raise UserError(f"{self.file.name} shows {run.name} during training: that model no longer exists")
        try:
            return RunFolder(self._found(run.name, run.model_sha256, _digest_of_model))
        except UserError:
            kept = _kept_run(run.name, run.model_sha256)
            if kept is None:
                raise
            return kept

    def _found(self, name: str, sha256: str, digest_of: Callable[[Path], str]) -> Path:
        candidates = list(dict.fromkeys(path.absolute() for path in self._candidates(name)))
        for path in candidates:
            if digest_of(path) == sha256:
                return path
        if not candidates and not _is_bare(name):
            said = f"{self.file.name} names its source by a path, {name}"
            raise UserError(f"{said}, which is not looked up: give it with --source")
        if not candidates:
            raise UserError(
                f"expected the source {name} beside {self.file.name}, in the current folder or "
                "given with --source, found none"
            )
        shown = candidates[0]
        raise UserError(
            f"the source has changed since {self.file.name} was made: expected SHA-256 {sha256[:12]}…, "
            f"got {digest_of(shown)[:12]}…: {shown}"
        )

    def _candidates(self, name: str) -> Iterator[Path]:
        """What is there under this name; a source that is given may have another one."""
        bare = PurePosixPath(name.replace("\\", "/")).name
        for path in self.given:
            named = path / bare if bare and (path / bare).exists() else path
            yield named
            if named.is_dir():  # What a DICOM object of nobody names its source tells nothing.
                ending = PurePosixPath(bare).suffix
                yield from (each for each in files_in(named) if ending and each.suffix == ending)
        if not _is_bare(name):
            return
        for folder in (self.file.absolute().parent, Path.cwd(), phantom_path().parent):
            path = folder / name
            if (path.is_file() or path.is_dir()) and path != self.file.absolute() and _lies_in(path, folder):
                yield path


def _is_bare(name: str) -> bool:
    """Whether it is a name, as provenance holds: a path might lead anywhere, and the file may be anyone's."""
    return name not in ("", ".", "..") and not any(sign in name for sign in "/\\\0")


def _lies_in(path: Path, folder: Path) -> bool:
    """Whether a link leads out of the folder; where one is meant, --source says so."""
    return path.resolve().is_relative_to(folder.resolve())


def _kept_run(name: str, sha256: str) -> RunFolder | None:
    """Of the runs that the window keeps, the one with this model; it may have been renamed since."""
    place = runs_place()
    folders = sorted(place.iterdir(), key=lambda path: path.name != name) if place.is_dir() else []
    runs = (RunFolder(path) for path in folders if not path.is_symlink())
    return next((run for run in runs if run.is_finished and _digest_of_model(run.path) == sha256), None)


def _digest_of_model(path: Path) -> str:
    run = RunFolder(path)
    return digest(run.model_path) if run.is_finished else "no finished run"
